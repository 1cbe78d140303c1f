// Included by recurrent_preblur.comp (RAW 1: from the light of the lighting stages), recurrent_blur_history.comp (HISTORY 1: to the history) and recurrent_blur.comp
// (both 0: from the history).
//
// Blur of both light channels over a disk, on the flat extent: Zhdanov 2021, chapter 49.3. Eight taps on a spiral (Vogel 1979, "A Better Way to Construct the Sunflower
// Head"), turned from pixel to pixel and from frame to frame. The radius is push.radius pixels times
//   h / (h + d)      h: hit distance, d: distance of the surface: contact shadows stay sharp
//   1 / sqrt(n)      n: frames of the history, of which the variance is a share; RAW 0 alone
// and that of specular light at most what the lobe spreads.
#include "denoise_records.glsl"

layout(local_size_x = 16, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { RecurrentPush push; };
#if HISTORY
layout(set = 2, binding = 0, rgba32f) uniform writeonly image2D im_history_hf_target;
layout(set = 2, binding = 1, rgba32f) uniform writeonly image2D im_history_spec_target;
#else
layout(set = 2, binding = 0, rgba32f) uniform writeonly image2D target_hf;
layout(set = 2, binding = 1, rgba32f) uniform writeonly image2D target_spec;
#endif
#include "recurrent.glsl"
#if RAW
#include "light_sample.glsl"
#else
layout(set = 2, binding = 2) uniform sampler2D source_hf;
layout(set = 2, binding = 3) uniform sampler2D source_spec;
#include "history.glsl"
#include "history_code.glsl"
#endif

const int TAPS = 8;
const float GOLDEN_ANGLE = 2.39996323;
const float FARTHEST_HIT = 1e6;

Lights lights_at(ivec2 at, bool surface) {
#if RAW
    LightSample light = load_light(at, surface);
    if (!light.known) return NO_LIGHTS;
    float hf = imageLoad(ch_color_hf, at).a, spec = imageLoad(ch_color_spec, at).a;
    vec2 hits = clamp(vec2(is_finite(vec3(hf)) ? hf : 0.0, is_finite(vec3(spec)) ? spec : 0.0), 0.0, FARTHEST_HIT);
    return Lights(vec4(light.hf, hits.x), vec4(light.spec, hits.y));
#else
    if (!surface) return NO_LIGHTS;
    vec4 hf = texelFetch(source_hf, at, 0), spec = texelFetch(source_spec, at, 0);
#if HISTORY
    return Lights(hf, spec);
#else
    return Lights(light_of_history(hf), light_of_history(spec));
#endif
#endif
}

void store(ivec2 pixel, ivec2 at, vec4 hf, vec4 spec) {
#if HISTORY
    imageStore(im_history_hf_target, at, history_of_light(hf, pixel, DIM_HISTORIES + 5u, push.rounding));
    imageStore(im_history_spec_target, at, history_of_light(spec, pixel, DIM_HISTORIES + 6u, push.rounding));
#else
    imageStore(target_hf, at, hf);
    imageStore(target_spec, at, spec);
#endif
}

// Where nothing was hit, nothing says that the light is near.
float hit_share(float hit, float distance) { return hit > 0.0 ? hit / (hit + max(abs(distance), 1e-6)) : 1.0; }

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (!inside(pixel)) return;
    ivec2 at = flat_to_split(pixel, field_width());
    Guide p = load_guide(at);
    Lights own = lights_at(at, p.normal != 0u);
    if (p.normal == 0u) {
        store(pixel, at, own.hf, own.spec);
        return;
    }
#if RAW
    vec2 frames = vec2(1.0);
    float turn = 0.0;
#else
    uint word = imageLoad(im_surface, at).y;
    vec2 frames = max(vec2(history_frames(word), specular_frames(word)), 1.0);
    float turn = float(history_frames(word) & 63u);
#endif
    vec2 radius = push.radius * inversesqrt(frames) * vec2(hit_share(own.hf.a, p.geometry.x), hit_share(own.spec.a, p.geometry.x));
    float pixel_angle = max(imageLoad(ch_bounce_throughput, at).a, 1e-6);
    float lobe = push.lobe * square(p.geometry.z) * hit_share(own.spec.a, p.geometry.x) / pixel_angle;
    radius.y = min(radius.y, lobe);
    // A pattern of 4 x 4 pixels.
    int place = (pixel.x & 3) * 5 + (pixel.y & 3) * 7;
    float start = GOLDEN_ANGLE * (float(place & 15) + turn);
    Blur hf = Blur(vec4(0.0), 0.0), spec = hf;
    add(hf, own.hf, 1.0);
    add(spec, own.spec, 1.0);
    for (int i = 0; i < TAPS; ++i) {
        float share = (float(i) + 0.5) / float(TAPS), angle = start + GOLDEN_ANGLE * float(i);
        vec2 direction = sqrt(share) * vec2(cos(angle), sin(angle));
        // Both channels have radii of their own.
        for (int c = 0; c < 2; ++c) {
            ivec2 offset = ivec2(round(direction * radius[c]));
            if (offset == ivec2(0) || !inside(pixel + offset)) continue;
            ivec2 other = flat_to_split(pixel + offset, field_width());
            Guide q = load_guide(other);
            if (q.normal == 0u || !same_path(p, q, offset)) continue;
            vec2 weights = surface_weights(p, q, length(vec2(offset)));
            Lights tap = lights_at(other, true);
            // Gaussian of which the disk has two standard deviations.
            float spread = exp(-2.0 * share);
            if (c == 0) add(hf, tap.hf, spread * weights.x);
            else add(spec, tap.spec, spread * weights.y);
        }
    }
    store(pixel, at, mean(hf, own.hf), mean(spec, own.spec));
}
