// From a hit to a surface: geometry in world space, now and in the last frame, and the material at it.
#include "scene.glsl"
#include "pack.glsl"
#include "texture_filter.glsl"
#include "waves.glsl"

struct Surface {
    uint material;
    vec3 position;
    vec3 face_normal;    // of the triangle, on the front side
    vec3 vertex_normal;  // interpolated, on the front side
    vec4 tangent;        // w: sign of the bitangent
    vec2 uv[2];
    vec4 color;          // vertex colour
    vec3 e1, e2;         // edges, world space
    vec2 duv1[2], duv2[2]; // UV along the edges, per UV set
};

struct MaterialSample {
    vec3 base_color;
    float metallic;
    float roughness;
    float ior;
    float specular;       // KHR_materials_specular
    vec3 specular_color;
    float transmission;
    vec3 normal;   // world space, normal map applied, on the side of vertex_normal
    vec3 emission; // radiance
};

// Lobes of KHR extensions over and in the base layer; a factor of 0: the lobe is absent.
struct LobesSample {
    float clearcoat;
    float clearcoat_roughness;
    vec3 clearcoat_normal;       // world space, as MaterialSample::normal
    vec3 sheen_color;
    float sheen_roughness;
    float anisotropy;            // strength
    vec2 anisotropy_direction;   // unit vector in the tangent plane: x along the first, y along the second column of tangent_frame
    float iridescence;
    float iridescence_ior;
    float iridescence_thickness; // nm
    float dispersion;            // 20 / Abbe number
};

// UV change along two axes of the pixel's footprint, in units of surface barycentrics.
struct Footprint {
    vec2 bary_x;
    vec2 bary_y;
    float depth_range; // along the ray, metres; 0: no footprint
    vec4 random;       // of the stochastic texture filter, which draws a texel in the footprint
};

// Textures at their finest level.
const Footprint NO_FOOTPRINT = Footprint(vec2(0.0), vec2(0.0), 0.0, vec4(0.0));

// Where the same point of the object was in the last frame.
vec3 previous_position(uint instance_index, uint triangle, vec2 barycentrics) {
    InstanceRecord instance = scene_instance(instance_index);
    MeshRecord mesh = scene_mesh(instance.mesh);
    uvec3 index = IndexTable(mesh.indices).at[triangle];
    PositionTable position = PositionTable(mesh.positions_prev);
    vec3 w = vec3(1.0 - barycentrics.x - barycentrics.y, barycentrics);
    precise vec3 object_position = w.x * position.at[index.x] + w.y * position.at[index.y] + w.z * position.at[index.z];
    return transform_point(instance.world_from_object_prev, object_position);
}

Surface load_surface(uint instance_index, uint triangle, vec2 barycentrics) {
    InstanceRecord instance = scene_instance(instance_index);
    MeshRecord mesh = scene_mesh(instance.mesh);
    uvec3 index = IndexTable(mesh.indices).at[triangle];
    PositionTable position = PositionTable(mesh.positions);
    VertexTable vertex = VertexTable(mesh.vertices);
    vec3 w = vec3(1.0 - barycentrics.x - barycentrics.y, barycentrics);
    vec3 p0 = position.at[index.x], p1 = position.at[index.y], p2 = position.at[index.z];
    precise vec3 object_position = w.x * p0 + w.y * p1 + w.z * p2;

    Surface s;
    s.material = material_of(instance, mesh, triangle);
    s.position = transform_point(instance.world_from_object, object_position);
    s.e1 = transform_vector(instance.world_from_object, p1 - p0);
    s.e2 = transform_vector(instance.world_from_object, p2 - p0);
    float side = instance.mirrored != 0u ? -1.0 : 1.0;
    s.face_normal = normalize(cross(s.e1, s.e2)) * side;

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
        s.color += w[i] * vertex_color(mesh, index[i]);
        uv[0][i] = vec2(v.uv0[0], v.uv0[1]);
        uv[1][i] = vec2(v.uv1[0], v.uv1[1]);
    }
    // Normals go with the inverse transpose; object_from_world is the inverse, its transpose is applied.
    s.vertex_normal = normalize(transform_transposed(instance.object_from_world, n));
    s.tangent = vec4(transform_vector(instance.world_from_object, t), bitangent_sign * side);
    for (int k = 0; k < 2; k++) {
        s.uv[k] = w.x * uv[k][0] + w.y * uv[k][1] + w.z * uv[k][2];
        s.duv1[k] = uv[k][1] - uv[k][0];
        s.duv2[k] = uv[k][2] - uv[k][0];
    }
    return s;
}

