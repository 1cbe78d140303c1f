// A record whose members stand in another order than the host's: creating the kernel must fail.
struct FrameRecord {
    uint seed;
    uvec2 size;
};

layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 0, scalar) uniform frame_uniforms { FrameRecord frame; };
layout(set = 2, binding = 0, scalar) buffer sums { uint sum[]; };

void main() { sum[0] = frame.seed + frame.size.x; }
