// Metallic-roughness BRDF of the real-time stages (glTF 2.0 specification, appendix B.3): GGX with the height-correlated Smith term
// (bsdf/ggx.glsl), Schlick's Fresnel term and a Lambertian base. Directions are unit vectors in the frame of the shading normal
// (+Z) that point away from the surface. Host twin: pt_lights::oracle::brdf.
#include "sampling.glsl"
#include "bsdf/ggx.glsl"
#include "reflectance.glsl"

// Lower bound of alpha = roughness^2. A mirror under a delta light has no value in fp32; this lobe is about 0.1 degrees wide.
const float MIN_ALPHA = 1e-3;

struct Brdf {
    vec3 albedo; // of the diffuse base
    vec3 f0;     // specular reflectance at normal incidence
    float f90;   // and at grazing incidence: KHR_materials_specular's factor, 1 for metals
    float alpha;
};

// The two parts of the BRDF in 1/sr. `diffuse` leaves the albedo out: (1 - F) / pi.
struct BrdfValue {
    vec3 diffuse;
    vec3 specular;
};

// `base`: rgb = base colour, a = specular factor (channel base_color).
Brdf make_brdf(vec4 base, float metallic, float roughness) {
    return Brdf(diffuse_albedo(base.rgb, metallic), specular_f0(base.rgb, metallic, base.a), mix(base.a, 1.0, metallic),
                max(roughness * roughness, MIN_ALPHA));
}

BrdfValue brdf_eval(Brdf b, vec3 v, vec3 l) {
    if (v.z <= 0.0 || l.z <= 0.0) return BrdfValue(vec3(0.0), vec3(0.0));
    vec3 h = normalize(v + l);
    vec3 f = fresnel_schlick(b.f0, b.f90, dot(v, h));
    return BrdfValue((vec3(1.0) - f) * INV_PI, f * (ggx_d(b.alpha, h) * ggx_visibility(vec2(b.alpha), v, l)));
}

// Probability with which brdf_sample takes the specular lobe: by the lobes' estimated reflectances, neither lobe below 0.1
// while it has any.
float specular_probability(Brdf b, vec3 v) {
    vec3 f = fresnel_schlick(b.f0, b.f90, v.z);
    float specular = luminance(f);
    float diffuse = luminance(b.albedo * (vec3(1.0) - f));
    if (b.f90 <= 0.0 && max_component(b.f0) <= 0.0) return 0.0;
    if (max_component(b.albedo) <= 0.0) return 1.0;
    return clamp(specular / max(specular + diffuse, 1e-20), 0.1, 0.9);
}

// Direction for (cos x whole BRDF); z <= 0: the sample lies below the surface and carries nothing.
vec3 brdf_sample(Brdf b, vec3 v, vec3 xi) {
    if (xi.z < specular_probability(b, v)) return reflect(-v, sample_ggx_vndf(v, b.alpha, xi.xy));
    return sample_cosine_hemisphere(xi.xy);
}

// Density of brdf_sample per solid angle.
float brdf_pdf(Brdf b, vec3 v, vec3 l) {
    if (v.z <= 0.0 || l.z <= 0.0) return 0.0;
    float p = specular_probability(b, v);
    float specular = p > 0.0 ? p * ggx_reflection_pdf(v, l, b.alpha) : 0.0;
    return specular + (1.0 - p) * cosine_hemisphere_pdf(l.z);
}
