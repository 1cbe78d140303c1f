// Samples the scene's lights from a shading point, one kind of light each. The functions take 4 x 32 random bits (random_bits) and return
// a sample whose pdf contains all choices made on the way. Nothing is clamped. Host twin: pt_light_sampling::oracle::lights.
#include "lights/local_lights.glsl"
#include "environment.glsl"

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
    LightRecord light = LightTable(scene.light_tables.lights).at[index];
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
