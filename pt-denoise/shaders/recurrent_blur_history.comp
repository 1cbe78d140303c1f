#define RAW 0
#define HISTORY 1
#include "recurrent_blur.glsl"
