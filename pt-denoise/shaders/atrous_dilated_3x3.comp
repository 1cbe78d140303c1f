#define RADIUS 1
#define ROOTS 0
#include "atrous_dilated.glsl"
