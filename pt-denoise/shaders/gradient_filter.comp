#define INDIRECT 0
#include "gradient_filter.glsl"
