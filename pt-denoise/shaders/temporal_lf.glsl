// Included by temporal_lf.comp (ANTILAG 0) and temporal_lf_antilag.comp (ANTILAG 1).
//
// Temporal accumulation of indirect diffuse light, as temporal.glsl does it for the other channels, on the flat extent. The coefficients are
// integrals over directions, so their mean is light again. The history has a length of its own: z of its chroma; w: mean of its
// squared luma, -1 where there is no history.
#include "channels.glsl"
#include "denoise_records.glsl"

layout(local_size_x = 16, local_size_y = 16) in;
layout(push_constant, scalar) uniform Push { TemporalPush push; };
#if ANTILAG
layout(set = 2, binding = 0) uniform sampler2D sums_lf;
#include "antilag.glsl"
#endif
#include "history_code.glsl"
#include "lf_light.glsl"
#include "light_sample.glsl"
#include "reprojection.glsl"

// The group's pixels and one more on each side.
const int TILE = 18;
// Luma; negative: missing.
shared float tile_luma[TILE * TILE];

ShLight light_at(ivec2 at) { return ShLight(imageLoad(ch_color_lf_sh, at), imageLoad(ch_color_lf_cocg, at).xy); }

void load_tile() {
    ivec2 corner = ivec2(gl_WorkGroupID.xy) * 16 - 1;
    for (int i = int(gl_LocalInvocationIndex); i < TILE * TILE; i += 256) {
        ivec2 pixel = corner + ivec2(i % TILE, i / TILE);
        float luma = -1.0;
        if (inside(pixel)) {
            ivec2 at = flat_to_split(pixel, field_width());
            ShLight light = light_at(at);
            if (is_surface(at) && is_light(light)) luma = light.luma.w;
        }
        tile_luma[i] = luma;
    }
}

// Mean luma of the eight pixels around, without the brightest.
float luma_around() {
    ivec2 local = ivec2(gl_LocalInvocationID.xy);
    Surroundings around = Surroundings(vec2(0.0), vec2(0.0), 0.0);
    for (int i = 0; i < 9; ++i) {
        float luma = tile_luma[(local.y + i / 3) * TILE + local.x + i % 3];
        if (i != 4 && luma >= 0.0) add(around, vec2(luma));
    }
    return mean(around).x;
}

void main() {
    // The same for all threads.
    if (push.firefly_lf > 0.0) load_tile();
    barrier();
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (!inside(pixel)) return;
    ivec2 at = flat_to_split(pixel, field_width());
    uint flags = imageLoad(ch_view_direction, at).y;
    uint word = surface_word(at, flags);
    Taps taps = find_taps(reproject(pixel, at, word, flags), pixel);
    ShLight history = NO_LIGHT;
    float weights = 0.0, frames = 0.0, second = 0.0;
    for (int i = 0; i < 4; ++i) {
        if (taps.weight[i] == 0.0) continue;
        vec4 luma = luma_of_history(imageLoad(im_history_lf_sh_prev, taps.at[i]));
        vec4 chroma = chroma_of_history(imageLoad(im_history_lf_cocg_prev, taps.at[i]), luma.w);
        if (chroma.w < 0.0) continue;
        add(history, ShLight(luma, chroma.xy), taps.weight[i]);
        frames += taps.weight[i] * chroma.z;
        second += taps.weight[i] * chroma.w;
        weights += taps.weight[i];
    }
    if (weights > 0.0) {
        scale(history, 1.0 / weights);
        second /= weights;
        frames = max(floor(frames / weights + 0.5), 1.0);
    }
#if ANTILAG
    bool repeated = is_repeated(pixel) && frames > 0.0;
    float lag = antilag_of_sums(texelFetch(sums_lf, pixel / stratum_side, 0), push.antilag_lf);
    frames = float(kept_frames(uint(frames), lag));
#else
    const float lag = 0.0;
    const bool repeated = false;
#endif
    ShLight light = light_at(at);
    if (push.firefly_lf > 0.0 && is_light(light)) {
        float limit = push.firefly_lf * max(luma_around(), history.luma.w);
        if (limit > 0.0 && light.luma.w > limit) scale(light, limit / light.luma.w);
    }
    if (word != 0u && is_light(light) && !(repeated && frames == 0.0)) {
        if (!repeated) frames = min(frames + 1.0, float(push.max_length));
        float alpha = repeated ? 0.0 : max(1.0 / frames, push.alpha_lf);
        alpha = mix(alpha, 1.0, lag);
        history = ShLight(mix(history.luma, light.luma, alpha), mix(history.chroma, light.chroma, alpha));
        second = mix(second, light.luma.w * light.luma.w, alpha);
    }
    vec4 chroma = vec4(history.chroma, frames, frames > 0.0 ? second : -1.0);
    imageStore(im_history_lf_sh, at, history_of_luma(history.luma, pixel, push.rounding));
    imageStore(im_history_lf_cocg, at, history_of_chroma(chroma, history.luma.w, pixel, push.rounding));
}
