#define ANTILAG 0
#include "temporal.glsl"
