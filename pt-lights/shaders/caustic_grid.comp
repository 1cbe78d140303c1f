// The grid of a frame before its photons: no light in any cell, where the targets are, and the unit of the sums. Extent: the cells.
layout(local_size_x = 64) in;
#include "caustics.glsl"
#include "lights/light_tables.glsl"

CausticBox target_box(CausticTarget t) {
    vec3 size = t.high - t.low;
    CausticBox b = CausticBox(t.low, vec3[3](vec3(size.x, 0.0, 0.0), vec3(0.0, size.y, 0.0), vec3(0.0, 0.0, size.z)));
    if (t.instance == NONE) return b;
    vec4 rows[3] = scene_instance(t.instance).world_from_object;
    b.corner = transform_point(rows, b.corner);
    for (int i = 0; i < 3; i++) b.edges[i] = transform_vector(rows, b.edges[i]);
    return b;
}

// Most flux that a photon may begin with.
float most_flux() {
    float area = 0.0;
    for (uint i = 0u; i < push.target_count; i++) {
        CausticBox b = target_box(CausticTargets(push.targets).at[i]);
        CausticBoxes(push.boxes).at[i] = b;
        area += length(cross(b.edges[0], b.edges[1])) + length(cross(b.edges[1], b.edges[2])) + length(cross(b.edges[2], b.edges[0]));
    }
    float brightest = 0.0;
    for (uint i = 0u; i < choice_tables().sun_count; i++) {
        LightRecord light = LightTable(choice_tables().lights).at[i];
        if (light.pmf > 0.0) brightest = max(brightest, max_component(light.intensity) / light.pmf);
    }
    return area * brightest / float(push.photons);
}

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i > push.cell_mask) return;
    CausticCells(push.cells).at[i] = CausticCell(0u, uvec3(0u), uvec3(0u), 0u);
    if (i != 0u) return;
    // All photons in one cell stay below 2^31.
    float units = min(65536.0, 2147483648.0 / float(push.photons));
    vec3 offset = unit_from_bits(pcg4d(uvec4(frame.frame_index, frame.seed, DIM_CAUSTICS, push.photons))).xyz;
    CausticHeads(push.head).head = CausticHead(most_flux() / units, offset);
}
