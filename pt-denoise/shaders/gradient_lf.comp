// How much indirect diffuse light has changed. Its samples are not repeated: the sum of its luma over a stratum is compared with that of the
// history. x, y: the sums of this frame and of the history; z: variance of their difference, by which antilag.glsl tells noise from change. Extent:
// strata of 3 x 3 pixels of the flat frame.
#include "denoise_records.glsl"

layout(local_size_x = 16, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { TemporalPush push; };
#include "lf_light.glsl"
#include "reprojection.glsl"

void main() {
    ivec2 stratum = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(stratum, (ivec2(push.size) + 2) / 3))) return;
    vec4 gradient = vec4(0.0);
    for (int i = 0; i < 9; ++i) {
        ivec2 pixel = stratum * 3 + ivec2(i % 3, i / 3);
        if (!inside(pixel)) continue;
        ivec2 at = flat_to_split(pixel, field_width());
        uint flags = imageLoad(ch_view_direction, at).y;
        uint word = surface_word(at, flags);
        ShLight light = ShLight(imageLoad(ch_color_lf_sh, at), imageLoad(ch_color_lf_cocg, at).xy);
        if (word == 0u || !is_light(light)) continue;
        Taps taps = find_taps(reproject(pixel, at, word, flags), pixel);
        float before = 0.0, weights = 0.0;
        for (int k = 0; k < 4; ++k) {
            if (taps.weight[k] == 0.0 || imageLoad(im_history_lf_cocg_prev, taps.at[k]).w == 0.0) continue;
            before += taps.weight[k] * imageLoad(im_history_lf_sh_prev, taps.at[k]).w;
            weights += taps.weight[k];
        }
        if (weights == 0.0) continue;
        before /= weights;
        float difference = light.luma.w - before;
        gradient += vec4(light.luma.w, before, difference * difference, 0.0);
    }
    imageStore(im_sums_lf, stratum, gradient);
}
