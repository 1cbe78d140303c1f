#define RADIUS 1
#define ROOTS 1
#include "atrous_permuted.glsl"
