#define RAW 1
#define HISTORY 0
#include "recurrent_blur.glsl"
