// The direct lighting pass with the plainest visibility there is: every triangle of every instance, in world space.
#include "scene.glsl"

layout(local_size_x = 8, local_size_y = 4) in;

bool trace_occluded(Ray ray, uint mask) {
    for (uint i = 0u; i < scene.instance_count; i++) {
        InstanceRecord instance = scene_instance(i);
        MeshRecord mesh = scene_mesh(instance.mesh);
        if ((instance.mask & mask) == 0u) continue;
        for (uint t = 0u; t < mesh.triangle_count; t++) {
            uvec3 index = IndexTable(mesh.indices).at[t];
            PositionTable p = PositionTable(mesh.positions);
            vec3 a = transform_point(instance.world_from_object, p.at[index.x]);
            vec3 e1 = transform_point(instance.world_from_object, p.at[index.y]) - a;
            vec3 e2 = transform_point(instance.world_from_object, p.at[index.z]) - a;
            vec3 h = cross(ray.direction, e2), s = ray.origin - a, q = cross(s, e1);
            float determinant = dot(e1, h);
            if (determinant == 0.0) continue;
            float u = dot(s, h) / determinant, v = dot(ray.direction, q) / determinant, d = dot(e2, q) / determinant;
            if (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && d >= ray.t_min && d <= ray.t_max) return true;
        }
    }
    return false;
}

#include "../../shaders/direct_lighting.glsl"

void main() {
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(p, imageSize(ch_color_hf)))) return;
    direct_lighting(p);
}
