// What lies round the microfacet lobes: sheen, coat, energy compensation. Host twin: pt_reference::oracle::layers.
#include "math.glsl"
#include "reflectance.glsl"

// Directional albedos for perceptual roughnesses 0..1 (rows), from pt_reference::oracle::albedo::packed(). A buffer, since drivers that
// inline everything copy constant arrays of this size into every use.
const uint ALBEDO_COLUMNS = 32u;
const uint ALBEDO_ROWS = 16u;
const uint ALBEDO_MEANS = 61u;
layout(set = 0, binding = 2, scalar) readonly buffer bsdf_tables {
    float GGX_ALBEDO[ALBEDO_COLUMNS * ALBEDO_ROWS];     // of a white GGX lobe, for sqrt(cos / (cos + alpha / 2) (1 + alpha / 2))
    float GGX_GRAZING[ALBEDO_COLUMNS * ALBEDO_ROWS];    // fifth root of the part that (1 - v.h)^5 weights, for sqrt(cos)
    float CHARLIE_ALBEDO[ALBEDO_COLUMNS * ALBEDO_ROWS]; // of a white sheen, for sqrt(cos)
    vec2 GGX_MEAN[ALBEDO_MEANS];                        // cosine-weighted means, both parts
};

// Bilinear lookup in a table, both coordinates in [0, 1]. As a macro, since GLSL copies arrays that are passed.
#define LOOK_UP(table, across, along, result)                                                                              \
    {                                                                                                                      \
        vec2 at = clamp(vec2(across, along), 0.0, 1.0) * vec2(ALBEDO_COLUMNS - 1u, ALBEDO_ROWS - 1u);                      \
        uvec2 cell = min(uvec2(at), uvec2(ALBEDO_COLUMNS, ALBEDO_ROWS) - 2u);                                              \
        vec2 part = at - vec2(cell);                                                                                       \
        uint k = cell.y * ALBEDO_COLUMNS + cell.x;                                                                         \
        result = mix(mix(table[k], table[k + 1u], part.x),                                                                 \
                     mix(table[k + ALBEDO_COLUMNS], table[k + ALBEDO_COLUMNS + 1u], part.x), part.y);                      \
    }

// Directional albedo of a GGX lobe whose Fresnel term is Schlick's: f0 x + f90 y. `alpha` is isotropic.
vec2 ggx_albedo(float cos_theta, float alpha) {
    float roughness = sqrt(alpha);
    float whole, grazing;
    // E changes where the cosine is like alpha (see oracle::albedo::ggx_coordinate).
    float t = cos_theta / (cos_theta + 0.5 * alpha) * (1.0 + 0.5 * alpha);
    LOOK_UP(GGX_ALBEDO, sqrt(t), roughness, whole);
    LOOK_UP(GGX_GRAZING, sqrt(cos_theta), roughness, grazing);
    float f90 = whole * square(square(grazing)) * grazing;
    return vec2(whole - f90, f90);
}

// Its cosine-weighted mean over the hemisphere.
vec2 ggx_mean_albedo(float alpha) {
    float at = clamp(sqrt(alpha), 0.0, 1.0) * float(ALBEDO_MEANS - 1u);
    uint k = min(uint(at), ALBEDO_MEANS - 2u);
    return mix(GGX_MEAN[k], GGX_MEAN[k + 1u], at - float(k));
}

// Fresnel factor of the light that has met more than one microfacet: Kulla and Conty 2017, "Revisiting Physically Based Shading at
// Imageworks", with the mean of Schlick's term f0 + (f90 - f0) / 21. `mean`: whole mean albedo.
vec3 multiple_scattering_fresnel(vec3 f0, float f90, float mean) {
    vec3 f = f0 + (vec3(f90) - f0) * (1.0 / 21.0);
    return f * f * mean / (1.0 - f * (1.0 - mean));
}

// Sheen: Estevez and Kulla 2017, "Production Friendly Microfacet Sheen BRDF", eq. 2 (distribution) and 3 with table 1 (masking);
// KHR_materials_sheen. alpha = roughness^2.
float charlie_lambda_log(float x, float alpha) {
    float w = square(1.0 - alpha);
    vec4 p = mix(vec4(21.5473, 3.82987, 0.19823, -1.97760), vec4(25.3245, 3.32435, 0.16801, -1.27393), w);
    float e = mix(-4.32054, -4.85967, w);
    return p.x / (1.0 + p.y * pow(x, p.z)) + p.w * x + e;
}

float charlie_lambda(float cos_theta, float alpha) {
    float x = max(cos_theta, 1e-6);
    return exp(x < 0.5 ? charlie_lambda_log(x, alpha) : 2.0 * charlie_lambda_log(0.5, alpha) - charlie_lambda_log(1.0 - x, alpha));
}

// Narrower ones look the same, as no light comes from the horizon, and have no digits left.
const float MIN_SHEEN_ALPHA = 0.01;

// BRDF x l.z for a white sheen.
float charlie(vec3 v, vec3 l, float alpha) {
    vec3 h = normalize(v + l);
    float inverse = 1.0 / alpha;
    float d = (2.0 + inverse) * pow(max(length(h.xy), 1e-20), inverse) * (0.5 * INV_PI);
    return d / (4.0 * v.z * (1.0 + charlie_lambda(v.z, alpha) + charlie_lambda(l.z, alpha)));
}

// Directional albedo of it.
float charlie_albedo(float cos_theta, float alpha) {
    float albedo;
    LOOK_UP(CHARLIE_ALBEDO, sqrt(cos_theta), sqrt(alpha), albedo);
    return albedo;
}

// Reflectance of the coat towards a viewer at that angle to the coat's normal (KHR_materials_clearcoat: index 1.5).
float coat_fresnel(float cos_theta) { return fresnel_schlick(vec3(DIELECTRIC_F0), 1.0, cos_theta).x; }
