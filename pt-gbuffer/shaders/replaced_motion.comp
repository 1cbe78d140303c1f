// Motion of what is seen in curved mirrors and through glass: the place in the last frame that shows the same point. There is no closed form
// for the way through several interfaces, but the last frame's G-buffer says which points its pixels show: Newton's method on them, with their
// differences from pixel to pixel as derivatives, from the place that the motion so far leads to. Where it does not converge the motion stays.
// Extent: split frame.
layout(local_size_x = 16, local_size_y = 8) in;
#include "frame.glsl"
#include "channels.glsl"
#include "checkerboard.glsl"
#include "gbuffer_format.glsl"
#include "random.glsl"
#include "surface.glsl"
#include "gbuffer_records.glsl"

layout(push_constant, scalar) uniform Push { ReplacedMotionPush push; };

const int MAX_STEPS = 8;
// Pixels of one step at most.
const float MAX_STEP = 12.0;
// Lengths of the differences that the place may be away from the texel: what is nearer is between texels that see the same surface.
const float NEAR = 1.5;
// Part of the difference from pixel to pixel by which the point may be off its surface in the last frame.
const float MAX_MISS = 0.25;

// Flat pixels: where a texel was sampled.
vec2 sample_place(ivec2 p, uint frame_index, vec2 jitter) {
    ivec2 flat_pixel = split_to_flat(p, int(frame.field_width));
    if (push.jitter_per_pixel != 0u) {
        uvec2 key = uvec2(uint(flat_pixel.x) | uint(flat_pixel.y) << 16, frame_index);
        jitter = random_numbers(key, DIM_PIXEL).xy - 0.5;
    }
    return vec2(flat_pixel) + 0.5 + jitter;
}

// What a texel of the last frame shows, if it is the instance.
struct Before { bool seen; vec3 position; vec2 place; };

Before seen_before(ivec2 p, int field, uint instance) {
    int width = int(frame.field_width);
    bool inside = p.y >= 0 && p.y < int(frame.size.y) && p.x >= field * width && p.x < (field + 1) * width;
    if (!inside || imageLoad(ch_visibility_prev, p).x != instance) return Before(false, vec3(0.0), vec2(0.0));
    // Gradient pixels show a surface of the frame before that.
    if (imageLoad(ch_rng_seed_prev, p).y + 1u != frame.frame_index) return Before(false, vec3(0.0), vec2(0.0));
    return Before(true, imageLoad(ch_shading_position_prev, p).xyz, sample_place(p, frame.frame_index - 1u, push.jitter_prev));
}

ivec2 nearest_texel(vec2 place, int field) {
    int y = int(floor(place.y));
    float x = 0.5 * (place.x - 0.5 - float((y & 1) ^ field));
    return ivec2(int(floor(x + 0.5)) + field * int(frame.field_width), y);
}

// Moves `place` towards the pixel that shows `point`; false: nothing leads there. `done`: it has arrived.
bool newton_step(inout vec2 place, vec3 point, int field, uint instance, out bool done) {
    done = false;
    ivec2 p = nearest_texel(place, field);
    Before a = seen_before(p, field, instance);
    for (int i = 0; i < 4 && !a.seen; i++) {
        a = seen_before(p + ivec2(i == 0 ? 1 : i == 1 ? -1 : 0, i == 2 ? 1 : i == 3 ? -1 : 0), field, instance);
        if (a.seen) p = nearest_texel(a.place, field);
    }
    Before b = seen_before(p + ivec2(1, 0), field, instance), c = seen_before(p + ivec2(0, 1), field, instance);
    if (!b.seen) b = seen_before(p - ivec2(1, 0), field, instance);
    if (!c.seen) c = seen_before(p - ivec2(0, 1), field, instance);
    if (!a.seen || !b.seen || !c.seen) return false;

    vec3 e1 = b.position - a.position, e2 = c.position - a.position, miss = point - a.position;
    float g11 = dot(e1, e1), g12 = dot(e1, e2), g22 = dot(e2, e2), determinant = g11 * g22 - g12 * g12;
    if (!(determinant > 1e-6 * g11 * g22)) return false;
    vec2 r = vec2(dot(e1, miss), dot(e2, miss));
    vec2 st = vec2(g22 * r.x - g12 * r.y, g11 * r.y - g12 * r.x) / determinant;
    vec2 step = st.x * (b.place - a.place) + st.y * (c.place - a.place);
    step *= min(1.0, MAX_STEP / max(length(step), 1e-6));
    place = a.place + step;
    vec3 off = miss - st.x * e1 - st.y * e2;
    done = all(lessThan(abs(st), vec2(NEAR))) && dot(off, off) < MAX_MISS * MAX_MISS * max(g11, g22);
    return true;
}

void main() {
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (p.x >= 2 * int(frame.field_width) || p.y >= int(frame.size.y)) return;
    uvec2 visible = imageLoad(ch_visibility, p).xy;
    if (visible.x == NONE || imageLoad(ch_view_direction, p).y == FLAG_PRIMARY) return;
    vec4 motion = imageLoad(ch_motion, p);
    vec3 point = previous_position(visible.x, visible.y, imageLoad(ch_barycentrics, p).xy);
    int field = p.x >= int(frame.field_width) ? 1 : 0;
    vec2 here = sample_place(p, frame.frame_index, push.jitter), place = here + motion.xy * vec2(frame.size);
    for (int i = 0; i < MAX_STEPS; i++) {
        bool done;
        if (!newton_step(place, point, field, visible.x, done)) return;
        if (!done) continue;
        imageStore(ch_motion, p, motion_code(vec4((place - here) / vec2(frame.size), motion.zw)));
        return;
    }
}
