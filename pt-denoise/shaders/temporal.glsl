// Included by temporal.comp and its forms: ANTILAG 1: history follows changes of the light. VIRTUAL 1: specular history follows mirror images. SOURCE 1: the light comes
// from a filter, with hit distances in alpha, and so does the history.
//
// Temporal accumulation of both light channels, on the flat extent: Schied et al. 2017, "Spatiotemporal Variance-Guided Filtering",
// section 4.1. History is taken from the four pixels round the place where the surface was, in whichever checkerboard field they lie; each
// of them is tested by itself. How many samples a pixel holds is a whole number of its own: black light never means "no history".
#include "channels.glsl"
#include "denoise_records.glsl"

layout(local_size_x = 16, local_size_y = 16) in;
layout(push_constant, scalar) uniform Push { TemporalPush push; };
// Histories, or what has their format.
layout(set = 2, binding = 0, rgba32f) uniform writeonly image2D im_history_hf_target;
layout(set = 2, binding = 1, rgba32f) uniform writeonly image2D im_history_spec_target;
#include "history.glsl"
#include "history_code.glsl"
#if ANTILAG
layout(set = 2, binding = 2) uniform sampler2D gradients;
layout(set = 2, binding = 3) uniform sampler2D sums_hf;
layout(set = 2, binding = 4) uniform sampler2D sums_spec;
#include "antilag.glsl"
#endif
#if SOURCE
layout(set = 2, binding = 5) uniform sampler2D source_hf;
layout(set = 2, binding = 6) uniform sampler2D source_spec;
#endif
#include "light_sample.glsl"
#include "reprojection.glsl"
#if VIRTUAL
#include "virtual_motion.glsl"
#endif

// The group's pixels and one more on each side.
const int TILE = 18;
// Of both channels; negative: missing.
shared vec2 tile_luminance[TILE * TILE];
#if VIRTUAL
// Hit distance of specular light; 0: none.
shared float tile_hit[TILE * TILE];
#endif

LightSample sample_at(ivec2 at, bool surface) {
#if SOURCE
    vec3 hf = texelFetch(source_hf, at, 0).rgb, spec = texelFetch(source_spec, at, 0).rgb;
    // What the filter before has filled in is known, too; it marks what is not.
    return LightSample(hf, spec, surface && is_light(hf) && is_light(spec) && texelFetch(source_hf, at, 0).a >= 0.0);
#else
    return load_light(at, surface);
#endif
}

#if !SOURCE
// Of the luminance of a mean of n samples, or of an exponential mean of that weight: Schied et al. 2017, section 4.2.
vec2 temporal_variance(vec4 moments, uvec2 n) {
    vec2 share = max(1.0 / vec2(n), vec2(push.alpha_hf, push.alpha_spec) / (2.0 - vec2(push.alpha_hf, push.alpha_spec)));
    vec2 biased = max(moments.yw - moments.xz * moments.xz, 0.0);
    return biased * share / max(1.0 - share, 0.5);
}
#endif

struct History { vec3 hf; vec3 spec; vec4 moments; uint frames; vec2 hits; };

const History NO_HISTORY = History(vec3(0.0), vec3(0.0), vec4(0.0), 0u, vec2(0.0));

History history_at(Taps taps) {
    History sum = NO_HISTORY;
    float frames_sum = 0.0, weights = 0.0;
    for (int i = 0; i < 4; ++i) {
        if (taps.weight[i] == 0.0) continue;
        ivec2 from = taps.at[i];
        uint frames = history_frames(imageLoad(im_surface_prev, from).y);
        if (frames == 0u) continue;
        float weight = taps.weight[i];
        vec4 hf = light_of_history(imageLoad(im_history_hf_prev, from)), spec = light_of_history(imageLoad(im_history_spec_prev, from));
        sum.hf += weight * hf.rgb;
        sum.spec += weight * spec.rgb;
        sum.hits += weight * vec2(hf.a, spec.a);
        sum.moments += weight * moments_of_history(imageLoad(im_moments_prev, from));
        frames_sum += weight * float(frames);
        weights += weight;
    }
    if (weights == 0.0) return NO_HISTORY;
    float scale = 1.0 / weights;
    return History(sum.hf * scale, sum.spec * scale, sum.moments * scale, max(uint(frames_sum * scale + 0.5), 1u), sum.hits * scale);
}

