#define RAW 0
#define HISTORY 0
#include "recurrent_blur.glsl"
