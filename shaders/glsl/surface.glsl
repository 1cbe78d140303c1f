// From a hit to a surface: geometry in world space, now and in the last frame, and the material at it.
#include "scene.glsl"
#include "pack.glsl"

struct Surface {
    uint material;
    vec3 position;
    vec3 position_prev;  // the same point of the object in the last frame
    vec3 flat_normal;    // of the triangle, on the front side
    vec3 geo_normal;     // interpolated, on the front side
    vec4 tangent;        // w: sign of the bitangent
    vec2 uv[2];
    vec4 color;          // vertex colour
    vec3 e1, e2;         // edges, world space
    vec2 duv1[2], duv2[2]; // UV along the edges, per UV set
};

struct MaterialSample {
    vec3 base_color;
    float alpha;
    float metallic;
    float roughness;
    float specular;
    float transmission;
    vec3 normal;   // world space, normal map applied, on the side of geo_normal
    vec3 emission; // radiance
};

// UV change along two axes of the pixel's footprint, in units of surface barycentrics.
struct Footprint {
    vec2 bary_x;
    vec2 bary_y;
    float depth_range; // along the ray, metres
};

Surface load_surface(uint instance_index, uint triangle, vec2 barycentrics) {
    InstanceRecord instance = scene_instance(instance_index);
    MeshRecord mesh = scene_mesh(instance.mesh);
    uvec3 index = IndexTable(mesh.indices).at[triangle];
    PositionTable position = PositionTable(mesh.positions);
    VertexTable vertex = VertexTable(mesh.vertices);
    vec3 w = vec3(1.0 - barycentrics.x - barycentrics.y, barycentrics);
    PositionTable position_prev = PositionTable(mesh.positions_prev);
    vec3 p0 = position.at[index.x], p1 = position.at[index.y], p2 = position.at[index.z];
    precise vec3 object_position = w.x * p0 + w.y * p1 + w.z * p2;
    precise vec3 object_position_prev =
        w.x * position_prev.at[index.x] + w.y * position_prev.at[index.y] + w.z * position_prev.at[index.z];

    Surface s;
    s.material = UintTable(mesh.triangle_materials).at[triangle];
    s.position = transform_point(instance.world_from_object, object_position);
    s.position_prev = transform_point(instance.world_from_object_prev, object_position_prev);
    s.e1 = transform_vector(instance.world_from_object, p1 - p0);
    s.e2 = transform_vector(instance.world_from_object, p2 - p0);
    float side = instance.mirrored != 0u ? -1.0 : 1.0;
    s.flat_normal = normalize(cross(s.e1, s.e2)) * side;

    vec3 n = vec3(0.0), t = vec3(0.0);
    float bitangent_sign = 1.0;
    s.color = vec4(0.0);
    vec2 uv[2][3];
    for (int i = 0; i < 3; i++) {
        VertexRecord v = vertex.at[index[i]];
        vec4 tangent = unpack_tangent(v.tangent);
        n += w[i] * unpack_unit_vector(v.normal);
        t += w[i] * tangent.xyz;
        bitangent_sign = tangent.w;
        s.color += w[i] * unpackUnorm4x8(v.color);
        uv[0][i] = vec2(v.uv0[0], v.uv0[1]);
        uv[1][i] = vec2(v.uv1[0], v.uv1[1]);
    }
    // Normals go with the inverse transpose; object_from_world is the inverse, its transpose is applied.
    s.geo_normal = normalize(transform_transposed(instance.object_from_world, n));
    s.tangent = vec4(transform_vector(instance.world_from_object, t), bitangent_sign * side);
    for (int k = 0; k < 2; k++) {
        s.uv[k] = w.x * uv[k][0] + w.y * uv[k][1] + w.z * uv[k][2];
        s.duv1[k] = uv[k][1] - uv[k][0];
        s.duv2[k] = uv[k][2] - uv[k][0];
    }
    return s;
}

