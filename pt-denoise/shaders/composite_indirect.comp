// Composite of direct and indirect light.
#define INDIRECT
#include "composite.glsl"
