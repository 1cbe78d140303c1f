// Turns demodulated light into radiance. Extent: split frame.
//   color = ((hf + lf) * albedo + spec * max(0.01, F0)) * throughput, then the transparent layer "over" it.
// lf, with INDIRECT alone: irradiance / pi of the low-frequency light at the pixel's normal. Its specular reflection is added to spec where the surface is rough
// enough, if a knob asks for it.
// Where there is no surface only the transparent layer counts. A pixel of a transparent background, where the camera ray itself meets no
// surface, is 0 in all channels: no flag in alpha says that it is empty.
#include "channels.glsl"
#include "composite_push.glsl"
#include "constants.glsl"
#include "gbuffer_format.glsl"
#include "history_code.glsl"
#include "reflectance.glsl"
#ifdef INDIRECT
#include "bsdf/ggx.glsl"
#include "math.glsl"
#include "pack.glsl"
#include "sh.glsl"
#endif

layout(local_size_x = 16, local_size_y = 16) in;
layout(set = 2, binding = 0) uniform sampler2D light_hf;
layout(set = 2, binding = 1) uniform sampler2D light_spec;
#ifdef INDIRECT
layout(set = 2, binding = 2) uniform sampler2D light_lf_sh;
layout(set = 2, binding = 3) uniform sampler2D light_lf_cocg;
#endif
layout(push_constant, scalar) uniform Push { CompositePush push; };

// A history that nothing filters may hold roots.
vec3 light_at(vec4 stored) { return push.roots != 0u ? decoded_light(stored).rgb : stored.rgb; }

#ifdef INDIRECT
ShLight low_frequency_at(ivec2 p) {
    vec4 luma = texelFetch(light_lf_sh, p, 0), chroma = texelFetch(light_lf_cocg, p, 0);
    return push.roots_lf != 0u ? ShLight(signed_squares(luma), signed_squares(chroma).xy) : ShLight(luma, chroma.xy);
}
#endif

vec3 low_frequency(ivec2 p) {
#ifdef INDIRECT
    ShLight light = low_frequency_at(p);
    return sh_irradiance(light, unpack_unit_vector(imageLoad(ch_normal, p).x)) * (INV_PI * push.scale_lf);
#else
    return vec3(0.0);
#endif
}

// Specular reflection over F0 of the light that the spherical harmonics hold, as if it came from one direction. l = 1 over l = 0 says which, and how sharply: light from
// all sides has a ratio of 0, where the mirror direction and a lobe as wide as that of roughness 1 stand for it; uniform light of radiance L then gives L at normal
// incidence.
vec3 reflected_low_frequency(ivec2 p) {
#ifdef INDIRECT
    float roughness = imageLoad(ch_metallic_roughness, p).y;
    if (push.fake_specular > 1.0 || roughness < push.fake_specular) return vec3(0.0);
    ShLight indirect = low_frequency_at(p);
    vec4 luma = indirect.luma;
    if (!(luma.w > 0.0)) return vec3(0.0);
    vec3 n = unpack_unit_vector(imageLoad(ch_normal, p).x), d = unpack_unit_vector(imageLoad(ch_view_direction, p).x);
    vec3 directed = luma.xyz * (SH_Y0 / (SH_Y1 * luma.w));
    float sharpness = min(length(directed), 1.0);
    vec3 l = normalize(mix(reflect(d, n), directed / max(length(directed), 1e-6), sharpness));
    float alpha = square(max(mix(1.0, roughness, sharpness), 0.01));
    float n_l = dot(n, l), n_v = -dot(n, d);
    if (!(n_l > 0.0) || !(n_v > 0.0)) return vec3(0.0);
    // Isotropic: the z axis is the normal, and x and y need only have the right lengths.
    vec3 v = vec3(sqrt(max(1.0 - n_v * n_v, 0.0)), 0.0, n_v), to_light = vec3(sqrt(max(1.0 - n_l * n_l, 0.0)), 0.0, n_l);
    vec3 h = normalize(l - d);
    float n_h = clamp(dot(n, h), 0.0, 1.0);
    vec3 half_vector = vec3(sqrt(1.0 - n_h * n_h), 0.0, n_h);
    float whole = luma.w / SH_Y0;
    vec3 light = max(rgb_from_ycocg(vec3(whole, indirect.chroma)), vec3(0.0));
    return light * (ggx_d(alpha, half_vector) * ggx_visibility(vec2(alpha), v, to_light) * n_l);
#else
    return vec3(0.0);
#endif
}

void main() {
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(p, imageSize(ch_color)))) return;

    vec3 color = vec3(0.0);
    uint flags = imageLoad(ch_view_direction, p).y;
    // The word is an integer in a float image: small indices are denormal numbers and must not meet arithmetic.
    bool surface = floatBitsToUint(imageLoad(ch_shading_position, p).w) != 0u;
    if (push.transparent_background != 0u && !surface && flags == FLAG_PRIMARY) {
        imageStore(ch_color, p, vec4(0.0));
        return;
    }
    if (surface) {
        vec4 base = base_color_of(imageLoad(ch_base_color, p));
        float metallic = imageLoad(ch_metallic_roughness, p).x;
        vec3 albedo = push.use_albedo != 0u ? vec3(push.albedo) : diffuse_albedo(base.rgb, metallic);
        vec3 diffuse = (light_at(texelFetch(light_hf, p, 0)) * push.scale_hf + low_frequency(p)) * albedo;
        vec3 reflected = light_at(texelFetch(light_spec, p, 0)) + reflected_low_frequency(p);
        vec3 specular = reflected * demodulation(base, metallic) * push.scale_spec;
        color = (diffuse + specular) * imageLoad(ch_throughput, p).rgb;
    }
    vec4 overlay = imageLoad(ch_transparent, p);
    color = color * (1.0 - overlay.a) + overlay.rgb * push.scale_overlay;
    imageStore(ch_color, p, vec4(color, float(flags)));
}
