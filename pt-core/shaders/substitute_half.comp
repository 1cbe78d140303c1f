// The radiance of an image of half floats replaced by another.
#define FORMAT rgba16f
#include "substitute.glsl"
