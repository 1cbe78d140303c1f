// Mean of 4 x 4 pixels, on a quarter of the extent rounded up: what the Gaussian bloom blurs. Pixels outside the frame and
// those that are not finite are left out.
#include "finite.glsl"
#include "post_records.glsl"

layout(local_size_x = 16, local_size_y = 16) in;
layout(set = 2, binding = 0) uniform sampler2D source;
layout(set = 2, binding = 1, rgba16f) uniform writeonly image2D target;

const float MAX_HALF = 65504.0;

void main() {
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(p, imageSize(target)))) return;
    ivec2 size = textureSize(source, 0);
    vec3 sum = vec3(0.0);
    float count = 0.0;
    for (int i = 0; i < 16; ++i) {
        ivec2 at = 4 * p + ivec2(i % 4, i / 4);
        if (any(greaterThanEqual(at, size))) continue;
        vec3 c = texelFetch(source, at, 0).rgb;
        if (!is_finite(c)) continue;
        sum += clamp(c, 0.0, MAX_HALF);
        count += 1.0;
    }
    imageStore(target, p, vec4(sum / max(count, 1.0), 1.0));
}
