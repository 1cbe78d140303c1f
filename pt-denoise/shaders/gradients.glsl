// Included by gradients.comp (INDIRECT 0) and gradients_indirect.comp (INDIRECT 1: there is indirect diffuse light).
//
// How much the light has changed: Schied, Peters and Dachsbacher 2018, section 4. Extent: strata of the flat frame; one thread for a pixel.
// A gradient pixel has taken the light sample of the last frame again, so that a difference is a change of the light and no noise. It cannot find a light that was dark then,
// and indirect diffuse light is not sampled again: sums over strata of the light of the other pixels are compared with those of the history.
// Changes and luminances are filtered apart, and divided where they are used: black strata then do not count.
#include "denoise_records.glsl"

layout(push_constant, scalar) uniform Push { TemporalPush push; };
#include "antilag.glsl"
#include "history_code.glsl"
#include "light_sample.glsl"
#include "reprojection.glsl"
#include "sums.glsl"
#if INDIRECT
#include "lf_light.glsl"
#endif

// Of one channel at a time: more groups run at once if each needs less shared memory.
shared vec4 terms[GROUP_SIDE * GROUP_SIDE];
// Of the gradient pixels of the group's strata.
shared vec4 gradients[25];

// Changes below the gate are rounding and the turn of a lobe with the camera; (change, greater of both).
vec2 change(float now, float before) {
    float greatest = max(now, before);
    return vec2(max(abs(now - before) - push.gate * greatest, 0.0), greatest);
}

struct Terms { vec4 hf; vec4 spec; vec4 lf; };

// Sums of the history over the four pixels that a pixel continues.
struct Before { vec4 moments; float frames; float weights; };

Terms terms_of(ivec2 pixel, LightSample light, bool is_sum) {
    Terms terms = Terms(vec4(0.0), vec4(0.0), vec4(0.0));
    ivec2 at = flat_to_split(pixel, field_width());
    uint flags = imageLoad(ch_view_direction, at).y;
    uint word = surface_word(at, flags);
    if (word == 0u) return terms;
    Taps taps = find_taps(reproject(pixel, at, word, flags), pixel);
    if (is_sum && light.known) {
        Before before = Before(vec4(0.0), 0.0, 0.0);
        for (int k = 0; k < 4; ++k) {
            if (taps.weight[k] == 0.0) continue;
            uint n = history_frames(imageLoad(im_surface_prev, taps.at[k]).y);
            if (n == 0u) continue;
            before.moments += taps.weight[k] * moments_of_history(imageLoad(im_moments_prev, taps.at[k]));
            before.frames += taps.weight[k] * float(n);
            before.weights += taps.weight[k];
        }
        if (before.weights > 0.0) {
            vec4 moments = before.moments / before.weights;
            float frames = before.frames / before.weights;
            vec2 now = luminances(light);
            terms.hf = sum_term(now.x, moments.x, moments.y, history_share(frames, push.alpha_hf));
            terms.spec = sum_term(now.y, moments.z, moments.w, history_share(frames, push.alpha_spec));
        }
    }
#if INDIRECT
    ShLight indirect = ShLight(imageLoad(ch_color_lf_sh, at), imageLoad(ch_color_lf_cocg, at).xy);
    if (is_light(indirect)) {
        Before before = Before(vec4(0.0), 0.0, 0.0);
        for (int k = 0; k < 4; ++k) {
            if (taps.weight[k] == 0.0) continue;
            float luma = luma_of_history(imageLoad(im_history_lf_sh_prev, taps.at[k])).w;
            vec4 chroma = chroma_of_history(imageLoad(im_history_lf_cocg_prev, taps.at[k]), luma);
            if (chroma.w < 0.0) continue;
            before.moments.xy += taps.weight[k] * vec2(luma, chroma.w);
            before.frames += taps.weight[k] * chroma.z;
            before.weights += taps.weight[k];
        }
        if (before.weights > 0.0) {
            vec2 moments = before.moments.xy / before.weights;
            terms.lf = sum_term(indirect.luma.w, moments.x, moments.y, history_share(before.frames / before.weights, push.alpha_lf));
        }
    }
#endif
    return terms;
}

// Sum of a channel's terms over the stratum that the thread stores; each thread gives its own.
vec4 sum_of_stratum(vec4 term) {
    int own = int(gl_LocalInvocationIndex);
    barrier();
    terms[own] = term;
    barrier();
    vec4 sum = vec4(0.0);
    if (own < group_strata() * group_strata()) {
        for (int i = 0; i < stratum_side * stratum_side; ++i) sum += terms[thread_of(own, i)];
    }
    return sum;
}

void main() {
    int own = int(gl_LocalInvocationIndex);
    if (own < group_strata() * group_strata()) gradients[own] = vec4(0.0);
    barrier();
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    Terms sums = Terms(vec4(0.0), vec4(0.0), vec4(0.0));
    if (inside(pixel)) {
        LightSample light = load_light(flat_to_split(pixel, field_width()), true);
        bool repeated = is_repeated(pixel);
        if (repeated && light.known) {
            ivec2 local = ivec2(gl_LocalInvocationID.xy) / stratum_side;
            vec2 now = luminances(light), before = imageLoad(ch_gradient_sample, pixel / stratum_side).yz;
            gradients[local.y * group_strata() + local.x] = vec4(change(now.x, before.x), change(now.y, before.y));
        }
        sums = terms_of(pixel, light, !repeated);
    }
    sums.hf = sum_of_stratum(sums.hf);
    sums.spec = sum_of_stratum(sums.spec);
#if INDIRECT
    sums.lf = sum_of_stratum(sums.lf);
#endif
    ivec2 stratum;
    if (!stores_stratum(stratum)) return;
    imageStore(im_gradients, stratum, gradients[own]);
    imageStore(im_sums_hf, stratum, sums.hf);
    imageStore(im_sums_spec, stratum, sums.spec);
#if INDIRECT
    imageStore(im_sums_lf, stratum, sums.lf);
#endif
}
