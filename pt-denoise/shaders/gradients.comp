#define INDIRECT 0
#include "gradients.glsl"
