// The surface of the reference path tracer. glTF 2.0, appendix B.2, with KHR_materials_ior, _specular, _transmission, _volume
// (whether there is a solid behind), _clearcoat, _sheen, _anisotropy. Directions are unit vectors in world space that point away
// from the surface: wo to where light leaves, wi to where it comes from.
//
//     Bsdf bsdf_towards(Bsdf b, vec3 wo)     with what depends on wo alone; for all of these:
//     vec3 bsdf_eval(Bsdf b, vec3 wi)        f |cos|, all lobes that are no delta
//     float bsdf_pdf(Bsdf b, vec3 wi)        density per solid angle of wi with which bsdf_sample draws them
//     BsdfSample bsdf_sample(Bsdf b, vec4 u) direction, weight = f |cos| / pdf, pdf, flags
//     bool bsdf_is_delta(Bsdf b)             whether all lobes are: no use in sampling lights
//
// A sample with pdf == 0 is no sample: the path ends. SAMPLE_DELTA: eval and pdf know nothing of the direction, pdf is the
// probability of the lobe, other strategies never find it (their weight is 1). SAMPLE_TRANSMISSION: wi is on the other side.
// How to get a Bsdf from a hit: bsdf_surface.glsl. A kernel that includes this has the buffer "bsdf_tables" bound (bsdf_layers.glsl). Host twin: pt_reference::oracle::bsdf.
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
// through. The shading normal is bent towards the viewer until the mirror direction is above the triangle (bend_normal). What a
// lobe loses below the horizon of the triangle is lost: strongly bumped surfaces come out darker towards grazing angles.
//
// Lobes are drawn by their estimated reflectances; at the interface a microfacet is drawn first, then whether it reflects, by
// its own Fresnel term. All densities are those of the whole mixture.
#include "bsdf_dielectric.glsl"
#include "bsdf_layers.glsl"
#include "sampling.glsl"

const uint BSDF_SOLID = 1u;               // light is bent on its way through
const uint BSDF_ENERGY_COMPENSATION = 2u;

const uint SAMPLE_DELTA = 1u;
const uint SAMPLE_TRANSMISSION = 2u;

// Below it a lobe is a delta: half as wide as the sun at 0.05.
const float MIRROR_ROUGHNESS = 0.02;

// Probabilities with which bsdf_sample takes the lobes.
struct LobeChoice { float coat, interface_, diffuse; };

struct LobeWeights {
    float coat;    // c Fc
    float base;    // what coat and sheen leave, as far as it depends on v alone
    LobeChoice p;
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
    uint flags;          // BSDF_SOLID, BSDF_ENERGY_COMPENSATION
    // Made by bsdf_towards.
    vec3 wo;
    vec3 local_wo;       // in `frame`
    LobeWeights lobes;
};

struct BsdfSample {
    vec3 direction;
    vec3 weight;
    float pdf;
    uint flags; // SAMPLE_DELTA, SAMPLE_TRANSMISSION
};

const BsdfSample NO_BSDF_SAMPLE = BsdfSample(vec3(0.0, 0.0, 1.0), vec3(0.0), 0.0, 0u);

// alpha of a perceptual roughness: its square, 0 for a delta.
float ggx_alpha(float roughness) { return roughness < MIRROR_ROUGHNESS ? 0.0 : roughness * roughness; }

// KHR_materials_anisotropy. Along a lobe's tangent the roughness grows with the strength.
vec2 ggx_alpha(float roughness, float anisotropy) {
    float alpha = ggx_alpha(roughness);
    return alpha == 0.0 ? vec2(0.0) : vec2(mix(alpha, 1.0, anisotropy * anisotropy), alpha);
}

// The shading normal `n`, bent as little as needed for wo to be reflected above the triangle: Keller et al. 2017, "The Iray Light
// Transport Simulation and Rendering System", app. A.3.
vec3 bend_normal(vec3 n, vec3 face_normal, vec3 wo) {
    const float ABOVE = 1e-3;
    if (dot(n, face_normal) <= 0.0) n = face_normal;
    vec3 mirrored = reflect(-wo, n);
    float height = dot(mirrored, face_normal);
    if (height >= ABOVE && dot(n, wo) > 0.0) return n;
    vec3 lifted = mirrored + face_normal * (ABOVE - height);
    vec3 h = wo + normalize(lifted);
    // Both at the horizon and opposite: the triangle's own normal.
    return dot(h, h) > 1e-6 && dot(h, wo) > 0.0 ? normalize(h) : face_normal;
}

