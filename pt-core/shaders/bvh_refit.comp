// Refits one level of the wide BVHs of deforming meshes to new vertex positions, one thread a node: the topology stays, triangles are
// read anew, the boxes of children that are nodes come from the level below, and the node's grid is laid over them (Ylitie,
// Karras, Laine 2017, section 3.1). Levels are done from the deepest to the root.
#include "records.glsl"
#include "refit_records.glsl"
#include "trace/gpu_traversal.glsl"

layout(local_size_x = 64) in;

layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer MeshTable { MeshRecord at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer PositionTable { vec3 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer IndexTable { uvec3 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer RefitTable { RefitNode at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer TriangleTable { BvhTriangle at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer BoundsTable { NodeBounds at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer NodeWords { uint at[20]; };
layout(push_constant, scalar) uniform Push { RefitPush push; };

const uint NODE_BYTES = 80u;
// Smallest extent of a node's grid: keeps its steps normal numbers.
const float LEAST_EXTENT = 1e-20;

// Biased exponent of the smallest power of two by which 255 steps are at least `extent`.
uint grid_exponent(float extent) {
    float least = max(extent, LEAST_EXTENT);
    uint bits = floatBitsToUint(least / 255.0);
    uint exponent = (bits >> 23) + ((bits & 0x7fffffu) != 0u ? 1u : 0u);
    // The quotient may have been rounded down to a power of two.
    if (least * uintBitsToFloat((254u - exponent) << 23) > 255.0) exponent++;
    return exponent;
}

// Sets byte `slot` of the eight bytes that begin at word `word`.
void put(inout uint words[12], uint word, uint slot, float value) {
    words[word + (slot >> 2)] |= uint(clamp(value, 0.0, 255.0)) << (8u * (slot & 3u));
}

void main() {
    uint index = gl_GlobalInvocationID.y * push.width + gl_GlobalInvocationID.x;
    if (gl_GlobalInvocationID.x >= push.width || index >= push.count) return;
    RefitNode work = RefitTable(push.nodes).at[push.first + index];
    MeshRecord mesh = MeshTable(push.meshes).at[work.mesh];
    NodeWords node = NodeWords(mesh.bvh_nodes + uint64_t(work.node) * NODE_BYTES);
    uint inner_set = node.at[3] >> 24;
    uint leaf_set = node.at[4] >> 28 | (node.at[5] >> 28) << 4;
    uint first_child = node.at[4] & 0xfffffffu;
    uint first_leaf = node.at[5] & 0xfffffffu;

    vec3 child_low[8];
    vec3 child_high[8];
    vec3 low = vec3(3.4e38), high = vec3(-3.4e38);
    for (uint slot = 0u; slot < 8u; slot++) {
        uint bit = 1u << slot;
        vec3 a = vec3(3.4e38), b = vec3(-3.4e38);
        if ((leaf_set & bit) != 0u) {
            uint leaf = first_leaf + uint(bitCount(leaf_set & (bit - 1u)));
            TriangleTable triangles = TriangleTable(mesh.bvh_triangles);
            PositionTable position = PositionTable(mesh.positions);
            for (uint k = 0u; k < LEAF_TRIANGLES; k++) {
                uint entry = leaf * LEAF_TRIANGLES + k;
                uvec3 corner = IndexTable(mesh.indices).at[triangles.at[entry].triangle];
                vec3 p0 = position.at[corner.x], p1 = position.at[corner.y], p2 = position.at[corner.z];
                triangles.at[entry].v0 = p0;
                triangles.at[entry].e1 = p1 - p0;
                triangles.at[entry].e2 = p2 - p0;
                a = min(a, min(p0, min(p1, p2)));
                b = max(b, max(p0, max(p1, p2)));
            }
        } else if ((inner_set & bit) != 0u) {
            NodeBounds child = BoundsTable(push.bounds).at[work.bounds + first_child + uint(bitCount(inner_set & (bit - 1u)))];
            a = child.low;
            b = child.high;
        }
        child_low[slot] = a;
        child_high[slot] = b;
        low = min(low, a);
        high = max(high, b);
    }
    BoundsTable(push.bounds).at[work.bounds + work.node] = NodeBounds(low, high);

    uvec3 exponent = uvec3(grid_exponent(high.x - low.x), grid_exponent(high.y - low.y), grid_exponent(high.z - low.z));
    vec3 steps = uintBitsToFloat((254u - exponent) << 23);
    uint planes[12] = uint[12](0u, 0u, 0u, 0u, 0u, 0u, 0u, 0u, 0u, 0u, 0u, 0u);
    for (uint slot = 0u; slot < 8u; slot++) {
        if (((leaf_set | inner_set) & (1u << slot)) == 0u) continue;
        vec3 a = floor((child_low[slot] - low) * steps), b = ceil((child_high[slot] - low) * steps);
        for (int axis = 0; axis < 3; axis++) {
            put(planes, 4u * uint(axis), slot, a[axis]);
            put(planes, 4u * uint(axis) + 2u, slot, b[axis]);
        }
    }
    node.at[0] = floatBitsToUint(low.x);
    node.at[1] = floatBitsToUint(low.y);
    node.at[2] = floatBitsToUint(low.z);
    node.at[3] = exponent.x | exponent.y << 8 | exponent.z << 16 | inner_set << 24;
    for (int word = 0; word < 12; word++) node.at[6 + word] = planes[word];
}
