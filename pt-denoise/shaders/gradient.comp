// How much the light of the gradient pixels has changed: Schied, Peters and Dachsbacher 2018, section 4. A gradient pixel has taken the light
// sample of the last frame again, so that a difference is a change of the light and no noise. Extent: strata of the flat frame.
// Sums over strata of changes and of luminances are filtered apart, and divided where they are used: black strata then do not count.
#include "channels.glsl"
#include "checkerboard.glsl"
#include "denoise_images.glsl"
#include "denoise_records.glsl"
#include "light_sample.glsl"

layout(local_size_x = 16, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { GradientPush push; };
#include "stratum.glsl"

// Changes below the gate are rounding and the turn of a lobe with the camera; (change, greater of both).
vec2 change(float now, float before) {
    float greatest = max(now, before);
    return vec2(max(abs(now - before) - push.gate * greatest, 0.0), greatest);
}

void main() {
    ivec2 stratum = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(stratum, stratum_count()))) return;
    vec4 gradient = vec4(0.0);
    vec4 chosen = imageLoad(ch_gradient_sample, stratum);
    if (chosen.x > 0.0) {
        ivec2 pixel = stratum_pixel(stratum, int(chosen.x) - 1);
        LightSample light = load_light(flat_to_split(pixel, (int(push.size.x) + 1) / 2), true);
        if (light.known) {
            vec2 now = luminances(light);
            gradient = vec4(change(now.x, chosen.y), change(now.y, chosen.z));
        }
    }
    imageStore(im_gradients, stratum, gradient);
}
