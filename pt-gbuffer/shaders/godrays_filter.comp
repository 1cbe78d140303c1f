// From the marched pixels to all pixels: a bilateral filter (Tomasi and Manduchi 1998) over 5 x 5 blocks whose weights are Gaussian in distance and
// fall with the relative difference of depth. Then the medium lies before what the camera ray has found: that is weakened, scattered light is
// added. Extent: split frame.
#include "checkerboard.glsl"
#include "godrays.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

const int RADIUS = 2;
// Of the Gaussian, pixels.
const float SIGMA = 2.5;
// Relative difference of depth whose weight is 1 / e.
const float DEPTH_RANGE = 0.1;
// Weight that pixels of any depth keep: a pixel that is like none of its neighbours takes their mean.
const float ANY_DEPTH = 1e-4;

float similarity(float a, float b) { return exp(-abs(a - b) / (DEPTH_RANGE * min(a, b))) + ANY_DEPTH; }

void main() {
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (p.x >= 2 * int(frame.field_width) || p.y >= int(frame.size.y)) return;
    float way = medium_length(p);
    if (way <= 0.0) return;
    ivec2 pixel = split_to_flat(p, int(frame.field_width)), blocks = imageSize(im_godrays);

    vec4 sum = vec4(0.0);
    for (int i = 0; i < (2 * RADIUS + 1) * (2 * RADIUS + 1); i++) {
        ivec2 q = pixel / 2 + ivec2(i % (2 * RADIUS + 1), i / (2 * RADIUS + 1)) - RADIUS;
        if (any(lessThan(q, ivec2(0))) || any(greaterThanEqual(q, blocks))) continue;
        vec4 marched = imageLoad(im_godrays, q);
        if (marched.a <= 0.0) continue;
        vec2 offset = vec2(marched_pixel(q) - pixel);
        float weight = exp(-0.5 * dot(offset, offset) / square(SIGMA)) * similarity(marched.a, way);
        sum += weight * vec4(marched.rgb, 1.0);
    }
    float depth = push.density * way, left = exp(-depth);
    vec3 scattered = sum.rgb * (opacity(depth) / max(sum.a, 1e-20));
    vec4 overlay = imageLoad(ch_transparent, p), throughput = imageLoad(ch_throughput, p);
    imageStore(ch_transparent, p, vec4(overlay.rgb * left + scattered, overlay.a));
    imageStore(ch_throughput, p, vec4(throughput.rgb * left, throughput.a));
}
