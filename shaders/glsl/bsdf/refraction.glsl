// Rough interface between two dielectrics: Walter et al. 2007, "Microfacet Models for Refraction through Rough Surfaces", with
// visible normals (Heitz 2018). Directions are in the frame of the surface; v.z > 0 is the side of the viewer, l.z < 0 the far
// one; `eta`: index of refraction on the far side over that on the side of v. Host twin: pt_reference::oracle::dielectric.
//
// Radiance, not importance: light that comes from l is spread over another solid angle on the side of v, f has the factor
// 1 / eta^2 (Veach 1997, sec. 5.2). Around a closed solid the factors of entry and exit cancel.
#include "bsdf/ggx.glsl"

// An interface with an index this close to 1 has no half vector in fp32: it is passed straight.
const float INDEX_MATCHED = 1e-3;

bool is_index_matched(float eta) { return abs(eta - 1.0) < INDEX_MATCHED; }

struct Refraction {
    vec3 h;         // normal of the microfacet, h.z > 0
    float density;  // of l per solid angle, when microfacets are drawn by visible normals. 0: no microfacet refracts so
    float value;    // BTDF x |l.z|, without 1 - F
};

// Half vector: eq. 16, turned to the side of v. Jacobian: eq. 17. BTDF: eq. 21 with separable masking, which leaves
// G1(l) / eta^2 of the density.
Refraction refraction(vec3 v, vec3 l, vec2 alpha, float eta) {
    vec3 h = normalize(v + eta * l);
    h = h.z < 0.0 ? -h : h;
    float vh = dot(v, h), lh = dot(l, h);
    if (vh <= 0.0 || lh >= 0.0) return Refraction(h, 0.0, 0.0);
    float jacobian = square(eta) * -lh / square(vh + eta * lh);
    float density = ggx_vndf_pdf(v, h, alpha) * jacobian;
    return Refraction(h, density, density * ggx_g1(alpha, l) / square(eta));
}

// A thin sheet with rough faces scatters what it lets through as it does what it reflects, to the other side and without
// bending it (KHR_materials_transmission).
vec3 through_thin(vec3 l) { return vec3(l.xy, -l.z); }
