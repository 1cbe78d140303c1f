// Counts shadow rays of push.seed clusters and lights in any order, or (family 1) says what is known of each of them.
#include "lights/statistics.glsl"
#include "test_records.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Push { SamplerPush push; };
layout(set = 2, binding = 0, scalar) writeonly buffer samples { SampleRecord sample_at[]; };

// Host twin: `Pair`.
const uint LIGHTS = 61u;
vec3 side_normal(uint pair) {
    vec3 n = vec3(0.0);
    n[pair % 3u] = (pair / 3u) % 2u == 0u ? 1.0 : -1.0;
    return n;
}

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= push.count) return;
    uint pair = push.family == 1u ? i : pcg(i) % push.seed;
    uint cluster = pair / LIGHTS, light = pair % LIGHTS;
    vec3 n = side_normal(pair);
    if (push.family == 1u) {
        uint slot = shadow_slot(scene.light_tables.shadow_keys, shadow_key(cluster, light, n));
        uvec2 counts = slot == NONE ? uvec2(0u) : ShadowCountTable(scene.shadow_counts).at[slot];
        sample_at[i] = SampleRecord(vec3(counts, 0.0), lit_share(cluster, light, n), vec3(0.0), 0.0, vec3(0.0), slot);
        return;
    }
    // With a parameter above 0 the even ones are left out.
    if (push.parameter > 0.0 && pair % 2u == 0u) return;
    count_shadow_ray(cluster, light, n, i % 4u == 0u);
}
