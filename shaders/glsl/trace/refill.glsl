// Kernels that trace the rays of a list. With the compute backend about as many workgroups as a GPU has at a time share the list: lanes whose rays are
// done take new ones while the others of their subgroup go on (Aila and Laine 2009, "Understanding the Efficiency of Ray Traversal on GPUs"). With the
// others each thread has one entry. A kernel includes this header behind trace.glsl and defines
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
// Workgroups that share a list.
const uint REFILLING_GROUPS = 4096u;

// How many lanes wait before they take rays. Frames with an eighth take up to 2 % more on an H200, with three eighths up to 1 %; on lavapipe half is slower.
uint most_waiting() { return max(gl_SubgroupSize / 4u, 1u); }

uint count_lanes(bool which) { return subgroupBallotBitCount(subgroupBallot(which)); }

// Steps are in a loop of their own: a CPU device executes what is behind an `if` whether or not a lane needs it.
void trace_refilling(const bool any_hit) {
    Traversal t = begin_traversal(Ray(vec3(0.0), 0.0, vec3(0.0), 0.0), 0u, uvec2(0u));
    uint lanes = count_lanes(true), count = entry_count(), entry = NONE, pieces = 0u;
    bool more = true;
    for (;;) {
        if (more) {
            uvec4 idle = subgroupBallot(entry == NONE);
            uint idle_count = subgroupBallotBitCount(idle), first = 0u;
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
        }
        bool waits = entry == NONE;
        uint waiting = count_lanes(waits);
        if (waiting == lanes) break;
        for (uint enough = more ? most_waiting() : lanes; waiting < enough; waiting = count_lanes(waits)) {
            if (!waits) {
                step_traversal(t, any_hit);
                waits = is_done(t, any_hit);
            }
        }
        if (waits && entry != NONE) {
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
#endif

// `place`: in the list, of a thread of a launch with workgroups of RAY_LIST_TRACE_GROUP.
void trace_listed(uint place, const bool any_hit) {
#ifdef TRACE_COMPUTE
    // What a ray meets behind the sky is known only when it is done.
    if (!scene_has(FEATURE_SKY)) {
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
