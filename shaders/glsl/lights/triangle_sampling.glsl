// Points of a triangle, drawn for a shading point in one of three ways (AREA_SAMPLING_*), with their densities per solid angle there.
// Both sides of the triangle count: which of them emits is the caller's question. Host twin: pt_light_sampling::oracle::triangle.
//
// Spherical triangles: the map of Arvo 1995, "Stratified Sampling of Spherical Triangles", from the unit square. Arvo's equations take
// cosines of arcs and sums of angles, which have no digits left for small and distant triangles. Here arcs are tangents of half angles, and
// all small quantities are products with the edges of the triangle, so that errors are relative at every size; no other method is
// needed below some size. Solid angle: Van Oosterom and Strackee 1983, "The Solid Angle of a Plane Triangle", eq. 8.
#include "records.glsl"
#include "sampling.glsl"

struct TrianglePoint {
    vec2 barycentrics; // weights of the second and third corner
    vec3 direction;    // unit, from the shading point
    float distance;
    float pdf;         // per solid angle at the shading point; 0: no sample
};

const TrianglePoint NO_TRIANGLE_POINT = TrianglePoint(vec2(0.0), vec3(0.0), 0.0, 0.0);

// A triangle as its shading point, the origin, sees it.
struct SphericalTriangle {
    vec3 position, e1, e2;  // of the first corner; edges to the others
    vec3 distance;          // of the corners
    vec3 a, b, c;           // their directions
    float half_solid_angle; // 0: the triangle is not seen
    // From a along the arc to c, a point at the half angle with tangent t cuts off, with the arc from a to b, a solid angle of
    // 2 atan(height t / (base + lean t)).
    float height, base, lean;
};

// Relative accuracy for small angles, which the functions of the driver need not have (Vulkan: sin has an absolute error).
float accurate_sin(float x) { return x < 0.1 ? x - x * x * x * (1.0 / 6.0) * (1.0 - x * x * 0.05) : sin(x); }

float accurate_atan(float y, float x) {
    float r = y / x;
    return x > 0.0 && r < 0.1 ? r - r * r * r * (1.0 / 3.0 - 0.2 * r * r) : atan(y, x);
}

SphericalTriangle spherical_triangle(vec3 position, vec3 e1, vec3 e2) {
    SphericalTriangle s;
    s.position = position;
    s.e1 = e1;
    s.e2 = e2;
    s.distance = vec3(length(position), length(position + e1), length(position + e2));
    s.a = position / s.distance.x;
    s.b = (position + e1) / s.distance.y;
    s.c = (position + e2) / s.distance.z;
    float triple = abs(dot(s.a, cross(e1, e2))) / s.distance.y; // |a . (b x c)|, up to the distance of c
    vec3 across = cross(s.a, e2);
    float sine = length(across);
    vec3 ab = s.a + s.b;
    s.height = triple / sine;
    s.base = 0.5 * dot(ab, ab); // 1 + a . b
    s.lean = dot(s.b, cross(across, s.a)) / sine;
    float angle = accurate_atan(triple / s.distance.z, s.base + dot(ab, s.c));
    // False for what is not a number, of a triangle with the shading point on its outline or of none at all.
    s.half_solid_angle = angle > 1e-30 && sine > 0.0 ? angle : 0.0;
    return s;
}

// Solid angle of the triangle with these corners, relative to the point that sees it.
float triangle_solid_angle(vec3 a, vec3 b, vec3 c) { return 2.0 * spherical_triangle(a, b - a, c - a).half_solid_angle; }

// Tangent of half the angle under which the origin sees a segment from a point in direction `start` to `end`.
float tan_half_angle(vec3 start, vec3 segment, vec3 end) {
    return length(cross(segment, start)) / (length(end) + dot(end, start));
}

