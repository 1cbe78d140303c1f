// How much of a history the change of the light makes worthless: Schied, Peters and Dachsbacher 2018, "Gradient Estimation for Real-Time Adaptive
// Temporal Filtering", section 4.3. The kernel declares `push` as TemporalPush and samples `gradients`, which gradient_atrous.comp has
// filtered.
#include "channels.glsl"

// Pixels of the flat frame along a side of a stratum, which has one gradient pixel.
const int STRATUM_SIDE = 3;

vec4 gradient_at(ivec2 pixel) { return texelFetch(gradients, pixel / STRATUM_SIDE, 0); }

// Whether the light of a pixel is the sample of the last frame, taken again.
bool is_repeated(ivec2 pixel) {
    ivec2 within = pixel % STRATUM_SIDE;
    return imageLoad(ch_gradient_sample, pixel / STRATUM_SIDE).x == float(1 + within.y * STRATUM_SIDE + within.x);
}

float relative(float change, float greatest) { return greatest > 0.0 ? clamp(change / greatest, 0.0, 1.0) : 0.0; }

// Of the diffuse and of the specular channel.
vec2 antilag(vec4 g) {
    return min(vec2(push.antilag_hf, push.antilag_spec) * vec2(relative(g.x, g.y), relative(g.z, g.w)), 1.0);
}

// Of indirect diffuse light, whose samples are new ones. x, y: sums of its luma in this frame and in the history; z: variance of their difference.
float antilag_lf(vec4 g) {
    float change = max(abs(g.x - g.y) - push.gate_lf * sqrt(max(g.z, 0.0)), 0.0);
    return min(push.antilag_lf * relative(change, max(g.x, g.y)), 1.0);
}

// Length of a history that is left: n (1 - a)^10, rounded down.
uint kept_frames(uint frames, float lag) {
    float kept = 1.0 - lag, second = kept * kept, fourth = second * second;
    return uint(float(frames) * (fourth * fourth * second));
}
