// A pixel's sums after many samples: add_sample() of film.glsl.
#include "../../shaders/film.glsl"
#include "rng.glsl"
#include "test_records.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Push { ListPush push; };
layout(set = 2, binding = 0, scalar) writeonly buffer results { FilmPixel result_at[]; };

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= push.count) return;
    FilmPixel pixel = FilmPixel(vec3(0.0), 0u, vec3(0.0), 0u, vec3(0.0), vec3(0.0), uvec2(0u));
    for (uint k = 0u; k < push.per_thread; k++) add_sample(pixel, 4.0 * random4(uvec2(i, k), 0u, 0u).xyz);
    result_at[i] = pixel;
}
