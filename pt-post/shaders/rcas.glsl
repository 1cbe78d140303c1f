// Robust contrast-adaptive sharpening of display codes (sRGB or PQ, 0..1): AMD FidelityFX Super Resolution 1, as described in
// Lottes 2021. Included by rcas.comp and rcas_codes.comp, which differ in the format that they store.
//
// The pixel e becomes (e + w (b + d + f + h)) / (1 + 4 w) with its four cross neighbours. w is the most negative at which a
// pixel within the neighbours' range cannot leave 0..1 in any channel, at least -3/16, times push.strength.
#include "display_codes.glsl"
#include "post_records.glsl"

layout(local_size_x = 16, local_size_y = 16) in;
layout(push_constant, scalar) uniform Push { RcasPush push; };
layout(set = 2, binding = 0) uniform sampler2D source;
layout(set = 2, binding = 1, TARGET_FORMAT) uniform writeonly image2D target;

// At -1/4 the divisor vanishes.
const float LIMIT = 0.25 - 1.0 / 16.0;
const int TILE = 18;
shared vec3 tile[TILE * TILE];

float luma(vec3 c) { return c.g + 0.5 * (c.r + c.b); }

void main() {
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = imageSize(target);
    ivec2 base = ivec2(gl_WorkGroupID.xy) * 16 - 1;
    for (int i = int(gl_LocalInvocationIndex); i < TILE * TILE; i += 256) {
        ivec2 at = clamp(base + ivec2(i % TILE, i / TILE), ivec2(0), size - 1);
        tile[i] = clamp(texelFetch(source, at, 0).rgb, 0.0, 1.0);
    }
    barrier();
    if (any(greaterThanEqual(p, size))) return;

    int at = (int(gl_LocalInvocationID.y) + 1) * TILE + int(gl_LocalInvocationID.x) + 1;
    vec3 b = tile[at - TILE];
    vec3 d = tile[at - 1];
    vec3 e = tile[at];
    vec3 f = tile[at + 1];
    vec3 h = tile[at + TILE];
    vec3 low = min(min(b, d), min(f, h));
    vec3 high = max(max(b, d), max(f, h));
    // -w at which e = low beside four neighbours `high` becomes 0, and e = high beside four `low` becomes 1.
    vec3 to_black = low / max(4.0 * high, 1e-6);
    vec3 to_white = (1.0 - high) / max(4.0 - 4.0 * low, 1e-6);
    vec3 room = min(to_black, to_white);
    float w = -clamp(min(room.r, min(room.g, room.b)), 0.0, LIMIT) * push.strength;
    if (push.denoise != 0u) {
        float mean = 0.25 * (luma(b) + luma(d) + luma(f) + luma(h));
        float range = max(max(luma(b), luma(d)), max(max(luma(f), luma(h)), luma(e)))
                    - min(min(luma(b), luma(d)), min(min(luma(f), luma(h)), luma(e)));
        w *= 1.0 - 0.5 * clamp(abs(mean - luma(e)) / max(range, 1e-6), 0.0, 1.0);
    }
    vec3 code = clamp((e + w * (b + d + f + h)) / (1.0 + 4.0 * w), 0.0, 1.0);
    if (push.encoding == ENCODING_SCRGB) code = REC709_FROM_REC2020 * pq_decode(code) * SCRGB_PER_PQ;
    imageStore(target, p, vec4(store(code, p), 1.0));
}
