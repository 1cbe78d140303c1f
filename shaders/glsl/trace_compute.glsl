// trace.glsl as a compute kernel's own traversal of two levels of compressed 8-wide BVHs: Ylitie, Karras, Laine 2017,
// "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs". Nodes come from pt_core::trace::bvh.
layout(local_size_x = 8, local_size_y = 4) in;

uvec2 launch_id() { return gl_GlobalInvocationID.xy; }

// A node is five uvec4: origin and exponents | imask << 24; first inner child, first leaf entry, two words of child meta;
// then for x, y, z two words of lower and two of upper planes, a byte a child.
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer BvhNode { uvec4 words[5]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer TriangleRef { BvhTriangle triangle; };

// pt_core::trace::bvh::STACK_SIZE
const uint STACK_SIZE = 32u;
// Barycentrics this far outside still hit: closes the cracks that rounding leaves between neighbours.
const float EDGE_TOLERANCE = 1e-6;

// What the box test needs of a ray.
struct BoxRay {
    vec3 origin;
    vec3 inverse;  // 1 / direction, finite
    uint octant;   // order in which children are visited: bit 2, 1, 0 set where x, y, z is not negative
};

BoxRay box_ray(Ray ray) {
    vec3 direction = mix(ray.direction, vec3(1e-20), lessThan(abs(ray.direction), vec3(1e-20)));
    uvec3 positive = uvec3(greaterThanEqual(direction, vec3(0.0)));
    return BoxRay(ray.origin, 1.0 / direction, positive.x << 2 | positive.y << 1 | positive.z);
}

// Four planes of one side, as bytes.
vec4 planes(uint word) { return vec4(word & 0xffu, (word >> 8) & 0xffu, (word >> 16) & 0xffu, word >> 24); }

// For four children: bits of those hit, at the places that their meta bytes give (leaf entries 0..23, inner children 24..31).
uint hit_children(uint near_x, uint far_x, uint near_y, uint far_y, uint near_z, uint far_z, uint meta, vec3 scale, vec3 enter, vec3 leave,
                  float t_min, float t_max) {
    vec4 t_near = max(max(fma(planes(near_x), scale.xxxx, enter.xxxx), fma(planes(near_y), scale.yyyy, enter.yyyy)),
                      max(fma(planes(near_z), scale.zzzz, enter.zzzz), vec4(t_min)));
    vec4 t_far = min(min(fma(planes(far_x), scale.xxxx, leave.xxxx), fma(planes(far_y), scale.yyyy, leave.yyyy)),
                     min(fma(planes(far_z), scale.zzzz, leave.zzzz), vec4(t_max)));
    uint hits = 0u;
    [[unroll]] for (int i = 0; i < 4; i++) {
        uint bits = bitfieldExtract(meta, 8 * i + 5, 3) << bitfieldExtract(meta, 8 * i, 5);
        hits |= t_near[i] <= t_far[i] ? bits : 0u;
    }
    return hits;
}

// Moves bit i of an 8-bit set to i ^ octant.
uint permute(uint bits, uint octant) {
    bits = (octant & 1u) != 0u ? (bits & 0x55u) << 1 | (bits >> 1) & 0x55u : bits;
    bits = (octant & 2u) != 0u ? (bits & 0x33u) << 2 | (bits >> 2) & 0x33u : bits;
    return (octant & 4u) != 0u ? (bits & 0x0fu) << 4 | bits >> 4 : bits;
}

// A set of siblings: x = index of the first, y = those to visit (in order, bits 24..31) | imask (inner nodes), or bits 0..23
// (leaf entries).
struct Children {
    uvec2 inner;
    uvec2 leaf;
};

Children visit(BvhNode node, BoxRay ray, float t_min, float t_max) {
    uvec4 head = node.words[0];
    uvec4 base = node.words[1];
    uvec4 x = node.words[2];
    uvec4 y = node.words[3];
    uvec4 z = node.words[4];
    vec3 extent = vec3(uintBitsToFloat(uvec3((head.w << 23) & 0x7f800000u, (head.w << 15) & 0x7f800000u, (head.w << 7) & 0x7f800000u)));
    vec3 scale = extent * ray.inverse;
    vec3 offset = (uintBitsToFloat(head.xyz) - ray.origin) * ray.inverse;
    // Widened by the rounding of both terms: no box is missed that touches the ray.
    vec3 slack = 4e-7 * fma(abs(scale), vec3(255.0), abs(offset));
    vec3 enter = offset - slack;
    vec3 leave = offset + slack;
    if (ray.inverse.x < 0.0) x = x.zwxy;
    if (ray.inverse.y < 0.0) y = y.zwxy;
    if (ray.inverse.z < 0.0) z = z.zwxy;
    uint hits = hit_children(x.x, x.z, y.x, y.z, z.x, z.z, base.z, scale, enter, leave, t_min, t_max) |
                hit_children(x.y, x.w, y.y, y.w, z.y, z.w, base.w, scale, enter, leave, t_min, t_max);
    uint inner = permute(hits >> 24, ray.octant) << 24 | head.w >> 24;
    return Children(uvec2(base.x, inner), uvec2(base.y, hits & 0xffffffu));
}

uvec2 stack[STACK_SIZE];

// Takes the next child out of a set of inner siblings; its node index.
uint take_child(inout uvec2 siblings, uint octant) {
    uint place = uint(findMSB(siblings.y));
    siblings.y ^= 1u << place;
    uint slot = (place - 24u) ^ octant;
    return siblings.x + uint(bitCount(siblings.y & 0xffu & ~(0xffffffffu << slot)));
}

BvhNode node_at(uint64_t nodes, uint index) { return BvhNode(nodes + uint64_t(index * 80u)); }

// One mesh. `floor` is the stack's height that belongs to the caller. Shrinks best.t; with `any` returns at the first hit.
bool traverse_mesh(Ray world_ray, uint instance, uint height, bool any_hit, inout Hit best) {
    InstanceTable table = InstanceTable(scene.instances);
    MeshTable meshes = MeshTable(scene.meshes);
    uint mesh = table.at[instance].mesh;
    uint64_t nodes = meshes.at[mesh].bvh_nodes;
    uint64_t triangles = meshes.at[mesh].bvh_triangles;
    uint first_masked = meshes.at[mesh].first_masked;
    Ray ray = object_space_ray(world_ray, table.at[instance].object_from_world);
    BoxRay box = box_ray(ray);
    uint bottom = height;
    uvec2 inner = uvec2(0u, 0x80000000u);
    bool found = false;
    for (;;) {
        uint child = take_child(inner, box.octant);
        if (inner.y > 0xffffffu) stack[height++] = inner;
        Children children = visit(node_at(nodes, child), box, ray.t_min, best.t);
        inner = children.inner;
        uvec2 leaf = children.leaf;
        while (leaf.y != 0u) {
            uint place = uint(findMSB(leaf.y));
            leaf.y ^= 1u << place;
            BvhTriangle triangle = TriangleRef(triangles + uint64_t((leaf.x + place) * 40u)).triangle;
            vec3 uvt = triangle_intersection(ray, triangle.v0, triangle.e1, triangle.e2);
            bool hit = uvt.x >= -EDGE_TOLERANCE && uvt.y >= -EDGE_TOLERANCE && uvt.x + uvt.y <= 1.0 + EDGE_TOLERANCE &&
                       uvt.z >= ray.t_min && uvt.z < best.t;
            if (hit) {
                best = Hit(instance, triangle.triangle, uvt.xy, uvt.z);
                found = true;
            }
        }
        if (any_hit && found) break;
        if (inner.y <= 0xffffffu) {
            if (height == bottom) break;
            inner = stack[--height];
        }
    }
    return found;
}

Hit trace_closest(Ray ray, uint mask) {
    Hit best = Hit(NONE, NONE, vec2(0.0), ray.t_max);
    traverse_mesh(ray, 0u, 0u, false, best);
    return best;
}

bool trace_occluded(Ray ray, uint mask) {
    Hit best = Hit(NONE, NONE, vec2(0.0), ray.t_max);
    return traverse_mesh(ray, 0u, 0u, true, best);
}
