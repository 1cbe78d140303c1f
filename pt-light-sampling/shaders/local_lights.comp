// The local lights where they are now. Extent: one thread a light.
#include "lights/local_lights.glsl"
#include "local_lights_records.glsl"

layout(local_size_x = 64) in;

layout(buffer_reference, scalar, buffer_reference_align = 16) writeonly buffer LocalLightsOut { LocalLightRecord at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) writeonly buffer LightCandidatesOut { LightCandidateRecord at[]; };
layout(push_constant, scalar) uniform Push { LocalLightsPush push; };

LocalLightRecord triangle_light(uint i) {
    EmissiveRecord e = EmissiveTable(scene.emissives).at[i];
    InstanceRecord instance = scene_instance(e.instance);
    MeshRecord mesh = scene_mesh(instance.mesh);
    uvec3 index = IndexTable(mesh.indices).at[e.triangle];
    PositionTable p = PositionTable(mesh.positions);
    vec3 v0 = p.at[index.x];
    vec3 e1 = transform_vector(instance.world_from_object, p.at[index.y] - v0);
    vec3 e2 = transform_vector(instance.world_from_object, p.at[index.z] - v0);
    MaterialRecord m = MaterialTable(scene.materials).at[material_of(instance, mesh, e.triangle)];
    uint kind = LOCAL_TRIANGLE;
    if ((m.flags & MATERIAL_DOUBLE_SIDED) != 0u) kind |= LOCAL_DOUBLE_SIDED;
    if (m.emissive_texture.texture != NONE || e.triangle >= mesh.first_masked) kind |= LOCAL_TEXTURED;
    vec3 origin = transform_point(instance.world_from_object, v0);
    // The front is where cross(edge1, edge2) points to.
    if (instance.mirrored != 0u) return LocalLightRecord(origin, kind | LOCAL_SWAPPED, e2, e.luminance, e1, 0u, m.emissive, 0u);
    return LocalLightRecord(origin, kind, e1, e.luminance, e2, 0u, m.emissive, 0u);
}

LocalLightRecord positional_light(uint i) {
    LightRecord l = LightTable(scene.light_tables.lights).at[scene.light_tables.sun_count + i];
    uint kind = l.kind == LIGHT_SPOT ? LOCAL_SPOT : LOCAL_POINT;
    return LocalLightRecord(l.position, kind, vec3(l.radius, l.spot_scale, l.spot_offset), luminance(l.intensity), l.direction, 0u, l.intensity, 0u);
}

LocalLightRecord environment_light(uint i) {
    EnvironmentQuadRecord q = environment_quad(i);
    vec2 r = scene.environment_rotation;
    vec3 axis = vec3(r.x * q.axis.x + r.y * q.axis.z, q.axis.y, r.x * q.axis.z - r.y * q.axis.x);
    vec3 spread = vec3(q.cos_spread, sqrt(max(1.0 - q.cos_spread * q.cos_spread, 0.0)), 0.0);
    float intensity = scene.environment_intensity;
    return LocalLightRecord(axis, LOCAL_ENVIRONMENT, spread, q.irradiance * intensity, vec3(r, intensity), 0u, vec3(0.0), 0u);
}

LocalLightRecord light_now(uint i) {
    switch (kind_of_light(i)) {
    case KIND_EMISSIVE: return triangle_light(i);
    case KIND_POSITIONAL: return positional_light(i - first_positional_light());
    default: return environment_light(i - first_environment_light());
    }
}

void main() {
    uint i = gl_GlobalInvocationID.y * push.width + gl_GlobalInvocationID.x;
    if (gl_GlobalInvocationID.x >= push.width || i >= push.count) return;
    LocalLightRecord light = light_now(i);
    LocalLightsOut(push.local_lights).at[i] = light;
    LightCandidatesOut(push.light_candidates).at[i] = light_candidate(light);
}
