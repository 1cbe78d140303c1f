// Kernels that trace the rays of a list. With refill_lanes() about as many workgroups as a GPU has at a time share the list: a lane whose ray is done
// takes a new one while the others of its subgroup go on (Aila and Laine 2009, "Understanding the Efficiency of Ray Traversal on GPUs"). Else each
// thread has one entry. A kernel includes this header behind trace.glsl and defines
//
//     uint entry_count()                 of the list
//     uint entry_at(uint place)          an entry of the list; `place` is below that
//     uint take_entries(uint count)      counts so many more as taken; place of the first, perhaps past the end
//     EntryRay load_entry(uint entry)    its ray
//     bool finish_entry(uint entry, Hit hit, uint pieces)   true: the entry goes on, with the ray that load_entry() has now; `pieces`: how often it
//                                        has done so. Of a ray for any hit only hit.instance is defined
struct EntryRay {
    Ray ray;
    uint mask;
    uvec2 coverage;
};

uint entry_count();
uint entry_at(uint place);
uint take_entries(uint count);
EntryRay load_entry(uint entry);
bool finish_entry(uint entry, Hit hit, uint pieces);

#ifdef TRACE_COMPUTE
// Set for GPUs. A CPU device executes both sides of a branch and is slower with it.
layout(constant_id = 20) const bool refills_lanes = false;

// What a ray meets behind the sky is known only when it is done.
bool refill_lanes() { return refills_lanes && !scene_has(FEATURE_SKY); }

// Lanes that are idle before they take rays, or else all: with fewer at a time the others wait too often (NVIDIA H200: frames with 4 and 12 take up to 1 % more,
// with 16 1 to 3 %).
const uint IDLE_LANES = 8u;

void trace_refilling(const bool any_hit) {
    Traversal t = begin_traversal(Ray(vec3(0.0), 0.0, vec3(0.0), 0.0), 0u, uvec2(0u));
    uint count = entry_count(), entry = NONE, pieces = 0u;
    bool more = true;
    for (;;) {
        uvec4 idle = subgroupBallot(entry == NONE);
        uint idle_count = subgroupBallotBitCount(idle);
        bool all_idle = idle_count == subgroupBallotBitCount(subgroupBallot(true));
        if (more && (idle_count >= IDLE_LANES || all_idle)) {
            uint first = 0u;
            if (subgroupElect()) first = take_entries(idle_count);
            first = subgroupBroadcastFirst(first);
            more = first + idle_count < count;
            uint place = first + subgroupBallotExclusiveBitCount(idle);
            if (entry == NONE && place < count) {
                entry = entry_at(place);
                pieces = 0u;
                EntryRay r = load_entry(entry);
                t = begin_traversal(r.ray, r.mask, r.coverage);
            }
        } else if (all_idle) {
            break;
        }
        if (entry != NONE) {
            step_traversal(t, any_hit);
            if (is_done(t, any_hit)) {
                if (finish_entry(entry, t.best, pieces)) {
                    pieces++;
                    EntryRay r = load_entry(entry);
                    t = begin_traversal(r.ray, r.mask, r.coverage);
                } else {
                    entry = NONE;
                }
            }
        }
    }
}
#endif

// `place`: in the list, of a thread of a launch with workgroups of RAY_LIST_TRACE_GROUP.
void trace_listed(uint place, const bool any_hit) {
#ifdef TRACE_COMPUTE
    if (refill_lanes()) {
        if (place < REFILLING_GROUPS * RAY_LIST_TRACE_GROUP) trace_refilling(any_hit);
        return;
    }
#endif
    if (place >= entry_count()) return;
    uint entry = entry_at(place);
    for (uint pieces = 0u;; pieces++) {
        EntryRay r = load_entry(entry);
        Hit hit = MISS;
        if (any_hit) hit.instance = trace_blocker(r.ray, r.mask, r.coverage);
        else hit = trace_closest(r.ray, r.mask, r.coverage);
        if (!finish_entry(entry, hit, pieces)) break;
    }
}
