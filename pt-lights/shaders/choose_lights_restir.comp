// As choose_lights.comp, with the samples of local lights that sampler restir-di has kept. Extent: split frame.
#define RESTIR
layout(local_size_x = 16, local_size_y = 8) in;
#include "reservoir.glsl"
#include "choose_lights.glsl"
