// Samples of `reuse=restir-gi` and their reuse over time, of one pixel: Ouyang et al. 2021, section 4.2, with the balance heuristic as the weights of multiple
// importance sampling (Lin et al. 2022, eq. 22). A kernel that includes this defines sees() before.
#include "bsdf/shading_normal.glsl"
#include "surface.glsl"

void store(ivec2 p, Reservoir r) {
    imageStore(im_reuse_point, p, reservoir_point(r));
    imageStore(im_reuse_light, p, reservoir_light(r));
}

// Normals of the triangle and of shading, on the viewer's side, as the first ray was drawn with.
uvec2 surface_normals(ivec2 p) {
    uvec2 visible = imageLoad(ch_visibility, p).xy;
    Surface s = load_surface(visible.x, visible.y, imageLoad(ch_barycentrics, p).xy);
    vec3 wo = -unpack_unit_vector(imageLoad(ch_view_direction, p).x);
    vec3 face_normal = dot(s.face_normal, wo) >= 0.0 ? s.face_normal : -s.face_normal;
    vec3 normal = bend_normal(unpack_unit_vector(imageLoad(ch_normal, p).x), face_normal, wo);
    return uvec2(pack_unit_vector(face_normal), pack_unit_vector(normal));
}

// Light that its own path alone brings to a surface stays among `lights`.
void give_back(uint index, vec4 reusable) {
    if (max_component(reusable.rgb) <= 0.0) return;
    store_light(index, load_light(index) + vec4(reusable.rgb, 0.0));
    store_reusable(index, vec4(vec3(0.0), reusable.w));
}

// The sample of the pixel's own path; without light it has the weight 0, but it counts.
Reservoir own_sample(uint index, ReuseSurface s, vec4 path) {
    Reservoir r = NO_RESERVOIR;
    r.count = 1u;
    if (!(path.w > 0.0 && max_component(path.rgb) > 0.0)) return r;
    uvec4 point = RowTable(bounce_tables().points).at[index];
    vec3 light = push.clamp > 0.0 ? min(path.rgb, vec3(push.clamp)) : path.rgb;
    uvec4 words = uvec4(pack_light(light), 0u, 0u);
    r = make_reservoir(point, words);
    r.count = 1u;
    r.least_cosine = uintBitsToFloat(RowTable(bounce_tables().shares).at[index].w);
    if (geometric_target(s, r) <= 0.0) {
        give_back(index, path);
        r.light = vec3(0.0);
        return r;
    }
    vec3 way = r.position - s.position;
    float squared = dot(way, way);
    r.weight = 1.0 / (path.w * area_to_solid_angle(-dot(r.normal, way) * inversesqrt(squared), squared));
    return r;
}

// Frames that the past counts at most.
uint most_history() { return push.restir_counts & 0xffffu; }

struct Past {
    Reservoir reservoir;
    ReuseSurface surface;
};

// The reservoir of the pixel at flat position `at` of the last frame, if it saw the same kind of surface. `depth`: of the pixel's own, then.
bool load_past(ivec2 at, ReuseSurface s, float depth, uint flags, out Past past) {
    past.reservoir = NO_RESERVOIR;
    if (any(lessThan(at, ivec2(0))) || any(greaterThanEqual(at, ivec2(frame.size)))) return false;
    ivec2 q = flat_to_split(at, int(frame.field_width));
    uvec2 normals = imageLoad(im_reuse_surface_prev, q).xy;
    if (normals.x == 0u || imageLoad(ch_view_direction_prev, q).y != flags) return false;
    past.surface = make_surface(imageLoad(ch_shading_position_prev, q).xyz, imageLoad(ch_view_depth_prev, q).x, normals);
    if (!reusable(s, depth, past.surface)) return false;
    past.reservoir = make_reservoir(imageLoad(im_reuse_point_prev, q), imageLoad(im_reuse_light_prev, q));
    past.reservoir.count = min(past.reservoir.count, most_history());
    return true;
}

// The pixel that the motion points to or, where that shows another surface, the next one in the same row, which is in the other field.
bool find_past(ivec2 p, ReuseSurface s, out Past past) {
    vec4 motion = imageLoad(ch_motion, p);
    vec2 before = vec2(split_to_flat(p, int(frame.field_width))) + 0.5 + motion.xy * vec2(frame.size);
    float depth = s.depth + motion.z;
    uint flags = imageLoad(ch_view_direction, p).y;
    ivec2 at = ivec2(floor(before));
    if (load_past(at, s, depth, flags, past)) return true;
    at.x += fract(before.x) < 0.5 ? -1 : 1;
    return load_past(at, s, depth, flags, past);
}

// Weight of a sample in multiple importance sampling, times its target at the pixel without the luminance, for a technique with `count` samples and `own`
// there against the other one.
float balanced(float target, float count, float own, float other_count, float other) {
    float sum = count * own + other_count * other;
    return sum > 0.0 ? count * own / sum * target : 0.0;
}

Reservoir combine(ivec2 p, ReuseSurface s, Reservoir now, Past past, float xi) {
    float now_count = float(now.count), past_count = float(past.reservoir.count);
    float now_weight = 0.0, past_weight = 0.0, now_target = 0.0, past_target = 0.0;
    if (now.weight > 0.0) {
        now_target = geometric_target(s, now);
        float then = geometric_target(past.surface, now);
        if (then > 0.0 && !sees(p, past.surface, now)) then = 0.0;
        now_weight = balanced(now_target, now_count, now_target, past_count, then) * luminance(now.light) * now.weight;
    }
    Reservoir r = past.reservoir;
    if (r.weight > 0.0) {
        past_target = geometric_target(s, r);
        if (past_target > 0.0 && sees(p, s, r)) {
            float then = geometric_target(past.surface, r);
            past_weight = balanced(past_target, past_count, then, now_count, past_target) * luminance(r.light) * r.weight;
        }
    }
    float sum = now_weight + past_weight;
    bool takes_past = xi * sum < past_weight;
    if (!takes_past) r = now;
    r.weight = sum > 0.0 ? sum / ((takes_past ? past_target : now_target) * luminance(r.light)) : 0.0;
    r.count = now.count + past.reservoir.count;
    return r;
}

void reuse_over_time(ivec2 p) {
    uint index = path_index(uvec2(p));
    vec4 path = load_reusable(index);
    if (path.w < 0.0) {
        give_back(index, path);
        imageStore(im_reuse_surface, p, uvec4(0u));
        store(p, NO_RESERVOIR);
        return;
    }
    uvec2 normals = surface_normals(p);
    imageStore(im_reuse_surface, p, uvec4(normals, 0u, 0u));
    ReuseSurface s = make_surface(imageLoad(ch_shading_position, p).xyz, imageLoad(ch_view_depth, p).x, normals);
    Reservoir r = own_sample(index, s, path);
    Past past;
    if (most_history() > 0u && find_past(p, s, past)) {
        r = combine(p, s, r, past, random_numbers(imageLoad(ch_rng_seed, p).xy, DIM_REUSE).x);
    }
    store(p, r);
}
