// One sampler of lights.glsl from the shading point push.vector.
#include "lights.glsl"
#include "test_records.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Push { SamplerPush push; };
layout(set = 2, binding = 0, scalar) writeonly buffer samples { SampleRecord sample_at[]; };

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= push.count) return;
    uvec4 bits = random4_bits(uvec2(i, 0u), push.family, push.seed);
    LightSample s = NO_LIGHT_SAMPLE;
    switch (push.family) {
    case DIM_SUN: s = sample_sun(bits); break;
    case DIM_POSITIONAL: s = sample_positional(push.vector, bits); break;
    case DIM_EMISSIVE: s = sample_emissive(push.vector, bits); break;
    case DIM_ENVIRONMENT: s = sample_environment(bits); break;
    }
    uint word = (s.delta ? 1u : 0u) | (s.finite ? 2u : 0u);
    float pdf_again = push.family == DIM_ENVIRONMENT ? environment_pdf(s.direction) : 0.0;
    sample_at[i] = SampleRecord(s.direction, s.pdf, s.radiance, pdf_again, s.target, word);
}
