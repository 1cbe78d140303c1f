// Lobe: the interface of a dielectric or a metal, which reflects part of the light at its microfacets and, where it is transmissive,
// refracts the rest.
#include "bsdf/fresnel.glsl"
#include "bsdf/model.glsl"
#include "bsdf/refraction.glsl"
#include "bsdf/sheen.glsl"
#include "bsdf/thin_film.glsl"

// Fresnel term of the dielectric at a microfacet.
vec3 dielectric_fresnel(Bsdf b, float cos_theta) {
    if (b.transmission > 0.0) {
        float f = fresnel_dielectric(cos_theta, b.eta);
        // Total reflection is total whatever the specular factor.
        return f >= 1.0 ? vec3(1.0) : tint_specular(f, b.eta, b.specular, b.specular_color);
    }
    float f0 = square((b.eta - 1.0) / (b.eta + 1.0));
    return fresnel_schlick(min(f0 * b.specular_color, vec3(1.0)) * b.specular, b.specular, cos_theta);
}

// Of what a microfacet gets: the parts that are reflected (rgb) and that pass the interface.
struct InterfaceFresnel { vec3 reflected; float passed; };

InterfaceFresnel interface_fresnel(Bsdf b, float cos_theta) {
    vec3 f = dielectric_fresnel(b, cos_theta), metal = fresnel_schlick(b.base_color, 1.0, cos_theta);
    if (b.iridescence > 0.0) {
        // Under total reflection there is no light in the base.
        if (min(f.x, min(f.y, f.z)) < 1.0) {
            // From inside it reflects as much as from outside at the angle that the light is bent to.
            float outside = cos_theta;
            if (b.transmission > 0.0 && b.eta < 1.0) outside = sqrt(max(1.0 - (1.0 - square(cos_theta)) / square(b.eta), 0.0));
            vec3 film = thin_film_fresnel(dielectric_fresnel(b, 1.0), b.film_ior, b.film_thickness, outside);
            f = mix(f, film, b.iridescence);
        }
        metal = mix(metal, thin_film_fresnel(b.base_color, b.film_ior, b.film_thickness, cos_theta), b.iridescence);
    }
    return InterfaceFresnel(mix(f, metal, b.metallic), (1.0 - b.metallic) * (1.0 - max_component(f)));
}

// Without it nothing but the diffuse base is under coat and sheen.
bool has_interface(Bsdf b) { return b.specular > 0.0 || b.iridescence > 0.0 || b.metallic > 0.0 || b.transmission > 0.0; }

bool interface_transmits(Bsdf b) { return b.transmission > 0.0 && b.metallic < 1.0; }
bool interface_bends(Bsdf b) { return (b.flags & BSDF_SOLID) != 0u && !is_index_matched(b.eta); }

// Whether transmitted light goes one way.
bool interface_transmits_delta(Bsdf b) { return b.alpha.x == 0.0 || (b.flags & BSDF_SOLID) != 0u && !interface_bends(b); }

// Whether transmitted light goes on in its own direction: through a smooth thin sheet, or from one medium into another of the same index.
bool interface_transmits_straight(Bsdf b) { return interface_transmits(b) && interface_transmits_delta(b) && !interface_bends(b); }

// Part of the light that goes straight on through the interface, for the viewer's direction.
vec3 interface_straight(Bsdf b) {
    if (!interface_transmits_straight(b) || b.local_wo.z <= 0.0) return vec3(0.0);
    InterfaceFresnel f = interface_fresnel(b, b.local_wo.z);
    return b.base_color * (b.lobes.base * under_sheen(b, b.local_wo.z) * f.passed * b.transmission);
}

// Probability that a microfacet which has been drawn reflects.
float reflect_probability(Bsdf b, InterfaceFresnel f) {
    float transmitted = f.passed * b.transmission * luminance(b.base_color);
    float reflected = luminance(f.reflected);
    return transmitted > 0.0 ? reflected / (reflected + transmitted) : 1.0;
}

// `h`: half vector of l and the viewer, `f`: Fresnel terms there.
BsdfValue interface_reflection(Bsdf b, vec3 l, vec3 h, InterfaceFresnel f) {
    BsdfValue r = BsdfValue(vec3(0.0), 0.0);
    if (b.alpha.x <= 0.0 || !has_interface(b)) return r;
    vec3 v = b.local_wo;
    float d = ggx_d(b.alpha, h);
    r.f_cos = f.reflected * (d * ggx_visibility(b.alpha, v, l) * l.z);
    r.pdf = ggx_reflection_pdf(b.lobes.p.interface_ * reflect_probability(b, f) * d, v, b.alpha);
    return r;
}

// `l` is on the other side.
BsdfValue interface_transmission(Bsdf b, vec3 l) {
    vec3 v = b.local_wo;
    BsdfValue r = BsdfValue(vec3(0.0), 0.0);
    if (!interface_transmits(b) || interface_transmits_delta(b)) return r;
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
    InterfaceFresnel f = interface_fresnel(b, dot(v, t.h));
    r.f_cos = b.base_color * (f.passed * b.transmission * t.value * b.lobes.base) * under_sheen(b, v.z);
    r.pdf = b.lobes.p.interface_ * (1.0 - reflect_probability(b, f)) * t.density;
    return r;
}

// u.xy: microfacet; u.z: reflection or transmission.
BsdfSample interface_sample(Bsdf b, vec3 u) {
    vec3 v = b.local_wo;
    float base = b.lobes.base * under_sheen(b, v.z);
    bool delta = b.alpha.x == 0.0;
    vec3 h = delta ? vec3(0.0, 0.0, 1.0) : sample_ggx_vndf(v, b.alpha, u.xy);
    InterfaceFresnel f = interface_fresnel(b, dot(v, h));
    float p = reflect_probability(b, f);
    float pmf;
    vec3 reflectance, l = reflect(-v, h);
    bool transmitted = u.z >= p;
    if (transmitted) {
        delta = interface_transmits_delta(b);
        bool bends = interface_bends(b);
        if (bends) l = refract(-v, h, 1.0 / b.eta);
        else if (delta) l = -v;
        else l = through_thin(l);
        pmf = b.lobes.p.interface_ * (1.0 - p);
        reflectance = base * f.passed * b.transmission * b.base_color;
        if (bends) reflectance /= square(b.eta);
    } else {
        pmf = b.lobes.p.interface_ * p;
        reflectance = base * f.reflected;
    }
    // On the side of the shading normal that the lobe belongs to.
    if ((l.z < 0.0) != transmitted) return NO_BSDF_SAMPLE;
    return BsdfSample(b.frame * l, reflectance / pmf, pmf, (delta ? SAMPLE_DELTA : 0u) | (transmitted ? SAMPLE_TRANSMISSION : 0u));
}
