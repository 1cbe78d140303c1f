// Split frame -> flat frame, on the flat extent.
//
// A pixel with one path type is copied. Where a surface was split between reflection and refraction (more than one
// checkerboard flag), each field holds one half of the light: the pixel becomes the average of its own value and the
// mean of its cross neighbours, which all lie in the other field. Neighbours outside the frame do not count.
#include "channels.glsl"
#include "checkerboard.glsl"
#include "interleave_push.glsl"
#include "math.glsl"

layout(local_size_x = 16, local_size_y = 16) in;
layout(push_constant, scalar) uniform Push { InterleavePush push; };

// In this order the first of equally bright neighbours gives the motion.
const ivec2 CROSS[4] = ivec2[4](ivec2(-1, 0), ivec2(1, 0), ivec2(0, -1), ivec2(0, 1));

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = imageSize(ch_flat_color);
    if (any(greaterThanEqual(pixel, size))) return;
    int field_width = (size.x + 1) / 2;
    ivec2 own = flat_to_split(pixel, field_width);
    vec4 color = imageLoad(ch_color, own);
    vec4 motion = imageLoad(ch_motion, own);

    if (push.blend_split != 0u && bitCount(uint(color.a)) > 1) {
        vec3 sum = vec3(0.0);
        int count = 0;
        float brightest = -1.0;
        ivec2 brightest_at = own;
        for (int i = 0; i < 4; ++i) {
            ivec2 neighbour = pixel + CROSS[i];
            if (any(lessThan(neighbour, ivec2(0))) || any(greaterThanEqual(neighbour, size))) continue;
            ivec2 at = flat_to_split(neighbour, field_width);
            vec3 c = imageLoad(ch_color, at).rgb;
            sum += c;
            ++count;
            if (luminance(c) > brightest) {
                brightest = luminance(c);
                brightest_at = at;
            }
        }
        if (count > 0) {
            vec3 other = sum / float(count);
            if (luminance(other) > luminance(color.rgb)) motion = imageLoad(ch_motion, brightest_at);
            color.rgb = 0.5 * (color.rgb + other);
        }
    }
    imageStore(ch_flat_color, pixel, color);
    imageStore(ch_flat_motion, pixel, vec4(motion.xy, 0.0, 0.0));
}
