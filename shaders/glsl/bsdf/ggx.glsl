// GGX microfacets: distribution, masking, visible normals; for the BRDF of the real-time stages (brdf.glsl), their glass
// (smooth_surface.glsl) and the BSDF of the reference (bsdf.glsl). Directions are unit vectors in the frame of the surface (+Z: normal, +X: tangent); `alpha` is the
// roughness along tangent and bitangent, both > 0. v is the side that light leaves to, above the surface.
//
// Distribution: Walter et al. 2007, "Microfacet Models for Refraction through Rough Surfaces", eq. 33; anisotropic: Burley 2012,
// eq. 13. Masking: Smith, Heitz 2014, "Understanding the Masking-Shadowing Function", eq. 86 (anisotropic Lambda), 43 (G1), 99
// (height-correlated G2). Visible normals: Heitz 2018, "Sampling the GGX Distribution of Visible Normals", drawn with the
// spherical caps of Dupuy and Benyoub 2023. Host twin: pt_reference::oracle::ggx.
#include "math.glsl"

// sin^2 is taken from x and y: 1 - h.z^2 has no digits left at the peak of a smooth surface.
float ggx_d(vec2 alpha, vec3 h) {
    vec2 slope = h.xy / alpha;
    return 1.0 / (PI * alpha.x * alpha.y * square(dot(slope, slope) + h.z * h.z));
}

float ggx_d(float alpha, vec3 h) { return ggx_d(vec2(alpha), h); }

// |cos| (1 + 2 Lambda): the root that all of Smith's terms are made of.
float ggx_root(vec2 alpha, vec3 v) { return length(vec3(alpha * v.xy, v.z)); }

float ggx_g1(vec2 alpha, vec3 v) { return 2.0 * abs(v.z) / (abs(v.z) + ggx_root(alpha, v)); }

// G2 / (4 v.z l.z) of a reflection.
float ggx_visibility(vec2 alpha, vec3 v, vec3 l) { return 0.5 / (l.z * ggx_root(alpha, v) + v.z * ggx_root(alpha, l)); }

// Normal from the distribution of those visible from `v` (v.z > 0).
vec3 sample_ggx_vndf(vec3 v, vec2 alpha, vec2 xi) {
    vec3 stretched = normalize(vec3(alpha * v.xy, v.z));
    float phi = 2.0 * PI * xi.x;
    float z = (1.0 - xi.y) * (1.0 + stretched.z) - stretched.z;
    float sin_theta = sqrt(clamp(1.0 - z * z, 0.0, 1.0));
    vec3 h = vec3(sin_theta * cos(phi), sin_theta * sin(phi), z) + stretched;
    return normalize(vec3(alpha * h.xy, max(h.z, 0.0)));
}

vec3 sample_ggx_vndf(vec3 v, float alpha, vec2 xi) { return sample_ggx_vndf(v, vec2(alpha), xi); }

// Its density per solid angle of h: G1(v) max(0, v.h) D(h) / v.z (Heitz 2018, eq. 3).
float ggx_vndf_pdf(vec3 v, vec3 h, vec2 alpha) {
    return 2.0 * max(dot(v, h), 0.0) * ggx_d(alpha, h) / (v.z + ggx_root(alpha, v));
}

// Density, per solid angle of l, of reflecting v about such a normal: G1(v) D(h) / (4 v.z) (Heitz 2018, eq. 17). `d`: D(h), times the
// probability of the lobe if the density is to be that of a mixture.
float ggx_reflection_pdf(float d, vec3 v, vec2 alpha) { return 0.5 * d / (v.z + ggx_root(alpha, v)); }

float ggx_reflection_pdf(vec3 v, vec3 l, vec2 alpha) { return ggx_reflection_pdf(ggx_d(alpha, normalize(v + l)), v, alpha); }

float ggx_reflection_pdf(vec3 v, vec3 l, float alpha) { return ggx_reflection_pdf(v, l, vec2(alpha)); }

// Weights, but for Fresnel's term, of directions that were found by a visible normal. Reflected: G2 / G1(v), height-correlated as in
// ggx_visibility. 0 below the horizon.
float ggx_reflection_weight(vec3 v, vec3 l, vec2 alpha) {
    float a = ggx_root(alpha, v), b = ggx_root(alpha, l);
    return l.z <= 0.0 ? 0.0 : l.z * (v.z + a) / (l.z * a + v.z * b);
}

// Refracted: G1(l), separable. 0 above the horizon.
float ggx_refraction_weight(vec3 l, vec2 alpha) { return l.z >= 0.0 ? 0.0 : ggx_g1(alpha, l); }
