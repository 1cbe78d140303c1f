// Robust contrast-adaptive sharpening of display codes (sRGB or PQ, 0..1): AMD FidelityFX Super Resolution 1, as described in
// Lottes 2021. Included by rcas.comp and rcas_codes.comp, which differ in the format that they store; rcas_half.comp is the same in fp16.
//
// The pixel e becomes (e + w (b + d + f + h)) / (1 + 4 w) with its four cross neighbours. w is the most negative at which neither it nor any
// pixel within the neighbours' range can leave 0..1 in any channel, at least -3/16, times push.strength.
#include "display_codes.glsl"
#include "post_records.glsl"

// A group is a row of threads that go down RCAS_ROWS rows of pixels, RCAS_COLUMNS wide.
layout(local_size_x = RCAS_COLUMNS + 2) in;
layout(push_constant, scalar) uniform Push { RcasPush push; };
layout(set = 2, binding = 0) uniform sampler2D source;
layout(set = 2, binding = 1, TARGET_FORMAT) uniform writeonly image2D target;

// At -1/4 the divisor vanishes.
const float LIMIT = 0.25 - 1.0 / 16.0;
// A row of codes as half floats, which is what they are; twice: one is read while the next is written.
shared uvec2 row[2][RCAS_COLUMNS + 2];

vec3 unpacked(uvec2 code) { return vec3(unpackHalf2x16(code.x), unpackHalf2x16(code.y).x); }

vec3 code_at(ivec2 at) {
    return clamp(texelFetch(source, clamp(at, ivec2(0), textureSize(source, 0) - 1), 0).rgb, 0.0, 1.0);
}

float luma(vec3 c) { return c.g + 0.5 * (c.r + c.b); }

// The pixel e between b above, d on the left, f on the right and h below.
vec3 sharpened(vec3 b, vec3 d, vec3 e, vec3 f, vec3 h) {
    vec3 low = min(min(b, d), min(f, h));
    vec3 high = max(max(b, d), max(f, h));
    // -w at which the darker of e and low beside four neighbours `high` becomes 0, and the brighter of e and high beside four `low` becomes 1.
    vec3 to_black = min(low, e) / max(4.0 * high, 1e-6);
    vec3 to_white = (1.0 - max(high, e)) / max(4.0 - 4.0 * low, 1e-6);
    vec3 room = min(to_black, to_white);
    float w = -clamp(min(room.r, min(room.g, room.b)), 0.0, LIMIT) * push.strength;
    if (push.denoise != 0u) {
        float mean = 0.25 * (luma(b) + luma(d) + luma(f) + luma(h));
        float range = max(max(luma(b), luma(d)), max(max(luma(f), luma(h)), luma(e)))
                    - min(min(luma(b), luma(d)), min(min(luma(f), luma(h)), luma(e)));
        w *= 1.0 - 0.5 * clamp(abs(mean - luma(e)) / max(range, 1e-6), 0.0, 1.0);
    }
    vec3 code = clamp((e + w * (b + d + f + h)) / (1.0 + 4.0 * w), 0.0, 1.0);
    return push.encoding == ENCODING_SCRGB ? REC709_FROM_REC2020 * pq_decode(code) * SCRGB_PER_PQ : code;
}

void main() {
    ivec2 size = imageSize(target);
    ivec2 corner = ivec2(gl_WorkGroupID.xy) * ivec2(RCAS_COLUMNS, RCAS_ROWS);
    int thread = int(gl_LocalInvocationIndex);
    // The first and the last thread only read.
    ivec2 p = corner + ivec2(thread - 1, 0);
    bool shown = thread > 0 && thread <= int(RCAS_COLUMNS) && p.x < size.x;
    vec3 above = code_at(p - ivec2(0, 1));
    vec3 here = code_at(p);
    vec3 below = code_at(p + ivec2(0, 1));
    int end = min(corner.y + int(RCAS_ROWS), size.y);
    for (; p.y < end; ++p.y) {
        vec3 next = code_at(p + ivec2(0, 2));
        row[p.y & 1][thread] = uvec2(packHalf2x16(here.rg), packHalf2x16(vec2(here.b, 0.0)));
        barrier();
        if (shown) {
            vec3 left = unpacked(row[p.y & 1][thread - 1]);
            vec3 right = unpacked(row[p.y & 1][thread + 1]);
            imageStore(target, p, vec4(store(sharpened(above, left, here, right, below), p), 1.0));
        }
        above = here;
        here = below;
        below = next;
    }
}
