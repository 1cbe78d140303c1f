// Counts the picks from an alias table of push.family entries.
#include "lights.glsl"
#include "test_records.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Push { SamplerPush push; };
layout(set = 2, binding = 0, scalar) buffer counts { uint count_at[]; };

void main() {
    if (gl_GlobalInvocationID.x >= push.count) return;
    uvec4 bits = random4_bits(uvec2(gl_GlobalInvocationID.x, 0u), 0u, push.seed);
    atomicAdd(count_at[alias_pick(scene.emissive_alias, push.family, bits.x, unit_from_bits(bits).y)], 1u);
}
