#define RADIUS 2
#include "atrous_dilated.glsl"
