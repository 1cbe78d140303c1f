// Gives the light of the paths to the surfaces of the G-buffer: its diffuse part to color_lf, the rest to color_spec. Extent: split frame; with
// half_rows every other row.
layout(local_size_x = 16, local_size_y = 8) in;
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

// How much of the light that comes along the first ray, of length `reach`, the specular lobes give, after what knobs take away.
float specular_factor(float roughness, float reach) {
    float fade = 1.0 - smoothstep(push.specular_fade, push.specular_fade + 0.1, roughness);
    return (push.specular_fade < 1.0 ? fade : 1.0) / max(1.0, reach * roughness * push.anti_flicker);
}

void add_up(ivec2 p, uint index) {
    uvec4 words = load_first(index);
    if (!is_path(words)) {
        store_diffuse(p, NO_SH_LIGHT);
        return;
    }
    FirstFactors first = unpack_first(words);
    vec3 direction = unpack_unit_vector(WordTable(bounce_tables().first_directions).at[index]);
    vec4 light = load_light(index);
    vec3 diffuse_light = light.rgb, specular_light = light.rgb + unpack_light(PairTable(bounce_tables().reflected).at[index]);
    if (push.clamp > 0.0) {
        diffuse_light = min(diffuse_light, vec3(push.clamp));
        specular_light = min(specular_light, vec3(push.clamp));
    }
    float weight = push.half_rows != 0u ? 2.0 : 1.0;
    vec3 irradiance = diffuse_light * (weight * PI * first.diffuse);
    if (!is_finite(irradiance)) irradiance = vec3(0.0);
    vec3 normal = unpack_unit_vector(imageLoad(ch_normal, p).x);
    store_diffuse(p, push.directional != 0u ? sh_encode_irradiance(direction, irradiance, normal) : sh_constant(irradiance));
    if (push.half_rows != 0u) return;
    float metallic = imageLoad(ch_metallic_roughness, p).x;
    float factor = specular_factor(first.roughness, light.w);
    vec3 specular = specular_light * first.specular * (factor / demodulation(imageLoad(ch_base_color, p), metallic));
    vec4 color_spec = imageLoad(ch_color_spec, p);
    if (is_finite(specular)) color_spec.rgb += specular;
    if (first.is_specular) color_spec.a = light.w;
    imageStore(ch_color_spec, p, color_spec);
}

void main() {
    // The lists have been read: the next frame begins new ones.
    if (gl_WorkGroupID.xy == uvec2(0u) && gl_LocalInvocationIndex < BOUNCE_LIST_HEADS) {
        RayListCount(bounce_tables().heads + uint64_t(gl_LocalInvocationIndex * RAY_LIST_HEAD_BYTES)).head = empty_list(push.columns);
    }
    ivec2 launch = ivec2(gl_GlobalInvocationID.xy), size = imageSize(ch_color_lf_sh);
    uint index = path_index(uvec2(launch));
    ivec2 p = path_texel(index);
    if (launch.x >= size.x) return;
    // The row that is traced in the next frame.
    ivec2 beside = ivec2(p.x, p.y ^ 1);
    if (push.half_rows != 0u && all(lessThan(beside, size))) store_diffuse(beside, NO_SH_LIGHT);
    if (all(lessThan(p, size))) add_up(p, index);
}
