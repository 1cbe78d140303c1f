// Indirect diffuse light between two passes: sums and weighted means of it.
#include "finite.glsl"
#include "sh.glsl"

const ShLight NO_LIGHT = ShLight(vec4(0.0), vec2(0.0));

// Greatest luma of a sample, as MAX_RADIANCE of the other channels.
const float MAX_LUMA = 1e15;

// What is not finite, negative or beyond all measure is a missing sample.
bool is_light(ShLight l) {
    vec4 size = abs(l.luma);
    bool finite = is_finite(l.luma.xyz) && is_finite(vec3(l.luma.w, l.chroma));
    return finite && l.luma.w >= 0.0 && max(max(size.x, size.y), max(size.z, size.w)) <= MAX_LUMA && all(lessThanEqual(abs(l.chroma), vec2(8.0 * MAX_LUMA)));
}

void add(inout ShLight sum, ShLight light, float weight) {
    sum.luma += weight * light.luma;
    sum.chroma += weight * light.chroma;
}

// Light of a surface as a surface with another vertex normal has it: directions keep their angles with the normal. A curved surface then shows of
// its neighbours' light what they show of it. Rodrigues' rotation from one unit normal to the other.
void turn_light(inout ShLight light, vec3 from, vec3 to) {
    vec3 axis = cross(from, to), v = light.luma.xyz;
    float cosine = dot(from, to);
    light.luma.xyz = cosine * v + cross(axis, v) + axis * (dot(axis, v) / (1.0 + max(cosine, 0.0)));
}

void scale(inout ShLight light, float factor) {
    light.luma *= factor;
    light.chroma *= factor;
}