#if VIRTUAL
struct SpecularHistory { vec3 light; vec2 moments; uint frames; };

// `hit`: hit distance that the pixels of the last frame must have had; 0: any.
SpecularHistory specular_history_at(Taps taps, float hit, float distance) {
    SpecularHistory sum = SpecularHistory(vec3(0.0), vec2(0.0), 0u);
    float frames_sum = 0.0, weights = 0.0;
    for (int i = 0; i < 4; ++i) {
        if (taps.weight[i] == 0.0) continue;
        ivec2 from = taps.at[i];
        uint frames = specular_frames(imageLoad(im_surface_prev, from).y);
        if (frames == 0u) continue;
        // Hit distances are compared one by one: the mean of two images' is that of none.
        float was = min(imageLoad(ch_color_spec_prev, from).a, FARTHEST_HIT);
        if (hit > 0.0 && !(abs(was - hit) <= HIT_TOLERANCE * (abs(distance) + min(was, hit)))) continue;
        float weight = taps.weight[i];
        sum.light += weight * light_of_history(imageLoad(im_history_spec_prev, from)).rgb;
        sum.moments += weight * moments_of_history(imageLoad(im_moments_prev, from)).zw;
        frames_sum += weight * float(frames);
        weights += weight;
    }
    if (weights == 0.0) return SpecularHistory(vec3(0.0), vec2(0.0), 0u);
    return SpecularHistory(sum.light / weights, sum.moments / weights, max(uint(frames_sum / weights + 0.5), 1u));
}

// Its own hit distance or, where its ray brought no light, the least one around.
float hit_distance(ivec2 local) {
    float own = tile_hit[(local.y + 1) * TILE + local.x + 1], least = 0.0;
    for (int i = 0; i < 9; ++i) {
        float other = tile_hit[(local.y + i / 3) * TILE + local.x + i % 3];
        if (other > 0.0) least = least == 0.0 ? other : min(least, other);
    }
    return own > 0.0 ? own : least;
}
#endif

void load_tile() {
    ivec2 corner = ivec2(gl_WorkGroupID.xy) * 16 - 1;
    for (int i = int(gl_LocalInvocationIndex); i < TILE * TILE; i += 256) {
        ivec2 pixel = corner + ivec2(i % TILE, i / TILE);
        vec2 l = vec2(-1.0);
        float hit = 0.0;
        if (inside(pixel)) {
            ivec2 at = flat_to_split(pixel, field_width());
            LightSample light = sample_at(at, is_surface(at));
            if (light.known) l = luminances(light);
#if VIRTUAL
            float found = imageLoad(ch_color_spec, at).a;
            if (light.known && found > 0.0) hit = min(found, FARTHEST_HIT);
#endif
        }
        tile_luminance[i] = l;
#if VIRTUAL
        tile_hit[i] = hit;
#endif
    }
}

