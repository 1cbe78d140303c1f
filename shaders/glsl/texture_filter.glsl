// Stochastic texture filtering: one texel of one mip level is read, drawn with the weights of the filter. Pharr, Wronski, Salvi and Fajardo
// 2024, "Filtering After Shading With Stochastic Texture Filtering", section 3.
//
// The filter whose value is expected is that of the Vulkan 1.3 specification, chapter "Image Operations": its section on
// anisotropic filtering for the taps along the major axis and the level of detail, then linear blending between two levels and bilinear
// blending between four texels. Samplers that take the nearest texel or level do so here too.
#include "scene.glsl"

// As the sampler of the texture does outside [0, 1]. Half a texel keeps the quotient off whole numbers, which devices round either way.
vec2 wrap_texel(uint flags, vec2 texel, vec2 size) {
    bvec2 clamped = notEqual(uvec2(flags) & uvec2(TEXTURE_CLAMP_U, TEXTURE_CLAMP_V), uvec2(0u));
    bvec2 mirrored = notEqual(uvec2(flags) & uvec2(TEXTURE_MIRROR_U, TEXTURE_MIRROR_V), uvec2(0u));
    vec2 period = mix(size, 2.0 * size, mirrored);
    vec2 turn = texel - period * floor((texel + 0.5) / period);
    turn = min(turn, 2.0 * size - 1.0 - turn);
    return clamp(mix(turn, texel, clamped), vec2(0.0), size - 1.0);
}

// `dx`, `dy`: axes of the footprint in UV; `random`: dimensions.rs, DIM_TEXTURE.
vec4 draw_texel(TextureSlot slot, vec2 uv, vec2 dx, vec2 dy, vec4 random) {
    ivec2 extent = textureSize(textures[nonuniformEXT(slot.texture)], 0);
    vec2 size = vec2(extent);
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
    // Not textureSize of that level: lavapipe answers for one level where threads side by side ask for several.
    vec2 level_size = vec2(max(extent >> level, 1));
    bool nearest = (slot.flags & (lod > 0.0 ? TEXTURE_MIN_NEAREST : TEXTURE_MAG_NEAREST)) != 0u;
    vec2 texel = floor(uv * level_size + (nearest ? vec2(0.0) : random.xy - 0.5));
    return texelFetch(textures[nonuniformEXT(slot.texture)], ivec2(wrap_texel(slot.flags, texel, level_size)), level);
}
