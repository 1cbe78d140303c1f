// What the a-trous levels know of a surface, in one texel of im_guide.
// Angles of a half float: from 6e-11 to 64 radians.
const float ANGLE_SCALE = 1024.0;

uvec4 pack_guide(Guide guide, float pixel_angle) {
    if (guide.normal == 0u) return uvec4(0u);
    uint roughness = uint(round(clamp(guide.geometry.z, 0.0, 1.0) * 65535.0));
    return uvec4(floatBitsToUint(guide.geometry.xy), guide.normal, roughness | packHalf2x16(vec2(0.0, pixel_angle * ANGLE_SCALE)));
}

Guide unpack_guide(uvec4 word) {
    if (word.z == 0u) return NO_GUIDE;
    float roughness = float(word.w & 0xffffu) * (1.0 / 65535.0);
    return Guide(vec4(uintBitsToFloat(word.xy), roughness, unpackHalf2x16(word.w).y * (1.0 / ANGLE_SCALE)), word.z);
}
