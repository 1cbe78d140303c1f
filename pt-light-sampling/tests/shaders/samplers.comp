// One sampler of sampling.glsl, with its density.
#include "sampling.glsl"
#include "bsdf/ggx.glsl"
#include "rng.glsl"
#include "test_records.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Push { SamplerPush push; };
layout(set = 2, binding = 0, scalar) writeonly buffer samples { SampleRecord sample_at[]; };

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= push.count) return;
    vec4 xi = random4(uvec2(i, 0u), 0u, push.seed);
    vec3 value = vec3(0.0);
    float pdf = 0.0;
    switch (push.family) {
    case 0u:
        value = vec3(sample_triangle(xi.xy), 0.0);
        pdf = 2.0;
        break;
    case 1u:
        value = vec3(sample_disk(xi.xy), 0.0);
        pdf = INV_PI;
        break;
    case 2u:
        value = sample_cone(xi.xy, push.parameter);
        pdf = cone_pdf(push.parameter);
        break;
    case 3u:
        value = sample_cosine_hemisphere(xi.xy);
        pdf = cosine_hemisphere_pdf(value.z);
        break;
    case 4u:
        value = reflect(-push.vector, sample_ggx_vndf(push.vector, push.parameter, xi.xy));
        pdf = ggx_reflection_pdf(push.vector, value, push.parameter);
        break;
    }
    sample_at[i] = SampleRecord(value, pdf, vec3(0.0), 0.0, vec3(0.0), 0u);
}
