// Included by temporal.comp (ANTILAG 0) and temporal_antilag.comp (ANTILAG 1).
//
// Temporal accumulation of both light channels, on the flat extent: Schied et al. 2017, "Spatiotemporal Variance-Guided Filtering",
// section 4.1. History is taken from the four pixels round the place where the surface was, in whichever checkerboard field they lie; each
// of them is tested by itself. How many samples a pixel holds is a whole number of its own: black light never means "no history".
#include "channels.glsl"
#include "denoise_records.glsl"

layout(local_size_x = 16, local_size_y = 16) in;
layout(push_constant, scalar) uniform Push { TemporalPush push; };
layout(set = 2, binding = 0, rgba32f) uniform writeonly image2D target_hf;
layout(set = 2, binding = 1, rgba32f) uniform writeonly image2D target_spec;
#if ANTILAG
layout(set = 2, binding = 2) uniform sampler2D gradients;
layout(set = 2, binding = 3) uniform sampler2D sums_hf;
layout(set = 2, binding = 4) uniform sampler2D sums_spec;
#include "antilag.glsl"
#endif
#include "light_sample.glsl"
#include "reprojection.glsl"

// The group's pixels and one more on each side.
const int TILE = 18;
// Of both channels; negative: missing.
shared vec2 tile_luminance[TILE * TILE];

struct History { vec3 hf; vec3 spec; vec4 moments; uint frames; };

const History NO_HISTORY = History(vec3(0.0), vec3(0.0), vec4(0.0), 0u);

History history_at(Taps taps) {
    History sum = NO_HISTORY;
    float frames_sum = 0.0, weights = 0.0;
    for (int i = 0; i < 4; ++i) {
        if (taps.weight[i] == 0.0) continue;
        ivec2 from = taps.at[i];
        uint frames = imageLoad(im_surface_prev, from).y;
        if (frames == 0u) continue;
        float weight = taps.weight[i];
        sum.hf += weight * imageLoad(im_history_hf_prev, from).rgb;
        sum.spec += weight * imageLoad(im_history_spec_prev, from).rgb;
        sum.moments += weight * imageLoad(im_moments_prev, from);
        frames_sum += weight * float(frames);
        weights += weight;
    }
    if (weights == 0.0) return NO_HISTORY;
    float scale = 1.0 / weights;
    return History(sum.hf * scale, sum.spec * scale, sum.moments * scale, max(uint(frames_sum * scale + 0.5), 1u));
}

void load_tile() {
    ivec2 corner = ivec2(gl_WorkGroupID.xy) * 16 - 1;
    for (int i = int(gl_LocalInvocationIndex); i < TILE * TILE; i += 256) {
        ivec2 pixel = corner + ivec2(i % TILE, i / TILE);
        vec2 l = vec2(-1.0);
        if (inside(pixel)) {
            ivec2 at = flat_to_split(pixel, field_width());
            LightSample light = load_light(at, is_surface(at));
            if (light.known) l = luminances(light);
        }
        tile_luminance[i] = l;
    }
}

void main() {
    load_tile();
    barrier();
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (!inside(pixel)) return;
    ivec2 at = flat_to_split(pixel, field_width());
    uint flags = imageLoad(ch_view_direction, at).y;
    uint word = surface_word(at, flags);
    LightSample light = load_light(at, word != 0u);
    History history = history_at(find_taps(reproject(pixel, at, word, flags), pixel));
#if ANTILAG
    // The sample of a gradient pixel is in the history already. Where all of that is forgotten the light is missing: it is that of the pixels around.
    bool repeated = is_repeated(pixel) && history.frames > 0u;
    ivec2 stratum = pixel / STRATUM_SIDE;
    vec2 lag = antilag(texelFetch(gradients, stratum, 0));
    lag.x = max(lag.x, antilag_of_sums(texelFetch(sums_hf, stratum, 0), push.antilag_hf));
    lag.y = max(lag.y, antilag_of_sums(texelFetch(sums_spec, stratum, 0), push.antilag_spec));
    history.frames = kept_frames(history.frames, max(lag.x, lag.y));
    if (repeated && history.frames == 0u) light.known = false;
#else
    const vec2 lag = vec2(0.0);
    const bool repeated = false;
#endif

    if (light.known && push.firefly > 0.0) {
        Surroundings around = Surroundings(vec2(0.0), vec2(0.0), 0.0);
        ivec2 local = ivec2(gl_LocalInvocationID.xy);
        for (int i = 0; i < 9; ++i) {
            vec2 l = tile_luminance[(local.y + i / 3) * TILE + local.x + i % 3];
            if (i != 4 && l.x >= 0.0) add(around, l);
        }
        vec2 limit = push.firefly * max(mean(around), history.moments.xz);
        light.hf = limited(light.hf, limit.x);
        light.spec = limited(light.spec, limit.y);
    }
    if (light.known) {
        vec2 l = luminances(light);
        if (!repeated) history.frames = min(history.frames + 1u, push.max_length);
        float share = repeated ? 0.0 : 1.0 / float(history.frames);
        vec3 least = repeated ? vec3(0.0) : vec3(push.alpha_hf, push.alpha_spec, push.alpha_moments);
        vec3 alpha = mix(max(vec3(share), least), vec3(1.0), vec3(lag, max(lag.x, lag.y)));
        history.hf = mix(history.hf, light.hf, alpha.x);
        history.spec = mix(history.spec, light.spec, alpha.y);
        history.moments = mix(history.moments, vec4(l.x, l.x * l.x, l.y, l.y * l.y), alpha.z);
    }
    imageStore(im_surface, at, uvec4(word, history.frames, 0u, 0u));
    imageStore(im_moments, at, history.moments);
    imageStore(target_hf, at, vec4(history.hf, 0.0));
    imageStore(target_spec, at, vec4(history.spec, 0.0));
}
