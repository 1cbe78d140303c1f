#define RADIUS 1
#include "atrous_dilated.glsl"
