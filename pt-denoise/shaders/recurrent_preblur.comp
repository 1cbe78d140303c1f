#define RAW 1
#include "recurrent_blur.glsl"