// Fresnel term of the dielectric at a microfacet.
vec3 bsdf_dielectric_fresnel(Bsdf b, float cos_theta) {
    if (b.transmission > 0.0) {
        float f = fresnel_dielectric(cos_theta, b.eta);
        // Total reflection is total whatever the specular factor.
        return f >= 1.0 ? vec3(1.0) : tint_specular(f, b.eta, b.specular, b.specular_color);
    }
    float f0 = square((b.eta - 1.0) / (b.eta + 1.0));
    return fresnel_schlick(min(f0 * b.specular_color, vec3(1.0)) * b.specular, b.specular, cos_theta);
}

// Of what a microfacet gets: the parts that are reflected (rgb) and that pass the interface.
struct InterfaceShare { vec3 reflected; float passed; };

InterfaceShare bsdf_interface(Bsdf b, float cos_theta) {
    vec3 f = bsdf_dielectric_fresnel(b, cos_theta);
    return InterfaceShare(mix(f, fresnel_schlick(b.base_color, 1.0, cos_theta), b.metallic),
                          (1.0 - b.metallic) * (1.0 - max_component(f)));
}

bool bsdf_transmits(Bsdf b) { return b.transmission > 0.0 && b.metallic < 1.0; }
bool bsdf_bends(Bsdf b) { return (b.flags & BSDF_SOLID) != 0u && !is_index_matched(b.eta); }

// Whether transmitted light goes one way.
bool bsdf_transmits_delta(Bsdf b) { return b.alpha.x == 0.0 || (b.flags & BSDF_SOLID) != 0u && !bsdf_bends(b); }

// Light that meets more than one microfacet, and the weight of the diffuse base, with energy compensation.
struct Compensation {
    vec3 scattered;   // albedo of the multiple scattering lobe
    float base;       // what the diffuse base gets
};

// Both are factors of (v) and (l): F_ms (1 - E(v)) (1 - E(l)) / (1 - mean E) and the like.
Compensation bsdf_compensation(Bsdf b, float v_z, float l_z) {
    float alpha = sqrt(b.alpha.x * b.alpha.y);
    vec2 mean = ggx_mean_albedo(alpha), towards_v = ggx_albedo(v_z, alpha), towards_l = ggx_albedo(l_z, alpha);
    float whole = mean.x + mean.y;
    vec3 f0 = bsdf_dielectric_fresnel(b, 1.0);
    vec3 f0_mixed = mix(f0, b.base_color, b.metallic);
    float f90_mixed = mix(b.specular, 1.0, b.metallic);
    float lost_v = 1.0 - towards_v.x - towards_v.y, lost_l = 1.0 - towards_l.x - towards_l.y;
    Compensation c;
    c.scattered = multiple_scattering_fresnel(f0_mixed, f90_mixed, whole) * (lost_v * lost_l / max(1.0 - whole, 1e-6));
    // The dielectric's own lobe, with what it scatters.
    float f = max_component(f0);
    float again = multiple_scattering_fresnel(vec3(f), b.specular, whole).x;
    float e_v = f * towards_v.x + b.specular * towards_v.y + again * lost_v;
    float e_l = f * towards_l.x + b.specular * towards_l.y + again * lost_l;
    float e_mean = f * mean.x + b.specular * mean.y + again * (1.0 - whole);
    c.base = (1.0 - b.metallic) * (1.0 - e_v) * (1.0 - e_l) / max(1.0 - e_mean, 1e-6);
    return c;
}

LobeWeights bsdf_lobes(Bsdf b) {
    vec3 v = b.local_wo;
    const float LEAST = 0.05;
    LobeWeights w;
    w.coat = b.coat > 0.0 ? b.coat * coat_fresnel(dot(b.coat_normal, b.wo)) : 0.0;
    w.base = 1.0 - w.coat;
    float sheen = max_component(b.sheen_color), left = w.base, sheen_albedo = 0.0;
    if (sheen > 0.0) {
        sheen_albedo = charlie_albedo(v.z, b.sheen_alpha);
        left *= max(1.0 - sheen * sheen_albedo, 0.0);
    }
    InterfaceShare share = bsdf_interface(b, v.z);
    float passed = left * share.passed * luminance(b.base_color);
    float interface_ = left * luminance(share.reflected) + passed * b.transmission;
    float diffuse = passed * (1.0 - b.transmission) + w.base * luminance(b.sheen_color) * sheen_albedo;
    if ((b.flags & BSDF_ENERGY_COMPENSATION) != 0u && b.alpha.x > 0.0) {
        Compensation c = bsdf_compensation(b, v.z, v.z);
        diffuse += left * luminance(c.scattered);
    }
    float least = LEAST * (w.coat + interface_ + diffuse);
    vec3 p = vec3(w.coat, interface_, diffuse);
    p = mix(max(p, vec3(least)), vec3(0.0), lessThanEqual(p, vec3(0.0)));
    p /= max(p.x + p.y + p.z, 1e-20);
    w.p = LobeChoice(p.x, p.y, p.z);
    return w;
}

