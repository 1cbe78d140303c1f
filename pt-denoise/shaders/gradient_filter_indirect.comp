#define INDIRECT 1
#include "gradient_filter.glsl"
