// The part of the light of a path that other surfaces can take up.
//
// What leaves the point that the first ray has met depends on where it goes, and a path knows it for one direction alone. But a part of the BSDF does
// not depend on it: with diffuse bases under an interface f_d = (1 - F(h)) base_color / pi (bsdf.glsl), it is never less than
//
//     f_min(l) = (1 - F(h_min(l))) base_color / pi       h_min: half vector of l and the direction, of all above the horizon, farthest from it
//
// since F falls with cos(h, l). f = f_min + rest: f_min is reused, the rest of the path stays with its own surface, and their sum is as before,
// sample by sample. Lambertian surfaces have no rest, mirrors have nothing else; at an index of 1.5 f_min reflects 81 % of the base colour, f_d 96 %.
#include "bounce_path.glsl"
#include "bounce_vertex.glsl"

// Least cosine at which the vertex may be seen: the mirror direction is above the triangle then, whatever the azimuth, and the shading normal is not bent
// towards the viewer (bsdf/shading_normal.glsl). 1: from nowhere. Bounds that depend on the viewer otherwise are not reused.
float reusable_cosine(BounceVertex v) {
    Bsdf b = v.bsdf;
    if (b.coat > 0.0 || max_component(b.sheen_color) > 0.0 || b.iridescence > 0.0 || b.transmission > 0.0) return 1.0;
    // As surface_bsdf turns it. MARGIN: more than the height that bend_normal() asks for, and the rounding of normals in reservoirs.
    const float MARGIN = 4e-3;
    float cosine = clamp(dot(v.front ? v.sampled.normal : -v.sampled.normal, b.face_normal), 0.0, 1.0);
    if (square(cosine) <= 0.5) return 1.0;
    return min(2.0 * cosine * sqrt(1.0 - square(cosine)) + MARGIN, 1.0);
}

// f_min |cos|; `wi`: where light comes from.
vec3 least_diffuse_cos(Bsdf b, vec3 wi) {
    vec3 l = wi * b.frame;
    if (l.z <= 0.0 || dot(b.face_normal, wi) <= 0.0) return vec3(0.0);
    float sine = sqrt(max(1.0 - square(l.z), 0.0));
    float farthest = sqrt(max(0.5 - 0.5 * sine, 0.0));
    float passed = (1.0 - b.metallic) * (1.0 - max_component(dielectric_fresnel(b, farthest)));
    return b.base_color * (max(passed, 0.0) * l.z * INV_PI);
}

// Its share of all light from there, `f_cos`.
vec3 least_diffuse_share(Bsdf b, vec3 wi, vec3 f_cos) {
    vec3 share = least_diffuse_cos(b, wi) / f_cos;
    return mix(vec3(0.0), clamp(share, 0.0, 1.0), greaterThan(f_cos, vec3(0.0)));
}
