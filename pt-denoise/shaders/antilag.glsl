// How much of a history the change of the light makes worthless: Schied, Peters and Dachsbacher 2018, "Gradient Estimation for Real-Time Adaptive
// Temporal Filtering", section 4.3. The kernel declares `push` as TemporalPush. Gradients are those that gradient_filter.glsl has filtered.
#include "channels.glsl"
#include "history.glsl"
#include "stratum.glsl"

// Whether the light of a pixel is the sample of the last frame, taken again.
bool is_repeated(ivec2 pixel) { return imageLoad(ch_gradient_sample, pixel / stratum_side).x == gradient_number(pixel); }

float relative(float change, float greatest) { return greatest > 0.0 ? clamp(change / greatest, 0.0, 1.0) : 0.0; }

// Of the diffuse and of the specular channel.
vec2 antilag(vec4 g) {
    return min(vec2(push.antilag_hf, push.antilag_spec) * vec2(relative(g.x, g.y), relative(g.z, g.w)), 1.0);
}

// Of light that is not sampled again. x, y: sums of its luminance in this frame and in the history; z, w: variance of their difference by this frame and by
// the history. `k`: factor.
float antilag_of_sums(vec4 sums, float k) {
    // Of independent changes and noise the squares add up.
    float difference = sums.x - sums.y, noise = push.gate_noise * sqrt(max(max(sums.z, sums.w), 0.0));
    float change = sqrt(max(difference * difference - noise * noise, 0.0));
    return min(k * relative(change, max(sums.x, sums.y)), 1.0);
}
