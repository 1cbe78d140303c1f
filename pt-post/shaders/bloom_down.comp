// One level down in the bloom's chain: Bjorge 2015, "Bandwidth-efficient rendering" (dual filter): the 2 x 2 texels in the
// middle count half, the four diagonal 2 x 2 neighbours an eighth each. Texels that are not finite count as black.
#include "finite.glsl"
#include "post_records.glsl"

layout(local_size_x = 16, local_size_y = 16) in;
layout(set = 2, binding = 0) uniform sampler2D source;
layout(set = 2, binding = 1, rgba16f) uniform writeonly image2D target;

const float MAX_HALF = 65504.0;

// Mean of the 2 x 2 texels from `first` on; the edge texels go on outside.
vec3 box(ivec2 first, ivec2 size) {
    vec3 sum = vec3(0.0);
    for (int i = 0; i < 4; ++i) {
        vec3 c = texelFetch(source, clamp(first + ivec2(i & 1, i >> 1), ivec2(0), size - 1), 0).rgb;
        if (is_finite(c)) sum += clamp(c, 0.0, MAX_HALF);
    }
    return 0.25 * sum;
}

void main() {
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(p, imageSize(target)))) return;
    ivec2 size = textureSize(source, 0);
    ivec2 at = 2 * p;
    vec3 sum = 0.5 * box(at, size);
    sum += 0.125 * (box(at - 1, size) + box(at + ivec2(1, -1), size) + box(at + ivec2(-1, 1), size) + box(at + 1, size));
    imageStore(target, p, vec4(sum, 1.0));
}
