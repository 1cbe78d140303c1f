// Samples the scene's lights from a shading point. Each function samples one kind of light: it takes 4 x 32 random bits
// (random_bits) and returns a sample whose pdf contains all choices made on the way. Nothing is clamped. Host twin:
// pt_lights::oracle::lights.
#include "scene.glsl"
#include "ray_offset.glsl"
#include "sampling.glsl"
#include "environment.glsl"
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

// First of the lights [first, first + count) whose cdf is above xi.
uint punctual_pick(uint first, uint count, float xi) {
    uint low = first, high = first + count - 1u;
    while (low < high) {
        uint middle = (low + high) / 2u;
        if (LightTable(scene.lights).at[middle].cdf > xi) high = middle;
        else low = middle + 1u;
    }
    return low;
}

// A directional light. With an angular radius its radiance is constant over the cone and gives the nominal lux to a surface
// that faces it: E = L pi sin^2(radius).
LightSample sample_sun(uvec4 bits) {
    if (scene.sun_count == 0u) return NO_LIGHT_SAMPLE;
    vec4 xi = unit_from_bits(bits);
    LightRecord light = LightTable(scene.lights).at[punctual_pick(0u, scene.sun_count, xi.x)];
    LightSample s = NO_LIGHT_SAMPLE;
    s.direction = -light.direction;
    s.radiance = light.intensity;
    s.pdf = light.pmf;
    s.delta = light.radius <= 0.0;
    if (!s.delta) {
        float one_minus_cos = 2.0 * square(sin(0.5 * light.radius));
        s.direction = basis_around(-light.direction) * sample_cone(xi.zw, one_minus_cos);
        s.radiance *= INV_PI / square(sin(light.radius));
        s.pdf *= cone_pdf(one_minus_cos);
    }
    return s;
}

// Angular attenuation recommended by KHR_lights_punctual. `direction`: from the light.
float spot_attenuation(LightRecord light, vec3 direction) {
    if (light.kind != LIGHT_SPOT) return 1.0;
    return square(clamp(dot(light.direction, direction) * light.spot_scale + light.spot_offset, 0.0, 1.0));
}

// A point or spot light. With a radius it is a sphere of constant radiance whose projected disk gives the nominal candela:
// I = L pi radius^2, sampled in the cone that it fills. Inside the sphere there is no light.
LightSample sample_positional(vec3 position, uvec4 bits) {
    uint count = scene.light_count - scene.sun_count;
    if (count == 0u) return NO_LIGHT_SAMPLE;
    vec4 xi = unit_from_bits(bits);
    LightRecord light = LightTable(scene.lights).at[punctual_pick(scene.sun_count, count, xi.x)];
    vec3 d = light.position - position;
    float distance2 = dot(d, d);
    float radius2 = light.radius * light.radius;
    if (distance2 <= radius2) return NO_LIGHT_SAMPLE;
    float distance = sqrt(distance2);
    LightSample s = NO_LIGHT_SAMPLE;
    s.finite = true;
    s.direction = d / distance;
    s.delta = light.radius <= 0.0;
    if (s.delta) {
        s.target = light.position;
        s.radiance = light.intensity / distance2;
        s.pdf = light.pmf;
    } else {
        float sin2_max = radius2 / distance2;
        float one_minus_cos = sin2_max / (1.0 + sqrt(1.0 - sin2_max));
        vec3 local = sample_cone(xi.zw, one_minus_cos);
        s.direction = basis_around(s.direction) * local;
        float reach = distance * local.z - sqrt(max(0.0, radius2 - distance2 * dot(local.xy, local.xy)));
        s.target = position + reach * s.direction;
        s.radiance = light.intensity * INV_PI / radius2;
        s.pdf = light.pmf * cone_pdf(one_minus_cos);
    }
    s.radiance *= spot_attenuation(light, -s.direction);
    return s;
}

// A point of an emissive triangle: triangle by alias table, point uniform in area, pdf = pmf / area x d^2 / cos.
LightSample sample_emissive(vec3 position, uvec4 bits) {
    if (scene.emissive_count == 0u) return NO_LIGHT_SAMPLE;
    vec4 xi = unit_from_bits(bits);
    EmissiveRecord e = EmissiveTable(scene.emissives).at[alias_pick(scene.emissive_alias, scene.emissive_count, bits.x, xi.y)];
    InstanceRecord instance = scene_instance(e.instance);
    MeshRecord mesh = scene_mesh(instance.mesh);
    uvec3 index = IndexTable(mesh.indices).at[e.triangle];
    PositionTable p = PositionTable(mesh.positions);
    vec3 v0 = p.at[index.x], e1 = p.at[index.y] - v0, e2 = p.at[index.z] - v0;
    vec2 bary = sample_triangle(xi.zw);
    vec3 point = transform_point(instance.world_from_object, v0 + bary.x * e1 + bary.y * e2);
    vec3 normal = cross(transform_vector(instance.world_from_object, e1), transform_vector(instance.world_from_object, e2));
    float twice_area = length(normal);
    vec3 d = point - position;
    float distance2 = dot(d, d);
    if (twice_area <= 0.0 || distance2 <= 0.0) return NO_LIGHT_SAMPLE;
    normal *= (instance.mirrored != 0u ? -1.0 : 1.0) / twice_area;

    LightSample s = NO_LIGHT_SAMPLE;
    s.finite = true;
    s.direction = d * inversesqrt(distance2);
    MaterialTable materials = MaterialTable(scene.materials);
    uint material = material_of(instance, mesh, e.triangle);
    float cos_light = -dot(normal, s.direction);
    float covered = coverage(mesh, e.triangle, bary);
    if ((materials.at[material].flags & MATERIAL_DOUBLE_SIDED) != 0u && cos_light < 0.0) {
        cos_light = -cos_light;
        normal = -normal;
    }
    if (cos_light <= 0.0 || covered <= 0.0) return NO_LIGHT_SAMPLE;
    s.target = offset_point(point, normal, scene.near_origin);
    s.pdf = e.pmf * 2.0 * distance2 / (twice_area * cos_light);
    s.radiance = materials.at[material].emissive * covered;
    TextureSlot slot = materials.at[material].emissive_texture;
    if (slot.texture != NONE) {
        vec2 uv = transform_uv(slot, triangle_uv(mesh, index, bary, slot.uv_set));
        s.radiance *= textureLod(textures[nonuniformEXT(slot.texture)], uv, 0.0).rgb;
    }
    return s;
}

