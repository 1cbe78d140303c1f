#define RADIUS 2
#define ROOTS 1
#include "atrous_permuted.glsl"
