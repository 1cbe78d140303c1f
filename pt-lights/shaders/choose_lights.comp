// Chooses lights and lists the shadow rays that tell whether they arrive: a ray for each kind of light that is on. Extent: split frame.
layout(local_size_x = 16, local_size_y = 8) in;
#include "choose_lights.glsl"
