// Included by variance.comp (TEMPORAL 1) and variance_spatial.comp (TEMPORAL 0).
//
// Variance of the luminance of both light channels, into their alpha; -1 = the light is missing. On the flat extent. Schied et al. 2017,
// section 4.2: temporal.comp has estimated it from the moments of the samples; where the history is short, it is replaced by that of the 7 x 7 pixels around.
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
layout(set = 2, binding = 0, rgba32f) uniform image2D im_history_hf_target;
layout(set = 2, binding = 1, rgba32f) uniform image2D im_history_spec_target;
#include "history_code.glsl"
#else
layout(set = 2, binding = 0, rgba32f) uniform writeonly image2D light_hf;
layout(set = 2, binding = 1, rgba32f) uniform writeonly image2D light_spec;
#endif

const int RADIUS = 3;
const ivec2 BLOCK = ivec2(16, 8);
const ivec2 TILE = BLOCK + 2 * RADIUS;
const int THREADS = BLOCK.x * BLOCK.y;
// Normal and distance.
shared vec4 tile_surface[TILE.x * TILE.y];
// steepness(); 0: no surface, or its light is missing.
shared float tile_steep[TILE.x * TILE.y];
shared vec2 tile_luminance[TILE.x * TILE.y];
#if TEMPORAL
// Blocks of the group that have short histories, a bit each. The others need no tile.
shared uint short_blocks;
// Pixels of a block with a short history.
shared uint short_count;
shared uint short_pixels[THREADS];
#endif

int field_width() { return (int(push.size.x) + 1) / 2; }

bool inside(ivec2 pixel) { return all(greaterThanEqual(pixel, ivec2(0))) && all(lessThan(pixel, ivec2(push.size))); }

#if TEMPORAL
// Whether the history is too short for its moments, of each channel. `word`: of im_surface.
bvec2 short_channels(uint word) { return lessThan(uvec2(history_frames(word), specular_frames(word)), uvec2(push.min_length)); }
#endif

LightSample accumulated_light(ivec2 at, bool surface) {
#if TEMPORAL
    bool known = surface && history_frames(imageLoad(im_surface, at).y) > 0u;
    vec3 hf = light_of_history(imageLoad(im_history_hf_target, at)).rgb, spec = light_of_history(imageLoad(im_history_spec_target, at)).rgb;
    return LightSample(hf, spec, known);
#else
    return load_light(at, surface);
#endif
}

// `corner`: first pixel of the block.
void load_tile(ivec2 corner) {
    for (int i = int(gl_LocalInvocationIndex); i < TILE.x * TILE.y; i += THREADS) {
        ivec2 pixel = corner - RADIUS + ivec2(i % TILE.x, i / TILE.x);
        tile_steep[i] = 0.0;
        tile_luminance[i] = vec2(0.0);
        if (!inside(pixel)) continue;
        ivec2 at = flat_to_split(pixel, field_width());
        Guide guide = unpack_guide(imageLoad(im_guide, at));
        LightSample light = accumulated_light(at, guide.normal != 0u);
        if (!light.known) continue;
        tile_surface[i] = vec4(unpack_unit_vector(guide.normal), guide.geometry.x);
        tile_steep[i] = steepness(guide.geometry.y, push.depth);
        tile_luminance[i] = luminances(light);
    }
}

