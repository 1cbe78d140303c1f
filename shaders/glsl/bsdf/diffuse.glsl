// Lobe: the Lambertian base, and what else scatters widely (sheen, light that has met more than one microfacet) is drawn with it.
#include "bsdf/model.glsl"
#include "sampling.glsl"

// `passed`: part of the light that the interface lets through to the base.
BsdfValue diffuse_evaluate(Bsdf b, vec3 l, float passed) {
    return BsdfValue(b.base_color * (passed * (1.0 - b.transmission) * l.z * INV_PI), b.lobes.p.diffuse * cosine_hemisphere_pdf(l.z));
}

BsdfSample diffuse_sample(Bsdf b, vec2 u) {
    return BsdfSample(b.frame * sample_cosine_hemisphere(u), vec3(0.0), b.lobes.p.diffuse, 0u);
}
