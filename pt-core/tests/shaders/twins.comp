// Runs pack.glsl and rng.glsl on inputs from the host.
#include "pack.glsl"
#include "rng.glsl"

layout(local_size_x = 64) in;
layout(set = 2, binding = 0, scalar) readonly buffer vectors { vec3 vector[]; };
layout(set = 2, binding = 1, scalar) writeonly buffer words { uint word[]; };
layout(set = 2, binding = 2, scalar) writeonly buffer decoded { vec3 unpacked[]; };
layout(set = 2, binding = 3, scalar) writeonly buffer randoms { vec4 random[]; };

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= uint(vector.length())) return;
    word[i] = pack_unit_vector(vector[i]);
    unpacked[i] = unpack_unit_vector(pack_unit_vector(vector[i]));
    random[i] = random4(uvec2(i | (7u << 16), i * 3u), 5u, 11u);
}
