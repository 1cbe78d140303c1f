// How much direct light has changed, beside what the gradient pixels show, whose light samples are those of the last frame: these cannot find a light that
// was dark then. The luminance of both channels is compared with their first moments, without the gradient pixels. Extent: strata.
#include "denoise_records.glsl"

layout(push_constant, scalar) uniform Push { TemporalPush push; };
#include "antilag.glsl"
#include "light_sample.glsl"
#include "reprojection.glsl"
#include "sums.glsl"

shared vec4 terms_hf[GROUP_SIDE * GROUP_SIDE];
shared vec4 terms_spec[GROUP_SIDE * GROUP_SIDE];

void compare(ivec2 pixel, out vec4 hf, out vec4 spec) {
    hf = vec4(0.0);
    spec = vec4(0.0);
    if (!inside(pixel) || is_repeated(pixel)) return;
    ivec2 at = flat_to_split(pixel, field_width());
    uint flags = imageLoad(ch_view_direction, at).y;
    uint word = surface_word(at, flags);
    LightSample light = load_light(at, word != 0u);
    if (!light.known) return;
    Taps taps = find_taps(reproject(pixel, at, word, flags), pixel);
    vec4 moments = vec4(0.0);
    float weights = 0.0, frames = 0.0;
    for (int k = 0; k < 4; ++k) {
        if (taps.weight[k] == 0.0) continue;
        uint n = history_frames(imageLoad(im_surface_prev, taps.at[k]).y);
        if (n == 0u) continue;
        moments += taps.weight[k] * imageLoad(im_moments_prev, taps.at[k]);
        frames += taps.weight[k] * float(n);
        weights += taps.weight[k];
    }
    if (weights == 0.0) return;
    moments /= weights;
    frames /= weights;
    vec2 now = luminances(light);
    hf = sum_term(now.x, moments.x, moments.y, history_share(frames, push.alpha_hf));
    spec = sum_term(now.y, moments.z, moments.w, history_share(frames, push.alpha_spec));
}

void main() {
    vec4 hf, spec;
    compare(ivec2(gl_GlobalInvocationID.xy), hf, spec);
    terms_hf[gl_LocalInvocationIndex] = hf;
    terms_spec[gl_LocalInvocationIndex] = spec;
    barrier();
    ivec2 stratum;
    if (!stores_stratum(stratum)) return;
    hf = vec4(0.0);
    spec = vec4(0.0);
    for (int i = 0; i < stratum_side * stratum_side; ++i) {
        hf += terms_hf[thread_of(int(gl_LocalInvocationIndex), i)];
        spec += terms_spec[thread_of(int(gl_LocalInvocationIndex), i)];
    }
    imageStore(im_sums_hf, stratum, hf);
    imageStore(im_sums_spec, stratum, spec);
}