// Index of a triangle among the emissive ones, or NONE.
uint emissive_index(uint instance, uint triangle) {
    if (scene.emissive_count == 0u) return NONE;
    UintTable lookup = UintTable(scene.emissive_lookup);
    uint first = lookup.at[instance];
    return first == NONE ? NONE : lookup.at[first + triangle];
}

// Density of sample_emissive for a point of emissive triangle `index` that something else found, seen at `distance` under
// `cos_light`.
float emissive_pdf(uint index, float twice_area, float distance, float cos_light) {
    if (index == NONE || cos_light <= 0.0) return 0.0;
    return EmissiveTable(scene.emissives).at[index].pmf * 2.0 * distance * distance / (twice_area * cos_light);
}

// A directional light with an angular radius, as seen along `direction`: radiance, and density of sample_sun for the direction.
// The chord to the axis is compared, because the cosine has no digits left at the sun's size.
struct SunDisc {
    vec3 radiance;
    float pdf;
};

SunDisc sun_disc(uint index, vec3 direction) {
    LightRecord light = LightTable(scene.lights).at[index];
    vec3 chord = direction + light.direction;
    float one_minus_cos = 2.0 * square(sin(0.5 * light.radius));
    if (light.radius <= 0.0 || dot(chord, chord) > 2.0 * one_minus_cos) return SunDisc(vec3(0.0), 0.0);
    return SunDisc(light.intensity * (INV_PI / square(sin(light.radius))), light.pmf * cone_pdf(one_minus_cos));
}

// Solid angle of every texel of an environment row: cos(top) - cos(bottom) as a product, which keeps its digits at the poles.
float environment_texel_solid_angle(uint row) {
    vec2 size = vec2(scene.environment_size);
    return 4.0 * PI / size.x * sin(PI * (float(row) + 0.5) / size.y) * sin(0.5 * PI / size.y);
}

// A texel by alias table, then uniform in its solid angle: azimuth and sin^2(theta / 2) are uniform between the texel's borders.
// Rows below the horizon are sampled as their mirror images above, where sin^2(theta / 2) has all its digits.
LightSample sample_environment(uvec4 bits) {
    if (scene.environment_intensity <= 0.0) return NO_LIGHT_SAMPLE;
    vec4 xi = unit_from_bits(bits);
    uvec2 size = scene.environment_size;
    uint texel = alias_pick(scene.environment_alias, size.x * size.y, bits.x, xi.y);
    uint row = texel / size.x;
    bool below = 2u * row >= size.y;
    float mirrored_row = float(below ? size.y - 1u - row : row);
    float half_step = 0.5 * PI / float(size.y);
    float k = mix(square(sin(half_step * mirrored_row)), square(sin(half_step * (mirrored_row + 1.0))), xi.w);
    float sin_theta = 2.0 * sqrt(k * (1.0 - k));
    float cos_theta = below ? 2.0 * k - 1.0 : 1.0 - 2.0 * k;
    float phi = 2.0 * PI * ((float(texel % size.x) + xi.z) / float(size.x) - 0.5);
    vec2 r = scene.environment_rotation;
    vec2 xz = sin_theta * vec2(cos(phi), sin(phi));
    LightSample s = NO_LIGHT_SAMPLE;
    s.direction = vec3(r.x * xz.x + r.y * xz.y, cos_theta, r.x * xz.y - r.y * xz.x);
    s.pdf = AliasTable(scene.environment_alias).at[texel].pmf / environment_texel_solid_angle(row);
    s.radiance = environment_radiance(s.direction);
    return s;
}

// Density of sample_environment for a direction that something else found.
float environment_pdf(vec3 direction) {
    if (scene.environment_intensity <= 0.0) return 0.0;
    uvec2 texel = min(uvec2(environment_uv(direction) * vec2(scene.environment_size)), scene.environment_size - 1u);
    float pmf = AliasTable(scene.environment_alias).at[texel.y * scene.environment_size.x + texel.x].pmf;
    return pmf / environment_texel_solid_angle(texel.y);
}
