// Candidates of sampler restir-di and their reuse over time: Bitterli et al. 2020, algorithms 3 and 4; the weights are those of Lin et
// al. 2022 (generalised resampled importance sampling), eq. 20 and section 5. Extent: split frame.
#include "frame.glsl"
#include "reservoir.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { DirectPush push; };

#include "shading_point.glsl"

void store(ivec2 p, Reservoir r) {
    imageStore(im_restir_temporal_point, p, uvec4(reservoir_point(r), 0u, 0u));
    imageStore(im_restir_temporal_weight, p, uvec4(reservoir_weight(r), 0u, 0u));
}

uint pack_material(ShadingPoint s) {
    float f0 = luminance(s.brdf.f0);
    float specular = clamp(f0 / max(f0 + luminance(s.brdf.albedo), 1e-6), 0.0, 0.9);
    return packUnorm2x16(vec2(s.roughness, specular));
}

// Resampling of `ris_candidates` candidates. Their density is the probability of the light alone: the numbers are uniform.
Reservoir draw_candidates(LightContext c, uvec2 key, float xi, out float kept_target) {
    Reservoir r = Reservoir(NONE, 0u, 0.0, push.ris_candidates);
    float sum = 0.0;
    kept_target = 0.0;
    for (uint i = 0u; i < push.ris_candidates; i++) {
        uvec4 bits = random_bits(key, DIM_RIS + i);
        if (push.ris_stratified != 0u) bits.x = bits.x / push.ris_candidates + i * (0xffffffffu / push.ris_candidates);
        float pmf;
        uint light = ris_pick(c, bits, pmf);
        uint numbers = round_numbers(bits);
        float target = sample_target(c, light, numbers, push.kinds);
        if (target <= 0.0 || pmf <= 0.0) continue;
        float weight = target / pmf;
        sum += weight;
        float share = weight / sum;
        if (xi < share) {
            xi /= share;
            r.light = light;
            r.numbers = numbers;
            kept_target = target;
        } else {
            xi = (xi - share) / (1.0 - share);
        }
    }
    if (r.light != NONE) r.weight = sum / (float(push.ris_candidates) * kept_target);
    return r;
}

struct Past {
    Reservoir reservoir; // count 0: none
    LightContext context;
    uint kinds;
};

// The reservoir of the pixel at flat position `at` of the last frame, if it saw the same kind of surface.
bool load_past(ivec2 at, vec3 normal, float depth, uint flags, out Past past) {
    past.reservoir = NO_RESERVOIR;
    if (any(lessThan(at, ivec2(0))) || any(greaterThanEqual(at, ivec2(frame.size)))) return false;
    ivec2 q = flat_to_split(at, int(frame.field_width));
    vec4 position = imageLoad(ch_shading_position_prev, q);
    uvec2 direction = imageLoad(ch_view_direction_prev, q).xy;
    uint other_normal = imageLoad(ch_normal_prev, q).x;
    if (floatBitsToUint(position.w) == 0u || direction.y != flags) return false;
    if (!reusable(normal, unpack_unit_vector(other_normal), depth, imageLoad(ch_view_depth_prev, q).x)) return false;
    uvec2 surface = imageLoad(im_restir_surface_prev, q).xy;
    past.reservoir = make_reservoir(imageLoad(im_restir_history_point_prev, q).xy, imageLoad(im_restir_history_weight_prev, q).xy);
    past.context = make_context(position.xyz, other_normal, direction.x, surface.x, 0u);
    past.kinds = surface.y;
    past.reservoir.count = min(past.reservoir.count, push.restir_history * push.ris_candidates);
    return past.reservoir.count > 0u;
}

// The pixel that the motion points to or, where that shows another surface, the next one in the same row, which is in the other field.
bool find_past(ivec2 p, vec3 normal, uint flags, out Past past) {
    vec4 motion = imageLoad(ch_motion, p);
    vec2 before = vec2(split_to_flat(p, int(frame.field_width))) + 0.5 + motion.xy * vec2(frame.size);
    float depth = imageLoad(ch_view_depth, p).x + motion.z;
    ivec2 at = ivec2(floor(before));
    if (load_past(at, normal, depth, flags, past)) return true;
    at.x += fract(before.x) < 0.5 ? -1 : 1;
    return load_past(at, normal, depth, flags, past);
}

// Weight of a sample of the past in the sum of both, and that of a sample of now, with their targets there and then.
vec2 shares(float now_count, float past_count, float now, float then) {
    float all = now_count + past_count;
    if (push.restir_weights == RESTIR_WEIGHTS_ONE_OVER_M) return vec2(past_count, now_count) / all;
    // Balance heuristic.
    float past = past_count * then / (past_count * then + now_count * now);
    if (push.restir_weights == RESTIR_WEIGHTS_BALANCE) return vec2(past, 1.0 - past);
    // Pairwise, with one neighbour.
    past *= past_count / all;
    return vec2(past, 1.0 - past);
}

Reservoir combine(LightContext c, Reservoir now, float now_target, Past past, float xi) {
    float now_count = float(now.count), past_count = float(past.reservoir.count);
    float now_weight = 0.0, past_weight = 0.0, past_target = 0.0;
    if (now.weight > 0.0) {
        float then = last_target(past.context, now.light, now.numbers, past.kinds);
        now_weight = shares(now_count, past_count, now_target, then).y * now_target * now.weight;
    }
    Reservoir r = past.reservoir;
    if (r.weight > 0.0) {
        past_target = sample_target(c, r.light, r.numbers, push.kinds);
        if (past_target > 0.0) {
            float then = last_target(past.context, r.light, r.numbers, past.kinds);
            past_weight = shares(now_count, past_count, past_target, then).x * past_target * r.weight;
        }
    }
    float sum = now_weight + past_weight;
    bool takes_past = xi * sum < past_weight;
    if (!takes_past) r = now;
    r.weight = sum > 0.0 ? sum / (takes_past ? past_target : now_target) : 0.0;
    r.count = now.count + past.reservoir.count;
    return r;
}

void main() {
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(p, imageSize(im_restir_surface)))) return;
    vec4 position = imageLoad(ch_shading_position, p);
    // Where all lights are dark there is nothing to draw from: no reservoir, so that it does not count when one lights up.
    if (floatBitsToUint(position.w) == 0u || scene.light_tables.local_light_count == 0u) {
        imageStore(im_restir_surface, p, uvec4(0u));
        store(p, NO_RESERVOIR);
        return;
    }
    uint material = pack_material(load_shading_point(p, position));
    imageStore(im_restir_surface, p, uvec4(material, push.kinds, 0u, 0u));
    uvec2 direction = imageLoad(ch_view_direction, p).xy;
    LightContext c = make_context(position.xyz, imageLoad(ch_normal, p).x, direction.x, material, imageLoad(ch_cluster, p).x);
    uvec2 key = imageLoad(ch_rng_seed, p).xy;
    vec4 xi = random_numbers(key, DIM_RESTIR);
    float target;
    Reservoir r = draw_candidates(c, key, xi.x, target);
    Past past;
    if (push.restir_history > 0u && find_past(p, c.normal, direction.y, past)) r = combine(c, r, target, past, xi.y);
    store(p, r);
}
