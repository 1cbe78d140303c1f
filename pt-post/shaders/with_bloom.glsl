// A pixel of the frame with its bloom: a share of its light spreads as the blurred image says; the rest stays.
#include "finite.glsl"

layout(set = 2, binding = 0) uniform sampler2D radiance;
layout(set = 2, binding = 5) uniform sampler2D glow;

const float MAX_HALF = 65504.0;

vec3 with_bloom(vec3 c, ivec2 p, ivec2 size, float share) {
    // A pixel that is not finite stays so: the tone map knows what to show for it.
    if (share == 0.0 || !is_finite(c)) return c;
    return mix(clamp(c, 0.0, MAX_HALF), textureLod(glow, (vec2(p) + 0.5) / vec2(size), 0.0).rgb, share);
}
