#define RADIUS 1
#include "atrous_permuted.glsl"
