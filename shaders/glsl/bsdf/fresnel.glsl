// Fresnel terms: the reflectance of an interface by the angle of incidence. Host twins: pt_gbuffer::oracle::dielectric,
// pt_light_sampling::oracle::brdf.

// Reflectance at normal incidence of a dielectric with an index of refraction of 1.5.
const float DIELECTRIC_F0 = 0.04;

// Schlick 1994, "An Inexpensive BRDF Model for Physically-based Rendering", eq. 15; `f90`: reflectance at grazing incidence.
vec3 fresnel_schlick(vec3 f0, float f90, float cos_theta) {
    float m = clamp(1.0 - cos_theta, 0.0, 1.0);
    float m2 = m * m;
    return f0 + (vec3(f90) - f0) * (m2 * m2 * m);
}

// Share of unpolarised light that is reflected: Fresnel's equations. `eta`: index of refraction behind the interface over the
// index in front of it; `cos_theta` > 0 of the direction in front. 1: total internal reflection.
float fresnel_dielectric(float cos_theta, float eta) {
    float sin2_behind = (1.0 - cos_theta * cos_theta) / (eta * eta);
    if (sin2_behind >= 1.0) return 1.0;
    float cos_behind = sqrt(1.0 - sin2_behind);
    float s = (cos_theta - eta * cos_behind) / (cos_theta + eta * cos_behind);
    float p = (eta * cos_theta - cos_behind) / (eta * cos_theta + cos_behind);
    return 0.5 * (s * s + p * p);
}

// The same with KHR_materials_specular: the colour scales the reflectance at normal incidence, the factor all of it. `f`:
// fresnel_dielectric of the interface with index `ior`.
vec3 tint_specular(float f, float ior, float specular, vec3 specular_color) {
    float f0 = (ior - 1.0) * (ior - 1.0) / ((ior + 1.0) * (ior + 1.0));
    float rise = (f - f0) / max(1.0 - f0, 1e-6);
    vec3 tinted = min(f0 * specular_color, vec3(1.0));
    return clamp(specular * (tinted + (1.0 - tinted) * rise), 0.0, 1.0);
}
