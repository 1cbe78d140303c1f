// Robust contrast-adaptive sharpening of display codes (sRGB or PQ, 0..1): AMD FidelityFX Super Resolution 1, as described in
// Lottes 2021. Included by rcas.comp and rcas_codes.comp, which differ in the format that they store.
//
// The pixel e becomes (e + w (b + d + f + h)) / (1 + 4 w) with its four cross neighbours. w is the most negative at which a
// pixel within the neighbours' range cannot leave 0..1 in any channel, at least -3/16, times push.strength.
#include "display_codes.glsl"
#include "post_records.glsl"

// A group does 32 x 32 pixels, each thread RCAS_ROWS below each other.
layout(local_size_x = 32, local_size_y = 32 / RCAS_ROWS) in;
layout(push_constant, scalar) uniform Push { RcasPush push; };
layout(set = 2, binding = 0) uniform sampler2D source;
layout(set = 2, binding = 1, TARGET_FORMAT) uniform writeonly image2D target;

// At -1/4 the divisor vanishes.
const float LIMIT = 0.25 - 1.0 / 16.0;
const int SIDE = 32;
const int THREADS = SIDE * SIDE / int(RCAS_ROWS);
const int TILE = SIDE + 2;
// Codes as half floats, which is what they are.
shared uvec2 tile[TILE * TILE];

vec3 code_at(int at) { return vec3(unpackHalf2x16(tile[at].x), unpackHalf2x16(tile[at].y).x); }

float luma(vec3 c) { return c.g + 0.5 * (c.r + c.b); }

// The pixel e between b above, d on the left, f on the right and h below.
vec3 sharpened(vec3 b, vec3 d, vec3 e, vec3 f, vec3 h) {
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
    return push.encoding == ENCODING_SCRGB ? REC709_FROM_REC2020 * pq_decode(code) * SCRGB_PER_PQ : code;
}

void main() {
    const int LOADS = (TILE * TILE + THREADS - 1) / THREADS;
    ivec2 size = imageSize(target);
    ivec2 corner = ivec2(gl_WorkGroupID.xy) * SIDE;
    vec3 loaded[LOADS];
    for (int k = 0; k < LOADS; ++k) {
        int i = int(gl_LocalInvocationIndex) + k * THREADS;
        loaded[k] = texelFetch(source, clamp(corner - 1 + ivec2(i % TILE, i / TILE), ivec2(0), size - 1), 0).rgb;
    }
    for (int k = 0; k < LOADS; ++k) {
        int i = int(gl_LocalInvocationIndex) + k * THREADS;
        vec3 code = clamp(loaded[k], 0.0, 1.0);
        if (i < TILE * TILE) tile[i] = uvec2(packHalf2x16(code.rg), packHalf2x16(vec2(code.b, 0.0)));
    }
    barrier();

    ivec2 local = ivec2(gl_LocalInvocationID.xy) * ivec2(1, RCAS_ROWS);
    ivec2 p = corner + local;
    if (p.x >= size.x) return;
    int at = (local.y + 1) * TILE + local.x + 1;
    vec3 above = code_at(at - TILE);
    vec3 here = code_at(at);
    for (int i = 0; i < int(RCAS_ROWS); ++i) {
        vec3 below = code_at(at + TILE);
        if (p.y < size.y) {
            vec3 code = sharpened(above, code_at(at - 1), here, code_at(at + 1), below);
            imageStore(target, p, vec4(store(code, p), 1.0));
        }
        above = here;
        here = below;
        at += TILE;
        ++p.y;
    }
}
