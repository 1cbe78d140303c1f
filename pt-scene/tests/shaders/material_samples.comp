// surface.glsl on given points of a scene: base layer and lobes.
#include "surface.glsl"
#include "test_records.glsl"

layout(local_size_x = 64) in;
layout(set = 2, binding = 0, scalar) readonly buffer cases { MaterialCase case_at[]; };
layout(set = 2, binding = 1, scalar) writeonly buffer results { MaterialResult result_at[]; };

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= case_at.length()) return;
    MaterialCase c = case_at[i];
    Surface s = load_surface(c.instance, c.triangle, c.barycentrics);
    // The test's quads have their UV edges along the axes: the second one along u.
    Footprint f = Footprint(vec2(0.0, c.footprint.x), vec2(c.footprint.y, 0.0), 1.0, vec4(c.random_texel, c.random_level_place));
    MaterialSample m = load_material(s, f, 1.0);
    LobesSample l = load_lobes(s, f, 1.0);
    result_at[i] = MaterialResult(m.base_color, coverage(scene_mesh(scene_instance(c.instance).mesh), c.triangle, c.barycentrics), m.metallic, m.roughness, m.ior, m.specular, m.specular_color,
                                  m.transmission, m.normal, m.emission, l.clearcoat, l.clearcoat_roughness,
                                  l.clearcoat_normal, l.sheen_color, l.sheen_roughness, l.anisotropy,
                                  l.anisotropy_direction, l.iridescence, l.iridescence_ior, l.iridescence_thickness,
                                  l.dispersion);
}
