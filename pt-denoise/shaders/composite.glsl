// Turns demodulated light into radiance. Extent: split frame.
//   color = ((hf + lf) * albedo + spec * max(0.01, F0)) * throughput, then the transparent layer "over" it.
// lf, with INDIRECT alone: irradiance / pi of the low-frequency light at the pixel's normal.
// Where there is no surface only the transparent layer counts. A pixel of a transparent background, where the camera ray itself meets no
// surface, is 0 in all channels: no flag in alpha says that it is empty.
#include "channels.glsl"
#include "composite_push.glsl"
#include "constants.glsl"
#include "reflectance.glsl"
#ifdef INDIRECT
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

vec3 low_frequency(ivec2 p) {
#ifdef INDIRECT
    ShLight light = ShLight(texelFetch(light_lf_sh, p, 0), texelFetch(light_lf_cocg, p, 0).xy);
    return sh_irradiance(light, unpack_unit_vector(imageLoad(ch_normal, p).x)) * (INV_PI * push.scale_lf);
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
        vec4 base = imageLoad(ch_base_color, p);
        float metallic = imageLoad(ch_metallic_roughness, p).x;
        vec3 albedo = push.use_albedo != 0u ? vec3(push.albedo) : diffuse_albedo(base.rgb, metallic);
        vec3 diffuse = (texelFetch(light_hf, p, 0).rgb * push.scale_hf + low_frequency(p)) * albedo;
        vec3 specular = texelFetch(light_spec, p, 0).rgb * demodulation(base, metallic) * push.scale_spec;
        color = (diffuse + specular) * imageLoad(ch_throughput, p).rgb;
    }
    vec4 overlay = imageLoad(ch_transparent, p);
    color = color * (1.0 - overlay.a) + overlay.rgb * push.scale_overlay;
    imageStore(ch_color, p, vec4(color, float(flags)));
}
