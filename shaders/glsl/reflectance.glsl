// Diffuse and specular reflectance of the metallic-roughness material: glTF 2.0 specification, appendix B.
#include "bsdf/fresnel.glsl"

vec3 diffuse_albedo(vec3 base_color, float metallic) {
    return base_color * (1.0 - metallic);
}

// Specular reflectance of a dielectric at normal incidence: KHR_materials_ior and KHR_materials_specular.
vec3 dielectric_f0(float ior, float specular, vec3 specular_color) {
    float r = (ior - 1.0) / (ior + 1.0);
    return min(r * r * specular_color, vec3(1.0)) * specular;
}

// Specular reflectance at normal incidence of a mixture of a dielectric and a metal.
vec3 specular_f0(vec3 base_color, float metallic, vec3 dielectric) {
    return mix(dielectric, base_color, metallic);
}

// What specular light is divided by before filtering and multiplied by at the composite; bounded so that it can be undone.
// `base`: channel base_color, whose alpha is the largest component of the dielectric's F0.
vec3 demodulation(vec4 base, float metallic) {
    return max(vec3(0.01), specular_f0(base.rgb, metallic, vec3(base.a)));
}
