// rcas.comp in fp16: a thread does pairs of pixels beside each other, one in each half of its registers. 8-bit codes alone; those for HDR output have as
// many bits as half floats.
#define DITHERED
#include "display_codes.glsl"
#include "post_records.glsl"
#include "half.glsl"

// A group does 2 * 32 x RCAS_HALF_ROWS * 4 pixels; each thread goes down RCAS_HALF_ROWS rows.
layout(local_size_x = 32, local_size_y = 4) in;
layout(push_constant, scalar) uniform Push { RcasPush push; };
layout(set = 2, binding = 0) uniform sampler2D source;
layout(set = 2, binding = 1, rgba8) uniform writeonly image2D target;

const float16_t LIMIT = 0.25hf - 1.0hf / 16.0hf;
// A divisor at least: far below a step of 8 bits.
const float16_t LEAST = 1.0hf / 8192.0hf;

// Two pixels.
struct Pair { f16vec2 r, g, b; };

Pair pair(vec3 left, vec3 right) { return Pair(f16vec2(left.r, right.r), f16vec2(left.g, right.g), f16vec2(left.b, right.b)); }

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
    ivec2 size = imageSize(target), last = size - 1;
    ivec2 p = ivec2(gl_WorkGroupID.xy * gl_WorkGroupSize.xy + gl_LocalInvocationID.xy) * ivec2(2, RCAS_HALF_ROWS);
    if (p.x > last.x || p.y > last.y) return;
    ivec4 x = clamp(p.x + ivec4(-1, 0, 1, 2), 0, last.x);
    ivec2 first = ivec2(x.y, max(p.y - 1, 0));
    Pair above = pair(texelFetch(source, first, 0).rgb, texelFetch(source, ivec2(x.z, first.y), 0).rgb);
    Pair here = pair(texelFetch(source, ivec2(x.y, p.y), 0).rgb, texelFetch(source, ivec2(x.z, p.y), 0).rgb);
    for (int i = 0; i < int(RCAS_HALF_ROWS) && p.y <= last.y; ++i, ++p.y) {
        int down = min(p.y + 1, last.y);
        Pair below = pair(texelFetch(source, ivec2(x.y, down), 0).rgb, texelFetch(source, ivec2(x.z, down), 0).rgb);
        Pair sides = pair(texelFetch(source, ivec2(x.x, p.y), 0).rgb, texelFetch(source, ivec2(x.w, p.y), 0).rgb);
        Pair left = Pair(f16vec2(sides.r.x, here.r.x), f16vec2(sides.g.x, here.g.x), f16vec2(sides.b.x, here.b.x));
        Pair right = Pair(f16vec2(here.r.y, sides.r.y), f16vec2(here.g.y, sides.g.y), f16vec2(here.b.y, sides.b.y));
        Pair code = sharpened(above, left, here, right, below);
        store(vec3(code.r.x, code.g.x, code.b.x), p);
        if (p.x < last.x) store(vec3(code.r.y, code.g.y, code.b.y), p + ivec2(1, 0));
        above = here;
        here = below;
    }
}