Bsdf bsdf_towards(Bsdf b, vec3 wo) {
    b.wo = wo;
    b.local_wo = wo * b.frame;
    b.lobes = bsdf_lobes(b);
    return b;
}

// Probability that a microfacet of the interface which has been drawn reflects.
float bsdf_reflect_probability(Bsdf b, InterfaceShare share) {
    float transmitted = share.passed * b.transmission * luminance(b.base_color);
    float reflected = luminance(share.reflected);
    return transmitted > 0.0 ? reflected / (reflected + transmitted) : 1.0;
}

struct BsdfValue {
    vec3 f_cos;
    float pdf;
};

// Without it nothing but the diffuse base is under coat and sheen.
bool bsdf_has_interface(Bsdf b) { return b.specular > 0.0 || b.metallic > 0.0 || b.transmission > 0.0; }

BsdfValue bsdf_reflection(Bsdf b, vec3 l) {
    LobeWeights w = b.lobes;
    vec3 v = b.local_wo;
    BsdfValue r = BsdfValue(vec3(0.0), w.p.diffuse * cosine_hemisphere_pdf(l.z));
    vec3 h = normalize(v + l);
    InterfaceShare share = bsdf_interface(b, dot(v, h));
    if (b.alpha.x > 0.0 && bsdf_has_interface(b)) {
        float d = ggx_d(b.alpha, h);
        r.f_cos = share.reflected * (d * ggx_visibility(b.alpha, v, l) * l.z);
        r.pdf += w.p.interface_ * bsdf_reflect_probability(b, share) * 0.5 * d / (v.z + ggx_root(b.alpha, v));
    }
    float diffuse = share.passed;
    if ((b.flags & BSDF_ENERGY_COMPENSATION) != 0u) {
        Compensation c = bsdf_compensation(b, v.z, l.z);
        r.f_cos += c.scattered * (l.z * INV_PI);
        diffuse = c.base;
    }
    r.f_cos += b.base_color * (diffuse * (1.0 - b.transmission) * l.z * INV_PI);
    float sheen = max_component(b.sheen_color);
    if (sheen > 0.0) {
        r.f_cos *= max(1.0 - sheen * max(charlie_albedo(v.z, b.sheen_alpha), charlie_albedo(l.z, b.sheen_alpha)), 0.0);
        r.f_cos += b.sheen_color * charlie(v, l, b.sheen_alpha);
    }
    r.f_cos *= w.base;
    return r;
}

BsdfValue bsdf_transmission(Bsdf b, vec3 l) {
    LobeWeights w = b.lobes;
    vec3 v = b.local_wo;
    BsdfValue r = BsdfValue(vec3(0.0), 0.0);
    if (!bsdf_transmits(b) || bsdf_transmits_delta(b)) return r;
    Refraction t;
    if ((b.flags & BSDF_SOLID) != 0u) {
        t = refraction(v, l, b.alpha, b.eta);
    } else {
        vec3 mirrored = through_thin(l);
        t.h = normalize(v + mirrored);
        t.density = ggx_reflection_pdf(v, mirrored, b.alpha);
        t.value = ggx_d(b.alpha, t.h) * ggx_visibility(b.alpha, v, mirrored) * mirrored.z;
    }
    if (t.density <= 0.0) return r;
    InterfaceShare share = bsdf_interface(b, dot(v, t.h));
    r.f_cos = b.base_color * (share.passed * b.transmission * t.value * w.base);
    float sheen = max_component(b.sheen_color);
    if (sheen > 0.0) r.f_cos *= max(1.0 - sheen * charlie_albedo(v.z, b.sheen_alpha), 0.0);
    r.pdf = w.p.interface_ * (1.0 - bsdf_reflect_probability(b, share)) * t.density;
    return r;
}

