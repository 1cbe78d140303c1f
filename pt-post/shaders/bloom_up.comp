// One level up in the bloom's chain: Bjorge 2015, "Bandwidth-efficient rendering" (dual filter): eight bilinear taps of the
// lower level round the texel, diagonals twice, mixed into the level's own image. Weights sum to 1.
#include "post_records.glsl"

layout(local_size_x = 16, local_size_y = 16) in;
layout(push_constant, scalar) uniform Push { MixPush push; };
layout(set = 2, binding = 0) uniform sampler2D lower;
layout(set = 2, binding = 1, rgba16f) uniform image2D level;

void main() {
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = imageSize(level);
    if (any(greaterThanEqual(p, size))) return;
    vec2 uv = (vec2(p) + 0.5) / vec2(size);
    vec2 texel = 1.0 / vec2(textureSize(lower, 0));
    vec3 sum = vec3(0.0);
    for (int i = 0; i < 4; ++i) {
        vec2 side = vec2[4](vec2(1, 0), vec2(-1, 0), vec2(0, 1), vec2(0, -1))[i];
        vec2 diagonal = vec2[4](vec2(1, 1), vec2(-1, 1), vec2(1, -1), vec2(-1, -1))[i];
        sum += textureLod(lower, uv + side * texel, 0.0).rgb;
        sum += 2.0 * textureLod(lower, uv + 0.5 * diagonal * texel, 0.0).rgb;
    }
    vec3 own = imageLoad(level, p).rgb;
    imageStore(level, p, vec4(mix(own, sum / 12.0, push.share), 1.0));
}
