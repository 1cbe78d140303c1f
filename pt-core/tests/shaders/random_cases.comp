// Runs random.glsl on cases from the host.
#include "random.glsl"

layout(local_size_x = 64) in;
layout(set = 2, binding = 0, scalar) readonly buffer cases { uvec4 case_at[]; }; // pixel (x | y << 16), frame, dimension, triangle
layout(set = 2, binding = 1, scalar) writeonly buffer words { uvec4 word[]; };
layout(set = 2, binding = 2, scalar) writeonly buffer coverages { vec2 coverage_at[]; };

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= uint(case_at.length())) return;
    uvec4 c = case_at[i];
    word[i] = random_bits(c.xy, c.z);
    coverage_at[i] = vec2(coverage_number(random_coverage(c.xy, c.z), 3u, c.w), random_numbers(c.xy, c.z).x);
}
