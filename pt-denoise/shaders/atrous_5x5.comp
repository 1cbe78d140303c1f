#define RADIUS 2
#define ROOTS 0
#include "atrous_permuted.glsl"
