// rcas.comp in fp16: a thread does two pixels below each other at a time, one in each half of its registers. 8-bit codes alone; those for HDR output
// have as many bits as half floats.
#define DITHERED
#include "display_codes.glsl"
#include "post_records.glsl"
#include "half.glsl"

// A group is a row of threads that go down RCAS_ROWS rows of pixels, RCAS_COLUMNS wide, two at a time.
layout(local_size_x = RCAS_COLUMNS + 2) in;
layout(push_constant, scalar) uniform Push { RcasPush push; };
layout(set = 2, binding = 0) uniform sampler2D source;
layout(set = 2, binding = 1, rgba8) uniform writeonly image2D target;

const float16_t LIMIT = 0.25hf - 1.0hf / 16.0hf;
// A divisor at least: far below a step of 8 bits.
const float16_t LEAST = 1.0hf / 8192.0hf;

// Two pixels, the upper one first.
struct Pair { f16vec2 r, g, b; };

// A pair of each thread; twice: one is read while the next is written.
shared uvec3 pairs[2][RCAS_COLUMNS + 2];

Pair fetch(int x, ivec2 y) {
    vec3 upper = texelFetch(source, ivec2(x, y.x), 0).rgb, lower = texelFetch(source, ivec2(x, y.y), 0).rgb;
    return Pair(f16vec2(upper.r, lower.r), f16vec2(upper.g, lower.g), f16vec2(upper.b, lower.b));
}

Pair unpacked(uvec3 words) { return Pair(unpackFloat2x16(words.x), unpackFloat2x16(words.y), unpackFloat2x16(words.z)); }

// The lower one of the first pair and the upper one of the second.
f16vec2 between(f16vec2 first, f16vec2 second) { return f16vec2(first.y, second.x); }

Pair between(Pair first, Pair second) {
    return Pair(between(first.r, second.r), between(first.g, second.g), between(first.b, second.b));
}

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
    ivec2 corner = ivec2(gl_WorkGroupID.xy) * ivec2(RCAS_COLUMNS, RCAS_ROWS);
    int thread = int(gl_LocalInvocationIndex);
    // The first and the last thread only read.
    ivec2 p = corner + ivec2(thread - 1, 0);
    bool shown = thread > 0 && thread <= int(RCAS_COLUMNS) && p.x < size.x;
    int x = clamp(p.x, 0, last.x);
    Pair above = fetch(x, max(ivec2(p.y - 2, p.y - 1), 0)), here = fetch(x, min(ivec2(p.y, p.y + 1), last.y));
    int end = min(corner.y + int(RCAS_ROWS), size.y);
    for (uint parity = 0u; p.y < end; p.y += 2, parity ^= 1u) {
        Pair below = fetch(x, min(ivec2(p.y + 2, p.y + 3), last.y));
        pairs[parity][thread] = uvec3(packFloat2x16(here.r), packFloat2x16(here.g), packFloat2x16(here.b));
        barrier();
        if (shown) {
            Pair left = unpacked(pairs[parity][thread - 1]), right = unpacked(pairs[parity][thread + 1]);
            Pair code = sharpened(between(above, here), left, here, right, between(here, below));
            store(vec3(code.r.x, code.g.x, code.b.x), p);
            if (p.y < last.y) store(vec3(code.r.y, code.g.y, code.b.y), p + ivec2(0, 1));
        }
        above = here;
        here = below;
    }
}
