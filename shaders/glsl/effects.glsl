// The effects along a ray: particles, beams, sprites and fog, blended in their order. They are found by a traversal of their own, the same for all
// trace backends, because a ray meets all of them and not the closest one.
//
//     EffectsSeen effects_along(vec3 origin, vec3 direction, float t_max)    direction: unit length
//
// What is behind gets the factor `transmittance`, and `radiance` is added.
//
// Order: the `effect_layers` nearest effects are kept sorted. When one more comes, the two farthest are blended into one (Salvi and Vaidyanathan 2014,
// "Multi-Layer Alpha Blending"). With 1 layer each effect is blended over all others or under them, as it is nearer than the nearest or not.
#include "scene.glsl"

layout(constant_id = 20) const uint effect_layers = 4u;

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer EffectTable { EffectRecord at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer EffectNodeTable { EffectNode at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer FogTable { FogRecord at[]; };

const float NO_LAYER = 3e38;
// An effect that covers this much of what is behind hides its motion.
const float EFFECT_COVERS = 0.5;

struct EffectLayer { float t; vec3 radiance; float transmittance; };

// `leader`: the effect whose motion the eye follows, the nearest one that covers, or else the brightest; its distance; NONE: there is none.
struct EffectsSeen { vec3 radiance; float transmittance; uint leader; float leader_t; };

vec3 inverse_direction(vec3 direction) { return 1.0 / mix(direction, vec3(1e-20), lessThan(abs(direction), vec3(1e-20))); }

// Entry and exit of a box, at least 0; empty where x > y.
vec2 box_interval(vec3 low, vec3 high, vec3 origin, vec3 inverse) {
    vec3 a = (low - origin) * inverse, b = (high - origin) * inverse;
    return vec2(max(max_component(min(a, b)), 0.0), min_component(max(a, b)));
}

// The nearest approach of the ray to the axis of a capsule: t, and the square of the distance. On the ray's line the point s of the axis is as far as
// the parts of both that are perpendicular to the line; where the line is nearest behind the origin, the origin is nearest.
vec2 approach(vec3 origin, vec3 direction, vec3 end, vec3 axis) {
    vec3 w = end - origin;
    float du = dot(direction, axis), dw = dot(direction, w), uu = dot(axis, axis);
    vec3 across = axis - du * direction;
    float aa = dot(across, across);
    float s = aa > 1e-12 * uu ? clamp(-dot(w, across) / aa, 0.0, 1.0) : (du > 0.0 ? 0.0 : 1.0);
    float t = dw + s * du;
    if (t < 0.0) {
        t = 0.0;
        s = uu > 0.0 ? clamp(-dot(w, axis) / uu, 0.0, 1.0) : 0.0;
    }
    vec3 away = w + s * axis - t * direction;
    return vec2(t, dot(away, away));
}

// How much of an effect the ray meets, and where. The whole ray is looked at: what is nearest to it behind `t_max` is hidden.
EffectLayer effect_layer(EffectRecord e, vec3 origin, vec3 direction, float t_max) {
    EffectLayer none = EffectLayer(NO_LAYER, vec3(0.0), 1.0);
    if (e.radius > 0.0) {
        vec2 near = approach(origin, direction, e.position, e.axis);
        float part = 1.0 - near.y / square(e.radius);
        if (part <= 0.0 || near.x >= t_max) return none;
        part *= part;
        return EffectLayer(near.x, part * e.radiance, 1.0 - part * e.opacity);
    }
    vec3 n = cross(e.axis, e.half_height);
    float t = dot(e.position - origin, n) / dot(direction, n);
    if (!(t > 0.0 && t < t_max)) return none;
    vec3 at = origin + t * direction - e.position;
    vec2 place = vec2(dot(cross(at, e.half_height), n), dot(cross(e.axis, at), n)) / dot(n, n);
    if (max(abs(place.x), abs(place.y)) > 1.0) return none;
    vec4 texel = vec4(1.0);
    if (e.texture != NONE) texel = textureLod(textures[nonuniformEXT(e.texture)], vec2(0.5 + 0.5 * place.x, 0.5 - 0.5 * place.y), 0.0);
    return EffectLayer(t, texel.a * texel.rgb * e.radiance, 1.0 - texel.a * e.opacity);
}

// The fog between two distances. Density is linear along the ray, so that its integral is the mean of both ends times the length. Where volumes
// overlap their radiances are mixed in proportion to their optical depths.
void add_fog(vec3 origin, vec3 direction, float from, float to, inout vec3 radiance, inout float transmittance) {
    vec3 inverse = inverse_direction(direction);
    float depth = 0.0;
    vec3 weighted = vec3(0.0);
    for (uint i = 0u; i < scene.fog_count; i++) {
        FogRecord fog = FogTable(scene.fog).at[i];
        vec2 interval = box_interval(fog.min, fog.max, origin, inverse);
        interval = vec2(max(interval.x, from), min(interval.y, to));
        if (interval.x >= interval.y) continue;
        vec3 middle = origin + 0.5 * (interval.x + interval.y) * direction;
        float part = max(fog.density + dot(fog.gradient, middle - fog.min), 0.0) * (interval.y - interval.x);
        depth += part;
        weighted += part * fog.radiance;
    }
    if (depth <= 0.0) return;
    float left = exp(-depth);
    radiance += transmittance * (1.0 - left) / depth * weighted;
    transmittance *= left;
}

EffectsSeen effects_along(vec3 origin, vec3 direction, float t_max) {
    EffectLayer layers[effect_layers];
    for (uint i = 0u; i < effect_layers; i++) layers[i] = EffectLayer(NO_LAYER, vec3(0.0), 1.0);
    EffectsSeen seen = EffectsSeen(vec3(0.0), 1.0, NONE, NO_LAYER);
    bool covered = false;
    float brightest = 0.0;
    vec3 inverse = inverse_direction(direction);
    uint node = 0u;
    while (node < scene.effect_node_count) {
        EffectNode n = EffectNodeTable(scene.effect_nodes).at[node];
        vec2 interval = box_interval(n.min, n.max, origin, inverse);
        // Widened by the rounding of both ends.
        bool met = interval.x * (1.0 - 4e-7) <= interval.y * (1.0 + 4e-7) && interval.x < t_max;
        uint count = n.effects & ((1u << EFFECT_COUNT_BITS) - 1u);
        node = met && count == 0u ? node + 1u : n.skip;
        if (!met) continue;
        for (uint i = 0u; i < count; i++) {
            uint index = (n.effects >> EFFECT_COUNT_BITS) + i;
            EffectLayer layer = effect_layer(EffectTable(scene.effects).at[index], origin, direction, t_max);
            if (layer.t >= NO_LAYER) continue;
            bool covers = layer.transmittance <= 1.0 - EFFECT_COVERS;
            float light = luminance(layer.radiance);
            if (covers && !(covered && seen.leader_t <= layer.t) || !covered && light > brightest) {
                seen.leader = index;
                seen.leader_t = layer.t;
            }
            covered = covered || covers;
            brightest = max(brightest, light);
            for (uint k = 0u; k < effect_layers; k++) {
                if (layer.t < layers[k].t) {
                    EffectLayer farther = layers[k];
                    layers[k] = layer;
                    layer = farther;
                }
            }
            // What is left is the farthest: under the last one.
            if (layer.t < NO_LAYER) {
                layers[effect_layers - 1u].radiance += layers[effect_layers - 1u].transmittance * layer.radiance;
                layers[effect_layers - 1u].transmittance *= layer.transmittance;
            }
        }
    }
    float from = 0.0;
    for (uint i = 0u; i < effect_layers; i++) {
        if (layers[i].t >= NO_LAYER) break;
        add_fog(origin, direction, from, layers[i].t, seen.radiance, seen.transmittance);
        from = layers[i].t;
        seen.radiance += seen.transmittance * layers[i].radiance;
        seen.transmittance *= layers[i].transmittance;
    }
    add_fog(origin, direction, from, t_max, seen.radiance, seen.transmittance);
    return seen;
}
