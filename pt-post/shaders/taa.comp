// Temporal anti-aliasing in any space.
#define SPACE push.space
#include "taa.glsl"
