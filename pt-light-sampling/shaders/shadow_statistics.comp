// Adds the shadow rays that have been counted since the last time to the history and begins new counts. Extent: one thread an entry.
#include "lights/statistics.glsl"
#include "local_lights_records.glsl"

layout(local_size_x = 64) in;

layout(buffer_reference, scalar, buffer_reference_align = 4) buffer HistoryTable { uint at[]; };
layout(push_constant, scalar) uniform Push { ShadowStatisticsPush push; };

// Half floats end at 65504.
const float MAX_COUNT = 6e4;

void main() {
    uint i = gl_GlobalInvocationID.y * push.width + gl_GlobalInvocationID.x;
    if (gl_GlobalInvocationID.x >= push.width || i >= push.count) return;
    uint slot = push.first + i;
    ShadowCountTable counts = ShadowCountTable(scene.shadow_counts);
    HistoryTable history = HistoryTable(scene.light_tables.shadow_history);
    uvec2 counted = counts.at[slot];
    uint before = history.at[shadow_word(slot)];
    if (counted == uvec2(0u) && before == 0u) return;
    vec2 sum = min(unpackHalf2x16(before) * push.keep + vec2(counted), vec2(MAX_COUNT));
    // What no ray has asked for in a long time is forgotten, so that a hash table has room for others.
    if (sum.x + sum.y < 0.05) {
        sum = vec2(0.0);
        if (scene.shadow_counts_hashed != 0u) ShadowKeyTable(scene.light_tables.shadow_keys).at[shadow_word(slot)] = 0u;
    }
    history.at[shadow_word(slot)] = packHalf2x16(sum);
    counts.at[slot] = uvec2(0u);
}
