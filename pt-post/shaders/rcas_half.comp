// rcas.comp in fp16: a thread does two pixels below each other at a time, one in each half of its registers. 8-bit codes alone; those for HDR output
// have as many bits as half floats.
#define DITHERED
#include "display_codes.glsl"
#include "post_records.glsl"
#include "half.glsl"

layout(local_size_x = 32, local_size_y = 4) in;
layout(push_constant, scalar) uniform Push { RcasPush push; };
layout(set = 2, binding = 0) uniform sampler2D source;
layout(set = 2, binding = 1, rgba8) uniform writeonly image2D target;

const float16_t LIMIT = 0.25hf - 1.0hf / 16.0hf;
// A divisor at least: far below a step of 8 bits.
const float16_t LEAST = 1.0hf / 8192.0hf;

// Two pixels, the upper one first.
struct Pair { f16vec2 r, g, b; };

Pair fetch(int x, ivec2 y) {
    vec3 upper = texelFetch(source, ivec2(x, y.x), 0).rgb, lower = texelFetch(source, ivec2(x, y.y), 0).rgb;
    return Pair(f16vec2(upper.r, lower.r), f16vec2(upper.g, lower.g), f16vec2(upper.b, lower.b));
}

// The pixel above the first of the pair and that first one; the second one and the pixel below it.
Pair from_above(vec3 above, Pair c) { return Pair(f16vec2(above.r, c.r.x), f16vec2(above.g, c.g.x), f16vec2(above.b, c.b.x)); }
Pair to_below(Pair c, vec3 below) { return Pair(f16vec2(c.r.y, below.r), f16vec2(c.g.y, below.g), f16vec2(c.b.y, below.b)); }

f16vec2 luma(Pair c) { return c.g + 0.5hf * (c.r + c.b); }

// -w at the limits of one channel, see rcas.glsl.
f16vec2 room(f16vec2 b, f16vec2 d, f16vec2 e, f16vec2 f, f16vec2 h) {
    f16vec2 low = min(min(b, d), min(f, h)), high = max(max(b, d), max(f, h));
    f16vec2 to_black = min(low, e) * reciprocal(max(4.0hf * high, LEAST));
    f16vec2 to_white = (1.0hf - max(high, e)) * reciprocal(max(4.0hf - 4.0hf * low, LEAST));
    return min(to_black, to_white);
}

// The sum of the neighbours less four times the pixel.
f16vec2 around(f16vec2 b, f16vec2 d, f16vec2 e, f16vec2 f, f16vec2 h) { return (b - e) + (h - e) + ((d - e) + (f - e)); }

Pair sharpened(Pair b, Pair d, Pair e, Pair f, Pair h) {
    f16vec2 least = min(room(b.r, d.r, e.r, f.r, h.r), min(room(b.g, d.g, e.g, f.g, h.g), room(b.b, d.b, e.b, f.b, h.b)));
    f16vec2 w = -clamp(least, 0.0hf, LIMIT) * float16_t(push.strength);
    if (push.denoise != 0u) {
        f16vec2 up = luma(b), left = luma(d), here = luma(e), right = luma(f), down = luma(h);
        f16vec2 mean = 0.25hf * (up + left + right + down);
        f16vec2 range = max(max(max(up, left), max(right, down)), here) - min(min(min(up, left), min(right, down)), here);
        w *= 1.0hf - 0.5hf * clamp(abs(mean - here) * reciprocal(max(range, LEAST)), 0.0hf, 1.0hf);
    }
    // (e + w (b + d + f + h)) / (1 + 4 w) as a change of e: half floats then keep flat ground as it is.
    f16vec2 change = w * reciprocal(1.0hf + 4.0hf * w);
    return Pair(e.r + change * around(b.r, d.r, e.r, f.r, h.r), e.g + change * around(b.g, d.g, e.g, f.g, h.g),
                e.b + change * around(b.b, d.b, e.b, f.b, h.b));
}

void store(vec3 code, ivec2 p) { imageStore(target, p, vec4(to_8_bits(code, p, push.dither != 0u), 1.0)); }

void main() {
    ivec2 last = imageSize(target) - 1;
    ivec2 p = ivec2(gl_GlobalInvocationID.xy) * ivec2(1, 2);
    if (any(greaterThan(p, last))) return;
    ivec2 y = ivec2(p.y, min(p.y + 1, last.y));
    Pair here = fetch(p.x, y), left = fetch(max(p.x - 1, 0), y), right = fetch(min(p.x + 1, last.x), y);
    vec3 above = texelFetch(source, ivec2(p.x, max(p.y - 1, 0)), 0).rgb, below = texelFetch(source, ivec2(p.x, min(p.y + 2, last.y)), 0).rgb;
    Pair code = sharpened(from_above(above, here), left, here, right, to_below(here, below));
    store(vec3(code.r.x, code.g.x, code.b.x), p);
    if (p.y < last.y) store(vec3(code.r.y, code.g.y, code.b.y), p + ivec2(0, 1));
}
