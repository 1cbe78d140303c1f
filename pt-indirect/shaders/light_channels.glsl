// The end of the passes of indirect lighting: the light channels.
#include "channels.glsl"
#include "first_words.glsl"
#include "reflectance.glsl"
#include "sh.glsl"

void store_diffuse(ivec2 p, ShLight light) {
    imageStore(ch_color_lf_sh, p, light.luma);
    imageStore(ch_color_lf_cocg, p, vec4(light.chroma, 0.0, 0.0));
}

const ShLight NO_SH_LIGHT = ShLight(vec4(0.0), vec2(0.0));

// Neither NaN nor infinite; a surface of broken geometry can make either.
bool is_finite(vec3 v) { return all(lessThan(abs(v), vec3(1e30))); }

// Light of one direction: `irradiance` at the surface of pixel p.
ShLight diffuse_of(ivec2 p, vec3 direction, vec3 irradiance) {
    if (!is_finite(irradiance)) irradiance = vec3(0.0);
    vec3 normal = unpack_unit_vector(imageLoad(ch_normal, p).x);
    return push.directional != 0u ? sh_encode_irradiance(direction, irradiance, normal) : sh_constant(irradiance);
}

// How much of the light that comes along the first ray, of length `reach`, the specular lobes give, after what knobs take away.
float specular_factor(float roughness, float reach) {
    float fade = 1.0 - smoothstep(push.specular_fade, push.specular_fade + 0.1, roughness);
    return (push.specular_fade < 1.0 ? fade : 1.0) / max(1.0, reach * roughness * push.anti_flicker);
}

// The lists have been read: the next frame begins new ones.
void empty_lists() {
    if (gl_WorkGroupID.xy == uvec2(0u) && gl_LocalInvocationIndex < BOUNCE_LIST_HEADS) {
        RayListCount(bounce_tables().heads + uint64_t(gl_LocalInvocationIndex * RAY_LIST_HEAD_BYTES)).head = empty_list(push.columns);
    }
}
