// A path of bounce rays from a surface of the G-buffer on: at each surface that it meets one light sample (next event estimation) and
// one direction by the BSDF, the two combined by multiple importance sampling where both can find a light (Veach 1997, section 9.2).
#include "bounce_light.glsl"
#include "bounce_vertex.glsl"

// Light samples at the last vertex cannot find what the ray meets.
const uint PATH_DELTA = 1u;
// They have found it already: they go straight on through glass (`lights.glass_shadows`).
const uint PATH_COVERED = 2u;

// Boundaries inside of a stronger solid that a path may pass besides its bounces.
const uint MAX_PASSED = 8u;

struct BouncePath {
    Ray ray;
    vec3 throughput;
    float last_pdf;   // density per solid angle with which the direction was drawn
    uint flags;       // PATH_*
    vec2 cone;        // radius at the origin, metres, and half angle
    float chord;      // way since the last scattering, metres
    InteriorList interior;
};

// What the first ray meets.
struct FirstHit {
    vec3 emission;
    bool is_sampled;  // direct lighting samples it
    float light_pdf;  // emissive_pdf()
    float distance;   // metres
};

// The cone of a ray is as wide as the solid angle that the sample stands for, 1 / pdf (Bekaert et al. 2003), times push.texture_spread^2.
float cone_angle(float before, float pdf) { return max(before, push.texture_spread * inversesqrt(PI * pdf)); }

BouncePath start_path(vec3 position, vec3 face_normal, vec2 cone, vec3 direction, float pdf) {
    Ray ray = Ray(offset_point(position, face_normal, scene.near_origin), 0.0, direction, SKY_DISTANCE);
    return BouncePath(ray, vec3(1.0), pdf, 0u, vec2(cone.x, cone_angle(cone.y, pdf)), 0.0, EMPTY_INTERIOR);
}

// Weight of light that the ray meets and that light samples find with density `light_pdf`.
float ray_weight(BouncePath path, float light_pdf) {
    if ((path.flags & PATH_COVERED) != 0u) return 0.0;
    if ((path.flags & PATH_DELTA) != 0u || light_pdf <= 0.0) return 1.0;
    return glass_is_ignored() ? 0.0 : power_weight(path.last_pdf, light_pdf);
}

// The environment, and the discs of directional lights that have a size.
vec3 radiance_from_afar(BouncePath path) {
    vec3 sum = vec3(0.0), direction = path.ray.direction;
    if (kind_on(KIND_ENVIRONMENT)) {
        sum += ray_weight(path, environment_pdf(direction) * kind_pmf()) * environment_radiance(direction);
    }
    if (!kind_on(KIND_SUN)) return sum;
    for (uint i = 0u; i < scene.light_tables.sun_count; i++) {
        SunDisc disc = sun_disc(i, direction);
        if (disc.pdf > 0.0) sum += ray_weight(path, disc.pdf * kind_pmf()) * disc.radiance;
    }
    return sum;
}

// Emission of a surface that the ray meets; `is_sampled`: light samples find it, with `light_pdf`.
vec3 met_emission(BouncePath path, BounceVertex v, Hit hit, out bool is_sampled, out float light_pdf) {
    light_pdf = 0.0;
    is_sampled = false;
    bool emits = v.front || (v.flags & MATERIAL_DOUBLE_SIDED) != 0u;
    if ((push.kinds & KIND_EMISSIVE) == 0u || !emits || max_component(v.sampled.emission) <= 0.0) return vec3(0.0);
    uint index = emissive_index(hit.instance, hit.triangle);
    is_sampled = index != NONE;
    light_pdf = emissive_pdf(index, v.twice_area, path.chord, dot(v.bsdf.face_normal, -path.ray.direction));
    return v.sampled.emission;
}

// Draws the next ray; false: the path ends. `last`: the light samples of this vertex have found everything but what a delta lobe shows.
bool scatter(inout BouncePath path, BounceVertex v, uvec2 key, uint vertex, bool last) {
    BsdfSample s = bsdf_sample(v.bsdf, random_numbers(key, bounce_dimension(vertex, BOUNCE_DIRECTION)));
    bool delta = (s.flags & SAMPLE_DELTA) != 0u, transmitted = (s.flags & SAMPLE_TRANSMISSION) != 0u;
    if (!(s.pdf > 0.0) || !(max_component(s.weight) > 0.0) || last && !delta) return false;
    path.throughput *= s.weight;
    path.flags = delta ? PATH_DELTA : 0u;
    if (transmitted) {
        if (glass_is_passed()) path.flags = PATH_COVERED;
        if (v.solid) path.interior = interior_cross(path.interior, medium_boundary(v.material), v.front);
    }
    path.last_pdf = s.pdf;
    path.chord = 0.0;
    if (!delta) path.cone.y = cone_angle(path.cone.y, s.pdf);
    vec3 side = transmitted ? -v.bsdf.face_normal : v.bsdf.face_normal;
    path.ray = Ray(offset_point(v.position, side, scene.near_origin), 0.0, s.direction, SKY_DISTANCE);
    if (vertex <= push.roulette_start) return true;
    // Russian roulette (Arvo and Kirk 1990).
    float survival = clamp(max_component(path.throughput), 0.05, 0.95);
    path.throughput /= survival;
    return bounce_choices(key, vertex).y < survival;
}

// The light that comes to the path's start along its first ray, without what that ray meets itself (`first`).
vec3 bounced_light(BouncePath path, uvec2 key, out FirstHit first) {
    first = FirstHit(vec3(0.0), false, 0.0, SKY_DISTANCE);
    vec3 light = vec3(0.0);
    // Surfaces that the path has scattered at, the first one left out.
    uint vertex = 0u;
    for (uint i = 0u; i < push.bounces + 1u + MAX_PASSED; i++) {
        Hit hit = trace_closest(path.ray, unseen_mask(0xffu), random_coverage(key, bounce_dimension(vertex, BOUNCE_DIRECTION)));
        if (hit.instance == NONE) {
            if (vertex > 0u) light += path.throughput * medium_transmittance(path.interior, SKY_DISTANCE) * radiance_from_afar(path);
            break;
        }
        path.chord += hit.t;
        path.cone.x += hit.t * path.cone.y;
        BounceVertex v = load_bounce_vertex(path.interior, path.ray.direction, hit, path.cone.x);
        path.throughput *= medium_transmittance(v.medium, hit.t);
        if (v.is_passed) {
            path.interior = interior_cross(path.interior, medium_boundary(v.material), v.front);
            path.ray.origin = offset_point(v.position, -v.bsdf.face_normal, scene.near_origin);
            continue;
        }
        if (vertex == 0u) first.distance = path.chord;
        if ((v.flags & MATERIAL_UNLIT) != 0u) break;
        bool is_sampled;
        float light_pdf;
        vec3 emission = path.throughput * met_emission(path, v, hit, is_sampled, light_pdf);
        if (vertex == 0u) first = FirstHit(emission, is_sampled, light_pdf, path.chord);
        else if (max_component(emission) > 0.0) light += emission * ray_weight(path, light_pdf * kind_pmf());
        if (vertex == push.bounces) break;
        vertex++;
        bool last = vertex == push.bounces;
        light += path.throughput * light_at(v, key, vertex, last, first.distance);
        if (!scatter(path, v, key, vertex, last)) break;
    }
    return light;
}
