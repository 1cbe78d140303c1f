// The camera ray of a pixel.
#include "camera.glsl"
#include "random.glsl"
#include "sampling.glsl"

struct PixelRay { CameraRay camera; vec2 uv; };

// `key`: of the pixel's random numbers. `jitter`: of all pixels, or each draws its own.
PixelRay pixel_ray(ivec2 flat_pixel, uvec2 key, vec2 jitter, bool jitter_per_pixel) {
    vec4 random = random_numbers(key, DIM_PIXEL);
    vec2 offset = jitter_per_pixel ? random.xy - 0.5 : jitter;
    vec2 uv = (vec2(flat_pixel) + 0.5 + offset) / vec2(frame.size);
    return PixelRay(camera_ray(frame.camera, uv, sample_disk(random.zw)), uv);
}
