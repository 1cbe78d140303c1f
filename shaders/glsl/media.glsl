// Homogeneous absorbing media behind solid surfaces (KHR_materials_volume, KHR_materials_ior) along a path, from the list of the
// solids that it is inside of (interior.glsl). Lengths are metres; the vacuum has index 1 and absorbs nothing.
//
//     bool is_solid(MaterialRecord m)                              its surfaces bound a medium: a Boundary, BSDF_SOLID
//     Boundary medium_boundary(uint material)                      of a surface of that material
//     bool is_inside(InteriorList list)                            whether there is any solid
//     float medium_eta(Crossing c)                                 ior beyond over ior here: Bsdf::eta at a true hit
//     InteriorList interior_of(uvec4 words)                        a list that was stored without the indices of refraction
//     float channel_ior(Solid s, uint channel)                     index of refraction of a solid for one colour
//     float surface_eta(InteriorList list, float ior)              the same for a surface that bounds no medium
//     vec3 medium_transmittance(InteriorList list, float length)   Beer and Lambert, for `length` inside what is there
//
// At a hit of a path with list `interior` after a segment of length t:
//
//     throughput *= medium_transmittance(interior, t);
//     if (is_solid(material)) {
//         Crossing c = interior_crossing(interior, medium_boundary(material), entering);
//         if (is_false_hit(c)) { interior = interior_cross(...); go on from the other side of the surface; }
//         eta = medium_eta(c);                       and, if the sample has SAMPLE_TRANSMISSION, interior = interior_cross(...)
//     } else eta = surface_eta(interior, ior);
#include "absorption.glsl"
#include "interior.glsl"
#include "scene.glsl"

bool is_solid(MaterialRecord m) { return scene_has(FEATURE_TRANSMISSION) && m.transmission > 0.0 && m.thickness > 0.0; }

// Solids are told apart by what is in them: `medium` stands for all materials that have the same (MaterialRecord.medium).
Solid medium_solid(uint medium) {
    MaterialTable materials = MaterialTable(scene.materials);
    return make_solid(medium, materials.at[medium].nesting & 0xffu, materials.at[medium].ior);
}

Boundary medium_boundary(uint material) {
    MaterialTable materials = MaterialTable(scene.materials);
    uint exterior = materials.at[material].nesting >> 8u;
    Solid front = VACUUM;
    if (exterior != 0u) front = medium_solid(exterior - 1u);
    return Boundary(medium_solid(materials.at[material].medium), front);
}

bool is_inside(InteriorList list) { return scene_has(FEATURE_TRANSMISSION) && any(notEqual(list.words, uvec4(0u))); }

InteriorList interior_of(uvec4 words) {
    InteriorList list = EMPTY_INTERIOR;
    list.words = words;
    for (int i = 0; i < 4; i++) {
        if (words[i] != 0u) list.iors[i] = MaterialTable(scene.materials).at[solid_medium(Solid(words[i], 1.0))].ior;
    }
    return list;
}

float medium_eta(Crossing c) { return c.beyond.ior / c.here.ior; }

float surface_eta(InteriorList list, float ior) {
    return scene_has(FEATURE_TRANSMISSION) ? ior / interior_top(list).ior : ior;
}

// Index of refraction of a solid for red, green or blue light. KHR_materials_dispersion: the file's index is that of green light, red and
// blue are as far from it as the Abbe number says.
float channel_ior(Solid s, uint channel) {
    if (!scene_has(FEATURE_LOBES) || s.word == 0u) return s.ior;
    uint lobes = MaterialTable(scene.materials).at[solid_medium(s)].lobes;
    if (lobes == NONE) return s.ior;
    float spread = (s.ior - 1.0) * 0.025 * LobeTable(scene.lobes).at[lobes].dispersion;
    return s.ior + (float(channel) - 1.0) * spread;
}

vec3 medium_transmittance(InteriorList list, float length) {
    if (!scene_has(FEATURE_TRANSMISSION)) return vec3(1.0);
    Solid s = interior_top(list);
    if (s.word == 0u) return vec3(1.0);
    MaterialTable materials = MaterialTable(scene.materials);
    uint medium = solid_medium(s);
    return absorption(materials.at[medium].attenuation_color, materials.at[medium].attenuation_distance, length);
}