// Share of a segment that is seen under such an angle. The segment starts in direction `start` at `distance`.
float share_of_segment(vec3 start, float distance, vec3 segment, float tan_half) {
    float across = length(cross(segment, start));
    float rest = (1.0 - tan_half * tan_half) * across - 2.0 * tan_half * dot(segment, start);
    float along = 2.0 * tan_half * distance;
    return along < rest ? along / rest : 1.0;
}

// Barycentric weights of the second and third corner, uniform in solid angle. xi.x: share of the solid angle between the arc from a to b
// and that from b through the point; xi.y: share of 1 - cos on the latter.
vec2 spherical_to_barycentrics(SphericalTriangle s, vec2 xi) {
    float angle = xi.x * s.half_solid_angle;
    float sine = accurate_sin(angle);
    float t = share_of_segment(s.a, s.distance.x, s.e2, s.base * sine / max(s.height * cos(angle) - s.lean * sine, 1e-30));
    vec3 arc = t * s.e2 - s.e1;
    float whole = tan_half_angle(s.b, arc, s.position + t * s.e2);
    float part = whole * sqrt(xi.y / (1.0 + (1.0 - xi.y) * whole * whole));
    float u = share_of_segment(s.b, s.distance.y, arc, part);
    return vec2(1.0 - u, u * t);
}

// Its inverse.
vec2 barycentrics_to_spherical(SphericalTriangle s, vec2 barycentrics) {
    float u = 1.0 - barycentrics.x;
    if (u <= 0.0) return vec2(0.0);
    float t = clamp(barycentrics.y / u, 0.0, 1.0);
    vec3 end = s.position + t * s.e2;
    float along = tan_half_angle(s.a, t * s.e2, end);
    float angle = accurate_atan(s.height * along, s.base + s.lean * along);
    vec3 arc = t * s.e2 - s.e1;
    float whole = tan_half_angle(s.b, arc, end);
    float part = tan_half_angle(s.b, u * arc, s.position + s.e1 + u * arc);
    float share = square(part / whole) * (1.0 + whole * whole) / (1.0 + part * part);
    return clamp(vec2(angle / s.half_solid_angle, share), 0.0, 1.0);
}

// The cosine at the receiver as a linear function on the triangle: its values at a, b and c. Each is the clamped cosine there, raised where
// the cosine bulges in between, so that the mean is the one that the middles of the edges give (a rule that is exact for quadratic
// functions). The function is 0 at most at corners and on edges below the horizon, so every point above it can be drawn.
vec3 cosine_weights(SphericalTriangle s, vec3 normal) {
    vec3 corners = max(vec3(dot(normal, s.a), dot(normal, s.b), dot(normal, s.c)), 0.0);
    vec3 ab = s.a + s.b, bc = s.b + s.c, ca = s.c + s.a;
    vec3 length2 = max(vec3(dot(ab, ab), dot(bc, bc), dot(ca, ca)), 1e-20);
    vec3 middles = max(vec3(dot(normal, ab), dot(normal, bc), dot(normal, ca)) * inversesqrt(length2), 0.0);
    return corners + max(dot(middles - corners, vec3(1.0 / 3.0)), 0.0);
}

// Density on the unit square for the weights: 1 on average. In (x, sqrt(y)) the square is a triangle with the corners a (0, 1), b (y = 0) and
// c (1, 1), uniform in area; the density is linear there. Product sampling by warping the primary sample space: Hart et al. 2020,
// "Practical Product Sampling by Fitting and Composing Warps", with a linear function on the triangle in place of their bilinear one on
// the square: small triangles see a cosine that is linear on the triangle.
float warp_pdf(vec3 weights, vec2 xi) {
    float r = sqrt(xi.y);
    return 3.0 * mix(weights.y, mix(weights.x, weights.z, xi.x), r) / (weights.x + weights.y + weights.z);
}

// x with 3 x^2 - 2 x^3 = v: the inverse of smoothstep, without a difference.
float inverse_smoothstep(float v) {
    float third = atan(sqrt(v), sqrt(1.0 - v)) / 3.0;
    return 2.0 * sin(third) * sin(third + PI / 3.0);
}

