// Where effects cover what is behind them, or outshine it, anti-aliasing is to follow their motion. The denoiser, which filters the light of what is
// behind, has followed that. Extent: flat frame.
#include "channels.glsl"
#include "gbuffer_images.glsl"
#include "gbuffer_records.glsl"
#include "checkerboard.glsl"
#include "math.glsl"

layout(local_size_x = 16, local_size_y = 16) in;

// Share of the pixel's light from which on an effect decides on its motion.
const float LEADS = 0.5;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(ch_flat_color);
    if (any(greaterThanEqual(pixel, size))) return;
    vec4 effects = imageLoad(im_effects_motion, flat_to_split(pixel, (size.x + 1) / 2));
    float shown = luminance(imageLoad(ch_flat_color, pixel).rgb);
    if (effects.w >= LEADS || effects.z > 0.0 && effects.z >= LEADS * shown) imageStore(ch_flat_motion, pixel, vec4(effects.xy, 0.0, 0.0));
}
