// Diffuse and specular reflectance of the metallic-roughness material: glTF 2.0 specification, appendix B, with the
// dielectric F0 for an index of refraction of 1.5 scaled by KHR_materials_specular's factor.

const float DIELECTRIC_F0 = 0.04;

vec3 diffuse_albedo(vec3 base_color, float metallic) {
    return base_color * (1.0 - metallic);
}

// Specular reflectance at normal incidence.
vec3 specular_f0(vec3 base_color, float metallic, float specular) {
    return mix(vec3(DIELECTRIC_F0 * specular), base_color, metallic);
}

// What specular light is divided by before filtering and multiplied by at the composite; bounded so that it can be undone.
vec3 demodulation(vec3 f0) {
    return max(vec3(0.01), f0);
}

// Schlick 1994, "An Inexpensive BRDF Model for Physically-based Rendering", eq. 15; `f90`: reflectance at grazing incidence.
vec3 fresnel_schlick(vec3 f0, float f90, float cos_theta) {
    float m = clamp(1.0 - cos_theta, 0.0, 1.0);
    float m2 = m * m;
    return f0 + (vec3(f90) - f0) * (m2 * m2 * m);
}
