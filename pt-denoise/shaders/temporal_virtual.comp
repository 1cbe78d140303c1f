#define ANTILAG 0
#define VIRTUAL 1
#define SOURCE 0
#include "temporal.glsl"
