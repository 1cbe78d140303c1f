// The surface of the reference path tracer. glTF 2.0, appendix B.2, with KHR_materials_ior, _specular, _transmission, _volume
// (whether there is a solid behind), _clearcoat, _sheen, _anisotropy, _iridescence. Directions are unit vectors in world space that point away
// from the surface: wo to where light leaves, wi to where it comes from.
//
//     Bsdf bsdf_towards(Bsdf b, vec3 wo)     with what depends on wo alone; for all of these:
//     BsdfValue bsdf_evaluate(Bsdf b, vec3 wi) both of:
//     vec3 bsdf_eval(Bsdf b, vec3 wi)        f |cos|, all lobes that are no delta
//     float bsdf_pdf(Bsdf b, vec3 wi)        density per solid angle of wi with which bsdf_sample draws them
//     BsdfSample bsdf_sample(Bsdf b, vec4 u) direction, weight = f |cos| / pdf, pdf, flags
//     bool bsdf_is_delta(Bsdf b)             whether all lobes are: no use in sampling lights
//     bool bsdf_has_delta(Bsdf b)            whether any may be
//
// A sample with pdf == 0 is no sample: the path ends. SAMPLE_DELTA: eval and pdf know nothing of the direction, pdf is the
// probability of the lobe, other strategies never find it (their weight is 1). SAMPLE_TRANSMISSION: wi is on the other side.
// How to get a Bsdf from a hit: bsdf_surface.glsl. A kernel that includes this has the buffer "bsdf_tables" bound (bsdf/albedo.glsl). The
// lobes stand in bsdf/, here is their mixture. Host twin: pt_reference::oracle::bsdf.
//
// The model:
//   coated   = (1 - c Fc) sheened + c Fc GGX(coat)         c: clearcoat, Fc: Schlick(0.04) at the angle of wo to the coat's normal
//   sheened  = color Charlie + (1 - max(color) max(E(v), E(l))) base                    E: directional albedo of the sheen
//   base     = (1 - metallic) dielectric + metallic Schlick(base_color) GGX
//   dielectric = F GGX + (1 - max(F)) ((1 - transmission) base_color / pi + transmission base_color BTDF)
// F is taken at the half vector. It is Schlick's for opaque materials, as in appendix B, Fresnel's equations where light passes
// (transmission > 0). specularFactor 0 leaves a Lambertian. GGX is height-correlated in reflection, separable in transmission.
// A thin sheet (no BSDF_SOLID): BTDF is the GGX lobe on the other side, unbent. Roughness below MIRROR_ROUGHNESS: a delta.
//
// BSDF_ENERGY_COMPENSATION adds the light that leaves a rough surface after more than one microfacet (Kulla and Conty 2017) and
// puts (1 - E(v)) (1 - E(l)) / (1 - mean E), E of the specular lobe, in the place of 1 - max(F) for the diffuse base (Kelemen and
// Szirmay-Kalos 2001): metals and opaque dielectrics then lose and gain nothing. Without it rough metals lose up to 60 %, and
// smooth white dielectrics gain up to 80 % at grazing incidence, where F(half vector) is small for the base and large for the lobe.
// It is made for isotropic lobes and takes sqrt(alpha_x alpha_y); transmitted light is left alone.
//
// Reciprocal but for the coat, whose share depends on wo alone, as the extension has it, and for the 1 / eta^2 of refraction.
//
// Shading normals: a direction counts when it is on the same side of the triangle as of the shading normal, so that nothing leaks
// through. The shading normal is bent towards the viewer until the mirror direction is above the triangle (bsdf/shading_normal.glsl). What a
// lobe loses below the horizon of the triangle is lost: strongly bumped surfaces come out darker towards grazing angles.
//
// Lobes are drawn by their estimated reflectances; at the interface a microfacet is drawn first, then whether it reflects, by
// its own Fresnel term. All densities are those of the whole mixture.
#include "bsdf/coat.glsl"
#include "bsdf/compensation.glsl"
#include "bsdf/diffuse.glsl"
#include "bsdf/interface.glsl"
#include "bsdf/sheen.glsl"

// No lobe that reflects anything is drawn with less than this times its part.
const float LEAST_PROBABILITY = 0.05;

LobeWeights bsdf_lobes(Bsdf b) {
    vec3 v = b.local_wo;
    LobeWeights w;
    w.coat = b.coat > 0.0 ? b.coat * coat_fresnel(dot(b.coat_normal, b.wo)) : 0.0;
    w.base = 1.0 - w.coat;
    float sheen_albedo = has_sheen(b) ? charlie_albedo(v.z, b.sheen_alpha) : 0.0;
    float left = w.base * max(1.0 - max_component(b.sheen_color) * sheen_albedo, 0.0);
    InterfaceFresnel f = interface_fresnel(b, v.z);
    float passed = left * f.passed * luminance(b.base_color);
    float interface_ = left * luminance(f.reflected) + passed * b.transmission;
    float diffuse = passed * (1.0 - b.transmission) + w.base * luminance(b.sheen_color) * sheen_albedo;
    if ((b.flags & BSDF_ENERGY_COMPENSATION) != 0u && b.alpha.x > 0.0) {
        diffuse += left * luminance(compensation(b, v.z, v.z).scattered);
    }
    float least = LEAST_PROBABILITY * (w.coat + interface_ + diffuse);
    vec3 p = vec3(w.coat, interface_, diffuse);
    p = mix(max(p, vec3(least)), vec3(0.0), lessThanEqual(p, vec3(0.0)));
    p /= max(p.x + p.y + p.z, 1e-20);
    w.p = LobeProbabilities(p.x, p.y, p.z);
    return w;
}

