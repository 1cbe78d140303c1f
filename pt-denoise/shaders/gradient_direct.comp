// How much direct light has changed, beside what the gradient pixels show, whose light samples are those of the last frame: these cannot find a light that
// was dark then. As gradient_lf.comp, of the luminance of both channels against their first moments, without the gradient pixels.
#include "denoise_records.glsl"

layout(local_size_x = 16, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { TemporalPush push; };
#include "antilag.glsl"
#include "light_sample.glsl"
#include "reprojection.glsl"

void main() {
    ivec2 stratum = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(stratum, (ivec2(push.size) + 2) / 3))) return;
    vec4 hf = vec4(0.0), spec = vec4(0.0);
    for (int i = 0; i < 9; ++i) {
        ivec2 pixel = stratum * 3 + ivec2(i % 3, i / 3);
        if (!inside(pixel) || is_repeated(pixel)) continue;
        ivec2 at = flat_to_split(pixel, field_width());
        uint flags = imageLoad(ch_view_direction, at).y;
        uint word = surface_word(at, flags);
        LightSample light = load_light(at, word != 0u);
        if (!light.known) continue;
        Taps taps = find_taps(reproject(pixel, at, word, flags), pixel);
        vec2 before = vec2(0.0);
        float weights = 0.0;
        for (int k = 0; k < 4; ++k) {
            if (taps.weight[k] == 0.0 || imageLoad(im_surface_prev, taps.at[k]).y == 0u) continue;
            before += taps.weight[k] * imageLoad(im_moments_prev, taps.at[k]).xz;
            weights += taps.weight[k];
        }
        if (weights == 0.0) continue;
        before /= weights;
        vec2 now = luminances(light), difference = now - before;
        hf += vec4(now.x, before.x, difference.x * difference.x, 0.0);
        spec += vec4(now.y, before.y, difference.y * difference.y, 0.0);
    }
    imageStore(im_sums_hf, stratum, hf);
    imageStore(im_sums_spec, stratum, spec);
}
