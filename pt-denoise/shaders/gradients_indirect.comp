#define INDIRECT 1
#include "gradients.glsl"
