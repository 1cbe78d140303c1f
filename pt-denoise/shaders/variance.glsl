// Included by variance.comp (TEMPORAL 1) and variance_spatial.comp (TEMPORAL 0).
//
// Variance of the luminance of both light channels, into their alpha; -1 = the light is missing. On the flat extent. Schied et al. 2017,
// section 4.2: temporal.comp has estimated it from the moments of the samples; where the history is short, it is replaced by that of the 7 x 7 pixels around.
// What the a-trous levels need to know of the surface is gathered in one image, which each of them reads.
#include "checkerboard.glsl"
#include "denoise_images.glsl"
#include "denoise_records.glsl"
#include "edge_stopping.glsl"
#include "packed_guide.glsl"
#include "history.glsl"
#include "light_sample.glsl"

layout(local_size_x = 16, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { VariancePush push; };
#if TEMPORAL
// A pixel changes the alpha of its own texel, and reads the colour of the others.
layout(set = 2, binding = 0, rgba32f) uniform image2D light_hf;
layout(set = 2, binding = 1, rgba32f) uniform image2D light_spec;
#else
layout(set = 2, binding = 0, rgba32f) uniform writeonly image2D light_hf;
layout(set = 2, binding = 1, rgba32f) uniform writeonly image2D light_spec;
#endif

const int RADIUS = 3;
const ivec2 TILE = ivec2(16, 8) + 2 * RADIUS;
shared vec2 tile_luminance[TILE.x * TILE.y];
// Missing light has no surface here.
shared vec4 tile_geometry[TILE.x * TILE.y];
shared uint tile_normal[TILE.x * TILE.y];
#if TEMPORAL
// Whether any pixel of the group has a short history; otherwise no tile is needed.
shared uint any_short;
#endif

int field_width() { return (int(push.size.x) + 1) / 2; }

LightSample accumulated_light(ivec2 at, bool surface) {
#if TEMPORAL
    bool known = surface && history_frames(imageLoad(im_surface, at).y) > 0u;
    return LightSample(imageLoad(light_hf, at).rgb, imageLoad(light_spec, at).rgb, known);
#else
    return load_light(at, surface);
#endif
}

void load_tile() {
    ivec2 corner = ivec2(gl_WorkGroupID.xy) * ivec2(16, 8) - RADIUS;
    for (int i = int(gl_LocalInvocationIndex); i < TILE.x * TILE.y; i += 128) {
        ivec2 pixel = corner + ivec2(i % TILE.x, i / TILE.x);
        Guide guide = NO_GUIDE;
        vec2 l = vec2(0.0);
        if (all(greaterThanEqual(pixel, ivec2(0))) && all(lessThan(pixel, ivec2(push.size)))) {
            ivec2 at = flat_to_split(pixel, field_width());
            guide = load_guide(at);
            LightSample light = accumulated_light(at, guide.normal != 0u);
            if (light.known) l = luminances(light);
            else guide = NO_GUIDE;
        }
        tile_luminance[i] = l;
        tile_geometry[i] = guide.geometry;
        tile_normal[i] = guide.normal;
    }
}

Guide guide_at(int i) { return Guide(tile_geometry[i], tile_normal[i]); }

// Unbiased variance of weighted samples. A pixel that nothing resembles may be off by all that it is.
vec2 spatial_variance(int centre) {
    Guide p = guide_at(centre);
    vec2 first = vec2(0.0), second = vec2(0.0), reference = tile_luminance[centre];
    float weights = 0.0, squares = 0.0;
    for (int y = -RADIUS; y <= RADIUS; ++y) {
        for (int x = -RADIUS; x <= RADIUS; ++x) {
            int i = centre + y * TILE.x + x;
            Guide q = guide_at(i);
            ivec2 offset = ivec2(x, y);
            if (q.normal == 0u || !same_path(p, q, offset)) continue;
            float w = 1.0;
            if (offset != ivec2(0)) {
                w = depth_weight(p, q, length(vec2(offset)), push.depth) * pow(normal_cosine(p, q), push.normal);
            }
            // Differences from the centre: squares of the light itself would cancel.
            vec2 d = tile_luminance[i] - reference;
            first += w * d;
            second += w * d * d;
            weights += w;
            squares += w * w;
        }
    }
    float spread = 1.0 - squares / (weights * weights);
    if (spread < 1e-3) return reference * reference;
    first /= weights;
    return max(second / weights - first * first, 0.0) / spread;
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), local = ivec2(gl_LocalInvocationID.xy);
    ivec2 at = flat_to_split(pixel, field_width());
    bool in_picture = all(lessThan(pixel, ivec2(push.size)));
    int centre = (local.y + RADIUS) * TILE.x + local.x + RADIUS;
#if TEMPORAL
    uint word = in_picture ? imageLoad(im_surface, at).y : 0u;
    uvec2 n = uvec2(history_frames(word), specular_frames(word));
    bvec2 is_short = lessThan(n, uvec2(push.min_length));
    if (gl_LocalInvocationIndex == 0u) any_short = 0u;
    barrier();
    if (n.x > 0u && any(is_short)) atomicOr(any_short, 1u);
    barrier();
    if (any_short != 0u) load_tile();
#else
    load_tile();
#endif
    barrier();
    if (!in_picture) return;
    imageStore(im_guide, at, pack_guide(load_guide(at), imageLoad(ch_bounce_throughput, at).a));
#if TEMPORAL
    if (any_short == 0u || !any(is_short) || tile_normal[centre] == 0u) return;
    vec2 variance = spatial_variance(centre);
    if (is_short.x) imageStore(light_hf, at, vec4(imageLoad(light_hf, at).rgb, variance.x));
    if (is_short.y) imageStore(light_spec, at, vec4(imageLoad(light_spec, at).rgb, variance.y));
#else
    LightSample light = LightSample(vec3(0.0), vec3(0.0), false);
    vec2 variance = vec2(-1.0);
    if (tile_normal[centre] != 0u) {
        light = load_light(at, true);
        variance = spatial_variance(centre);
        if (push.firefly > 0.0) {
            Surroundings around = Surroundings(vec2(0.0), vec2(0.0), 0.0);
            for (int i = 0; i < 9; ++i) {
                int q = centre + (i / 3 - 1) * TILE.x + i % 3 - 1;
                if (i != 4 && tile_normal[q] != 0u) add(around, tile_luminance[q]);
            }
            vec2 limit = push.firefly * mean(around);
            light.hf = limited(light.hf, limit.x);
            light.spec = limited(light.spec, limit.y);
        }
    }
    imageStore(light_hf, at, vec4(light.hf, variance.x));
    imageStore(light_spec, at, vec4(light.spec, variance.y));
#endif
}
