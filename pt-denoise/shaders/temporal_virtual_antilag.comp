#define ANTILAG 1
#define VIRTUAL 1
#define SOURCE 0
#include "temporal.glsl"