// Ellipse that a ray cone of `radius` cuts out of the triangle's plane: Akenine-Moller et al. 2021, "Improved Shader and
// Texture Level of Detail Using Ray Cones", JCGT 10(1), section 5.
Footprint cone_footprint(Surface s, vec3 direction, float radius) {
    vec3 n = s.flat_normal;
    vec3 a1 = direction - dot(n, direction) * n;
    if (dot(a1, a1) < 1e-8) a1 = basis_around(n)[0];
    vec3 a2 = cross(n, a1);
    a1 *= radius / max(1e-4 * length(a1), length(a1 - dot(direction, a1) * direction));
    a2 *= radius / max(1e-4 * length(a2), length(a2 - dot(direction, a2) * direction));

    vec3 area = cross(s.e1, s.e2);
    float scale = 1.0 / max(dot(area, area), 1e-30);
    Footprint f;
    f.bary_x = vec2(dot(cross(a1, s.e2), area), dot(cross(s.e1, a1), area)) * scale;
    f.bary_y = vec2(dot(cross(a2, s.e2), area), dot(cross(s.e1, a2), area)) * scale;
    // A pixel is at least as deep as its footprint is wide: keeps 1 / depth_range finite at normal incidence at any scale.
    f.depth_range = max(radius, abs(dot(a1, direction)) + abs(dot(a2, direction)));
    return f;
}

vec4 sample_texture(TextureSlot slot, Surface s, Footprint f, float lod_scale) {
    uint k = slot.uv_set;
    vec2 uv = transform_uv(slot, s.uv[k]);
    mat2 linear = mat2(slot.transform[0][0], slot.transform[1][0], slot.transform[0][1], slot.transform[1][1]);
    vec2 dx = linear * (s.duv1[k] * f.bary_x.x + s.duv2[k] * f.bary_x.y) * lod_scale;
    vec2 dy = linear * (s.duv1[k] * f.bary_y.x + s.duv2[k] * f.bary_y.y) * lod_scale;
    return textureGrad(textures[nonuniformEXT(slot.texture)], uv, dx, dy);
}

// `lod_scale` = 2^bias on the texture gradients.
MaterialSample load_material(Surface s, Footprint f, float lod_scale) {
    MaterialRecord m = MaterialTable(scene.materials).at[s.material];
    vec4 base = m.base_color * s.color;
    if (m.base_color_texture.texture != NONE) base *= sample_texture(m.base_color_texture, s, f, lod_scale);
    vec2 roughness_metallic = vec2(m.roughness, m.metallic);
    if (m.metallic_roughness_texture.texture != NONE) {
        roughness_metallic *= sample_texture(m.metallic_roughness_texture, s, f, lod_scale).gb;
    }
    MaterialSample r;
    r.base_color = clamp(base.rgb, 0.0, 1.0);
    r.alpha = (m.flags & MATERIAL_BLEND) != 0u ? clamp(base.a, 0.0, 1.0) : 1.0;
    r.roughness = clamp(roughness_metallic.x, 0.0, 1.0);
    r.metallic = clamp(roughness_metallic.y, 0.0, 1.0);
    r.specular = m.specular;
    r.transmission = m.transmission;
    r.emission = m.emissive;
    if (m.emissive_texture.texture != NONE) r.emission *= sample_texture(m.emissive_texture, s, f, lod_scale).rgb;

    r.normal = s.geo_normal;
    if (m.normal_texture.texture != NONE) {
        vec3 n = sample_texture(m.normal_texture, s, f, lod_scale).xyz * 2.0 - 1.0;
        n.xy *= m.normal_scale;
        vec3 tangent = s.tangent.xyz - dot(s.tangent.xyz, s.geo_normal) * s.geo_normal;
        if (dot(tangent, tangent) > 0.0) {
            tangent = normalize(tangent);
            vec3 bitangent = cross(s.geo_normal, tangent) * s.tangent.w;
            vec3 mapped = tangent * n.x + bitangent * n.y + s.geo_normal * n.z;
            if (dot(mapped, mapped) > 0.0) r.normal = normalize(mapped);
        }
    }
    return r;
}
