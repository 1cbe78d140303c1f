// Stores a surface to the G-buffer, whether a primary ray or a bounce found it.
#include "bsdf/shading_normal.glsl"
#include "channels.glsl"
#include "clusters.glsl"
#include "gbuffer_format.glsl"
#include "reflectance.glsl"
#include "sky.glsl"
#include "surface.glsl"
#include "texture_random.glsl"

struct SeenSurface {
    Hit hit;
    Surface geometry;
    vec3 position_prev; // of the same point of the object in the last frame
    MaterialSample material;
    bool front;       // seen from the front side
    vec3 face_normal; // all three normals are on the viewer's side
    vec3 vertex_normal;
    vec3 normal;      // shading normal
    float inverse_depth_range; // 1 / m
    vec4 overlay;     // its part of channel transparent: emission (alpha 0), or an unlit material's colour (alpha 1)
};

// `key`: channel rng_seed; `radius`: of the pixel's cone at the hit, metres.
SeenSurface seen_surface(uvec2 key, Hit hit, vec3 direction, float radius, float lod_scale) {
    SeenSurface s;
    s.hit = hit;
    s.geometry = load_surface(hit.instance, hit.triangle, hit.barycentrics);
    s.position_prev = previous_position(hit.instance, hit.triangle, hit.barycentrics);
    Footprint footprint = cone_footprint(s.geometry, direction, radius, texture_random(key, hit.instance));
    s.inverse_depth_range = 1.0 / footprint.depth_range;
    s.material = load_material(s.geometry, footprint, lod_scale);

    s.front = dot(s.geometry.face_normal, direction) < 0.0;
    s.face_normal = s.front ? s.geometry.face_normal : -s.geometry.face_normal;
    // Normals of the file that point into the surface are worth nothing: the triangle's own.
    s.vertex_normal = s.front ? s.geometry.vertex_normal : -s.geometry.vertex_normal;
    if (dot(s.vertex_normal, s.face_normal) <= 0.0) s.vertex_normal = s.face_normal;
    s.normal = bend_normal(s.front ? s.material.normal : -s.material.normal, s.face_normal, -direction);

    uint flags = MaterialTable(scene.materials).at[s.geometry.material].flags;
    bool emits = s.front || (flags & MATERIAL_DOUBLE_SIDED) != 0u;
    s.overlay = emits ? vec4(s.material.emission, 0.0) : vec4(0.0);
    if ((flags & MATERIAL_UNLIT) != 0u) s.overlay = vec4(s.material.base_color, 1.0);
    return s;
}

void store_surface(ivec2 p, SeenSurface s) {
    imageStore(ch_visibility, p, uvec4(s.hit.instance, s.hit.triangle, 0, 0));
    imageStore(ch_barycentrics, p, vec4(s.hit.barycentrics, 0.0, 0.0));
    imageStore(ch_cluster, p, uvec4(cluster_of(s.geometry.position)));
    // What is transmitted does not leave diffusely: the dielectric's diffuse base is what remains (KHR_materials_transmission).
    vec3 base = s.material.base_color * mix(1.0 - s.material.transmission, 1.0, s.material.metallic);
    vec3 f0 = dielectric_f0(s.material.ior, s.material.specular, s.material.specular_color);
    imageStore(ch_base_color, p, base_color_code(vec4(base, max_component(f0))));
    imageStore(ch_metallic_roughness, p, vec4(s.material.metallic, s.material.roughness, 0.0, 0.0));
    imageStore(ch_normal, p, uvec4(pack_unit_vector(s.normal)));
    imageStore(ch_vertex_normal, p, uvec4(pack_unit_vector(s.vertex_normal)));
    imageStore(ch_shading_position, p, vec4(s.geometry.position, uintBitsToFloat(s.geometry.material + 1u)));
}

void store_no_surface(ivec2 p) {
    imageStore(ch_visibility, p, uvec4(NONE, NONE, 0, 0));
    imageStore(ch_barycentrics, p, vec4(0.0));
    imageStore(ch_cluster, p, uvec4(NO_CLUSTER));
    imageStore(ch_base_color, p, vec4(0.0));
    imageStore(ch_metallic_roughness, p, vec4(0.0));
    imageStore(ch_normal, p, uvec4(0));
    imageStore(ch_vertex_normal, p, uvec4(0));
    imageStore(ch_shading_position, p, vec4(0.0));
}
