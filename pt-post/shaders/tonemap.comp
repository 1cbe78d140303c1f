// Exposure, tone curve and sRGB encoding of the flat frame: scene radiance to 8-bit display codes.
//
// Per channel: NaN and negative values are black, +infinity is as bright as can be.
#include "channels.glsl"
#include "finite.glsl"
#include "post_records.glsl"

layout(local_size_x = 16, local_size_y = 16) in;
layout(push_constant, scalar) uniform Push { TonemapPush push; };
layout(set = 2, binding = 0, rgba32f) uniform readonly image2D radiance;
layout(set = 2, binding = 1, scalar) readonly buffer exposure { ExposureRecord exposed; };

// Far beyond where every curve is flat to 8 bits, and no square of it overflows.
const float MAX_EXPOSED = 65504.0;

// Narkowicz 2015, "ACES Filmic Tone Mapping Curve".
float aces(float x) { return x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14); }

// Reinhard et al. 2002, "Photographic Tone Reproduction for Digital Images", eq. 3.
float reinhard(float x) { return x / (1.0 + x); }

// IEC 61966-2-1.
float srgb_encode(float x) { return x <= 0.0031308 ? 12.92 * x : 1.055 * pow(x, 1.0 / 2.4) - 0.055; }

float display(float c) {
    if (is_nan(c)) return 0.0;
    float x = clamp(c * exposed.scale, 0.0, MAX_EXPOSED);
    if (push.operator == TONEMAP_ACES) x = aces(x);
    else if (push.operator == TONEMAP_REINHARD) x = reinhard(x);
    // Rounded here: drivers may round to either neighbour when they store.
    return floor(srgb_encode(min(x, 1.0)) * 255.0 + 0.5) / 255.0;
}

void main() {
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(p, imageSize(ch_display)))) return;
    vec3 c = imageLoad(radiance, p).rgb;
    imageStore(ch_display, p, vec4(display(c.r), display(c.g), display(c.b), 1.0));
}
