// The slots of a workgroup in the order of the materials that their rays have met (counting sort), so that threads side by side read the
// same textures: the device need not sample one after the other.
const uint BUCKETS = 64u;
shared uint bucket_count[BUCKETS];
shared uint bucket_first[BUCKETS];
shared uint sorted_slots[SHADE_GROUP];

uint material_bucket(uint slot) {
    if (slot == NONE) return BUCKETS - 1u;
    Hit hit = load_hit(slot);
    if (hit.instance == NONE) return BUCKETS - 2u;
    InstanceRecord instance = scene_instance(hit.instance);
    return material_of(instance, scene_mesh(instance.mesh), hit.triangle) % (BUCKETS - 2u);
}

// Called by all threads of the group with their slots (or NONE); each gets another one of them.
uint sort_by_material(uint slot) {
    uint thread = gl_LocalInvocationIndex;
    if (thread < BUCKETS) bucket_count[thread] = 0u;
    barrier();
    uint bucket = material_bucket(slot);
    uint rank = atomicAdd(bucket_count[bucket], 1u);
    barrier();
    if (thread == 0u) {
        uint first = 0u;
        for (uint i = 0u; i < BUCKETS; i++) {
            bucket_first[i] = first;
            first += bucket_count[i];
        }
    }
    barrier();
    sorted_slots[bucket_first[bucket] + rank] = slot;
    barrier();
    return sorted_slots[thread];
}
