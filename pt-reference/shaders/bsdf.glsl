#include "sampling.glsl"
struct Bsdf { vec3 albedo; mat3 frame; vec3 wo; vec3 flat_normal; };
struct BsdfSample { vec3 direction; vec3 weight; float pdf; bool delta; };
bool bsdf_is_delta(Bsdf b) { return false; }
vec3 bsdf_eval(Bsdf b, vec3 wi) { return dot(b.flat_normal, wi) > 0.0 ? b.albedo * INV_PI * max(dot(b.frame[2], wi), 0.0) : vec3(0.0); }
float bsdf_pdf(Bsdf b, vec3 wi) { return cosine_hemisphere_pdf(dot(b.frame[2], wi)); }
BsdfSample bsdf_sample(Bsdf b, vec4 xi) {
    vec3 l = sample_cosine_hemisphere(xi.xy);
    vec3 d = b.frame * l;
    return BsdfSample(d, dot(d, b.flat_normal) > 0.0 ? b.albedo : vec3(0.0), cosine_hemisphere_pdf(l.z), false);
}
