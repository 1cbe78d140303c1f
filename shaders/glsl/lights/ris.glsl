// Resampled importance sampling (Talbot, Cline and Egbert 2005): of several candidates, drawn with a density that is easy to draw from, one
// is taken in proportion to an estimate of the light that it gives over its density. The sample's weight, sum / (M target), takes the
// place of 1 / pdf and is unbiased because the target is above 0 wherever the point can get light.
#include "lights/light_sampler.glsl"
#include "random.glsl"

// Where candidates come from (RIS_SOURCE_*).
layout(constant_id = 16) const uint ris_source = RIS_SOURCE_CLUSTER;

// What the target is proportional to: unshadowed light, Lambertian and with a Phong lobe for the specular part.
float ris_target(LightContext c, LightSample s) {
    float cos_theta = dot(c.normal, s.direction);
    if (s.pdf <= 0.0 || cos_theta <= 0.0) return 0.0;
    float lobe = c.specular > 0.0 ? phong_lobe(c, s.direction) : 1.0;
    return luminance(s.radiance) * cos_theta * mix(1.0, lobe, c.specular);
}

// The light of a candidate, NONE: none, and its probability. `bits`: of the candidate's own, of which it takes the first two.
uint ris_pick(LightContext c, uvec4 bits, out float pmf) {
    vec2 xi = unit_from_bits(bits).xy;
    pmf = 0.0;
    uint light;
    if (light_sampler == LIGHT_SAMPLER_NEE_AT) return pick_light(c, bits, pick_by_power(pcg4d(bits)), pmf);
    if (ris_source == RIS_SOURCE_CLUSTER) {
        ClusterListRecord list = cluster_list(c.cluster);
        uint size = cluster_list_size(list);
        bool all = xi.x < list.catch_all;
        if (!all && size == 0u) return NONE;
        if (all) {
            light = alias_pick(choice_tables().local_alias, choice_tables().local_light_count, uint(xi.x / list.catch_all * 4294967040.0), xi.y);
        } else {
            uint place = min(uint((xi.x - list.catch_all) / (1.0 - list.catch_all) * float(size)), size - 1u);
            light = cluster_list_light(list, place);
        }
        bool listed = !all || cluster_list_place(list, c.cluster, light) != NONE;
        pmf = listed ? (1.0 - list.catch_all) / float(size) : 0.0;
        if (list.catch_all > 0.0) pmf += list.catch_all * power_pmf(light);
    } else {
        light = alias_pick(choice_tables().local_alias, choice_tables().local_light_count, bits.x, xi.y);
        pmf = power_pmf(light);
    }
    return light;
}

// A candidate, its pdf with the choice of the light, as the frame saw it that chooses. `bits`: of the candidate's own.
LightSample ris_candidate(LightContext c, uvec4 bits, out uint light) {
    float pmf;
    light = ris_pick(c, bits, pmf);
    if (light == NONE) return NO_LIGHT_SAMPLE;
    LightSample s = sample_light_of(choice_tables(), c, light, unit_from_bits(bits).zw);
    s.pdf *= pmf;
    return s;
}

// The kept sample with the light as it is in this frame. The weight is that of a point of primary sample space, so the pdf changes with the
// density of the points on the light. Kernels with gradient pixels do this in every pixel: both frames then round alike.
LightSample ris_evaluated(LightContext c, LightSample kept, uint light, vec2 xi) {
    LightSample s = sample_local_light(c, light, xi);
    LocalLightRecord before = choice_light(light), now = local_light(light);
    bool same_place = before.position == now.position && before.edge1 == now.edge1 && before.edge2 == now.edge2;
    s.pdf = same_place && s.pdf > 0.0 ? kept.pdf : kept.pdf * (s.pdf / sample_light_of(choice_tables(), c, light, xi).pdf);
    return s;
}

// One of `count` candidates; its pdf is the reciprocal of the weight. `stratified`: the numbers that choose the lights are spread evenly.
// `dimension`: of the first candidate's random numbers.
LightSample ris_sample(LightContext c, uvec2 key, uint dimension, float xi, uint count, bool stratified, out uint light) {
    LightSample kept = NO_LIGHT_SAMPLE;
    float sum = 0.0, kept_target = 0.0;
    vec2 kept_xi = vec2(0.0);
    light = NONE;
    if (choice_tables().local_light_count == 0u) return kept;
    for (uint i = 0u; i < count; i++) {
        uvec4 bits = random_bits(key, dimension + i);
        if (stratified) bits.x = bits.x / count + i * (0xffffffffu / count);
        uint drawn;
        LightSample s = ris_candidate(c, bits, drawn);
        float target = ris_target(c, s);
        if (target <= 0.0) continue;
        float weight = target / s.pdf;
        sum += weight;
        float share = weight / sum;
        if (xi < share) {
            xi /= share;
            kept = s;
            kept_target = target;
            kept_xi = unit_from_bits(bits).zw;
            light = drawn;
        } else {
            xi = (xi - share) / (1.0 - share);
        }
    }
    if (light != NONE) kept.pdf = float(count) * kept_target / sum;
    if (replays_samples && light != NONE) return ris_evaluated(c, kept, light, kept_xi);
    return kept;
}

LightSample ris_sample(LightContext c, uvec2 key, float xi, uint count, bool stratified, out uint light) {
    return ris_sample(c, key, DIM_RIS, xi, count, stratified, light);
}
