// The frame with its bloom, as an image.
#include "post_records.glsl"
#include "with_bloom.glsl"

layout(local_size_x = 16, local_size_y = 16) in;
layout(push_constant, scalar) uniform Push { MixPush push; };
layout(set = 2, binding = 1, rgba16f) uniform writeonly image2D target;

void main() {
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = imageSize(target);
    if (any(greaterThanEqual(p, size))) return;
    imageStore(target, p, vec4(with_bloom(texelFetch(radiance, p, 0).rgb, p, size, push.share), 1.0));
}
