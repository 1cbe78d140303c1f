// Directions of the environment through portals: parallelograms such as windows, through which it shines into a room. With the probability `share`
// a sample goes through one of them, uniformly in the solid angle that all of them have at the shading point; else it is one of the whole
// environment. Its density is that of both together (one-sample balance heuristic, Veach 1997, section 9.2),
//
//     pdf = share * crossings / solid angle of the portals + (1 - share) * environment_pdf,
//
// so the estimate is unbiased wherever the portals are, also where light comes in beside them. `crossings`: of the direction with portals.
#include "lights.glsl"
#include "lights/triangle_sampling.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer PortalTable { PortalRecord at[]; };

// Half number `i` of all portals, relative to the shading point: a portal is two triangles.
SphericalTriangle portal_half(uint i, vec3 position) {
    PortalRecord p = PortalTable(scene.portals).at[i / 2u];
    vec3 diagonal = p.edge1 + p.edge2;
    if ((i & 1u) == 0u) return spherical_triangle(p.corner - position, p.edge1, diagonal);
    return spherical_triangle(p.corner - position, diagonal, p.edge2);
}

float portals_solid_angle(vec3 position) {
    float sum = 0.0;
    for (uint i = 0u; i < 2u * scene.portal_count; i++) sum += 2.0 * portal_half(i, position).half_solid_angle;
    return sum;
}

// How many portals the ray crosses.
uint portal_crossings(vec3 position, vec3 direction) {
    uint count = 0u;
    for (uint i = 0u; i < scene.portal_count; i++) {
        PortalRecord p = PortalTable(scene.portals).at[i];
        vec3 n = cross(p.edge1, p.edge2), corner = p.corner - position;
        float t = dot(n, corner) / dot(n, direction);
        // False for what is not a number, too.
        if (!(t > 0.0)) continue;
        vec3 d = t * direction - corner;
        vec2 at = vec2(dot(cross(d, p.edge2), n), dot(cross(p.edge1, d), n)) / dot(n, n);
        if (all(greaterThanEqual(at, vec2(0.0))) && all(lessThanEqual(at, vec2(1.0)))) count++;
    }
    return count;
}

// A direction through a portal. `angle`: part of their solid angle that stands before it.
vec3 portal_direction(vec3 position, float angle, vec2 xi) {
    SphericalTriangle s;
    for (uint i = 0u; i < 2u * scene.portal_count; i++) {
        SphericalTriangle next = portal_half(i, position);
        if (next.half_solid_angle <= 0.0) continue;
        s = next;
        if (angle < 2.0 * s.half_solid_angle) break;
        angle -= 2.0 * s.half_solid_angle;
    }
    vec2 barycentrics = spherical_to_barycentrics(s, xi);
    return normalize(s.position + barycentrics.x * s.e1 + barycentrics.y * s.e2);
}

// Density of sample_environment_through() for a direction that something else found.
float environment_through_pdf(vec3 position, float share, vec3 direction) {
    float pdf = environment_pdf(direction);
    if (share <= 0.0 || scene.environment_intensity <= 0.0) return pdf;
    float angle = portals_solid_angle(position);
    if (angle <= 0.0) return pdf;
    return (1.0 - share) * pdf + share * float(portal_crossings(position, direction)) / angle;
}

// `bits`: of a direction of the whole environment; `portal_bits`: x: which of both; y, z: point of the portal.
LightSample sample_environment_through(vec3 position, float share, uvec4 bits, uvec4 portal_bits) {
    float angle = share > 0.0 && scene.environment_intensity > 0.0 ? portals_solid_angle(position) : 0.0;
    vec4 xi = unit_from_bits(portal_bits);
    if (angle <= 0.0) return sample_environment(bits);
    LightSample s = NO_LIGHT_SAMPLE;
    uint least = 0u;
    if (xi.x < share) {
        s.direction = portal_direction(position, xi.x / share * angle, xi.yz);
        s.radiance = environment_radiance(s.direction);
        s.pdf = environment_pdf(s.direction);
        // Roundings may put it just beside the portal that it goes through.
        least = 1u;
    } else {
        s = sample_environment(bits);
    }
    uint crossings = max(portal_crossings(position, s.direction), least);
    s.pdf = (1.0 - share) * s.pdf + share * float(crossings) / angle;
    return s;
}
