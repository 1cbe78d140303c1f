// The random numbers of a path. Every decision has a dimension of its own, at the same place for every path: the camera the first
// one, each vertex three.
#include "rng.glsl"
#include "sampler.glsl"

struct PathRandom {
    Sampler numbers;
    uvec2 key; // of the pixel and the sample, as in rng.glsl
};

PathRandom path_random(uvec2 pixel, uint sample_index) {
    return PathRandom(make_sampler(sampler_kind, pixel, sample_index, frame.seed, push.log2_spp),
                      uvec2(pixel.x | pixel.y << 16, sample_index));
}

uvec4 path_bits(PathRandom r, uint dimension) {
    r.numbers.dimension = dimension;
    return sample_bits(r.numbers);
}

// x, y: place in the pixel; z, w: on the lens.
vec4 random_camera(PathRandom r) { return unit_from_bits(path_bits(r, 0u)); }
// As bsdf_sample takes them.
vec4 random_bsdf(PathRandom r, uint vertex) { return unit_from_bits(path_bits(r, 3u * vertex + 1u)); }
// As the samplers of lights.glsl take them.
uvec4 random_light(PathRandom r, uint vertex) { return path_bits(r, 3u * vertex + 2u); }
// x: kind of light; y: Russian roulette; z: channel where colours part.
vec3 random_choices(PathRandom r, uint vertex) { return unit_from_bits(path_bits(r, 3u * vertex + 3u)).xyz; }
// Of a camera ray in a medium: the share of the light that is scattered before.
float random_distance(PathRandom r) { return unit_from_bits(path_bits(r, 3u)).w; }

// Of the ray number `segment` of the path, and (shadow = 1) of the shadow ray from where it ends.
uint path_coverage_seed(PathRandom r, uint segment, uint shadow) {
    return coverage_seed(r.key, 2u * segment + shadow, frame.seed);
}
