#define RAW 0
#include "recurrent_blur.glsl"
