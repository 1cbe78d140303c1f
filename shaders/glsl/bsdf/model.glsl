// Shared by the lobes of the reference's surface (bsdf.glsl): the surface at a point, the results of evaluation and sampling, and
// the flags. Each lobe has a file of its own (coat, interface, diffuse, sheen) and provides
//
//     BsdfValue NAME_evaluate(Bsdf b, ...)    its part of f |cos| and of the mixture's density: they add up to the whole. The
//                                             interface has two: interface_reflection, interface_transmission
//     BsdfSample NAME_sample(Bsdf b, ...)     a direction drawn from it. Of a delta lobe (SAMPLE_DELTA) weight and pdf are final; of the
//                                             others pdf is the probability of the lobe: the mixture's value is taken
//
// `l` and `v` are directions in the frame of the shading normal (+Z), `wi` and `wo` the same in world space.
#include "bsdf/ggx.glsl"

// Bits of Bsdf::flags: what a surface is.
const uint BSDF_SOLID = 1u;               // light is bent on its way through
const uint BSDF_ENERGY_COMPENSATION = 2u;

// Bits of BsdfSample::flags: how a sample was drawn.
const uint SAMPLE_DELTA = 1u;
const uint SAMPLE_TRANSMISSION = 2u;

// Below it a lobe is a delta: half as wide as the sun at 0.05.
const float MIRROR_ROUGHNESS = 0.02;

// Probabilities with which bsdf_sample takes the lobes.
struct LobeProbabilities { float coat, interface_, diffuse; };

struct LobeWeights {
    float coat;    // c Fc
    float base;    // what the coat leaves
    LobeProbabilities p;
};

struct Bsdf {
    mat3 frame;          // world from local: tangent, bitangent, shading normal on the side of wo
    vec3 face_normal;    // of the triangle, on the side of wo
    vec3 coat_normal;    // on the side of wo
    vec3 base_color;
    float metallic;
    vec2 alpha;          // GGX along tangent and bitangent; 0: a delta
    float eta;           // index of refraction behind the surface over that in front
    float specular;      // KHR_materials_specular
    vec3 specular_color;
    float transmission;
    float coat;
    float coat_alpha;    // 0: a delta
    vec3 sheen_color;
    float sheen_alpha;
    float iridescence;    // KHR_materials_iridescence: strength, index of refraction and thickness (nm) of the film
    float film_ior;
    float film_thickness;
    uint flags;          // BSDF_*
    // Made by bsdf_towards.
    vec3 wo;
    vec3 local_wo;       // in `frame`
    LobeWeights lobes;
};

struct BsdfValue {
    vec3 f_cos;
    float pdf;
};

struct BsdfSample {
    vec3 direction;
    vec3 weight;
    float pdf;
    uint flags; // SAMPLE_*
};

const BsdfSample NO_BSDF_SAMPLE = BsdfSample(vec3(0.0, 0.0, 1.0), vec3(0.0), 0.0, 0u);

// alpha of a perceptual roughness: its square, 0 for a delta.
float ggx_alpha(float roughness) { return roughness < MIRROR_ROUGHNESS ? 0.0 : roughness * roughness; }

// KHR_materials_anisotropy. Along a lobe's tangent the roughness grows with the strength.
vec2 ggx_alpha(float roughness, float anisotropy) {
    float alpha = ggx_alpha(roughness);
    return alpha == 0.0 ? vec2(0.0) : vec2(mix(alpha, 1.0, anisotropy * anisotropy), alpha);
}
