// Fresnel term of a thin film on a base (KHR_materials_iridescence): Belcour and Barla 2017, "A Practical Extension to Microfacet Theory
// for the Modeling of Varying Iridescence". The light that is reflected m times inside of the film interferes with a phase that grows with
// its way; what the eye's three sensitivities make of all wavelengths is a sum of Gaussians in Fourier space (their section 4). Host twin:
// pt_reference::oracle::thin_film.
#include "bsdf/fresnel.glsl"
#include "math.glsl"

// Response of the sensitivities, as linear Rec. 709, to the optical path difference `way` (metres) at a phase shift for each channel.
vec3 film_response(float way, vec3 shift) {
    const mat3 rec709_from_xyz = mat3(3.2404542, -0.9692660, 0.0556434, -1.5371385, 1.8760108, -0.2040259, -0.4985314, 0.0415560, 1.0572252);
    float phase = 2.0 * PI * way;
    const vec3 value = vec3(5.4856e-13, 4.4201e-13, 5.2481e-13), position = vec3(1.6810e6, 1.7953e6, 2.2084e6);
    const vec3 variance = vec3(4.3278e9, 9.3046e9, 6.6121e9);
    vec3 xyz = value * sqrt(2.0 * PI * variance) * cos(position * phase + shift) * exp(-variance * square(phase));
    xyz.x += 9.7470e-14 * sqrt(2.0 * PI * 4.5282e9) * cos(2.2399e6 * phase + shift.x) * exp(-4.5282e9 * square(phase));
    return rec709_from_xyz * (xyz / 1.0685e-7);
}

// `f0`: of the base without the film, in air; `thickness`: nm.
vec3 thin_film_fresnel(vec3 f0, float film_ior, float thickness, float cos_theta) {
    // A film thinner than light is none.
    float ior = mix(1.0, film_ior, smoothstep(0.0, 30.0, thickness));
    float sin2_film = (1.0 - square(cos_theta)) / square(ior);
    if (sin2_film >= 1.0) return vec3(1.0);
    float cos_film = sqrt(1.0 - sin2_film);
    float outer = fresnel_dielectric(cos_theta, ior);
    float passed = square(1.0 - outer);
    // The base as seen from the film.
    vec3 root = sqrt(clamp(f0, 0.0, 0.9999));
    vec3 base_ior = (1.0 + root) / (1.0 - root);
    vec3 ratio = (base_ior - ior) / (base_ior + ior);
    vec3 inner = fresnel_schlick(ratio * ratio, 1.0, cos_film);
    // A reflection at a denser medium turns the phase by half a wave.
    vec3 shift = vec3(ior < 1.0 ? 0.0 : PI) + mix(vec3(0.0), vec3(PI), lessThan(base_ior, vec3(ior)));
    float way = 2.0 * ior * thickness * 1e-9 * cos_film;

    vec3 both = min(outer * inner, 0.9999), amplitude = sqrt(both);
    vec3 series = passed * inner / (1.0 - both);
    vec3 sum = outer + series;
    vec3 term = series - (1.0 - outer);
    for (int m = 1; m <= 2; m++) {
        term *= amplitude;
        sum += term * 2.0 * film_response(float(m) * way, float(m) * shift);
    }
    return clamp(sum, 0.0, 1.0);
}
