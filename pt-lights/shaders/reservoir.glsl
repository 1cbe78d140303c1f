// Reservoirs of sampler restir-di, and the targets of their samples. A sample is a point of primary sample space: a light and the two numbers
// that choose a point on it. Every shading point maps it to a light sample of its own (random replay, Lin et al. 2022, section 5.4, the shift
// that has the Jacobian 1), so that points, spheres and triangles, whatever their density per solid angle is, are reused alike: target and
// candidates have their densities in primary sample space, and none per area meets one per solid angle.
#include "channels.glsl"
#include "checkerboard.glsl"
#include "lights/ris.glsl"
#include "lights_images.glsl"
#include "lights_records.glsl"
#include "pack.glsl"

struct Reservoir {
    uint light;   // NONE: no sample
    uint numbers; // 2 x 16 bits: where on the light
    float weight; // unbiased estimate of 1 / density of the sample
    uint count;   // candidates that it stands for; 0: no reservoir
};

const Reservoir NO_RESERVOIR = Reservoir(NONE, 0u, 0.0, 0u);

Reservoir make_reservoir(uvec2 point, uvec2 weight) { return Reservoir(point.x, point.y, uintBitsToFloat(weight.x), weight.y); }

uvec2 reservoir_point(Reservoir r) { return uvec2(r.light, r.numbers); }

uvec2 reservoir_weight(Reservoir r) { return uvec2(floatBitsToUint(r.weight), r.count); }

// The numbers are rounded before their first use: a sample is the same to the bit for whoever takes it up.
uint round_numbers(uvec4 bits) { return bits.z >> 16u | (bits.w & 0xffff0000u); }

vec2 unit_numbers(uint numbers) { return (vec2(numbers & 0xffffu, numbers >> 16u) + 0.5) * (1.0 / 65536.0); }

bool is_local_light(uint light, uint kinds) { return light < scene.light_tables.local_light_count && (kinds & kind_of_light(light)) != 0u; }

// Target over the density of the point on the light: proportional to the unshadowed light in primary sample space.
float primary_target(LightContext c, LightSample s) {
    float target = ris_target(c, s) / s.pdf;
    // False for what is not a number, too.
    return target > 0.0 && target < 1e30 ? target : 0.0;
}

// Target of a sample at a shading point of this frame, with this frame's lights.
float sample_target(LightContext c, uint light, uint numbers, uint kinds) {
    if (!is_local_light(light, kinds)) return 0.0;
    return primary_target(c, sample_local_light(c, light, unit_numbers(numbers)));
}

LocalLightRecord last_local_light(uint light) { return LocalLightTable(scene.light_tables_previous.local_lights).at[light]; }

// Target that a sample had at a shading point of the last frame: with the lights where they were, so that it is 0 where the last frame
// could not have drawn the sample.
float last_target(LightContext c, uint light, uint numbers, uint kinds) {
    if (!is_local_light(light, kinds) || light >= scene.light_tables_previous.local_light_count) return 0.0;
    LocalLightRecord l = last_local_light(light);
    vec2 xi = unit_numbers(numbers);
    if ((l.kind & LOCAL_KIND) == LOCAL_TRIANGLE) {
        return primary_target(c, sample_triangle_light(c.position, c.normal, l, light, area_sampling, xi));
    }
    if (environment_is_listed() && (l.kind & LOCAL_KIND) == LOCAL_ENVIRONMENT) {
        return primary_target(c, sample_environment_quad(l, light - first_environment_light(), xi));
    }
    uint kind = (l.kind & LOCAL_KIND) == LOCAL_SPOT ? LIGHT_SPOT : LIGHT_POINT;
    LightRecord r = LightRecord(l.radiance, kind, l.position, l.edge1.x, l.edge2, l.edge1.y, l.edge1.z, 0.0, 0.0, 0u);
    return primary_target(c, sample_positional_light(c.position, r, xi));
}

// Context from the words of the channels, so that whoever looks at a pixel sees the same. The cluster serves candidates alone.
LightContext make_context(vec3 position, uint normal, uint direction, uint material, uint cluster) {
    vec2 m = unpackUnorm2x16(material);
    return LightContext(position, unpack_unit_vector(normal), -unpack_unit_vector(direction), cluster, m.x, m.y, 0ul);
}

LightContext load_context(ivec2 p) {
    return make_context(imageLoad(ch_shading_position, p).xyz, imageLoad(ch_normal, p).x, imageLoad(ch_view_direction, p).x,
                        imageLoad(im_restir_surface, p).x, 0u);
}

// How far reuse reaches: surfaces must face about the same way (cosine), and their distances from the camera must be near each other. The
// choice of neighbours decides about noise alone: it does not look at samples, so it brings no bias.
const float REUSE_COSINE = 0.9;
const float REUSE_DEPTH = 0.1;

// Depths are negative for what mirrors show.
bool reusable(vec3 normal, vec3 other_normal, float depth, float other_depth) {
    return dot(normal, other_normal) >= REUSE_COSINE && abs(depth - other_depth) <= REUSE_DEPTH * abs(depth);
}
