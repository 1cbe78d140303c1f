#define ANTILAG 1
#include "temporal.glsl"
