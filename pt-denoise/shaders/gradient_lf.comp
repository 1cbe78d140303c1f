// How much indirect diffuse light has changed. Its samples are not repeated: its luma is compared with that of the history. Extent: strata of
// the flat frame.
#include "denoise_records.glsl"

layout(push_constant, scalar) uniform Push { TemporalPush push; };
#include "stratum.glsl"
#include "lf_light.glsl"
#include "reprojection.glsl"
#include "sums.glsl"

shared vec4 terms[GROUP_SIDE * GROUP_SIDE];

vec4 compare(ivec2 pixel) {
    if (!inside(pixel)) return vec4(0.0);
    ivec2 at = flat_to_split(pixel, field_width());
    uint flags = imageLoad(ch_view_direction, at).y;
    uint word = surface_word(at, flags);
    ShLight light = ShLight(imageLoad(ch_color_lf_sh, at), imageLoad(ch_color_lf_cocg, at).xy);
    if (word == 0u || !is_light(light)) return vec4(0.0);
    Taps taps = find_taps(reproject(pixel, at, word, flags), pixel);
    float before = 0.0, second = 0.0, frames = 0.0, weights = 0.0;
    for (int k = 0; k < 4; ++k) {
        if (taps.weight[k] == 0.0) continue;
        vec4 chroma = imageLoad(im_history_lf_cocg_prev, taps.at[k]);
        if (chroma.w < 0.0) continue;
        before += taps.weight[k] * imageLoad(im_history_lf_sh_prev, taps.at[k]).w;
        second += taps.weight[k] * chroma.w;
        frames += taps.weight[k] * chroma.z;
        weights += taps.weight[k];
    }
    if (weights == 0.0) return vec4(0.0);
    return sum_term(light.luma.w, before / weights, second / weights, history_share(frames / weights, push.alpha_lf));
}

void main() {
    terms[gl_LocalInvocationIndex] = compare(ivec2(gl_GlobalInvocationID.xy));
    barrier();
    ivec2 stratum;
    if (!stores_stratum(stratum)) return;
    vec4 sum = vec4(0.0);
    for (int i = 0; i < stratum_side * stratum_side; ++i) sum += terms[thread_of(int(gl_LocalInvocationIndex), i)];
    imageStore(im_sums_lf, stratum, sum);
}
