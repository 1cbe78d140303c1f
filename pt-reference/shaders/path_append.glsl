// Lists of slots are written by whole workgroups, so that neighbours stay side by side and the length is one atomic for many.
shared uint group_count;
shared uint group_first;

// Called by all threads of the group; `listed`: whether the thread's slot is added.
void append_slot(uint slot, uint list, bool listed) {
    if (gl_LocalInvocationIndex == 0u) group_count = 0u;
    barrier();
    uint place = listed ? atomicAdd(group_count, 1u) : 0u;
    barrier();
    if (gl_LocalInvocationIndex == 0u) group_first = atomicAdd(TileProgress(push.progress).tile.listed[list], group_count);
    barrier();
    if (listed) slot_list(list).at[group_first + place] = slot;
}
