// Diffuse and specular reflectance of the metallic-roughness material: glTF 2.0 specification, appendix B, with the
// dielectric F0 for an index of refraction of 1.5 scaled by KHR_materials_specular's factor.
#include "bsdf/fresnel.glsl"

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
