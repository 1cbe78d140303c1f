// The scene's tables, bound as "scene_uniforms"; geometry is reached by device addresses, textures are bindless.
#include "records.glsl"
#include "math.glsl"

layout(set = 0, binding = 1, scalar) uniform scene_uniforms { SceneRecord scene; };
layout(set = 3, binding = 0) uniform sampler2D textures[];

layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer InstanceTable { InstanceRecord at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer MeshTable { MeshRecord at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer MaterialTable { MaterialRecord at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer LightTable { LightRecord at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer EmissiveTable { EmissiveRecord at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer AliasTable { AliasRecord at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer VertexTable { VertexRecord at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer PositionTable { vec3 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer IndexTable { uvec3 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer ClusterTable { ClusterNode at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer UintTable { uint at[]; };

InstanceRecord scene_instance(uint i) { return InstanceTable(scene.instances).at[i]; }
MeshRecord scene_mesh(uint i) { return MeshTable(scene.meshes).at[i]; }

vec2 triangle_uv(MeshRecord mesh, uvec3 index, vec2 bary, uint uv_set) {
    VertexTable v = VertexTable(mesh.vertices);
    vec2 a = uv_set == 0u ? vec2(v.at[index.x].uv0[0], v.at[index.x].uv0[1]) : vec2(v.at[index.x].uv1[0], v.at[index.x].uv1[1]);
    vec2 b = uv_set == 0u ? vec2(v.at[index.y].uv0[0], v.at[index.y].uv0[1]) : vec2(v.at[index.y].uv1[0], v.at[index.y].uv1[1]);
    vec2 c = uv_set == 0u ? vec2(v.at[index.z].uv0[0], v.at[index.z].uv0[1]) : vec2(v.at[index.z].uv1[0], v.at[index.z].uv1[1]);
    return a * (1.0 - bary.x - bary.y) + b * bary.x + c * bary.y;
}

vec2 transform_uv(TextureSlot slot, vec2 uv) {
    vec3 h = vec3(uv, 1.0);
    return vec2(dot(vec3(slot.transform[0][0], slot.transform[0][1], slot.transform[0][2]), h),
                dot(vec3(slot.transform[1][0], slot.transform[1][1], slot.transform[1][2]), h));
}

// Coverage test of MASK materials at the finest mip, for the traversal of all backends.
// BLEND surfaces count as covered: they are split by the primary rays, not by the traversal.
bool alpha_test(MeshRecord mesh, uint triangle, vec2 bary) {
    uint material_index = UintTable(mesh.triangle_materials).at[triangle];
    MaterialTable material = MaterialTable(scene.materials);
    if ((material.at[material_index].flags & MATERIAL_MASK) == 0u) return true;
    uvec3 index = IndexTable(mesh.indices).at[triangle];
    float alpha = material.at[material_index].base_color.w;
    VertexTable v = VertexTable(mesh.vertices);
    alpha *= unpackUnorm4x8(v.at[index.x].color).a * (1.0 - bary.x - bary.y) +
             unpackUnorm4x8(v.at[index.y].color).a * bary.x + unpackUnorm4x8(v.at[index.z].color).a * bary.y;
    TextureSlot slot = material.at[material_index].base_color_texture;
    if (slot.texture != NONE) {
        vec2 uv = transform_uv(slot, triangle_uv(mesh, index, bary, slot.uv_set));
        alpha *= textureLod(textures[nonuniformEXT(slot.texture)], uv, 0.0).a;
    }
    return alpha >= material.at[material_index].alpha_cutoff;
}
