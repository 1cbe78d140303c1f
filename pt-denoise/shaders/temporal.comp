// Temporal accumulation of both light channels, on the flat extent: Schied et al. 2017, "Spatiotemporal Variance-Guided Filtering",
// section 4.1. History is taken from the four pixels round the place where the surface was, in whichever checkerboard field they lie; each
// of them is tested by itself. How many samples a pixel holds is a whole number of its own: black light never means "no history".
#include "channels.glsl"
#include "checkerboard.glsl"
#include "denoise_images.glsl"
#include "denoise_records.glsl"
#include "light_sample.glsl"
#include "pack.glsl"

layout(local_size_x = 16, local_size_y = 16) in;
layout(push_constant, scalar) uniform Push { TemporalPush push; };
layout(set = 2, binding = 0, rgba32f) uniform writeonly image2D target_hf;
layout(set = 2, binding = 1, rgba32f) uniform writeonly image2D target_spec;

// The group's pixels and one more on each side.
const int TILE = 18;
// Of both channels; negative: missing.
shared vec2 tile_luminance[TILE * TILE];

struct History { vec3 hf; vec3 spec; vec4 moments; uint frames; };

bool inside(ivec2 at) { return all(greaterThanEqual(at, ivec2(0))) && all(lessThan(at, ivec2(push.size))); }

bool is_surface(ivec2 at) { return floatBitsToUint(imageLoad(ch_shading_position, at).w) != 0u; }

int field_width() { return (int(push.size.x) + 1) / 2; }

// What identifies the surface and its path; 0 = none. Materials beyond 2^29 would only share numbers.
uint surface_word(ivec2 at, uint flags) {
    uint material = floatBitsToUint(imageLoad(ch_shading_position, at).w);
    return material == 0u ? 0u : max(material << 3 | flags, 1u);
}

History history_at(ivec2 pixel, ivec2 at, uint word, bool two_paths) {
    History none = History(vec3(0.0), vec3(0.0), vec4(0.0), 0u);
    vec4 motion = imageLoad(ch_motion, at);
    if (push.reset != 0u || !is_finite(motion.xyz)) return none;
    vec2 place = vec2(pixel) + motion.xy * vec2(push.size);
    // Far outside, where an integer could overflow.
    if (any(greaterThan(abs(place), vec2(1e6)))) return none;
    float depth = imageLoad(ch_view_depth, at).x + motion.z;
    float tolerance = push.depth * abs(depth) + 2.0 / max(motion.w, 1e-18);
    vec3 normal = unpack_unit_vector(imageLoad(ch_vertex_normal, at).x);
    ivec2 corner = ivec2(floor(place));
    vec2 f = place - vec2(corner);

    History sum = none;
    float frames_sum = 0.0, weights = 0.0;
    for (int i = 0; i < 4; ++i) {
        ivec2 offset = ivec2(i & 1, i >> 1), tap = corner + offset;
        float weight = (offset.x == 1 ? f.x : 1.0 - f.x) * (offset.y == 1 ? f.y : 1.0 - f.y);
        if (weight < 1e-3 || !inside(tap)) continue;
        if (two_paths && ((tap.x ^ tap.y ^ pixel.x ^ pixel.y) & 1) != 0) continue;
        ivec2 from = flat_to_split(tap, field_width());
        uvec2 was = imageLoad(im_surface_prev, from).xy;
        if (was.x != word || was.y == 0u) continue;
        if (!(abs(imageLoad(ch_view_depth_prev, from).x - depth) <= tolerance)) continue;
        if (dot(unpack_unit_vector(imageLoad(ch_vertex_normal_prev, from).x), normal) < push.normal) continue;
        sum.hf += weight * imageLoad(im_history_hf_prev, from).rgb;
        sum.spec += weight * imageLoad(im_history_spec_prev, from).rgb;
        sum.moments += weight * imageLoad(im_moments_prev, from);
        frames_sum += weight * float(was.y);
        weights += weight;
    }
    if (weights == 0.0) return none;
    float scale = 1.0 / weights;
    return History(sum.hf * scale, sum.spec * scale, sum.moments * scale, max(uint(frames_sum * scale + 0.5), 1u));
}

void load_tile() {
    ivec2 corner = ivec2(gl_WorkGroupID.xy) * 16 - 1;
    for (int i = int(gl_LocalInvocationIndex); i < TILE * TILE; i += 256) {
        ivec2 pixel = corner + ivec2(i % TILE, i / TILE);
        vec2 l = vec2(-1.0);
        if (inside(pixel)) {
            ivec2 at = flat_to_split(pixel, field_width());
            LightSample light = load_light(at, is_surface(at));
            if (light.known) l = luminances(light);
        }
        tile_luminance[i] = l;
    }
}

void main() {
    load_tile();
    barrier();
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (!inside(pixel)) return;
    ivec2 at = flat_to_split(pixel, field_width());
    uint flags = imageLoad(ch_view_direction, at).y;
    uint word = surface_word(at, flags);
    LightSample light = load_light(at, word != 0u);
    History history = History(vec3(0.0), vec3(0.0), vec4(0.0), 0u);
    if (word != 0u) history = history_at(pixel, at, word, bitCount(flags) > 1);

    if (light.known && push.firefly > 0.0) {
        Surroundings around = Surroundings(vec2(0.0), vec2(0.0), 0.0);
        ivec2 local = ivec2(gl_LocalInvocationID.xy);
        for (int i = 0; i < 9; ++i) {
            vec2 l = tile_luminance[(local.y + i / 3) * TILE + local.x + i % 3];
            if (i != 4 && l.x >= 0.0) add(around, l);
        }
        vec2 limit = push.firefly * max(mean(around), history.moments.xz);
        light.hf = limited(light.hf, limit.x);
        light.spec = limited(light.spec, limit.y);
    }
    if (light.known) {
        vec2 l = luminances(light);
        history.frames = min(history.frames + 1u, push.max_length);
        float share = 1.0 / float(history.frames);
        history.hf = mix(history.hf, light.hf, max(share, push.alpha_hf));
        history.spec = mix(history.spec, light.spec, max(share, push.alpha_spec));
        history.moments = mix(history.moments, vec4(l.x, l.x * l.x, l.y, l.y * l.y), max(share, push.alpha_moments));
    }
    imageStore(im_surface, at, uvec4(word, history.frames, 0u, 0u));
    imageStore(im_moments, at, history.moments);
    imageStore(target_hf, at, vec4(history.hf, 0.0));
    imageStore(target_spec, at, vec4(history.spec, 0.0));
}
