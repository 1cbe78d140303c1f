// brdf.glsl on given cases: value and density for l, and one sample with its density.
#include "brdf.glsl"
#include "test_records.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Push { SamplerPush push; };
layout(set = 2, binding = 0, scalar) readonly buffer cases { BrdfCase case_at[]; };
layout(set = 2, binding = 1, scalar) writeonly buffer samples { SampleRecord sample_at[]; };

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= push.count) return;
    BrdfCase c = case_at[i];
    Brdf b = make_brdf(c.base.rgb, c.metallic, c.roughness, c.f0, c.base.a, c.mixed != 0u);
    BrdfValue f = brdf_eval(b, c.v, c.l);
    vec3 l = brdf_sample(b, c.v, c.xi);
    sample_at[i] = SampleRecord(l, brdf_pdf(b, c.v, l), f.diffuse, brdf_pdf(b, c.v, c.l), f.specular, 0u);
}
