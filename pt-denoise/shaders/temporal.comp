#define ANTILAG 0
#define VIRTUAL 0
#define SOURCE 0
#include "temporal.glsl"
