// Composite of direct light.
#include "composite.glsl"
