// What the surface of the G-buffer does with the light that comes along the first ray, in 16 bytes: written by "choose bounces", read by
// "bounce lights" and "indirect lighting".
#include "bounce_path.glsl"

struct FirstFactors {
    vec3 specular;    // all that is not the diffuse base
    float diffuse;    // without the albedo
    float roughness;  // perceptual, of the smoothest lobe
    bool is_specular; // the ray was drawn for a specular lobe
};

const uvec4 NO_PATH = uvec4(0u);

void store_first(uint index, uvec4 words) { RowTable(bounce_tables().firsts).at[index] = words; }
uvec4 load_first(uint index) { return RowTable(bounce_tables().firsts).at[index]; }

// The lowest bit of the roughness says for which lobe.
uvec4 pack_first(FirstFactors f) {
    uint roughness = floatBitsToUint(f.roughness) & ~1u | (f.is_specular ? 1u : 0u);
    return uvec4(pack_light(f.specular), floatBitsToUint(f.diffuse), roughness);
}

FirstFactors unpack_first(uvec4 words) {
    return FirstFactors(unpack_light(words.xy), uintBitsToFloat(words.z), uintBitsToFloat(words.w & ~1u), (words.w & 1u) != 0u);
}

bool is_path(uvec4 words) { return any(notEqual(words.xyz, uvec3(0u))); }
