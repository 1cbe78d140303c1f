// trace.glsl for the compute backend: traverses two levels of compressed 8-wide BVHs (Ylitie, Karras, Laine 2017,
// "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs"). Nodes: BvhNode, made by pt_core::trace::bvh.
//
// Written for SIMD without branches as well (lavapipe executes both sides of every `if`, and a loop's body at least once): loads are 128 bit
// wide, stack entries 64 bit. There is one loop, whose steps visit a node or two each, so that lanes that change level or test alpha do not wait
// until all others have left their instances. Kernels for scenes of one instance have no top level: on an H200 frames of `room` take 4 and those of
// Sponza 5 % less.
#include "trace/gpu_traversal.glsl"

layout(local_size_x = 8, local_size_y = 4) in;

uvec2 launch_id() { return gl_GlobalInvocationID.xy; }

// Of 16 bytes: a GPU has instructions that load as much, and visiting nodes costs it instructions.
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer NodeWords { uvec4 at[5]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer TriangleWords { uvec4 at[3]; };

const uint NODE_BYTES = 80u;
const uint TRIANGLE_BYTES = 48u;
// pt_core::trace::bvh keeps the trees within it.
const uint STACK_SIZE = 48u;
// Barycentrics this far outside still hit: closes the cracks that rounding leaves between neighbours.
const float EDGE_TOLERANCE = 1e-6;

// Without branches the alpha test costs every ray something, so that a kernel may do without (TRACE_OPAQUE, see trace.glsl), and one that
// is specialised has it only for scenes that need it.
#ifdef TRACE_OPAQUE
#define ALPHA_TEST false
#else
#define ALPHA_TEST scene_has(FEATURE_COVERAGE)
#endif

// A set of siblings to visit: x = index of the first, y = those left in bits 8..15, all that are numbered from x in bits 0..7.
// Inner children stand in the order of visit (slot ^ octant), leaves in slots.
const uvec2 ROOT = uvec2(0u, 0x8000u);
const uvec2 NO_SIBLINGS = uvec2(0u);

bool is_empty(uvec2 siblings) { return siblings.y < 0x100u; }

uint64_t stack[STACK_SIZE];

// What the box test needs of a ray.
struct BoxRay {
    vec3 origin;
    vec3 inverse; // 1 / direction, finite
    uint octant;  // bit 2, 1, 0 set where x, y, z of the direction is not negative
};

BoxRay box_ray(Ray ray) {
    vec3 direction = mix(ray.direction, vec3(1e-20), lessThan(abs(ray.direction), vec3(1e-20)));
    uvec3 positive = uvec3(greaterThanEqual(direction, vec3(0.0)));
    return BoxRay(ray.origin, 1.0 / direction, positive.x << 2 | positive.y << 1 | positive.z);
}

// Four planes, as bytes. By way of signed integers: one instruction on a CPU, where unsigned ones take six.
vec4 planes(uint word) { return vec4(int(word & 0xffu), int((word >> 8) & 0xffu), int((word >> 16) & 0xffu), int(word >> 24)); }

// Set of four children that the ray meets in [t_min, t_max]; x, y, z are the near and far planes of one axis each.
uint hit_children(uvec2 x, uvec2 y, uvec2 z, vec3 scale, vec3 enter, vec3 leave, float t_min, float t_max) {
    vec4 near = max(max(fma(planes(x.x), scale.xxxx, enter.xxxx), fma(planes(y.x), scale.yyyy, enter.yyyy)),
                    max(fma(planes(z.x), scale.zzzz, enter.zzzz), vec4(t_min)));
    vec4 far = min(min(fma(planes(x.y), scale.xxxx, leave.xxxx), fma(planes(y.y), scale.yyyy, leave.yyyy)),
                   min(fma(planes(z.y), scale.zzzz, leave.zzzz), vec4(t_max)));
    return (near.x <= far.x ? 1u : 0u) | (near.y <= far.y ? 2u : 0u) | (near.z <= far.z ? 4u : 0u) | (near.w <= far.w ? 8u : 0u);
}

// Moves bit i of an 8-bit set to i ^ octant.
uint permute(uint bits, uint octant) {
    bits = (octant & 1u) != 0u ? (bits & 0x55u) << 1 | (bits >> 1) & 0x55u : bits;
    bits = (octant & 2u) != 0u ? (bits & 0x33u) << 2 | (bits >> 2) & 0x33u : bits;
    return (octant & 4u) != 0u ? (bits & 0x0fu) << 4 | bits >> 4 : bits;
}

// Inner children and leaves of a node that the ray meets in [t_min, t_max].
void visit(NodeWords node, BoxRay ray, float t_min, float t_max, out uvec2 inner, out uvec2 leaves) {
    uvec4 a = node.at[0], b = node.at[1], c = node.at[2], d = node.at[3];
    vec2 origin_xy = uintBitsToFloat(a.xy);
    uvec2 head = a.zw, base = b.xy;
    uvec2 x0 = b.zw, x1 = c.xy, y0 = c.zw, y1 = d.xy, z0 = d.zw, z1 = node.at[4].xy;
    vec3 extent = uintBitsToFloat(uvec3(head.y << 23, head.y << 15, head.y << 7) & 0x7f800000u);
    vec3 scale = extent * ray.inverse;
    vec3 offset = (vec3(origin_xy, uintBitsToFloat(head.x)) - ray.origin) * ray.inverse;
    // Widened by the rounding of both terms, so that no box is missed that touches the ray.
    vec3 slack = 4e-7 * fma(abs(scale), vec3(255.0), abs(offset));
    vec3 enter = offset - slack;
    vec3 leave = offset + slack;
    bvec3 back = lessThan(ray.inverse, vec3(0.0));
    uvec2 x_near = back.x ? x1 : x0, x_far = back.x ? x0 : x1;
    uvec2 y_near = back.y ? y1 : y0, y_far = back.y ? y0 : y1;
    uvec2 z_near = back.z ? z1 : z0, z_far = back.z ? z0 : z1;
    uint hits = hit_children(uvec2(x_near.x, x_far.x), uvec2(y_near.x, y_far.x), uvec2(z_near.x, z_far.x), scale, enter, leave, t_min, t_max) |
                hit_children(uvec2(x_near.y, x_far.y), uvec2(y_near.y, y_far.y), uvec2(z_near.y, z_far.y), scale, enter, leave, t_min, t_max) << 4;
    uint inner_set = head.y >> 24;
    uint leaf_set = base.x >> 28 | (base.y >> 28) << 4;
    inner = uvec2(base.x & 0xfffffffu, permute(hits & inner_set, ray.octant) << 8 | inner_set);
    leaves = uvec2(base.y & 0xfffffffu, (hits & leaf_set) << 8 | leaf_set);
}

// Takes the last one out of a set of siblings; its index.
uint take(inout uvec2 siblings, uint octant) {
    uint place = uint(findMSB(siblings.y));
    siblings.y ^= 1u << place;
    uint slot = (place - 8u) ^ octant;
    return siblings.x + uint(bitCount(siblings.y & ~(0xffffffffu << slot) & 0xffu));
}

struct MeshTriangle {
    vec3 v0, e1, e2;
    uint index;
};

MeshTriangle load_triangle(uint64_t triangles, uint entry) {
    TriangleWords words = TriangleWords(triangles + uint64_t(entry) * TRIANGLE_BYTES);
    uvec4 a = words.at[0], b = words.at[1], c = words.at[2];
    return MeshTriangle(uintBitsToFloat(a.xyz), uintBitsToFloat(uvec3(a.w, b.xy)), uintBitsToFloat(uvec3(b.zw, c.x)), c.y);
}

// How far the traversal for a ray has come.
struct Traversal {
    Ray world_ray;
    uint mask;
    uvec2 ray_coverage;
    Hit best;
    Hit candidate; // a triangle that waits for a test of its material
    // The level that the ray is in: a mesh, or (instance == NONE) the top level.
    uint instance;
    uint64_t nodes, triangles;
    uint first_masked;
    uint sides; // MASK_*SIDE* of the instance; 0 for rays that do not cull
    Ray ray;
    BoxRay box;
    uvec2 inner, leaves;
    uint height;
    uint bottom; // height below which the stack belongs to the level above
};

// Whether the kernel is made for scenes of one instance: rays are in it from the beginning, and there is no top level.
#define ONE_LEVEL (!scene_has(FEATURE_INSTANCES))

bool tests_sides() { return culling != CULLING_NONE && scene_has(FEATURE_MIXED_SIDES); }

bool tests_materials() { return ALPHA_TEST || tests_sides(); }

// Goes on in the tree of a mesh.
void enter_instance(inout Traversal t, uint instance) {
    t.instance = instance;
    InstanceRecord entered = scene_instance(t.instance);
    MeshRecord mesh = scene_mesh(entered.mesh);
    t.nodes = mesh.bvh_nodes;
    t.triangles = mesh.bvh_triangles;
    t.first_masked = mesh.first_masked;
    if (culling != CULLING_NONE) t.sides = (t.mask & CULL_BACK_FACES) != 0u ? entered.mask & (MASK_SINGLE_SIDED | MASK_MIXED_SIDES) : 0u;
    t.ray = object_space_ray(t.world_ray, entered.object_from_world);
    t.box = box_ray(t.ray);
    // One that the mask hides is left again after its root: nothing lies in an empty interval.
    if ((entered.mask & t.mask & 0xffu) == 0u) t.ray.t_min = 3e38;
    t.inner = ROOT;
    t.leaves = NO_SIBLINGS;
}

Traversal begin_traversal(Ray ray, uint mask, uvec2 ray_coverage) {
    Hit none = Hit(NONE, NONE, vec2(0.0), ray.t_max);
    Traversal t = Traversal(ray, mask, ray_coverage, none, none, NONE, scene.tlas_nodes, 0ul, NONE, 0u, ray, box_ray(ray), ROOT, NO_SIBLINGS, 0u, 0u);
    if (ONE_LEVEL) enter_instance(t, 0u);
    return t;
}

// From the top level, which the ray comes back to.
void descend(inout Traversal t) {
    uint entry = take(t.leaves, 0u);
    stack[t.height] = packUint2x32(t.inner);
    stack[t.height + 1u] = packUint2x32(t.leaves);
    t.height += 2u;
    t.bottom = t.height;
    enter_instance(t, UintTable(scene.tlas_instances).at[entry]);
}

// Whether the level has nodes to visit; if so, `inner` has some.
bool find_nodes(inout Traversal t) {
    if (!is_empty(t.inner)) return true;
    if (t.height == t.bottom) return false;
    t.inner = unpackUint2x32(stack[--t.height]);
    return true;
}

// After find_nodes.
void visit_next(inout Traversal t) {
    uint child = take(t.inner, t.box.octant);
    // Written in any case and kept when there is more to come: a masked store costs more.
    stack[t.height] = packUint2x32(t.inner);
    t.height += is_empty(t.inner) ? 0u : 1u;
    visit(NodeWords(t.nodes + uint64_t(child) * NODE_BYTES), t.box, t.ray.t_min, t.best.t, t.inner, t.leaves);
}

// One triangle of a leaf. True: it waits for a test of its material, but another one, the first of the leaf, does so already.
bool test_triangle(inout Traversal t, uint entry, bool done, const bool second) {
    MeshTriangle m = load_triangle(t.triangles, entry);
    vec3 uvt = triangle_intersection(t.ray, m.v0, m.e1, m.e2);
    bool hit = uvt.x >= -EDGE_TOLERANCE && uvt.y >= -EDGE_TOLERANCE && uvt.x + uvt.y <= 1.0 + EDGE_TOLERANCE &&
               uvt.z >= t.ray.t_min && uvt.z < t.best.t && !done;
    bool tested = ALPHA_TEST && m.index >= t.first_masked;
    if (culling != CULLING_NONE && t.sides != 0u && is_back_face(t.ray.direction, m.e1, m.e2)) {
        hit = hit && t.sides != MASK_SINGLE_SIDED;
        tested = tested || tests_sides();
    }
    if (hit && !tested) t.best = Hit(t.instance, m.index, uvt.xy, uvt.z);
    bool waits = hit && tested, full = second && t.candidate.instance != NONE;
    if (waits && !full) t.candidate = Hit(t.instance, m.index, uvt.xy, uvt.z);
    return waits && full;
}

// In the index of a set of leaves: of the leaf that comes next the first triangle is done.
const uint FIRST_DONE = 0x80000000u;

// The triangles of the leaves, up to one that waits for a test of its material.
void test_leaves(inout Traversal t) {
    while (!is_empty(t.leaves)) {
        uvec2 all = t.leaves;
        uint leaf = take(t.leaves, 0u);
        bool first_done = false;
        if (tests_materials() && gpu_traversal) {
            first_done = (leaf & FIRST_DONE) != 0u;
            leaf &= ~FIRST_DONE;
            t.leaves.x &= ~FIRST_DONE;
        }
        // Written out: a CPU device pays for a loop of one turn.
        test_triangle(t, leaf * LEAF_TRIANGLES, first_done, false);
        if (gpu_traversal && test_triangle(t, leaf * LEAF_TRIANGLES + 1u, false, true)) t.leaves = uvec2(all.x | FIRST_DONE, all.y);
        if (tests_materials() && t.candidate.instance != NONE) break;
    }
}

void test_candidate(inout Traversal t) {
    MeshRecord mesh = scene_mesh(scene_instance(t.instance).mesh);
    bool stops = true;
    if (tests_sides()) stops = !culls(t.mask) || !is_culled(t.instance, t.candidate.triangle, t.world_ray.direction);
    if (ALPHA_TEST) stops = stops && is_covered(mesh, t.instance, t.candidate.triangle, t.candidate.barycentrics, t.ray_coverage);
    // The other triangle of the leaf may be nearer.
    if (stops && t.candidate.t < t.best.t) t.best = t.candidate;
    t.candidate.instance = NONE;
}

// Back to the top level when the instance has nothing left.
void leave_instance(inout Traversal t) {
    if (t.instance == NONE || t.height != t.bottom || !is_empty(t.inner) || !is_empty(t.leaves)) return;
    t.leaves = unpackUint2x32(stack[t.height - 1u]);
    t.inner = unpackUint2x32(stack[t.height - 2u]);
    t.height -= 2u;
    t.bottom = 0u;
    t.instance = NONE;
    t.nodes = scene.tlas_nodes;
    t.ray = t.world_ray;
    t.box = box_ray(t.ray);
}

bool is_done(Traversal t, const bool any_hit) {
    return any_hit && t.best.instance != NONE || t.height == 0u && is_empty(t.inner) && is_empty(t.leaves);
}

// A node or two, and the triangles in their leaves. On a GPU a step visits a second node where the first has no leaf that the ray meets (H200: frames
// take 1 to 2.4 % less, the path tracer 4 %; with a third one 2 % more). Rays for the nearest hit do so in scenes of one instance alone: with instances
// they are up to 5 % slower with it. A CPU device visits it for all lanes when one needs it, and takes a third longer.
void step_traversal(inout Traversal t, const bool any_hit) {
    if (!ONE_LEVEL && t.instance == NONE && !is_empty(t.leaves)) descend(t);
    // Leaves are left over only after a test.
    if ((!tests_materials() || is_empty(t.leaves)) && find_nodes(t)) visit_next(t);
    if (gpu_traversal && (any_hit || ONE_LEVEL) && is_empty(t.leaves) && find_nodes(t)) visit_next(t);
    if (ONE_LEVEL || t.instance != NONE) test_leaves(t);
    if (tests_materials() && t.candidate.instance != NONE) test_candidate(t);
    if (!ONE_LEVEL) leave_instance(t);
}

Hit traverse(Ray ray, uint mask, uvec2 ray_coverage, const bool any_hit) {
    Traversal t = begin_traversal(ray, mask, ray_coverage);
    do {
        step_traversal(t, any_hit);
    } while (!is_done(t, any_hit));
    return t.best;
}

Hit find_closest(Ray ray, uint mask, uvec2 ray_coverage) { return traverse(ray, mask, ray_coverage, false); }

uint find_blocker(Ray ray, uint mask, uvec2 ray_coverage) { return traverse(ray, mask, ray_coverage, true).instance; }

bool find_any(Ray ray, uint mask, uvec2 ray_coverage) { return find_blocker(ray, mask, ray_coverage) != NONE; }
