// A list that one pass writes and later passes are launched over (Pass::dispatch_indirect): of rays, or of paths that have one. The host
// knows only how long it can be. Host twin: pt_core::RayLists.
//
// A kernel that traces has workgroups of 8 x 4 threads, `columns` in a row of its launch; one that shades has
//
//     layout(local_size_x = RAY_LIST_SHADING_GROUP) in;
#include "records.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 4) buffer RayListCount { RayListHead head; };

// The entry that a thread of a kernel that traces takes; at least `count` past the end.
uint traced_place(uvec2 launch, uint columns) {
    return (launch.y / 4u * columns + launch.x / 8u) * RAY_LIST_TRACE_GROUP + launch.y % 4u * 8u + launch.x % 8u;
}

uint list_rows(uint count, uint columns) {
    uint row = RAY_LIST_TRACE_GROUP * columns;
    return (count + row - 1u) / row;
}

// Room for `count` more; the place of the first. Whoever comes to a new row of workgroups counts it.
uint grow_list(RayListCount list, uint columns, uint count) {
    uint first = atomicAdd(list.head.count, count), rows = list_rows(first + count, columns);
    if (rows != list_rows(first, columns)) {
        atomicMax(list.head.groups.y, rows);
        atomicMax(list.head.shading_groups.y, rows);
    }
    return first;
}

RayListHead empty_list(uint columns) {
    return RayListHead(0u, uvec3(columns, 0u, 1u), uvec3(columns * RAY_LIST_TRACE_GROUP / RAY_LIST_SHADING_GROUP, 0u, 1u), 0u);
}
