// One axis of a Gaussian blur. Weights sum to 1; the edge texels go on outside.
//
// A group blurs 4 lines of 96 texels, whose taps it brings into shared memory, CHUNK of them at a time. Each thread makes
// BLUR_OUTPUTS texels in a row, and so reads a tap once for all of them; an odd number, so that the threads' places lie in different banks.
#include "post_records.glsl"

layout(local_size_x = 32, local_size_y = 4) in;
layout(push_constant, scalar) uniform Push { BlurPush push; };
layout(set = 2, binding = 0) uniform sampler2D source;
layout(set = 2, binding = 1, rgba16f) uniform writeonly image2D target;

const int LINES = 4;
const int THREADS = 32 * LINES;
const int SPAN = 32 * int(BLUR_OUTPUTS);
// Enough for the default blur of 2160 rows at once.
const int CHUNK = 192;
// With 4 more, so that texels beside each other in different lines lie in different banks.
const int WINDOW = SPAN + CHUNK + 4;
// Texels as half floats, which is what they are.
shared uvec2 taps[LINES * WINDOW];
// By distance; 0 beyond the radius.
shared float weights[BLUR_MAX_RADIUS + BLUR_OUTPUTS];

// Along the blurred axis and across it to texel and back.
ivec2 turned(ivec2 v) { return push.vertical != 0u ? v.yx : v; }

void main() {
    int thread = int(gl_LocalInvocationIndex);
    int radius = int(push.radius);
    ivec2 corner = ivec2(gl_WorkGroupID.xy) * ivec2(SPAN, LINES);
    ivec2 last = textureSize(source, 0) - 1;
    for (int i = thread; i < radius + int(BLUR_OUTPUTS); i += THREADS) {
        float x = float(i) / push.sigma;
        weights[i] = i <= radius ? exp(-0.5 * x * x) : 0.0;
    }

    int first = int(BLUR_OUTPUTS * gl_LocalInvocationID.x);
    int window = int(gl_LocalInvocationID.y) * WINDOW + first;
    vec3 sum[BLUR_OUTPUTS];
    // Weights of a tap for the first texel, the second and so on.
    float weight[BLUR_OUTPUTS];
    for (int k = 0; k < int(BLUR_OUTPUTS); ++k) {
        sum[k] = vec3(0.0);
        weight[k] = 0.0;
    }
    float total = 0.0;
    int count = 2 * radius + int(BLUR_OUTPUTS);
    for (int chunk = 0; chunk < count; chunk += CHUNK) {
        int end = min(count - chunk, CHUNK);
        barrier();
        for (int i = thread; i < LINES * (SPAN + end); i += THREADS) {
            ivec2 at = turned(corner + ivec2(chunk + i / LINES - radius, i % LINES));
            vec3 c = texelFetch(source, clamp(at, ivec2(0), last), 0).rgb;
            taps[i % LINES * WINDOW + i / LINES] = uvec2(packHalf2x16(c.rg), packHalf2x16(vec2(c.b, 0.0)));
        }
        barrier();
        for (int i = 0; i < end; ++i) {
            uvec2 bits = taps[window + i];
            vec3 c = vec3(unpackHalf2x16(bits.x), unpackHalf2x16(bits.y).x);
            for (int k = int(BLUR_OUTPUTS) - 1; k > 0; --k) weight[k] = weight[k - 1];
            weight[0] = weights[abs(chunk + i - radius)];
            total += weight[0];
            for (int k = 0; k < int(BLUR_OUTPUTS); ++k) sum[k] += weight[k] * c;
        }
    }
    for (int k = 0; k < int(BLUR_OUTPUTS); ++k) {
        ivec2 p = turned(corner + ivec2(first + k, gl_LocalInvocationID.y));
        if (all(lessThanEqual(p, last))) imageStore(target, p, vec4(sum[k] / total, 1.0));
    }
}
