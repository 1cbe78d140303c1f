// interior.glsl along sequences of boundaries, one thread a path.
#include "interior.glsl"
#include "test_records.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Push { ListPush push; };
layout(set = 2, binding = 0, scalar) readonly buffer events { InteriorEvent event_at[]; };
layout(set = 2, binding = 1, scalar) writeonly buffer results { InteriorResult result_at[]; };

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= push.count) return;
    InteriorList list = EMPTY_INTERIOR;
    for (uint k = i * push.per_thread; k < (i + 1u) * push.per_thread; k++) {
        InteriorEvent e = event_at[k];
        Boundary b = Boundary(Solid(e.behind, e.behind_ior), Solid(e.front, e.front_ior));
        Crossing c = interior_crossing(list, b, e.entering != 0u);
        list = interior_cross(list, b, e.entering != 0u);
        result_at[k] = InteriorResult(c.here.word, c.beyond.word, c.here.ior, c.beyond.ior, interior_top(list).word,
                                      is_false_hit(c) ? 1u : 0u);
    }
}
