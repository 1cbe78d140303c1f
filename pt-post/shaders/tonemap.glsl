// Bloom, exposure, tone curve and encoding of scene radiance. Included by tonemap.comp and tonemap_codes.comp, which differ in the
// format that they store: TARGET_FORMAT and store().
//
// Per channel: NaN and negative values are black, +infinity is as bright as can be.
#include "display_codes.glsl"
#include "math.glsl"
#include "post_records.glsl"
#include "tone_curves.glsl"
#include "with_bloom.glsl"

// Fixed when the kernels are made: with all curves at hand the kernel takes 18 % longer (NVIDIA H200).
layout(constant_id = 0) const uint tonemap = TONEMAP_ACES;
layout(constant_id = 1) const uint encoding = ENCODING_SRGB;
// The alpha of `radiance`, which is straight, is that of the picture; otherwise the picture is opaque.
layout(constant_id = 2) const bool with_alpha = false;

layout(local_size_x = 32, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { TonemapPush push; };
layout(set = 2, binding = 1, scalar) readonly buffer exposure { ExposureRecord exposed; };
layout(set = 2, binding = 2, scalar) readonly buffer curve { float values[CURVE_BINS + 1]; };
layout(set = 2, binding = 3, TARGET_FORMAT) uniform writeonly image2D target;

// Far beyond where every curve is flat to 8 bits, and no square of it overflows.
const float MAX_EXPOSED = 65504.0;

// The noise-aware curve at a luminance, in log2 display luminance; beyond its ends it goes on straight, or flat above.
float curve_at(float log_luminance) {
    float x = (log_luminance - float(MIN_LOG_LUMINANCE)) * float(CURVE_BINS_PER_OCTAVE);
    float at = clamp(x, 0.0, float(CURVE_BINS) - 1e-3);
    uint bin = uint(at);
    float value = mix(values[bin], values[bin + 1u], at - float(bin));
    return value + min(x, 0.0) / float(CURVE_BINS_PER_OCTAVE);
}

vec3 noise_aware(vec3 x, bool hdr) {
    float y = luminance(x);
    if (y <= 0.0) return vec3(0.0);
    // A manual exposure moves the curve by as much as it differs from the metered one.
    float shift = push.bias + push.compensation + (push.manual != 0u ? exposed.metered_ev100 - exposed.ev100 : 0.0);
    float curve_luminance = exp2(curve_at(log2(y / exposed.scale)) + shift);
    vec3 curved = x * (curve_luminance / y);
    if (!hdr) curved = bend(curved, push.knee, push.white_point);
    return mix(curved, x * (reinhard_white(y, push.white_point) / y), push.reinhard);
}

vec3 display_value(vec3 x, bool hdr) {
    switch (tonemap) {
        case TONEMAP_REINHARD: return reinhard(x);
        case TONEMAP_ACES: return aces_narkowicz(x);
        case TONEMAP_ACES_HILL: return aces_hill(x);
        case TONEMAP_AGX: return agx(x);
        case TONEMAP_NEUTRAL: return pbr_neutral(x);
        case TONEMAP_NOISE_AWARE: return noise_aware(x, hdr);
        default: return x;
    }
}

vec3 codes(vec3 c) {
    for (int i = 0; i < 3; ++i) c[i] = is_nan(c[i]) ? 0.0 : clamp(c[i] * exposed.scale, 0.0, MAX_EXPOSED);
    bool hdr = encoding != ENCODING_SRGB;
    vec3 shown = max(display_value(c, hdr), 0.0);
    if (!hdr) return srgb_encode(min(shown, 1.0));
    vec3 luminances = min(shown * push.paper_white, push.peak) / 10000.0;
    if (encoding == ENCODING_SCRGB) return luminances * SCRGB_PER_PQ;
    return pq_encode(REC2020_FROM_REC709 * luminances);
}

void main() {
    ivec2 size = imageSize(target);
    ivec2 first = ivec2(gl_GlobalInvocationID.xy) * ivec2(1, TONEMAP_ROWS);
    if (any(greaterThanEqual(first, size))) return;
    // All on their way before the first is needed.
    vec3 c[TONEMAP_ROWS];
    float alpha[TONEMAP_ROWS];
    for (int i = 0; i < int(TONEMAP_ROWS); ++i) {
        ivec2 p = min(first + ivec2(0, i), size - 1);
        vec4 texel = texelFetch(radiance, p, 0);
        alpha[i] = with_alpha ? texel.a : 1.0;
        c[i] = with_bloom(texel.rgb, p, size, push.glow_share);
    }
    for (int i = 0; i < int(TONEMAP_ROWS); ++i) {
        ivec2 p = first + ivec2(0, i);
        if (p.y < size.y) imageStore(target, p, vec4(store(codes(c[i]), p), alpha[i]));
    }
}
