// Stochastic texture filtering: one texel of one mip level is read, drawn with the weights of the filter. Pharr, Wronski, Salvi and Fajardo
// 2024, "Filtering After Shading With Stochastic Texture Filtering", section 3.
//
// The filter whose value is expected is that of the Vulkan 1.3 specification, chapter "Image Operations": its section on
// anisotropic filtering for the taps along the major axis and the level of detail, then linear blending between two levels and bilinear
// blending between four texels. Samplers that take the nearest texel or level do so here too.
#include "scene.glsl"

// `dx`, `dy`: axes of the footprint in UV; `random`: dimensions.rs, DIM_TEXTURE.
vec4 draw_texel(TextureSlot slot, vec2 uv, vec2 dx, vec2 dy, vec4 random) {
    vec2 size = vec2(textureSize(textures[nonuniformEXT(slot.texture)], 0));
    float length_x = length(dx * size), length_y = length(dy * size);
    float major = max(length_x, length_y), minor = min(length_x, length_y);
    float ratio = 1.0;
    if ((slot.flags & TEXTURE_UNFILTERED) == 0u && major > 0.0) {
        ratio = minor * MAX_TEXTURE_ANISOTROPY > major ? major / minor : MAX_TEXTURE_ANISOTROPY;
        float taps = ceil(ratio), tap = 1.0 + floor(random.w * taps);
        uv += (length_x >= length_y ? dx : dy) * (tap / (taps + 1.0) - 0.5);
    }
    float lod = log2(max(major / ratio, 1e-30));

    int last = (slot.flags & TEXTURE_MIP_OFF) != 0u ? 0 : textureQueryLevels(textures[nonuniformEXT(slot.texture)]) - 1;
    float rounding = (slot.flags & TEXTURE_MIP_NEAREST) != 0u ? 0.5 : random.z;
    // The sum may round up to last + 1.
    int level = min(int(floor(clamp(lod, 0.0, float(last)) + rounding)), last);
    vec2 level_size = vec2(textureSize(textures[nonuniformEXT(slot.texture)], level));
    bool nearest = (slot.flags & (lod > 0.0 ? TEXTURE_MIN_NEAREST : TEXTURE_MAG_NEAREST)) != 0u;
    vec2 texel = floor(uv * level_size + (nearest ? vec2(0.0) : random.xy - 0.5));
    // At the centre of a texel every filter gives that texel; the sampler wraps it.
    return textureLod(textures[nonuniformEXT(slot.texture)], (texel + 0.5) / level_size, float(level));
}