void main() {
    load_tile();
    barrier();
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (!inside(pixel)) return;
    ivec2 at = flat_to_split(pixel, field_width()), local = ivec2(gl_LocalInvocationID.xy);
    uint flags = imageLoad(ch_view_direction, at).y;
    uint word = surface_word(at, flags);
    LightSample light = sample_at(at, word != 0u);
    Reprojection surface = reproject(pixel, at, word, flags);
    Taps taps = find_taps(surface, pixel);
    History history = history_at(taps);
    // Of diffuse, of specular light.
    uvec2 frames = uvec2(history.frames);
#if VIRTUAL
    float hit = hit_distance(local), roughness = imageLoad(ch_metallic_roughness, at).y;
    vec2 parallax = surface.valid ? image_parallax(at, flags, hit, roughness) : vec2(0.0);
    SpecularHistory specular = specular_history_at(taps, 0.0, 0.0);
    float turned = turned_away(length(parallax), imageLoad(ch_bounce_throughput, at).a, roughness);
    if (push.specular != SPECULAR_MOTION_SURFACE && parallax != vec2(0.0)) {
        Taps image_taps = find_taps(reproject_image(surface, at, parallax), pixel);
        bool compare = push.specular == SPECULAR_MOTION_BETTER;
        SpecularHistory image = specular_history_at(image_taps, compare ? hit : 0.0, imageLoad(ch_view_depth, at).x);
        if (image.frames > 0u || !compare) {
            specular = image;
            turned = 0.0;
        }
    }
    history.spec = specular.light;
    history.moments.zw = specular.moments;
    frames.y = kept_frames(specular.frames, turned);
#endif
#if ANTILAG
    // The sample of a gradient pixel is in the history already. Where all of that is forgotten the light is missing: it is that of the pixels around.
    bool repeated = is_repeated(pixel) && frames.x > 0u;
    ivec2 stratum = pixel / stratum_side;
    vec2 lag = antilag(texelFetch(gradients, stratum, 0));
    lag.x = max(lag.x, antilag_of_sums(texelFetch(sums_hf, stratum, 0), push.antilag_hf));
    lag.y = max(lag.y, antilag_of_sums(texelFetch(sums_spec, stratum, 0), push.antilag_spec));
    frames = uvec2(kept_frames(frames.x, max(lag.x, lag.y)), kept_frames(frames.y, max(lag.x, lag.y)));
    if (repeated && frames.x == 0u) light.known = false;
#else
    const vec2 lag = vec2(0.0);
    const bool repeated = false;
#endif

    if (light.known && push.firefly > 0.0) {
        Surroundings around = Surroundings(vec2(0.0), vec2(0.0), 0.0);
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
        // A channel that has nothing takes the sample in any case.
        bvec2 again = bvec2(repeated && frames.x > 0u, repeated && frames.y > 0u);
        frames = mix(min(frames + 1u, uvec2(push.max_length)), frames, again);
        vec2 fresh = mix(1.0 / vec2(frames), vec2(0.0), again);
        vec2 least = mix(vec2(1.0), vec2(0.0), again);
        vec2 alpha = mix(max(fresh, least * vec2(push.alpha_hf, push.alpha_spec)), vec2(1.0), lag);
        vec2 alpha_moments = mix(max(fresh, least * push.alpha_moments), vec2(1.0), max(lag.x, lag.y));
        history.hf = mix(history.hf, light.hf, alpha.x);
        history.spec = mix(history.spec, light.spec, alpha.y);
        history.moments = mix(history.moments, vec4(l.x, l.x * l.x, l.y, l.y * l.y), alpha_moments.xxyy);
#if SOURCE
        history.hits = mix(history.hits, vec2(texelFetch(source_hf, at, 0).a, texelFetch(source_spec, at, 0).a), alpha);
#endif
    }
    imageStore(im_surface, at, uvec4(word, history_word(frames), 0u, 0u));
    imageStore(im_moments, at, history_of_moments(history.moments, pixel, push.rounding));
    bool missing = word == 0u || frames.x == 0u;
#if SOURCE
    vec2 alpha = missing ? vec2(-1.0) : history.hits;
#else
    // The variance. Where a history is short, variance.comp replaces it.
    vec2 alpha = missing ? vec2(-1.0) : temporal_variance(history.moments, max(frames, uvec2(1u)));
#endif
    imageStore(im_history_hf_target, at, history_of_light(vec4(history.hf, alpha.x), pixel, DIM_HISTORIES, push.rounding));
    imageStore(im_history_spec_target, at, history_of_light(vec4(history.spec, alpha.y), pixel, DIM_HISTORIES + 1u, push.rounding));
}
