#define TEMPORAL 1
#include "variance.glsl"
