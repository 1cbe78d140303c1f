#define TEMPORAL 0
#include "variance.glsl"
