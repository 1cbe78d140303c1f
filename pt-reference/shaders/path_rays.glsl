// The rays of a list of slots. A kernel that traces them defines
//
//     PathRay load_path_ray(uint slot)
//     void finish_path_ray(uint slot, Hit hit)
//
// With refills_lanes it calls trace_slots_refilling(): the launch has about as many threads as the device, and lanes whose rays are done take new ones
// from the list while the others go on (Aila and Laine 2009, "Understanding the Efficiency of Ray Traversal on GPUs"). Else each thread traces one.
struct PathRay {
    Ray ray;
    uint mask;
    uvec2 coverage;
};

PathRay load_path_ray(uint slot);
void finish_path_ray(uint slot, Hit hit);

#ifdef TRACE_COMPUTE
layout(constant_id = 20) const bool refills_lanes = false;

// Lanes that are idle before they take rays, or else all: with fewer at a time the others wait too often (NVIDIA H200: 1, 4, 8, 12, 16).
const uint IDLE_LANES = 12u;

void trace_slots_refilling(uint list, const bool any_hit) {
    TileProgress progress = TileProgress(push.progress);
    uint count = progress.tile.lists[list].count, slot = NONE;
    Traversal t = begin_traversal(Ray(vec3(0.0), 0.0, vec3(0.0), 0.0), 0u, uvec2(0u));
    bool more = true;
    for (;;) {
        uvec4 idle = subgroupBallot(slot == NONE);
        uint idle_count = subgroupBallotBitCount(idle);
        bool all_idle = idle_count == subgroupBallotBitCount(subgroupBallot(true));
        if (more && (idle_count >= IDLE_LANES || all_idle)) {
            uint first = 0u;
            if (subgroupElect()) first = atomicAdd(progress.tile.lists[list].taken, idle_count);
            first = subgroupBroadcastFirst(first);
            more = first + idle_count < count;
            if (slot == NONE) {
                slot = slot_at(first + subgroupBallotExclusiveBitCount(idle), list);
                if (slot != NONE) {
                    PathRay r = load_path_ray(slot);
                    t = begin_traversal(r.ray, r.mask, r.coverage);
                }
            }
        } else if (all_idle) {
            break;
        }
        if (slot != NONE) {
            step_traversal(t, any_hit);
            if (is_done(t, any_hit)) {
                finish_path_ray(slot, t.best);
                slot = NONE;
            }
        }
    }
}
#endif
