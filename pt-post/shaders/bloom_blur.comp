// One axis of a Gaussian blur. Two taps are one bilinear fetch between them. Weights sum to 1; the edge texels go on outside.
#include "post_records.glsl"

layout(local_size_x = 16, local_size_y = 16) in;
layout(push_constant, scalar) uniform Push { BlurPush push; };
layout(set = 2, binding = 0) uniform sampler2D source;
layout(set = 2, binding = 1, rgba16f) uniform writeonly image2D target;

float gauss(float x) { return exp(-0.5 * x * x / (push.sigma * push.sigma)); }

void main() {
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(p, imageSize(target)))) return;
    vec2 texel = 1.0 / vec2(textureSize(source, 0));
    vec2 uv = (vec2(p) + 0.5) * texel;
    vec3 sum = texelFetch(source, p, 0).rgb;
    float weights = 1.0;
    for (uint i = 1u; i < push.radius; i += 2u) {
        float a = gauss(float(i));
        float b = gauss(float(i + 1u));
        float weight = a + b;
        vec2 offset = push.axis * texel * (float(i) + b / weight);
        sum += weight * (textureLod(source, uv + offset, 0.0).rgb + textureLod(source, uv - offset, 0.0).rgb);
        weights += 2.0 * weight;
    }
    imageStore(target, p, vec4(sum / weights, 1.0));
}
