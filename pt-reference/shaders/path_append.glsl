// Lists of slots are written by whole workgroups, so that neighbours stay side by side and the length is one atomic for many.

shared uint group_count;
shared uint group_first;

uint groups_for(uint count, uint size) { return (count + size - 1u) / size; }

// Room in the list for `count` more; the place of the first. Whoever comes to a new workgroup of the launches over the list counts it.
uint grow_list(uint list, uint count) {
    TileProgress progress = TileProgress(push.progress);
    uint first = atomicAdd(progress.tile.lists[list].count, count);
    uint end = first + count;
    uint rows = groups_for(end, 32u * tile_blocks().x), groups = groups_for(end, SHADE_GROUP);
    if (rows != groups_for(first, 32u * tile_blocks().x)) atomicMax(progress.tile.lists[list].groups.y, rows);
    if (groups != groups_for(first, SHADE_GROUP)) atomicMax(progress.tile.lists[list].shading_groups.x, groups);
    return first;
}

// Called by all threads of the group; `listed`: whether the thread's slot is added.
void append_slot(uint slot, uint list, bool listed) {
    if (gl_LocalInvocationIndex == 0u) group_count = 0u;
    barrier();
    uint place = listed ? atomicAdd(group_count, 1u) : 0u;
    barrier();
    if (gl_LocalInvocationIndex == 0u) group_first = grow_list(list, group_count);
    barrier();
    if (listed) slot_list(list).at[group_first + place] = slot;
}
