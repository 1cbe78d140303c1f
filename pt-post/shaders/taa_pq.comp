// Temporal anti-aliasing in PQ space, the default, without the others' branches.
#define SPACE SPACE_PQ
#include "taa.glsl"
