// bsdf.glsl on given cases: value and density for wi, and one sample.
#include "bsdf_case.glsl"
#include "bsdf/shading_normal.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Push { HistogramPush push; };
layout(set = 2, binding = 1, scalar) writeonly buffer results { BsdfResult result_at[]; };

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= push.count) return;
    BsdfCase c = case_at[i];
    Bsdf b = test_bsdf(c);
    BsdfSample s = bsdf_sample(b, c.u);
    result_at[i] = BsdfResult(bsdf_eval(b, c.wi), bsdf_pdf(b, c.wi), s.direction, s.pdf, s.weight, s.flags,
                              bsdf_eval(b, s.direction), bsdf_pdf(b, s.direction),
                              bend_normal(c.coat_normal, c.face_normal, c.wo));
}
