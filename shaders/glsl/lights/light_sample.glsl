// A sample of the light at a shading point, and the ray that tells whether it arrives.
#include "scene.glsl"
#include "ray_offset.glsl"
#include "rng.glsl"

struct LightSample {
    vec3 direction; // unit, from the shading point to the light
    float pdf;      // density per solid angle; of a delta light the probability of its choice. 0: no sample
    vec3 radiance;  // towards the shading point; of a delta light the irradiance of a surface that faces it
    bool delta;     // no other strategy can find this light
    vec3 target;    // where a shadow ray ends, if finite
    bool finite;
};

const LightSample NO_LIGHT_SAMPLE = LightSample(vec3(0.0), 0.0, vec3(0.0), false, vec3(0.0), false);

// Power heuristic of multiple importance sampling, Veach 1997, section 9.2.2.
float power_weight(float pdf, float other) { return pdf > 0.0 ? 1.0 / (1.0 + square(other / pdf)) : 0.0; }

// Share of its length by which a shadow ray to a point ends early: some 80 roundings of t.
const float SHADOW_RAY_MARGIN = 1e-5;

// Ray from a surface towards a light sample. `normal`: geometric, on the side that the sample lies on.
Ray shadow_ray(vec3 position, vec3 normal, LightSample s) {
    vec3 origin = offset_point(position, normal, scene.near_origin);
    if (!s.finite) return Ray(origin, 0.0, s.direction, SKY_DISTANCE);
    vec3 d = s.target - origin;
    float distance = length(d);
    return Ray(origin, 0.0, d / distance, distance * (1.0 - SHADOW_RAY_MARGIN));
}

// Index picked from an alias table of `count` > 0 entries. 32 bits for the entry: 24 would favour some entries of a large table.
uint alias_pick(uint64_t table, uint count, uint bits, float xi) {
    uint entry, fraction;
    umulExtended(bits, count, entry, fraction);
    AliasRecord a = AliasTable(table).at[entry];
    return xi < a.keep ? entry : a.alias;
}