Bsdf bsdf_towards(Bsdf b, vec3 wo) {
    b.wo = wo;
    b.local_wo = wo * b.frame;
    b.lobes = bsdf_lobes(b);
    return b;
}

// All lobes below the coat, for l on the side of the viewer.
BsdfValue bsdf_below_coat(Bsdf b, vec3 l) {
    vec3 h = normalize(b.local_wo + l);
    InterfaceFresnel f = interface_fresnel(b, dot(b.local_wo, h));
    BsdfValue r = interface_reflection(b, l, h, f);
    float passed = f.passed;
    if ((b.flags & BSDF_ENERGY_COMPENSATION) != 0u) {
        Compensation c = compensation(b, b.local_wo.z, l.z);
        r.f_cos += c.scattered * (l.z * INV_PI);
        passed = c.base;
    }
    BsdfValue diffuse = diffuse_evaluate(b, l, passed);
    r.f_cos += diffuse.f_cos;
    r.pdf += diffuse.pdf;
    r = sheen_evaluate(b, l, r);
    r.f_cos *= b.lobes.base;
    return r;
}

BsdfValue bsdf_evaluate(Bsdf b, vec3 wi) {
    BsdfValue r = BsdfValue(vec3(0.0), 0.0);
    if (b.local_wo.z <= 0.0) return r;
    vec3 l = wi * b.frame;
    if (dot(b.face_normal, wi) <= 0.0) {
        if (l.z < 0.0) r = interface_transmission(b, l);
        return r;
    }
    if (l.z > 0.0) r = bsdf_below_coat(b, l);
    BsdfValue coat = coat_evaluate(b, wi);
    r.f_cos += coat.f_cos;
    r.pdf += coat.pdf;
    return r;
}

// The part of bsdf_eval that is the diffuse base, without its colour base_color (1 - metallic) (1 - transmission) and without energy
// compensation.
float bsdf_diffuse_cos(Bsdf b, vec3 wi) {
    vec3 l = wi * b.frame;
    if (b.local_wo.z <= 0.0 || l.z <= 0.0 || dot(b.face_normal, wi) <= 0.0) return 0.0;
    float passed = interface_fresnel(b, dot(b.local_wo, normalize(b.local_wo + l))).passed / max(1.0 - b.metallic, 1e-6);
    return b.lobes.base * min(under_sheen(b, b.local_wo.z), under_sheen(b, l.z)) * passed * l.z * INV_PI;
}

vec3 bsdf_eval(Bsdf b, vec3 wi) { return bsdf_evaluate(b, wi).f_cos; }

float bsdf_pdf(Bsdf b, vec3 wi) { return bsdf_evaluate(b, wi).pdf; }

bool bsdf_is_delta(Bsdf b) {
    bool diffuse = b.metallic < 1.0 && b.transmission < 1.0 && max_component(b.base_color) > 0.0;
    bool rough_coat = b.coat > 0.0 && b.coat_alpha > 0.0;
    return b.alpha.x == 0.0 && !diffuse && !rough_coat && max_component(b.sheen_color) <= 0.0;
}

// Whether a lobe that reflects anything may be one.
bool bsdf_has_delta(Bsdf b) { return b.alpha.x == 0.0 || b.coat > 0.0 && b.coat_alpha == 0.0; }

// As bsdf_sample draws it, before the mixture is evaluated: of a lobe that is no delta weight and pdf are those of the lobe alone.
BsdfSample bsdf_draw(Bsdf b, vec4 u) {
    if (b.local_wo.z <= 0.0) return NO_BSDF_SAMPLE;
    LobeProbabilities p = b.lobes.p;
    BsdfSample s;
    if (u.z < p.coat) s = coat_sample(b, u.xy);
    else if (u.z < p.coat + p.interface_) s = interface_sample(b, u.xyw);
    else s = diffuse_sample(b, u.xy);
    if (s.pdf <= 0.0) return NO_BSDF_SAMPLE;
    s.direction = normalize(s.direction);
    if ((dot(b.face_normal, s.direction) > 0.0) == ((s.flags & SAMPLE_TRANSMISSION) != 0u)) return NO_BSDF_SAMPLE;
    return s;
}

// u.xy: direction within a lobe; u.z: which lobe; u.w: reflection or transmission.
BsdfSample bsdf_sample(Bsdf b, vec4 u) {
    BsdfSample s = bsdf_draw(b, u);
    if (s.pdf <= 0.0 || (s.flags & SAMPLE_DELTA) != 0u) return s;
    BsdfValue r = bsdf_evaluate(b, s.direction);
    if (r.pdf <= 0.0) return NO_BSDF_SAMPLE;
    s.pdf = r.pdf;
    s.weight = r.f_cos / r.pdf;
    return s;
}
