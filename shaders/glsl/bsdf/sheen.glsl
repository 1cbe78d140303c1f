// Lobe: sheen of fibres, after Estevez and Kulla 2017 (KHR_materials_sheen). It takes its light from what lies below. Host twin:
// pt_reference::oracle::layers.
#include "bsdf/albedo.glsl"
#include "bsdf/model.glsl"

// Estevez and Kulla 2017, "Production Friendly Microfacet Sheen BRDF", eq. 2 (distribution) and 3 with table 1 (masking).
// alpha = roughness^2.
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

bool has_sheen(Bsdf b) { return max_component(b.sheen_color) > 0.0; }

// Part of the light at that angle which the sheen leaves to the base.
float under_sheen(Bsdf b, float cos_theta) {
    return has_sheen(b) ? max(1.0 - max_component(b.sheen_color) * charlie_albedo(cos_theta, b.sheen_alpha), 0.0) : 1.0;
}

// The lobe over `base`, which it attenuates on both ways of the light. Its directions are drawn with the diffuse lobe, which is about
// as wide.
BsdfValue sheen_evaluate(Bsdf b, vec3 l, BsdfValue base) {
    if (!has_sheen(b)) return base;
    vec3 v = b.local_wo;
    float albedo = max(charlie_albedo(v.z, b.sheen_alpha), charlie_albedo(l.z, b.sheen_alpha));
    base.f_cos *= max(1.0 - max_component(b.sheen_color) * albedo, 0.0);
    base.f_cos += b.sheen_color * charlie(v, l, b.sheen_alpha);
    return base;
}
