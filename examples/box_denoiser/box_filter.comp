// The mean of direct light over 5 x 5 pixels of a checkerboard field. It blurs across all edges.
#include "light_sample.glsl"
#include "denoise_images.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy), size = imageSize(ch_color_hf);
    if (any(greaterThanEqual(at, size))) return;
    // The split frame holds both fields side by side.
    int width = size.x / 2, left = at.x / width * width;
    vec4 hf = vec4(0.0), spec = vec4(0.0);
    for (int i = 0; i < 25; ++i) {
        ivec2 tap = at + ivec2(i % 5, i / 5) - 2;
        if (tap.x < left || tap.x >= left + width || tap.y < 0 || tap.y >= size.y) continue;
        LightSample light = load_light(tap, true);
        if (light.known) hf += vec4(light.hf, 1.0), spec += vec4(light.spec, 1.0);
    }
    imageStore(im_ping_hf, at, hf / max(hf.a, 1.0));
    imageStore(im_ping_spec, at, spec / max(spec.a, 1.0));
}
