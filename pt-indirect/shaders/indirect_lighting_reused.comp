// As indirect_lighting.comp where bounces are reused: a surface gets the light of its own path that is not reused, and that of the sample which the reuse has
// kept, for the diffuse base and, if it is rough, for all lobes. Extent: split frame.
layout(local_size_x = 16, local_size_y = 8) in;
#include "first_effects.glsl"
#include "first_surface.glsl"
#include "light_channels.glsl"

// Light for the channels.
struct Light {
    vec4 luma;       // of the diffuse light, ShLight
    vec3 irradiance; // the same light at the surface itself
    vec3 specular;   // before the demodulation
};

const Light NO_LIGHT = Light(vec4(0.0), vec3(0.0), vec3(0.0));

// `irradiance` and `specular` light that come from a direction.
Light make_light(ivec2 p, vec3 direction, vec3 irradiance, vec3 specular) {
    if (!is_finite(irradiance)) irradiance = vec3(0.0);
    return Light(diffuse_of(p, direction, irradiance).luma, irradiance, is_finite(specular) ? specular : vec3(0.0));
}

// The chroma that the surface itself sees in the hue of its irradiance: that of a sum is not the sum of those of its parts (sh_irradiance).
vec2 chroma_of(Light light) {
    vec3 c = ycocg_from_rgb(light.irradiance);
    return c.x > 0.0 ? c.yz * (light.luma.w / (SH_Y0 * c.x)) : vec2(0.0);
}

bool reuses_specular(float roughness) { return roughness >= push.restir_roughness; }

// Of the pixel's own path.
Light own_light(ivec2 p, uint index, FirstFactors first, vec4 reusable) {
    vec3 direction = unpack_unit_vector(WordTable(bounce_tables().first_directions).at[index]);
    vec4 light = load_light(index);
    EffectsSeen effects = first_effects(p, direction, light.w, first.specular);
    vec3 diffuse_light = light.rgb;
    vec3 specular_light = effects.transmittance * light.rgb + unpack_light(PairTable(bounce_tables().reflected).at[index]);
    if (reusable.w < 0.0 || !reuses_specular(first.roughness)) specular_light += effects.transmittance * reusable.rgb;
    specular_light += effects.radiance;
    if (push.clamp > 0.0) {
        diffuse_light = min(diffuse_light, vec3(push.clamp));
        specular_light = min(specular_light, vec3(push.clamp));
    }
    vec3 specular = specular_light * first.specular * specular_factor(first.roughness, light.w);
    return make_light(p, direction, diffuse_light * (PI * first.diffuse), specular);
}

// Of the sample that was kept; reused_light() of reuse_spatial.glsl packs it.
Light reused_light(ivec2 p, uint index) {
    uvec4 words = RowTable(bounce_tables().points).at[index];
    vec3 light = unpack_light(words.xy);
    if (max_component(light) <= 0.0) return NO_LIGHT;
    vec3 direction = unpack_unit_vector(words.z);
    FirstSurface s = load_first_surface(p, imageLoad(ch_shading_position, p));
    float diffuse = bsdf_diffuse_cos(s.bsdf, direction);
    vec3 specular = vec3(0.0);
    if (reuses_specular(s.roughness)) {
        float reach = uintBitsToFloat(words.w);
        specular = max(bsdf_eval(s.bsdf, direction) - diffuse * s.albedo, 0.0) * specular_factor(s.roughness, reach);
        // Their light comes along the pixel's own ray.
        specular *= first_effects(p, direction, reach, specular).transmittance;
    }
    return make_light(p, direction, light * (PI * diffuse), light * specular);
}

void add_up(ivec2 p, uint index) {
    Light sum = NO_LIGHT;
    uvec4 words = load_first(index);
    vec4 reusable = load_reusable(index);
    vec4 color_spec = imageLoad(ch_color_spec, p);
    if (is_path(words)) {
        FirstFactors first = unpack_first(words);
        sum = own_light(p, index, first, reusable);
        if (first.is_specular) color_spec.a = load_light(index).w;
    }
    if (reusable.w >= 0.0) {
        Light reused = reused_light(p, index);
        sum.luma += reused.luma;
        sum.irradiance += reused.irradiance;
        sum.specular += reused.specular;
    }
    store_diffuse(p, ShLight(sum.luma, chroma_of(sum)));
    color_spec.rgb += sum.specular / demodulation(base_color_of(imageLoad(ch_base_color, p)), imageLoad(ch_metallic_roughness, p).x);
    imageStore(ch_color_spec, p, color_spec);
}

void main() {
    empty_lists();
    uvec2 launch = gl_GlobalInvocationID.xy;
    if (launch.x < push.width && launch.y < uint(imageSize(ch_color_lf_sh).y)) add_up(ivec2(launch), path_index(launch));
}
