// Lists that compute kernels write by whole workgroups, so that neighbours stay side by side and the length is one atomic for many.
#include "ray_list.glsl"

shared uint group_count;
shared uint group_first;

// The place of the thread's entry, if it has one. Called by all threads of the workgroup.
uint append_to_list(RayListCount list, uint columns, bool has_entry) {
    if (gl_LocalInvocationIndex == 0u) group_count = 0u;
    barrier();
    uint place = has_entry ? atomicAdd(group_count, 1u) : 0u;
    barrier();
    if (gl_LocalInvocationIndex == 0u && group_count > 0u) group_first = grow_list(list, columns, group_count);
    barrier();
    return group_first + place;
}
