// The radiance of an image of floats replaced by another.
#define FORMAT rgba32f
#include "substitute.glsl"