BsdfValue bsdf_evaluate(Bsdf b, vec3 wi) {
    BsdfValue r = BsdfValue(vec3(0.0), 0.0);
    if (b.local_wo.z <= 0.0) return r;
    vec3 l = wi * b.frame;
    LobeWeights w = b.lobes;
    if (dot(b.face_normal, wi) <= 0.0) {
        if (l.z < 0.0) r = bsdf_transmission(b, l);
        return r;
    }
    if (l.z > 0.0) r = bsdf_reflection(b, l);
    if (w.coat > 0.0 && b.coat_alpha > 0.0) {
        mat3 coat_frame = basis_around(b.coat_normal);
        vec3 coat_v = b.wo * coat_frame, coat_l = wi * coat_frame;
        if (coat_v.z > 0.0 && coat_l.z > 0.0) {
            vec2 alpha = vec2(b.coat_alpha);
            float d = ggx_d(alpha, normalize(coat_v + coat_l));
            r.f_cos += vec3(w.coat * d * ggx_visibility(alpha, coat_v, coat_l) * coat_l.z);
            r.pdf += w.p.coat * 0.5 * d / (coat_v.z + ggx_root(alpha, coat_v));
        }
    }
    return r;
}

vec3 bsdf_eval(Bsdf b, vec3 wi) { return bsdf_evaluate(b, wi).f_cos; }

float bsdf_pdf(Bsdf b, vec3 wi) { return bsdf_evaluate(b, wi).pdf; }

bool bsdf_is_delta(Bsdf b) {
    bool diffuse = b.metallic < 1.0 && b.transmission < 1.0 && max_component(b.base_color) > 0.0;
    bool rough_coat = b.coat > 0.0 && b.coat_alpha > 0.0;
    return b.alpha.x == 0.0 && !diffuse && !rough_coat && max_component(b.sheen_color) <= 0.0;
}

// u.xy: direction within a lobe; u.z: which lobe; u.w: reflection or transmission.
BsdfSample bsdf_sample(Bsdf b, vec4 u) {
    BsdfSample s = NO_BSDF_SAMPLE;
    vec3 v = b.local_wo;
    if (v.z <= 0.0) return s;
    LobeWeights w = b.lobes;
    float sheen = max_component(b.sheen_color);
    float base = w.base * (sheen > 0.0 ? max(1.0 - sheen * charlie_albedo(v.z, b.sheen_alpha), 0.0) : 1.0);

    bool delta = false;
    float pmf = 0.0;
    vec3 reflectance = vec3(0.0);
    if (u.z < w.p.coat) {
        mat3 coat_frame = basis_around(b.coat_normal);
        vec3 coat_v = b.wo * coat_frame;
        delta = b.coat_alpha == 0.0;
        vec3 h = delta ? vec3(0.0, 0.0, 1.0) : sample_ggx_vndf(coat_v, b.coat_alpha, u.xy);
        vec3 coat_l = reflect(-coat_v, h);
        if (coat_l.z <= 0.0) return NO_BSDF_SAMPLE;
        s.direction = coat_frame * coat_l;
        pmf = w.p.coat;
        reflectance = vec3(w.coat);
    } else if (u.z < w.p.coat + w.p.interface_) {
        delta = b.alpha.x == 0.0;
        vec3 h = delta ? vec3(0.0, 0.0, 1.0) : sample_ggx_vndf(v, b.alpha, u.xy);
        InterfaceShare share = bsdf_interface(b, dot(v, h));
        float p = bsdf_reflect_probability(b, share);
        vec3 l = reflect(-v, h);
        if (u.w < p) {
            pmf = w.p.interface_ * p;
            reflectance = base * share.reflected;
        } else {
            s.flags = SAMPLE_TRANSMISSION;
            delta = bsdf_transmits_delta(b);
            if (bsdf_bends(b)) l = refract(-v, h, 1.0 / b.eta);
            else if (delta) l = -v;
            else l = through_thin(l);
            pmf = w.p.interface_ * (1.0 - p);
            reflectance = base * share.passed * b.transmission * b.base_color;
            if (bsdf_bends(b)) reflectance /= square(b.eta);
        }
        s.direction = b.frame * l;
        // On the side of the shading normal that the lobe belongs to.
        if ((l.z < 0.0) != (s.flags == SAMPLE_TRANSMISSION)) return NO_BSDF_SAMPLE;
    } else {
        s.direction = b.frame * sample_cosine_hemisphere(u.xy);
    }
    s.direction = normalize(s.direction);
    if ((dot(b.face_normal, s.direction) > 0.0) == ((s.flags & SAMPLE_TRANSMISSION) != 0u)) return NO_BSDF_SAMPLE;
    if (delta) {
        s.flags |= SAMPLE_DELTA;
        s.pdf = pmf;
        s.weight = reflectance / pmf;
        return s;
    }
    BsdfValue r = bsdf_evaluate(b, s.direction);
    if (r.pdf <= 0.0) return NO_BSDF_SAMPLE;
    s.pdf = r.pdf;
    s.weight = r.f_cos / r.pdf;
    return s;
}
