// sampler.glsl at given places.
#include "sampler.glsl"
#include "test_records.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Push { ListPush push; };
layout(set = 2, binding = 0, scalar) readonly buffer cases { SamplerCase case_at[]; };
layout(set = 2, binding = 1, scalar) writeonly buffer results { uvec4 result_at[]; };

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= push.count) return;
    SamplerCase c = case_at[i];
    Sampler s = make_sampler(c.kind, uvec2(c.x, c.y), c.index, c.seed, c.log2_spp);
    s.dimension = c.dimension;
    result_at[i] = sample_bits(s);
}
