// Light of directional lights that smooth glass has bent or mirrored: photons (Jensen 1996, "Global Illumination using Photon Maps") of one
// frame in a grid of cells. What the passes of caustics share: the records, and the place of a point in the grid.
//
// A cell is a column over a square of the two axes that the surface's normal has least of, on one of its two sides. A plane cuts the area
// size^2 / |n_k| out of a column, n_k the largest component of its unit normal, so that flux becomes irradiance without clipping:
//
//     E = flux |n_k| / size^2
//
// Along the third axis columns are cut where the plane meets their middle, at every CUT cells: points of one plane in a column are in one cell,
// surfaces behind each other are not. The grid lies elsewhere in each frame, so that the mean over frames has no blocks.
#include "caustics_records.glsl"
#include "random.glsl"
#include "scene.glsl"

layout(push_constant, scalar) uniform Push { CausticsPush push; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer CausticTargets { CausticTarget at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer CausticBoxes { CausticBox at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer CausticHeads { CausticHead head; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer CausticCells { CausticCell at[]; };

const float CUT = 4.0;
// Entries that are tried for a cell. A photon takes one at most and half of them stay free: more are hardly ever needed, and a photon that finds
// none is lost.
const uint MAX_PROBES = 64u;

struct GridPlace {
    uint key;    // of the cell, never 0
    float scale; // from flux to irradiance, 1 / m^2
};

uint largest_axis(vec3 n) {
    vec3 a = abs(n);
    return a.x >= a.y && a.x >= a.z ? 0u : a.y >= a.z ? 1u : 2u;
}

// `normal`: of the triangle, on the side that the light arrives at. `shift`: along the plane, parts of a cell.
GridPlace grid_place(vec3 position, vec3 normal, vec2 shift) {
    uint k = largest_axis(normal), i = (k + 1u) % 3u, j = (k + 2u) % 3u;
    vec3 offset = CausticHeads(push.head).head.offset;
    vec3 p = position / push.cell_size + offset;
    vec2 at = vec2(p[i], p[j]), cell = floor(at + shift);
    vec2 slope = -vec2(normal[i], normal[j]) / normal[k];
    float height = floor((p[k] + dot(slope, cell + 0.5 - at)) / CUT + offset[k]);
    uint side = 2u * k + (normal[k] < 0.0 ? 1u : 0u);
    uint key = pcg4d(uvec4(ivec3(vec3(cell, height)), side)).x;
    return GridPlace(max(key, 1u), abs(normal[k]) / square(push.cell_size));
}
