// Homogeneous absorbing media behind solid surfaces (KHR_materials_volume, KHR_materials_ior) along a path, from the list of the
// solids that it is inside of (interior.glsl). Lengths are metres; the vacuum has index 1 and absorbs nothing.
//
//     float medium_ior(uint material)                                  index of refraction of what a Crossing names
//     float medium_eta(Crossing c)                                     ior behind over ior in front: Bsdf::eta
//     vec3 medium_transmittance(InteriorList list, float length)       Beer and Lambert, for `length` inside what is there
#include "dielectric.glsl"
#include "interior.glsl"
#include "scene.glsl"

float medium_ior(uint material) { return material == NONE ? 1.0 : MaterialTable(scene.materials).at[material].ior; }

float medium_eta(Crossing c) { return medium_ior(c.behind) / medium_ior(c.front); }

vec3 medium_transmittance(InteriorList list, float length) {
    uint material = interior_top(list);
    if (material == NONE) return vec3(1.0);
    MaterialTable materials = MaterialTable(scene.materials);
    return absorption(materials.at[material].attenuation_color, materials.at[material].attenuation_distance, length);
}
