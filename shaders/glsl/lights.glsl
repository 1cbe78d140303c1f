// Samples the scene's lights from a shading point, one kind of light each. The functions take 4 x 32 random bits (random_bits) and return
// a sample whose pdf contains all choices made on the way. Nothing is clamped. Host twin: pt_light_sampling::oracle::lights.
#include "lights/local_lights.glsl"
#include "sky.glsl"

// First of the lights [first, first + count) whose cdf is above xi; how probable it is, `pmf`.
uint punctual_pick(uint first, uint count, float xi, out float pmf) {
    LightTable table = LightTable(choice_tables().lights);
    uint low = first, high = first + count - 1u;
    while (low < high) {
        uint middle = (low + high) / 2u;
        if (table.at[middle].cdf > xi) high = middle;
        else low = middle + 1u;
    }
    pmf = table.at[low].pmf;
    return low;
}

// A directional light. With an angular radius its radiance is constant over the cone and gives the nominal lux to a surface
// that faces it: E = L pi sin^2(radius).
LightSample sample_sun(uvec4 bits) {
    uint count = choice_tables().sun_count;
    if (count == 0u) return NO_LIGHT_SAMPLE;
    vec4 xi = unit_from_bits(bits);
    float pmf;
    LightRecord light = LightTable(scene.light_tables.lights).at[punctual_pick(0u, count, xi.x, pmf)];
    LightSample s = NO_LIGHT_SAMPLE;
    s.direction = -light.direction;
    s.radiance = light.intensity;
    s.pdf = pmf;
    s.delta = light.radius <= 0.0;
    if (!s.delta) {
        float one_minus_cos = 2.0 * square(sin(0.5 * light.radius));
        s.direction = basis_around(-light.direction) * sample_cone(xi.zw, one_minus_cos);
        s.radiance *= INV_PI / square(sin(light.radius));
        s.pdf *= cone_pdf(one_minus_cos);
    }
    return s;
}

// A point or spot light, picked by its power.
LightSample sample_positional(vec3 position, uvec4 bits) {
    LightTablesRecord tables = choice_tables();
    uint count = tables.light_count - tables.sun_count;
    if (count == 0u) return NO_LIGHT_SAMPLE;
    vec4 xi = unit_from_bits(bits);
    float pmf;
    uint picked = punctual_pick(tables.sun_count, count, xi.x, pmf) - tables.sun_count;
    LightRecord light = LightTable(scene.light_tables.lights).at[scene.light_tables.sun_count + picked];
    LightSample s = sample_positional_light(position, light, xi.zw);
    s.pdf *= pmf;
    return s;
}

// An emissive triangle, picked by alias table.
LightSample sample_emissive(vec3 position, uvec4 bits) {
    if (scene.emissive_count == 0u) return NO_LIGHT_SAMPLE;
    vec4 xi = unit_from_bits(bits);
    uint light = alias_pick(scene.emissive_alias, scene.emissive_count, bits.x, xi.y);
    LightSample s = sample_triangle_light(position, vec3(0.0), local_light(light), light, AREA_SAMPLING_UNIFORM, xi.zw);
    s.pdf *= EmissiveTable(scene.emissives).at[light].pmf;
    return s;
}

// Index of a triangle among the emissive ones, or NONE.
uint emissive_index(uint instance, uint triangle) {
    if (scene.emissive_count == 0u) return NONE;
    UintTable lookup = UintTable(scene.emissive_lookup);
    uint first = lookup.at[instance];
    return first == NONE ? NONE : lookup.at[first + triangle];
}

// Density per solid angle of a uniform point of a triangle, seen at `distance` under `cos_light` > 0.
float triangle_area_pdf(float twice_area, float distance, float cos_light) {
    return 2.0 * distance * distance / (twice_area * cos_light);
}

// Density of sample_emissive for a point of emissive triangle `index` that something else found, seen at `distance` under
// `cos_light`.
float emissive_pdf(uint index, float twice_area, float distance, float cos_light) {
    if (index == NONE || cos_light <= 0.0) return 0.0;
    return EmissiveTable(scene.emissives).at[index].pmf * triangle_area_pdf(twice_area, distance, cos_light);
}

// A texel by alias table, then uniform in its solid angle.
LightSample sample_environment(uvec4 bits) {
    if (scene.environment_intensity <= 0.0) return NO_LIGHT_SAMPLE;
    vec4 xi = unit_from_bits(bits);
    uvec2 size = scene.environment_size;
    uint texel = alias_pick(scene.environment_alias, size.x * size.y, bits.x, xi.y);
    uvec2 cell = uvec2(texel % size.x, texel / size.x);
    LightSample s = NO_LIGHT_SAMPLE;
    s.direction = environment_cell_direction(size, cell, scene.environment_rotation, xi.zw);
    s.pdf = AliasTable(scene.environment_alias).at[texel].pmf / environment_cell_solid_angle(size, cell.y);
    s.radiance = environment_radiance(s.direction);
    return s;
}

// Density of sample_environment for a direction that something else found.
float environment_pdf(vec3 direction) {
    if (scene.environment_intensity <= 0.0) return 0.0;
    uvec2 size = scene.environment_size, texel = environment_cell(size, direction);
    return AliasTable(scene.environment_alias).at[texel.y * size.x + texel.x].pmf / environment_cell_solid_angle(size, texel.y);
}
