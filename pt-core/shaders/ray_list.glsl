// A list of rays in, a list of hits out.
#include "trace.glsl"
#include "ray_list_push.glsl"
#include "trace/refill.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer RayTable { Ray at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer HitTable { Hit at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer TakenCount { uint count; };
layout(push_constant, scalar) uniform Push { RayListPush push; };

uint entry_count() { return push.count; }
uint entry_at(uint place) { return place; }
uint take_entries(uint count) { return atomicAdd(TakenCount(push.taken).count, count); }

EntryRay load_entry(uint index) {
    return EntryRay(RayTable(push.rays).at[index], push.mask, white_coverage(coverage_seed(uvec2(index, 0u), 0u, push.seed)));
}

void trace_list(const bool any_hit) {
    uvec2 id = launch_id();
    if (id.x < push.width) trace_listed(id.y * push.width + id.x, any_hit);
}
