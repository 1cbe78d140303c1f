// Lobe: clearcoat, a GGX lobe with a normal and a roughness of its own (KHR_materials_clearcoat).
#include "bsdf/fresnel.glsl"
#include "bsdf/model.glsl"

// Reflectance towards a viewer at that angle to the coat's normal (index 1.5).
float coat_fresnel(float cos_theta) { return fresnel_schlick(vec3(DIELECTRIC_F0), 1.0, cos_theta).x; }

BsdfValue coat_evaluate(Bsdf b, vec3 wi) {
    BsdfValue r = BsdfValue(vec3(0.0), 0.0);
    if (b.lobes.coat <= 0.0 || b.coat_alpha <= 0.0) return r;
    mat3 frame = basis_around(b.coat_normal);
    vec3 v = b.wo * frame, l = wi * frame;
    if (v.z <= 0.0 || l.z <= 0.0) return r;
    vec2 alpha = vec2(b.coat_alpha);
    float d = ggx_d(alpha, normalize(v + l));
    r.f_cos = vec3(b.lobes.coat * d * ggx_visibility(alpha, v, l) * l.z);
    r.pdf = ggx_reflection_pdf(b.lobes.p.coat * d, v, alpha);
    return r;
}

BsdfSample coat_sample(Bsdf b, vec2 u) {
    mat3 frame = basis_around(b.coat_normal);
    vec3 v = b.wo * frame;
    bool delta = b.coat_alpha == 0.0;
    vec3 h = delta ? vec3(0.0, 0.0, 1.0) : sample_ggx_vndf(v, b.coat_alpha, u);
    vec3 l = reflect(-v, h);
    if (l.z <= 0.0) return NO_BSDF_SAMPLE;
    return BsdfSample(frame * l, vec3(b.lobes.coat) / b.lobes.p.coat, b.lobes.p.coat, delta ? SAMPLE_DELTA : 0u);
}
