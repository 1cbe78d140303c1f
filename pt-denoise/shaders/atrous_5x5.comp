#define RADIUS 2
#include "atrous_permuted.glsl"
