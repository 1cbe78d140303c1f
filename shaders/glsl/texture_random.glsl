// Random numbers of the stochastic texture filter (texture_filter.glsl) at a surface that a pixel shows.
//
// All textures of the surface share them: textures of the same resolution take the same texel, so that the mean over the frames is that of
// shaded texels. Surfaces that a path meets one after the other must not share them: the mean of the product of two textures would not be
// the product of their means. The instance tells them apart in every pass that looks at the surface.
#include "random.glsl"

vec4 texture_random(uvec2 key, uint instance) {
    if (scene_has(FEATURE_TEXTURE_FILTER)) return vec4(0.0);
    return random_numbers(key, DIM_TEXTURE + instance % TEXTURE_DIMENSIONS);
}