// Unbiased variance of weighted samples. A pixel that nothing resembles may be off by all that it is.
vec2 spatial_variance(int centre) {
    vec4 surface = tile_surface[centre];
    float steep = tile_steep[centre];
    vec2 first = vec2(0.0), second = vec2(0.0), reference = tile_luminance[centre];
    // The centre itself.
    float weights = 1.0, squares = 1.0;
    [[unroll]] for (int y = -RADIUS; y <= RADIUS; ++y) {
        [[unroll]] for (int x = -RADIUS; x <= RADIUS; ++x) {
            if (x == 0 && y == 0) continue;
            int i = centre + y * TILE.x + x;
            vec4 other = tile_surface[i];
            float exponent = LOG2_E * push.normal * turn(surface.xyz, other.xyz)
                - depth_exponent(vec2(surface.w, steep), vec2(other.w, tile_steep[i]), length(vec2(x, y)));
            bool apart = ((x ^ y) & 1) != 0 && min(steep, tile_steep[i]) < 0.0;
            float w = tile_steep[i] == 0.0 || apart ? 0.0 : exp2(exponent);
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

int tile_place(ivec2 local) { return (local.y + RADIUS) * TILE.x + local.x + RADIUS; }

#if TEMPORAL
bool is_short(ivec2 pixel) {
    if (!inside(pixel)) return false;
    uint word = imageLoad(im_surface, flat_to_split(pixel, field_width())).y;
    return history_frames(word) > 0u && any(short_channels(word));
}

// Replaces variances of a block of which short_pixels lists the pixels.
void replace_variance(ivec2 corner) {
    uint number = short_pixels[gl_LocalInvocationIndex];
    ivec2 local = ivec2(number % BLOCK.x, number / BLOCK.x), at = flat_to_split(corner + local, field_width());
    int centre = tile_place(local);
    if (tile_steep[centre] == 0.0) return;
    bvec2 replaced = short_channels(imageLoad(im_surface, at).y);
    vec2 variance = spatial_variance(centre);
    if (replaced.x) imageStore(im_history_hf_target, at, vec4(imageLoad(im_history_hf_target, at).rgb, history_of_variance(variance.x)));
    if (replaced.y) imageStore(im_history_spec_target, at, vec4(imageLoad(im_history_spec_target, at).rgb, history_of_variance(variance.y)));
}

void main() {
    // A group has some blocks, one above the other: where all histories are long it has nothing but this to wait for.
    ivec2 corner = ivec2(gl_WorkGroupID.xy) * BLOCK * ivec2(1, VARIANCE_BLOCKS), local = ivec2(gl_LocalInvocationID.xy);
    uint own = gl_LocalInvocationIndex;
    if (own == 0u) short_blocks = 0u;
    barrier();
    uint blocks = 0u;
    [[unroll]] for (uint i = 0u; i < VARIANCE_BLOCKS; ++i) blocks |= is_short(corner + local + ivec2(0, i * BLOCK.y)) ? 1u << i : 0u;
    if (blocks != 0u) atomicOr(short_blocks, blocks);
    barrier();
    for (uint i = 0u; i < VARIANCE_BLOCKS; ++i, corner.y += BLOCK.y) {
        if ((short_blocks >> i & 1u) == 0u) continue;
        if (own == 0u) short_count = 0u;
        barrier();
        // The first threads take the pixels, so that no more of them than need be wait for each other.
        if ((blocks >> i & 1u) != 0u) short_pixels[atomicAdd(short_count, 1u)] = own;
        load_tile(corner);
        barrier();
        if (own < short_count) replace_variance(corner);
        barrier();
    }
}
#else
void main() {
    ivec2 corner = ivec2(gl_WorkGroupID.xy) * BLOCK, local = ivec2(gl_LocalInvocationID.xy), pixel = corner + local;
    load_tile(corner);
    barrier();
    if (!inside(pixel)) return;
    int centre = tile_place(local);
    LightSample light = LightSample(vec3(0.0), vec3(0.0), false);
    vec2 variance = vec2(-1.0);
    ivec2 at = flat_to_split(pixel, field_width());
    if (tile_steep[centre] != 0.0) {
        light = load_light(at, true);
        variance = spatial_variance(centre);
        if (push.firefly > 0.0) {
            Surroundings around = Surroundings(vec2(0.0), vec2(0.0), 0.0);
            for (int i = 0; i < 9; ++i) {
                int q = centre + (i / 3 - 1) * TILE.x + i % 3 - 1;
                if (i != 4 && tile_steep[q] != 0.0) add(around, tile_luminance[q]);
            }
            vec2 limit = push.firefly * mean(around);
            light.hf = limited(light.hf, limit.x);
            light.spec = limited(light.spec, limit.y);
        }
    }
    imageStore(light_hf, at, vec4(light.hf, variance.x));
    imageStore(light_spec, at, vec4(light.spec, variance.y));
}
#endif
