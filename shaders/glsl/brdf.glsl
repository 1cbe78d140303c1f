// Metallic-roughness BRDF of the real-time stages (glTF 2.0 specification, appendix B.3): GGX with the height-correlated Smith term
// (bsdf/ggx.glsl), Schlick's Fresnel term and a Lambertian base. Directions are unit vectors in the frame of the shading normal
// (+Z) that point away from the surface. Host twin: pt_light_sampling::oracle::brdf.
#include "sampling.glsl"
#include "bsdf/ggx.glsl"
#include "reflectance.glsl"

// Lower bound of alpha = roughness^2. A mirror under a delta light has no value in fp32; this lobe is about 0.1 degrees wide.
const float MIN_ALPHA = 1e-3;

struct Brdf {
    vec3 albedo;    // of the diffuse base
    vec3 f0;        // specular reflectance at normal incidence
    float f90;      // and at grazing incidence: KHR_materials_specular's factor, 1 for metals
    vec3 base_f0;   // of the dielectric, under which the diffuse base lies
    float base_f90;
    bool mixed;     // see make_brdf
    float alpha;
};

// The two parts of the BRDF in 1/sr. `diffuse` leaves the albedo out: (1 - F) / pi.
struct BrdfValue {
    vec3 diffuse;
    vec3 specular;
};

// `f0`, `f90`: of the dielectric. Metalness between 0 and 1 mixes two BRDFs, a dielectric and a metal: the light that the dielectric's
// interface does not reflect reaches the base (glTF 2.0, appendix B.2). `mixed`: one BRDF of mixed parameters, as in Quake II RTX, in
// which the base gets what the mixed F0 leaves; darker.
Brdf make_brdf(vec3 base_color, float metallic, float roughness, vec3 f0, float f90, bool mixed) {
    return Brdf(diffuse_albedo(base_color, metallic), specular_f0(base_color, metallic, f0), mix(f90, 1.0, metallic), f0, f90, mixed,
                max(roughness * roughness, MIN_ALPHA));
}

// Part of the light that passes the interface, to the diffuse base. `f`: what the specular lobe reflects.
vec3 passed_to_base(Brdf b, vec3 f, float cos_theta) {
    if (b.mixed) return vec3(1.0) - f;
    return vec3(1.0 - max_component(fresnel_schlick(b.base_f0, b.base_f90, cos_theta)));
}

BrdfValue brdf_eval(Brdf b, vec3 v, vec3 l) {
    if (v.z <= 0.0 || l.z <= 0.0) return BrdfValue(vec3(0.0), vec3(0.0));
    vec3 h = normalize(v + l);
    float cos_theta = dot(v, h);
    vec3 f = fresnel_schlick(b.f0, b.f90, cos_theta);
    return BrdfValue(passed_to_base(b, f, cos_theta) * INV_PI, f * (ggx_d(b.alpha, h) * ggx_visibility(vec2(b.alpha), v, l)));
}

// Probability with which brdf_sample takes the specular lobe: by the lobes' estimated reflectances, neither lobe below 0.1
// while it has any.
float specular_probability(Brdf b, vec3 v) {
    vec3 f = fresnel_schlick(b.f0, b.f90, v.z);
    float specular = luminance(f);
    float diffuse = luminance(b.albedo * passed_to_base(b, f, v.z));
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
