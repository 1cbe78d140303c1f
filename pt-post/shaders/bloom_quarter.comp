// Mean of 4 x 4 pixels, on a quarter of the extent rounded up: what the Gaussian bloom blurs. Pixels outside the frame and
// those that are not finite are left out. A group makes 16 x 16 means; a thread sums up columns of 4 pixels, so that neighbours
// in a group read neighbours in the frame.
#include "finite.glsl"
#include "post_records.glsl"

layout(local_size_x = 16, local_size_y = 16) in;
layout(set = 2, binding = 0) uniform sampler2D source;
layout(set = 2, binding = 1, rgba16f) uniform writeonly image2D target;

const float MAX_HALF = 65504.0;
// Sums of columns and numbers of their pixels, by row of the result; the columns of a mean lie 16 apart.
shared vec4 columns[16][64];

void main() {
    ivec2 size = textureSize(source, 0);
    int column = int(gl_LocalInvocationIndex % 64u);
    int x = int(gl_WorkGroupID.x) * 64 + column;
    for (int i = 0; i < 4; ++i) {
        int row = 4 * i + int(gl_LocalInvocationIndex / 64u);
        int y = (int(gl_WorkGroupID.y) * 16 + row) * 4;
        vec3 c[4];
        for (int k = 0; k < 4; ++k) c[k] = texelFetch(source, min(ivec2(x, y + k), size - 1), 0).rgb;
        vec4 sum = vec4(0.0);
        for (int k = 0; k < 4; ++k) {
            if (x < size.x && y + k < size.y && is_finite(c[k])) sum += vec4(clamp(c[k], 0.0, MAX_HALF), 1.0);
        }
        columns[row][column % 4 * 16 + column / 4] = sum;
    }
    barrier();
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(p, imageSize(target)))) return;
    ivec2 at = ivec2(gl_LocalInvocationID.xy);
    vec4 sum = columns[at.y][at.x] + columns[at.y][16 + at.x] + columns[at.y][32 + at.x] + columns[at.y][48 + at.x];
    imageStore(target, p, vec4(sum.rgb / max(sum.a, 1.0), 1.0));
}
