// Which pixels may share light: what the variance estimate and the a-trous filter know of a pixel, and the weights of a pair that follow
// from it. Every weight is the same for (p, q) and (q, p).
#include "channels.glsl"
#include "math.glsl"
#include "pack.glsl"

struct Guide {
    // x = signed distance, y = depth range of the pixel (negative: the fields hold two paths), z = roughness, w = angle between the rays of neighbouring pixels where it is known
    vec4 geometry;
    uint normal;   // packed; 0 = no surface
};

const Guide NO_GUIDE = Guide(vec4(0.0), 0u);

Guide guide_with(ivec2 at, uint normal) {
    if (normal == 0u) return NO_GUIDE;
    bool two_paths = bitCount(imageLoad(ch_view_direction, at).y) > 1;
    float range = 1.0 / max(imageLoad(ch_motion, at).w, 1e-18);
    return Guide(vec4(imageLoad(ch_view_depth, at).x, two_paths ? -range : range, 0.0, 0.0), normal);
}

Guide load_guide(ivec2 at) {
    Guide guide = guide_with(at, imageLoad(ch_normal, at).x);
    if (guide.normal != 0u) guide.geometry.z = imageLoad(ch_metallic_roughness, at).y;
    return guide;
}

// With the vertex normal, and without roughness.
Guide load_smooth_guide(ivec2 at) { return guide_with(at, imageLoad(ch_vertex_normal, at).x); }

// Whether both show the same path: where the fields reflect and refract, pixels of one field alone.
bool same_path(Guide p, Guide q, ivec2 offset) {
    bool two_paths = p.geometry.y < 0.0 || q.geometry.y < 0.0;
    return !two_paths || ((offset.x ^ offset.y) & 1) == 0;
}

// Dammertz et al. 2010 and Schied et al. 2017, eq. 3, with the slope of the steeper of the two. `pixels`: their distance.
float depth_weight(Guide p, Guide q, float pixels, float sigma) {
    float range = max(abs(p.geometry.y), abs(q.geometry.y));
    return exp(-abs(p.geometry.x - q.geometry.x) / (sigma * range * pixels));
}

float normal_cosine(Guide p, Guide q) {
    return clamp(dot(unpack_unit_vector(p.normal), unpack_unit_vector(q.normal)), 0.0, 1.0);
}

// The same as powers of two: a product of weights is one exponential of a sum.
const float LOG2_E = 1.442695041;

// What a difference of distances is multiplied by at a pixel with this depth range. It has the sign of the range.
float steepness(float range, float sigma) { return clamp(LOG2_E / (sigma * range), -1e30, 1e30); }

// Exponent of the weight by distances, positive. Distance and steepness() of two pixels; `pixels`: their distance.
float depth_exponent(vec2 p, vec2 q, float pixels) { return abs(p.x - q.x) * min(abs(p.y), abs(q.y)) * (1.0 / pixels); }

// Cosine between normals minus 1. exp(-n (1 - cos)) is cos^n to within 0.37 / n. The sum begins with the 1.
float turn(vec3 p, vec3 q) { return min(p.x * q.x + (p.y * q.y + (p.z * q.z - 1.0)), 0.0); }
