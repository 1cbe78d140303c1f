// Gives the light of the paths to the surfaces of the G-buffer: its diffuse part to color_lf, the rest to color_spec. Extent: split frame; with
// half_rows every other row.
layout(local_size_x = 16, local_size_y = 8) in;
#include "first_effects.glsl"
#include "gbuffer_format.glsl"
#include "light_channels.glsl"

void add_up(ivec2 p, uint index) {
    uvec4 words = load_first(index);
    if (!is_path(words)) {
        store_diffuse(p, NO_SH_LIGHT);
        return;
    }
    FirstFactors first = unpack_first(words);
    vec3 direction = unpack_unit_vector(WordTable(bounce_tables().first_directions).at[index]);
    vec4 light = load_light(index);
    vec3 diffuse_light = light.rgb;
    if (push.clamp > 0.0) diffuse_light = min(diffuse_light, vec3(push.clamp));
    float weight = push.half_rows != 0u ? 2.0 : 1.0;
    store_diffuse(p, diffuse_of(p, direction, diffuse_light * (weight * PI * first.diffuse)));
    if (push.half_rows != 0u) return;
    EffectsSeen effects = first_effects(p, direction, light.w, first.specular);
    vec3 specular_light = effects.transmittance * light.rgb + unpack_light(PairTable(bounce_tables().reflected).at[index]);
    specular_light += effects.radiance;
    if (push.clamp > 0.0) specular_light = min(specular_light, vec3(push.clamp));
    float metallic = imageLoad(ch_metallic_roughness, p).x;
    float factor = specular_factor(first.roughness, light.w);
    vec3 specular = specular_light * first.specular * (factor / demodulation(base_color_of(imageLoad(ch_base_color, p)), metallic));
    vec4 color_spec = imageLoad(ch_color_spec, p);
    if (is_finite(specular)) color_spec.rgb += specular;
    if (first.is_specular) color_spec.a = light.w;
    imageStore(ch_color_spec, p, color_spec);
}

void main() {
    empty_lists();
    ivec2 launch = ivec2(gl_GlobalInvocationID.xy), size = imageSize(ch_color_lf_sh);
    uint index = path_index(uvec2(launch));
    ivec2 p = path_texel(index);
    if (launch.x >= size.x) return;
    // The row that is traced in the next frame.
    ivec2 beside = ivec2(p.x, p.y ^ 1);
    if (push.half_rows != 0u && all(lessThan(beside, size))) store_diffuse(beside, NO_SH_LIGHT);
    if (all(lessThan(p, size))) add_up(p, index);
}
