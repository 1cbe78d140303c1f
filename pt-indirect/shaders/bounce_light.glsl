// Next event estimation at a surface that a bounce ray has met: one sample of one kind of light, with the light sampler that direct
// lighting has, and its shadow ray.
#include "bounce_random.glsl"
#include "bounce_vertex.glsl"
#include "lights/emission_share.glsl"
#include "lights/ris.glsl"
#include "clusters.glsl"
#include "reusable_light.glsl"
#include "shadow_path.glsl"

// The kinds of light that count and that the scene has; emissive triangles, point and spot lights are one.
uint light_kinds() {
    LightTablesRecord tables = choice_tables();
    uint kinds = push.kinds & KIND_SUN;
    if (tables.sun_count == 0u) kinds = 0u;
    if (tables.local_light_count > 0u && (push.kinds & (KIND_EMISSIVE | KIND_POSITIONAL)) != 0u) kinds |= KIND_LOCAL;
    if (scene.environment_intensity > 0.0) kinds |= push.kinds & KIND_ENVIRONMENT;
    return kinds;
}

bool kind_on(uint kind) { return (light_kinds() & kind) != 0u; }

// Probability of each of them.
float kind_pmf() { return 1.0 / float(max(bitCount(light_kinds()), 1)); }

// They do not even see it (`lights.glass_shadows=passed`). What is behind glass is then not told from what is not: light samples find all
// light but that of delta lobes.
bool glass_is_ignored() { return scene_has(FEATURE_TRANSMISSION) && push.glass_shadows == GLASS_SHADOWS_PASSED; }

// Whether light samples go straight on through the surface of the vertex.
bool is_passed(BounceVertex v) {
    if (push.glass_shadows == GLASS_SHADOWS_STRAIGHT) return interface_transmits_straight(v.bsdf);
    return push.glass_shadows != GLASS_SHADOWS_STOPPED;
}

LightContext light_context(BounceVertex v) {
    LobeProbabilities p = v.bsdf.lobes.p;
    return LightContext(v.position, v.bsdf.frame[2], v.bsdf.wo, cluster_of(v.position), max(v.sampled.roughness, 0.02),
                        clamp(p.coat + p.interface_, 0.0, 0.9), 0ul);
}

// An emissive triangle, a point or a spot light.
LightSample local_sample(LightContext c, uvec2 key, uint vertex, out uint light) {
    uvec4 bits = random_bits(key, bounce_dimension(vertex, BOUNCE_LIGHT));
    vec4 xi = unit_from_bits(bits);
    LightSample s = NO_LIGHT_SAMPLE;
    if (light_sampler == LIGHT_SAMPLER_RIS) {
        uint first = bounce_dimension(vertex, BOUNCE_CANDIDATES);
        s = ris_sample(c, key, first, xi.x, push.ris_candidates, push.ris_stratified != 0u, light);
    } else {
        float pmf;
        light = pick_light(c, bits, pick_by_power(random_bits(key, bounce_dimension(vertex, BOUNCE_LIGHT_BY_POWER))), pmf);
        if (light != NONE) s = sample_local_light(c, light, xi.zw);
        s.pdf *= pmf;
    }
    // Quads of the environment may be among the local lights; here the environment has samples of its own.
    bool on = light != NONE && (push.kinds & kind_of_light(light) & (KIND_EMISSIVE | KIND_POSITIONAL)) != 0u;
    return on ? s : NO_LIGHT_SAMPLE;
}

// A sample, its pdf with the choice of the kind. `ray_pdf`: what the weight of multiple importance sampling takes for it, as for a light that
// a ray has met; 0: no ray can meet it.
LightSample sample_light(BounceVertex v, uvec2 key, uint vertex, float reach, out float ray_pdf) {
    uint kinds = light_kinds();
    ray_pdf = 0.0;
    if (kinds == 0u) return NO_LIGHT_SAMPLE;
    uint left = min(uint(bounce_choices(key, vertex).x * float(bitCount(kinds))), uint(bitCount(kinds)) - 1u);
    for (; left > 0u; left--) kinds &= kinds - 1u;
    uint kind = kinds & -kinds, light = NONE;
    LightSample s;
    if (kind == KIND_LOCAL) {
        s = local_sample(light_context(v), key, vertex, light);
    } else {
        uvec4 bits = random_bits(key, bounce_dimension(vertex, BOUNCE_LIGHT));
        if (kind == KIND_SUN) s = sample_sun(bits);
        else s = sample_environment(bits);
        // Knob sun_range: fades the sun out with the length of the first ray.
        if (kind == KIND_SUN && push.sun_range > 0.0) s.radiance *= square(max(1.0 - square(square(reach / push.sun_range)), 0.0));
    }
    s.pdf *= kind_pmf();
    if (!s.delta && kind != KIND_LOCAL) ray_pdf = s.pdf;
    if (light < scene.emissive_count && s.pdf > 0.0) ray_pdf = emissive_sample_pdf(s, light, v.position) * kind_pmf();
    return s;
}

// The light that the vertex gets from a light sample and reflects along the path, and the ray that tells whether it arrives; false: none. `last`:
// no ray looks for lights from there. `reach`: length of the first ray. `pdf`: density of the sample; of a point light, its probability.
// `share`: what of the light can be reused, if bounces are.
bool light_at(BounceVertex v, uvec2 key, uint vertex, bool last, float reach, out ShadowPath shadow, out float pdf, out vec3 share) {
    pdf = 0.0;
    share = vec3(0.0);
    if (bsdf_is_delta(v.bsdf)) return false;
    float ray_pdf;
    LightSample s = sample_light(v, key, vertex, reach, ray_pdf);
    pdf = s.pdf;
    if (s.pdf <= 0.0) return false;
    bool beyond = dot(v.bsdf.face_normal, s.direction) < 0.0;
    // Light samples of the vertex before have gone straight on through this one.
    if (beyond && is_passed(v)) return false;
    BsdfValue f = bsdf_evaluate(v.bsdf, s.direction);
    shadow.light = f.f_cos * s.radiance / s.pdf;
    if (!(max_component(shadow.light) > 0.0)) return false;
    shadow.weight = last || ray_pdf <= 0.0 || glass_is_ignored() ? 1.0 : power_weight(ray_pdf, f.pdf);
    if (reuses_bounces) share = least_diffuse_share(v.bsdf, s.direction, f.f_cos);
    shadow.ray = shadow_ray(v.position, beyond ? -v.bsdf.face_normal : v.bsdf.face_normal, s);
    return true;
}
