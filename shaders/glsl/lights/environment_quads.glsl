// The environment as local lights: quads of a quad-tree over its cells (pt_light_sampling::EnvironmentQuads). In the table of local lights
// they stand between the emissive triangles and the positional lights: the numbers of triangles and quads do not change from frame to frame,
// so a quad keeps its index while positional lights appear and vanish. Host twin: pt_light_sampling::oracle::environment_quads.
#include "environment.glsl"
#include "lights/light_sample.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer EnvironmentQuadTable { EnvironmentQuadRecord at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer EnvironmentNodeTable { EnvironmentQuadNode at[]; };

// False: a kernel for scenes whose environment is sampled apart leaves out the quads.
layout(constant_id = 6) const bool environment_listed = true;

// Whether the environment is among the local lights: it is then not sampled apart.
bool environment_is_listed() { return environment_listed && scene.environment_quad_count > 0u; }

uint first_environment_light() { return scene.emissive_count; }

uint first_positional_light() { return scene.emissive_count + scene.environment_quad_count; }

EnvironmentQuadRecord environment_quad(uint quad) { return EnvironmentQuadTable(scene.environment_quads).at[quad]; }

// Address of the alias table over a quad's cells.
uint64_t environment_quad_cells(EnvironmentQuadRecord q) { return scene.environment_quad_cells + uint64_t(q.first) * 12ul; }

// The quad of a cell, NONE: it is black.
uint quad_of_cell(uvec2 cell) {
    uint node = 0u;
    while (true) {
        EnvironmentQuadNode n = EnvironmentNodeTable(scene.environment_quad_nodes).at[node];
        if (n.link == NONE) return NONE;
        if ((n.link & ENVIRONMENT_QUAD_LEAF) != 0u) return n.link & ~ENVIRONMENT_QUAD_LEAF;
        node = n.link + (cell.x >= n.split.x ? 1u : 0u) + (cell.y >= n.split.y ? 2u : 0u);
    }
}

// Density of a direction of a quad per solid angle.
float environment_cell_pdf(EnvironmentQuadRecord q, uvec2 cell) {
    uvec2 place = cell - q.corner;
    float pmf = AliasTable(environment_quad_cells(q)).at[place.y * q.size.x + place.x].pmf;
    return pmf / environment_cell_solid_angle(scene.environment_grid, cell.y);
}

// The local light that a direction belongs to, NONE: its part of the environment is black or the environment is not listed.
uint light_of_direction(vec3 direction) {
    if (!environment_is_listed() || scene.environment_intensity <= 0.0) return NONE;
    uint quad = quad_of_cell(environment_cell(scene.environment_grid, direction));
    return quad == NONE ? NONE : first_environment_light() + quad;
}

// Density with which sample_environment_quad() finds a direction of its local light, `light` (NONE: it has none).
float environment_quad_pdf(vec3 direction, out uint light) {
    light = light_of_direction(direction);
    if (light == NONE) return 0.0;
    return environment_cell_pdf(environment_quad(light - first_environment_light()), environment_cell(scene.environment_grid, direction));
}

// A direction of a quad with its density; `l`: its record, of this frame or of the last one. The two numbers, 16 bits of each, make up one
// number, which chooses an entry of the alias table; a hash of it decides the rest. So it takes no more numbers than a point on any other
// light, and sampler restir-di can repeat it.
LightSample sample_environment_quad(LocalLightRecord l, uint quad, vec2 xi) {
    float intensity = l.edge2.z;
    if (intensity <= 0.0) return NO_LIGHT_SAMPLE;
    EnvironmentQuadRecord q = environment_quad(quad);
    uint number = uint(xi.x * 65536.0) << 16u | uint(xi.y * 65536.0);
    vec4 more = unit_from_bits(pcg4d(uvec4(number, quad, 0u, 0u)));
    uint place = alias_pick(environment_quad_cells(q), q.size.x * q.size.y, number, more.x);
    uvec2 cell = q.corner + uvec2(place % q.size.x, place / q.size.x);
    LightSample s = NO_LIGHT_SAMPLE;
    s.direction = environment_cell_direction(scene.environment_grid, cell, l.edge2.xy, more.yz);
    s.pdf = environment_cell_pdf(q, cell);
    s.radiance = intensity * environment_lookup(rotated_environment_uv(s.direction, l.edge2.xy));
    return s;
}
