#define ANTILAG 0
#define VIRTUAL 0
#define SOURCE 1
#include "temporal.glsl"