// Ellipse that a ray cone of `radius` cuts out of the triangle's plane: Akenine-Moller et al. 2021, "Improved Shader and
// Texture Level of Detail Using Ray Cones", JCGT 10(1), section 5. `random`: texture_random().
Footprint cone_footprint(Surface s, vec3 direction, float radius, vec4 random) {
    vec3 n = s.face_normal;
    vec3 a1 = direction - dot(n, direction) * n;
    if (dot(a1, a1) < 1e-8) a1 = basis_around(n)[0];
    vec3 a2 = cross(n, a1);
    a1 *= radius / max(1e-4 * length(a1), length(a1 - dot(direction, a1) * direction));
    a2 *= radius / max(1e-4 * length(a2), length(a2 - dot(direction, a2) * direction));

    vec3 area = cross(s.e1, s.e2);
    float scale = 1.0 / max(dot(area, area), 1e-30);
    Footprint f;
    f.random = random;
    f.bary_x = vec2(dot(cross(a1, s.e2), area), dot(cross(s.e1, a1), area)) * scale;
    f.bary_y = vec2(dot(cross(a2, s.e2), area), dot(cross(s.e1, a2), area)) * scale;
    // A pixel is at least as deep as its footprint is wide: keeps 1 / depth_range finite at normal incidence at any scale.
    f.depth_range = max(radius, abs(dot(a1, direction)) + abs(dot(a2, direction)));
    return f;
}

vec4 sample_texture(TextureSlot slot, Surface s, Footprint f, float lod_scale) {
    // By choice and not by index, which would put the surface into memory.
    bool first = is_first_uv(slot);
    vec2 uv = transform_uv(slot, first ? s.uv[0] : s.uv[1]);
    vec2 duv1 = first ? s.duv1[0] : s.duv1[1], duv2 = first ? s.duv2[0] : s.duv2[1];
    if (f.depth_range == NO_FOOTPRINT.depth_range) return textureLod(textures[nonuniformEXT(slot.texture)], uv, 0.0);
    mat2 linear = mat2(slot.transform[0][0], slot.transform[1][0], slot.transform[0][1], slot.transform[1][1]);
    vec2 dx = linear * (duv1 * f.bary_x.x + duv2 * f.bary_x.y) * lod_scale;
    vec2 dy = linear * (duv1 * f.bary_y.x + duv2 * f.bary_y.y) * lod_scale;
    if (!scene_has(FEATURE_TEXTURE_FILTER)) return draw_texel(slot, uv, dx, dy, f.random);
    return textureGrad(textures[nonuniformEXT(slot.texture)], uv, dx, dy);
}

// World-space frame of normal maps and anisotropy: tangent, bitangent, vertex_normal. A surface without usable tangent gets one.
mat3 tangent_frame(Surface s) {
    vec3 tangent = s.tangent.xyz - dot(s.tangent.xyz, s.vertex_normal) * s.vertex_normal;
    if (dot(tangent, tangent) <= 0.0) return basis_around(s.vertex_normal);
    tangent = normalize(tangent);
    return mat3(tangent, cross(s.vertex_normal, tangent) * s.tangent.w, s.vertex_normal);
}

vec3 mapped_normal(TextureSlot slot, float scale, Surface s, Footprint f, float lod_scale) {
    if (!scene_has(FEATURE_NORMAL_TEXTURE) || slot.texture == NONE) return s.vertex_normal;
    // Maps hold the x and y of unit vectors; two channels are all that some have.
    vec2 n = sample_texture(slot, s, f, lod_scale).xy * 2.0 - 1.0;
    vec3 mapped = tangent_frame(s) * vec3(n * scale, sqrt(max(1.0 - dot(n, n), 0.0)));
    return dot(mapped, mapped) > 0.0 ? normalize(mapped) : s.vertex_normal;
}

