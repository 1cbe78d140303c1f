// Octahedral unit vectors: Cigolle et al. 2014, "A Survey of Efficient Representations for Independent Unit Vectors".
// The host twin is pt_core::pack. The all-zero word is no unit vector that encode produces for a surface (see below), so
// that 0 can mean "no surface".

vec2 octahedral_encode(vec3 n) {
    vec2 p = n.xy / (abs(n.x) + abs(n.y) + abs(n.z));
    vec2 folded = (1.0 - abs(p.yx)) * vec2(p.x >= 0.0 ? 1.0 : -1.0, p.y >= 0.0 ? 1.0 : -1.0);
    return n.z >= 0.0 ? p : folded;
}

vec3 octahedral_decode(vec2 p) {
    vec3 n = vec3(p, 1.0 - abs(p.x) - abs(p.y));
    float t = max(-n.z, 0.0);
    n.xy += vec2(n.x >= 0.0 ? -t : t, n.y >= 0.0 ? -t : t);
    return normalize(n);
}

// 2 x 16 bit. Code 0 is left out: [-1, 1] maps to 1..65535, so that the axes (0 -> 32768) are exact and no normal packs to 0.
uint pack_unit_vector(vec3 n) {
    uvec2 q = uvec2(round(clamp(octahedral_encode(n), -1.0, 1.0) * 32767.0) + 32768.0);
    return q.x | (q.y << 16);
}

vec3 unpack_unit_vector(uint word) {
    vec2 q = vec2(float(word & 0xffffu), float(word >> 16));
    return octahedral_decode((q - 32768.0) / 32767.0);
}

// Tangent with the bitangent's sign in the top bit: x 16 bit, y 15 bit.
uint pack_tangent(vec4 tangent) {
    vec2 p = clamp(octahedral_encode(tangent.xyz), -1.0, 1.0);
    uint x = uint(round(p.x * 32767.0) + 32768.0), y = uint(round(p.y * 16383.0) + 16384.0);
    return x | y << 16 | (tangent.w < 0.0 ? 0x80000000u : 0u);
}

vec4 unpack_tangent(uint word) {
    vec2 p = vec2((float(word & 0xffffu) - 32768.0) / 32767.0, (float((word >> 16) & 0x7fffu) - 16384.0) / 16383.0);
    return vec4(octahedral_decode(p), (word & 0x80000000u) != 0u ? -1.0 : 1.0);
}
