// Copies a buffer, 16 bytes per thread, to measure the copy bandwidth.
layout(local_size_x = 256) in;
layout(set = 2, binding = 0, scalar) readonly buffer source { uvec4 source_at[]; };
layout(set = 2, binding = 1, scalar) writeonly buffer target { uvec4 target_at[]; };

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i < uint(target_at.length())) target_at[i] = source_at[i];
}
