// The scene's tables, bound as "scene_uniforms"; geometry is reached by device addresses, textures are bindless.
#include "records.glsl"
#include "math.glsl"

layout(set = 0, binding = 1, scalar) uniform scene_uniforms { SceneRecord scene; };
layout(set = 3, binding = 0) uniform sampler2D textures[];

// FEATURE_* of the scene. Kernels that are specialised leave out what it has not: devices that compile the whole kernel into one piece
// pay for every branch, in registers or, without branches, in time.
layout(constant_id = 0) const uint scene_features = 0xffffffffu;

#define scene_has(feature) ((scene_features & (feature)) != 0u)

layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer InstanceTable { InstanceRecord at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer MeshTable { MeshRecord at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer MaterialTable { MaterialRecord at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer LobeTable { LobeRecord at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer LightTable { LightRecord at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer EmissiveTable { EmissiveRecord at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer AliasTable { AliasRecord at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer VertexTable { VertexRecord at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer PositionTable { vec3 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer ColorTable { vec4 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer IndexTable { uvec3 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer CameraTable { CameraRecord at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer ClusterTable { ClusterNode at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer UintTable { uint at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer LocalLightTable { LocalLightRecord at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer ClusterListTable { ClusterListRecord at[]; };

InstanceRecord scene_instance(uint i) {
    if (!scene_has(FEATURE_INSTANCES)) return scene.first_instance;
    return InstanceTable(scene.instances).at[i];
}

// Of an instance.
MeshRecord scene_mesh(uint i) {
    if (!scene_has(FEATURE_INSTANCES)) return scene.first_mesh;
    return MeshTable(scene.meshes).at[i];
}

// Weighted by barycentrics, in a fixed order: visibility must come out the same in every kernel. What is equal at all vertices stays so
// to the bit.
vec2 interpolate(vec2 a, vec2 b, vec2 c, vec2 bary) {
    precise vec2 r = fma(c - a, bary.yy, fma(b - a, bary.xx, a));
    return r;
}

bool is_first_uv(TextureSlot slot) { return !scene_has(FEATURE_SECOND_UV) || (slot.flags & TEXTURE_SECOND_UV) == 0u; }

vec4 vertex_color(MeshRecord mesh, uint vertex) {
    return scene_has(FEATURE_VERTEX_COLOR) && mesh.colors != 0ul ? ColorTable(mesh.colors).at[vertex] : vec4(1.0);
}

vec2 triangle_uv(MeshRecord mesh, uvec3 index, vec2 bary, TextureSlot slot) {
    VertexTable v = VertexTable(mesh.vertices);
    bool first = is_first_uv(slot);
    vec2 a = first ? vec2(v.at[index.x].uv0[0], v.at[index.x].uv0[1]) : vec2(v.at[index.x].uv1[0], v.at[index.x].uv1[1]);
    vec2 b = first ? vec2(v.at[index.y].uv0[0], v.at[index.y].uv0[1]) : vec2(v.at[index.y].uv1[0], v.at[index.y].uv1[1]);
    vec2 c = first ? vec2(v.at[index.z].uv0[0], v.at[index.z].uv0[1]) : vec2(v.at[index.z].uv1[0], v.at[index.z].uv1[1]);
    return interpolate(a, b, c, bary);
}

vec2 transform_uv(TextureSlot slot, vec2 uv) {
    if (!scene_has(FEATURE_TEXTURE_TRANSFORM)) return uv;
    precise vec2 r = fma(vec2(slot.transform[0][0], slot.transform[1][0]), uv.xx,
                         fma(vec2(slot.transform[0][1], slot.transform[1][1]), uv.yy,
                             vec2(slot.transform[0][2], slot.transform[1][2])));
    return r;
}

uint material_of(InstanceRecord instance, MeshRecord mesh, uint triangle) {
    return instance.material != NONE ? instance.material : UintTable(mesh.triangle_materials).at[triangle];
}

// Share of the light that a point of a triangle stops, 0..1: alpha of BLEND materials, 0 or 1 for MASK. At the finest mip.
// An instance with a material of its own has no alpha.
float coverage(MeshRecord mesh, uint triangle, vec2 bary) {
    uint material_index = UintTable(mesh.triangle_materials).at[triangle];
    MaterialTable material = MaterialTable(scene.materials);
    uint flags = material.at[material_index].flags;
    if ((flags & (MATERIAL_MASK | MATERIAL_BLEND)) == 0u) return 1.0;
    uvec3 index = IndexTable(mesh.indices).at[triangle];
    float vertex_alpha = interpolate(vec2(vertex_color(mesh, index.x).a), vec2(vertex_color(mesh, index.y).a),
                                     vec2(vertex_color(mesh, index.z).a), bary).x;
    float alpha = material.at[material_index].base_color.w * vertex_alpha;
    TextureSlot slot = material.at[material_index].base_color_texture;
    if (slot.texture != NONE) {
        vec2 uv = transform_uv(slot, triangle_uv(mesh, index, bary, slot));
        alpha *= textureLod(textures[nonuniformEXT(slot.texture)], uv, 0.0).a;
    }
    if ((flags & MATERIAL_MASK) != 0u) return alpha >= material.at[material_index].alpha_cutoff ? 1.0 : 0.0;
    return clamp(alpha, 0.0, 1.0);
}