// Uniform numbers to numbers with that density. r = sqrt(y) has the density 6 r (1 - r) for the weight of b and 3 r^2 for the others;
// x is linear for given r.
vec2 warp(vec3 weights, vec2 xi) {
    float others = weights.x + weights.z;
    float v = xi.y * (weights.y + others);
    float r = v < weights.y ? inverse_smoothstep(v / weights.y) : pow(min((weights.y + others - v) / max(others, 1e-30), 1.0), 1.0 / 3.0);
    vec2 ends = mix(weights.yy, weights.xz, r);
    float root = sqrt(mix(ends.x * ends.x, ends.y * ends.y, xi.x));
    return vec2(min(xi.x * (ends.x + ends.y) / max(ends.x + root, 1e-30), 1.0), r * r);
}

// Density of points that are uniform in area: d^2 / (area cos), with area d cos as a product of the edges and the first corner.
float uniform_triangle_pdf(vec3 position, vec3 e1, vec3 e2, float distance) {
    float volume = abs(dot(position, cross(e1, e2)));
    return volume > 0.0 ? 2.0 * distance * distance * (distance / volume) : 0.0;
}

// A point of the triangle v0, v0 + e1, v0 + e2. `method`: AREA_SAMPLING_*; `normal`: of the receiver, for AREA_SAMPLING_PROJECTED,
// which has no sample when the triangle is below the horizon.
TrianglePoint sample_triangle_point(uint method, vec3 position, vec3 normal, vec3 v0, vec3 e1, vec3 e2, vec2 xi) {
    vec3 first = v0 - position;
    TrianglePoint p;
    if (method == AREA_SAMPLING_UNIFORM) {
        p.barycentrics = sample_triangle(xi);
    } else {
        SphericalTriangle s = spherical_triangle(first, e1, e2);
        if (s.half_solid_angle <= 0.0) return NO_TRIANGLE_POINT;
        p.pdf = 0.5 / s.half_solid_angle;
        if (method == AREA_SAMPLING_PROJECTED) {
            vec3 weights = cosine_weights(s, normal);
            if (weights.x + weights.y + weights.z <= 0.0) return NO_TRIANGLE_POINT;
            xi = warp(weights, xi);
            p.pdf *= warp_pdf(weights, xi);
        }
        p.barycentrics = spherical_to_barycentrics(s, xi);
    }
    vec3 d = first + p.barycentrics.x * e1 + p.barycentrics.y * e2;
    p.distance = length(d);
    if (p.distance <= 0.0) return NO_TRIANGLE_POINT;
    p.direction = d / p.distance;
    if (method == AREA_SAMPLING_UNIFORM) p.pdf = uniform_triangle_pdf(first, e1, e2, p.distance);
    return p;
}

// Density of sample_triangle_point for a point of the triangle that something else found.
float triangle_point_pdf(uint method, vec3 position, vec3 normal, vec3 v0, vec3 e1, vec3 e2, vec3 point) {
    vec3 first = v0 - position;
    if (method == AREA_SAMPLING_UNIFORM) return uniform_triangle_pdf(first, e1, e2, length(point - position));
    SphericalTriangle s = spherical_triangle(first, e1, e2);
    if (s.half_solid_angle <= 0.0) return 0.0;
    float pdf = 0.5 / s.half_solid_angle;
    if (method != AREA_SAMPLING_PROJECTED) return pdf;
    vec3 weights = cosine_weights(s, normal);
    if (weights.x + weights.y + weights.z <= 0.0) return 0.0;
    vec3 across = cross(e1, e2), d = point - v0;
    float twice_area = length(across);
    vec2 barycentrics = vec2(dot(cross(d, e2), across), dot(cross(e1, d), across)) / twice_area / twice_area;
    return pdf * warp_pdf(weights, barycentrics_to_spherical(s, barycentrics));
}
