// Energy compensation: the light that leaves a rough surface after more than one microfacet (Kulla and Conty 2017). It is drawn with
// the diffuse lobe. Host twin: pt_reference::oracle::layers.
#include "bsdf/albedo.glsl"
#include "bsdf/interface.glsl"

// Fresnel factor of the light that has met more than one microfacet: Kulla and Conty 2017, "Revisiting Physically Based Shading at
// Imageworks", with the mean of Schlick's term f0 + (f90 - f0) / 21. `mean`: whole mean albedo.
vec3 multiple_scattering_fresnel(vec3 f0, float f90, float mean) {
    vec3 f = f0 + (vec3(f90) - f0) * (1.0 / 21.0);
    return f * f * mean / (1.0 - f * (1.0 - mean));
}

// Light that meets more than one microfacet, and the weight of the diffuse base, with energy compensation.
struct Compensation {
    vec3 scattered;   // albedo of the multiple scattering lobe
    float base;       // what the diffuse base gets
};

// Both are factors of (v) and (l): F_ms (1 - E(v)) (1 - E(l)) / (1 - mean E) and the like.
Compensation compensation(Bsdf b, float v_z, float l_z) {
    float alpha = sqrt(b.alpha.x * b.alpha.y);
    vec2 mean = ggx_mean_albedo(alpha), towards_v = ggx_albedo(v_z, alpha), towards_l = ggx_albedo(l_z, alpha);
    float whole = mean.x + mean.y;
    vec3 f0 = dielectric_fresnel(b, 1.0);
    vec3 f0_mixed = mix(f0, b.base_color, b.metallic);
    float f90_mixed = mix(b.specular, 1.0, b.metallic);
    float lost_v = 1.0 - towards_v.x - towards_v.y, lost_l = 1.0 - towards_l.x - towards_l.y;
    Compensation c;
    c.scattered = multiple_scattering_fresnel(f0_mixed, f90_mixed, whole) * (lost_v * lost_l / max(1.0 - whole, 1e-6));
    // The dielectric's own lobe, with what it scatters.
    float f = max_component(f0);
    float again = multiple_scattering_fresnel(vec3(f), b.specular, whole).x;
    float e_v = f * towards_v.x + b.specular * towards_v.y + again * lost_v;
    float e_l = f * towards_l.x + b.specular * towards_l.y + again * lost_l;
    float e_mean = f * mean.x + b.specular * mean.y + again * (1.0 - whole);
    c.base = (1.0 - b.metallic) * (1.0 - e_v) * (1.0 - e_l) / max(1.0 - e_mean, 1e-6);
    return c;
}
