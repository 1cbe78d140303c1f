// Directional albedos of white lobes, looked up in tables. The scene has the buffer "bsdf_tables". Host twin:
// pt_reference::oracle::albedo.
#include "math.glsl"

// Directional albedos for perceptual roughnesses 0..1 (rows), from pt_scene::bsdf_tables. A buffer, since drivers that
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

// Directional albedo of a white sheen (sheen.glsl).
float charlie_albedo(float cos_theta, float alpha) {
    float albedo;
    LOOK_UP(CHARLIE_ALBEDO, sqrt(cos_theta), sqrt(alpha), albedo);
    return albedo;
}
