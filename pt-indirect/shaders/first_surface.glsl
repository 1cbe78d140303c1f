// The surface of the G-buffer that a path starts at, and its first direction.
//
// The surface has the BSDF of the reference (bsdf.glsl) with the base colour, roughness and metalness of the G-buffer, as direct lighting
// shades it: nothing is transmitted, and no lobe is narrower than MIN_ROUGHNESS.
#include "bsdf_surface.glsl"
#include "camera.glsl"
#include "channels.glsl"
#include "frame.glsl"
#include "gbuffer_format.glsl"
#include "indirect_push.glsl"
#include "reflectance.glsl"
#include "texture_random.glsl"

// As in direct lighting.
const float MIN_ROUGHNESS = sqrt(1e-3);

struct FirstSurface {
    vec3 position;
    Bsdf bsdf;
    vec3 albedo;        // of the diffuse base: what the composite multiplies color_lf with
    vec3 demodulation;  // what it multiplies color_spec with
    float roughness;    // perceptual, of the smoothest lobe
    mat3 world_from_local; // frame of the G-buffer's normal
    InteriorList interior; // solids that the surface is in
    vec2 cone;          // of the pixel at the surface: radius, metres, and half angle
};

FirstSurface load_first_surface(ivec2 p, vec4 position) {
    FirstSurface s;
    s.position = position.xyz;
    uvec2 visible = imageLoad(ch_visibility, p).xy;
    vec3 direction = unpack_unit_vector(imageLoad(ch_view_direction, p).x);
    vec4 base = base_color_of(imageLoad(ch_base_color, p));
    vec2 metallic_roughness = imageLoad(ch_metallic_roughness, p).xy;
    s.world_from_local = basis_around(unpack_unit_vector(imageLoad(ch_normal, p).x));
    Surface surface = load_surface(visible.x, visible.y, imageLoad(ch_barycentrics, p).xy);
    MaterialRecord m = MaterialTable(scene.materials).at[surface.material];
    // The base of a glass that reflect_refract.trace has taken apart is Lambertian.
    bool lambertian = m.transmission > 0.0 && base.a == 0.0 && metallic_roughness == vec2(0.0, 1.0);

    float path_length = exp2(imageLoad(ch_throughput, p).a), half_angle = imageLoad(ch_bounce_throughput, p).a;
    s.cone = vec2(cone_radius(frame.camera, half_angle, path_length, frame.size.y), half_angle);
    Footprint footprint = cone_footprint(surface, direction, s.cone.x, texture_random(imageLoad(ch_rng_seed, p).xy, visible.x));
    MaterialSample sampled = MaterialSample(base.rgb, metallic_roughness.x, max(metallic_roughness.y, MIN_ROUGHNESS), m.ior, m.specular,
                                            m.specular_color, 0.0, vec3(0.0), vec3(0.0));
    float side = dot(surface.face_normal, direction) < 0.0 ? 1.0 : -1.0;
    sampled.normal = side * s.world_from_local[2];
    LobesSample lobes = LobesSample(0.0, 0.0, surface.vertex_normal, vec3(0.0), 0.0, 0.0, vec2(1.0, 0.0), 0.0, 1.3, 0.0, 0.0);
    if (lambertian) {
        sampled.specular = 0.0;
    } else if (scene_has(FEATURE_LOBES) && m.lobes != NONE) {
        MaterialSample textured = load_material(surface, footprint, push.lod_scale);
        sampled.specular = textured.specular;
        sampled.specular_color = textured.specular_color;
        lobes = load_lobes(surface, footprint, push.lod_scale);
        lobes.clearcoat_roughness = max(lobes.clearcoat_roughness, MIN_ROUGHNESS);
    }
    s.interior = EMPTY_INTERIOR;
    if (scene_has(FEATURE_TRANSMISSION)) s.interior = interior_of(imageLoad(ch_interior, p));
    s.bsdf = surface_bsdf(surface, sampled, lobes, -direction, m.ior, 0u);
    s.roughness = lobes.clearcoat > 0.0 ? min(sampled.roughness, lobes.clearcoat_roughness) : sampled.roughness;
    s.albedo = diffuse_albedo(base.rgb, metallic_roughness.x);
    s.demodulation = demodulation(base, metallic_roughness.x);
    return s;
}

// `pdf`: density of the direction per solid angle, of all lobes together. The parts are f |cos| / pdf.
struct FirstBounce {
    vec3 direction;
    float pdf;        // 0: there is no direction
    bool is_specular; // drawn for a specular lobe
    float diffuse;    // without the albedo
    vec3 specular;    // all that is not the diffuse base
};

// Probabilities of the lobes: by what they reflect; with DRAW_FIXED_HALF the specular ones have half of the rays, as in Quake II RTX.
LobeProbabilities first_probabilities(FirstSurface s) {
    LobeProbabilities p = s.bsdf.lobes.p;
    float specular = p.coat + p.interface_;
    bool faded = push.specular_fade < 1.0 && s.roughness >= push.specular_fade + 0.1;
    if (push.half_rows != 0u || faded) return LobeProbabilities(0.0, 0.0, p.diffuse > 0.0 ? 1.0 : 0.0);
    if ((push.draw & DRAW_FIXED_HALF) == 0u || specular <= 0.0 || p.diffuse <= 0.0) return p;
    return LobeProbabilities(0.5 * p.coat / specular, 0.5 * p.interface_ / specular, 0.5);
}

FirstBounce first_bounce(FirstSurface s, vec4 xi) {
    Bsdf b = s.bsdf;
    b.lobes.p = first_probabilities(s);
    LobeProbabilities p = b.lobes.p;
    bool uniform_hemisphere = (push.draw & DRAW_UNIFORM_HEMISPHERE) != 0u;
    FirstBounce r = FirstBounce(vec3(0.0), 0.0, xi.z < p.coat + p.interface_, 0.0, vec3(0.0));
    if (!(b.local_wo.z > 0.0) || p.coat + p.interface_ + p.diffuse <= 0.0) return r;
    // Tails of the lobe are left out by drawing from the middle of the visible normals alone.
    vec2 normal_xi = vec2(xi.x, xi.y * push.ndf_trim);
    BsdfSample drawn = NO_BSDF_SAMPLE;
    if (xi.z < p.coat) {
        drawn = coat_sample(b, normal_xi);
    } else if (r.is_specular) {
        drawn = interface_sample(b, vec3(normal_xi, xi.w));
    } else {
        drawn = diffuse_sample(b, xi.xy);
        if (uniform_hemisphere) drawn.direction = b.frame * sample_cone(xi.xy, 1.0);
    }
    if (!(drawn.pdf > 0.0)) return r;
    r.direction = normalize(drawn.direction);
    float cosine = dot(b.frame[2], r.direction);
    BsdfValue f = bsdf_evaluate(b, r.direction);
    if (uniform_hemisphere && cosine > 0.0) f.pdf += p.diffuse * (0.5 * INV_PI - cosine_hemisphere_pdf(cosine));
    if (!(f.pdf > 0.0)) return r;
    float diffuse = bsdf_diffuse_cos(b, r.direction);
    r.pdf = f.pdf;
    r.diffuse = diffuse / f.pdf;
    r.specular = max(f.f_cos - diffuse * s.albedo, 0.0) / f.pdf;
    return r;
}
