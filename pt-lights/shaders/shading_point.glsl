// What the direct lighting pass knows of a pixel's surface. Most materials are a metallic-roughness BRDF (brdf.glsl), which the G-buffer
// holds. Those with lobes of glTF extensions (coat, sheen, anisotropy, textured specular colour) are looked up again at the visible
// triangle and evaluated as in the reference path tracer (bsdf.glsl). Kernels for scenes without such materials leave them out.
#include "bsdf_surface.glsl"
#include "brdf.glsl"
#include "camera.glsl"
#include "channels.glsl"
#include "frame.glsl"
#include "gbuffer_format.glsl"
#include "lights_records.glsl"
#include "texture_random.glsl"

struct ShadingPoint {
    vec3 position;
    vec3 vertex_normal;
    vec3 view;          // towards the viewer, in the frame of the shading normal
    mat3 world_from_local;
    float roughness;
    Brdf brdf;
    bool has_lobes;     // `bsdf` counts, not `brdf`
    float diffuse_share; // `bsdf`: colour of its diffuse base over the albedo of the composite
    Bsdf bsdf;
};

// Narrower lobes than those of the BRDF have no value in fp32 under a delta light.
const float MIN_ROUGHNESS = sqrt(MIN_ALPHA);

Brdf load_brdf(vec4 base, vec2 metallic_roughness, MaterialRecord m, bool mixed) {
    // The G-buffer holds the largest component of F0, with all textures; its tint and f90 follow from the material.
    vec3 whole = dielectric_f0(m.ior, 1.0, m.specular_color);
    float largest = max_component(whole);
    vec3 f0 = largest > 0.0 ? whole * (base.a / largest) : vec3(0.0);
    float f90 = largest > 0.0 ? min(base.a / largest, 1.0) : m.specular;
    return make_brdf(base.rgb, metallic_roughness.x, metallic_roughness.y, f0, f90, mixed);
}

void load_bsdf(ivec2 p, vec3 direction, inout ShadingPoint s) {
    uvec2 visible = imageLoad(ch_visibility, p).xy;
    Surface surface = load_surface(visible.x, visible.y, imageLoad(ch_barycentrics, p).xy);
    float path_length = exp2(imageLoad(ch_throughput, p).a);
    float radius = cone_radius(frame.camera, imageLoad(ch_bounce_throughput, p).a, path_length, frame.size.y);
    Footprint footprint = cone_footprint(surface, direction, radius, texture_random(imageLoad(ch_rng_seed, p).xy, visible.x));
    MaterialSample m = load_material(surface, footprint, push.lod_scale);
    LobesSample lobes = load_lobes(surface, footprint, push.lod_scale);
    m.roughness = max(m.roughness, MIN_ROUGHNESS);
    lobes.clearcoat_roughness = max(lobes.clearcoat_roughness, MIN_ROUGHNESS);
    bool front = dot(surface.face_normal, direction) < 0.0;
    bool solid = is_solid(MaterialTable(scene.materials).at[surface.material]);
    s.bsdf = surface_bsdf(surface, m, lobes, -direction, solid && !front ? 1.0 / m.ior : m.ior, 0u);
    s.diffuse_share = (1.0 - m.transmission) / max(mix(1.0 - m.transmission, 1.0, m.metallic), 1e-6);
    s.roughness = lobes.clearcoat > 0.0 ? min(m.roughness, lobes.clearcoat_roughness) : m.roughness;
}

ShadingPoint load_shading_point(ivec2 p, vec4 position) {
    ShadingPoint s;
    s.position = position.xyz;
    s.vertex_normal = unpack_unit_vector(imageLoad(ch_vertex_normal, p).x);
    s.world_from_local = basis_around(unpack_unit_vector(imageLoad(ch_normal, p).x));
    vec3 direction = unpack_unit_vector(imageLoad(ch_view_direction, p).x);
    s.view = -direction * s.world_from_local;
    // The normal is on the viewer's side; what its 16 bits round below the horizon is lifted to grazing.
    s.view.z = max(s.view.z, 1e-4);
    vec4 base = base_color_of(imageLoad(ch_base_color, p));
    vec2 metallic_roughness = imageLoad(ch_metallic_roughness, p).xy;
    MaterialRecord m = MaterialTable(scene.materials).at[floatBitsToUint(position.w) - 1u];
    s.roughness = metallic_roughness.y;
    // The base of a glass that reflect_refract.trace has taken apart is Lambertian.
    bool lambertian = m.transmission > 0.0 && base.a == 0.0 && metallic_roughness == vec2(0.0, 1.0);
    if (lambertian) m.specular = 0.0;
    s.brdf = load_brdf(base, metallic_roughness, m, push.mixed != 0u);
    s.has_lobes = scene_has(FEATURE_LOBES) && m.lobes != NONE && !lambertian;
    if (s.has_lobes) load_bsdf(p, direction, s);
    return s;
}

// BRDF times cosine. A direction counts when it is above the horizon of both normals.
BrdfValue reflected(ShadingPoint s, vec3 direction) {
    if (dot(s.vertex_normal, direction) <= 0.0) return BrdfValue(vec3(0.0), vec3(0.0));
    if (s.has_lobes) {
        float diffuse = bsdf_diffuse_cos(s.bsdf, direction);
        vec3 color = s.bsdf.base_color * ((1.0 - s.bsdf.metallic) * (1.0 - s.bsdf.transmission));
        return BrdfValue(vec3(diffuse * s.diffuse_share), bsdf_eval(s.bsdf, direction) - diffuse * color);
    }
    vec3 l = direction * s.world_from_local;
    BrdfValue f = brdf_eval(s.brdf, s.view, l);
    return BrdfValue(f.diffuse * l.z, f.specular * l.z);
}

// Density of sample_reflected.
float reflected_pdf(ShadingPoint s, vec3 direction) {
    if (s.has_lobes) return bsdf_pdf(s.bsdf, direction);
    return brdf_pdf(s.brdf, s.view, direction * s.world_from_local);
}

// A direction in proportion to about the BRDF times the cosine; zero: none, with density 0.
vec3 sample_reflected(ShadingPoint s, vec4 xi) {
    if (s.has_lobes) {
        BsdfSample drawn = bsdf_sample(s.bsdf, xi);
        return drawn.pdf > 0.0 ? drawn.direction : vec3(0.0);
    }
    return s.world_from_local * brdf_sample(s.brdf, s.view, xi.xyz);
}
