// The frame with its bloom: a share of every pixel's light spreads as the blurred image says; the rest stays.
#include "finite.glsl"
#include "post_records.glsl"

layout(local_size_x = 16, local_size_y = 16) in;
layout(push_constant, scalar) uniform Push { MixPush push; };
layout(set = 2, binding = 0) uniform sampler2D source;
layout(set = 2, binding = 1) uniform sampler2D blurred;
layout(set = 2, binding = 2, rgba16f) uniform writeonly image2D target;

const float MAX_HALF = 65504.0;

void main() {
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = imageSize(target);
    if (any(greaterThanEqual(p, size))) return;
    vec3 c = texelFetch(source, p, 0).rgb;
    vec3 glow = textureLod(blurred, (vec2(p) + 0.5) / vec2(size), 0.0).rgb;
    // A pixel that is not finite stays so: the tone map knows what to show for it.
    vec3 mixed = is_finite(c) ? mix(clamp(c, 0.0, MAX_HALF), glow, push.share) : c;
    imageStore(target, p, vec4(mixed, 1.0));
}