// `lod_scale` = 2^bias on the texture gradients.
MaterialSample load_material(Surface s, Footprint f, float lod_scale) {
    MaterialRecord m = MaterialTable(scene.materials).at[s.material];
    vec4 base = m.base_color * s.color;
    if (scene_has(FEATURE_BASE_COLOR_TEXTURE) && m.base_color_texture.texture != NONE) {
        base *= sample_texture(m.base_color_texture, s, f, lod_scale);
    }
    vec2 roughness_metallic = vec2(m.roughness, m.metallic);
    if (scene_has(FEATURE_METALLIC_ROUGHNESS_TEXTURE) && m.metallic_roughness_texture.texture != NONE) {
        roughness_metallic *= sample_texture(m.metallic_roughness_texture, s, f, lod_scale).gb;
    }
    MaterialSample r;
    r.base_color = clamp(base.rgb, 0.0, 1.0);
    r.roughness = clamp(roughness_metallic.x, 0.0, 1.0);
    r.metallic = clamp(roughness_metallic.y, 0.0, 1.0);
    r.ior = m.ior;
    r.specular = m.specular;
    r.specular_color = m.specular_color;
    r.transmission = scene_has(FEATURE_TRANSMISSION) ? m.transmission : 0.0;
    if (scene_has(FEATURE_LOBES) && m.lobes != NONE) {
        LobeTable lobes = LobeTable(scene.lobes);
        TextureSlot slot = lobes.at[m.lobes].specular_texture;
        if (slot.texture != NONE) r.specular *= sample_texture(slot, s, f, lod_scale).a;
        slot = lobes.at[m.lobes].specular_color_texture;
        if (slot.texture != NONE) r.specular_color *= sample_texture(slot, s, f, lod_scale).rgb;
        slot = lobes.at[m.lobes].transmission_texture;
        if (slot.texture != NONE) r.transmission *= sample_texture(slot, s, f, lod_scale).r;
    }
    r.emission = m.emissive;
    if (scene_has(FEATURE_EMISSIVE_TEXTURE) && m.emissive_texture.texture != NONE) {
        r.emission *= sample_texture(m.emissive_texture, s, f, lod_scale).rgb;
    }
    r.normal = mapped_normal(m.normal_texture, m.normal_scale, s, f, lod_scale);
    if (scene_has(FEATURE_WAVES) && m.wave_slope > 0.0) {
        r.normal = wave_normal(s.vertex_normal, s.position, m.wave_slope, m.wave_length, scene.time);
    }
    return r;
}

LobesSample load_lobes(Surface s, Footprint f, float lod_scale) {
    LobesSample r = LobesSample(0.0, 0.0, s.vertex_normal, vec3(0.0), 0.0, 0.0, vec2(1.0, 0.0), 0.0, 1.3, 0.0, 0.0);
    if (!scene_has(FEATURE_LOBES)) return r;
    uint index = MaterialTable(scene.materials).at[s.material].lobes;
    if (index == NONE) return r;
    LobeRecord m = LobeTable(scene.lobes).at[index];

    r.clearcoat = m.clearcoat;
    r.clearcoat_roughness = m.clearcoat_roughness;
    if (m.clearcoat_texture.texture != NONE) r.clearcoat *= sample_texture(m.clearcoat_texture, s, f, lod_scale).r;
    if (m.clearcoat_roughness_texture.texture != NONE) {
        r.clearcoat_roughness *= sample_texture(m.clearcoat_roughness_texture, s, f, lod_scale).g;
    }
    r.clearcoat_normal = mapped_normal(m.clearcoat_normal_texture, m.clearcoat_normal_scale, s, f, lod_scale);

    r.sheen_color = m.sheen_color;
    r.sheen_roughness = m.sheen_roughness;
    if (m.sheen_color_texture.texture != NONE) r.sheen_color *= sample_texture(m.sheen_color_texture, s, f, lod_scale).rgb;
    if (m.sheen_roughness_texture.texture != NONE) {
        r.sheen_roughness *= sample_texture(m.sheen_roughness_texture, s, f, lod_scale).a;
    }

    r.anisotropy = m.anisotropy_strength;
    vec2 direction = vec2(1.0, 0.0);
    if (m.anisotropy_texture.texture != NONE) {
        vec3 t = sample_texture(m.anisotropy_texture, s, f, lod_scale).rgb;
        vec2 textured = t.rg * 2.0 - 1.0;
        if (dot(textured, textured) > 0.0) direction = normalize(textured);
        r.anisotropy *= t.b;
    }
    float c = cos(m.anisotropy_rotation), sn = sin(m.anisotropy_rotation);
    r.anisotropy_direction = vec2(c * direction.x - sn * direction.y, sn * direction.x + c * direction.y);

    r.iridescence = m.iridescence;
    r.iridescence_ior = m.iridescence_ior;
    if (m.iridescence_texture.texture != NONE) r.iridescence *= sample_texture(m.iridescence_texture, s, f, lod_scale).r;
    r.iridescence_thickness = m.iridescence_thickness_max;
    if (m.iridescence_thickness_texture.texture != NONE) {
        float t = sample_texture(m.iridescence_thickness_texture, s, f, lod_scale).g;
        r.iridescence_thickness = mix(m.iridescence_thickness_min, m.iridescence_thickness_max, t);
    }
    r.dispersion = m.dispersion;
    return r;
}
