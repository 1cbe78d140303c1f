// Where a history is short, it is replaced by a wide mean of the pixels around: Zhdanov 2021, chapter 49.3. 5 x 5 taps of the B3 spline, as far apart as the history lacks
// frames: up to push.radius pixels in all. Extent: the flat frame.
#include "denoise_records.glsl"

layout(local_size_x = 16, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { RecurrentPush push; };
layout(set = 2, binding = 0, rgba32f) uniform writeonly image2D target_hf;
layout(set = 2, binding = 1, rgba32f) uniform writeonly image2D target_spec;
layout(set = 2, binding = 2) uniform sampler2D source_hf;
layout(set = 2, binding = 3) uniform sampler2D source_spec;
#include "history.glsl"
#include "history_code.glsl"
#include "recurrent.glsl"

Lights lights_at(ivec2 at) { return Lights(light_of_history(texelFetch(source_hf, at, 0)), light_of_history(texelFetch(source_spec, at, 0))); }

const float KERNEL[3] = float[3](0.375, 0.25, 0.0625);

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (!inside(pixel)) return;
    ivec2 at = flat_to_split(pixel, field_width());
    Lights own = lights_at(at);
    Guide p = load_guide(at);
    uint frames = history_frames(imageLoad(im_surface, at).y);
    float lack = 1.0 - float(frames) / float(push.fix_frames);
    int step = int(ceil(0.5 * push.radius * lack));
    if (p.normal == 0u || step < 1) {
        imageStore(target_hf, at, own.hf);
        imageStore(target_spec, at, own.spec);
        return;
    }
    // Specular light only as far as its lobe spreads.
    float pixel_angle = max(imageLoad(ch_bounce_throughput, at).a, 1e-6), reach = push.lobe * square(p.geometry.z) / pixel_angle;
    Blur hf = Blur(vec4(0.0), 0.0), spec = hf;
    for (int y = -2; y <= 2; ++y) {
        for (int x = -2; x <= 2; ++x) {
            ivec2 offset = ivec2(x, y) * step;
            if (!inside(pixel + offset)) continue;
            ivec2 other = flat_to_split(pixel + offset, field_width());
            Guide q = load_guide(other);
            if (q.normal == 0u || !same_path(p, q, offset)) continue;
            float pixels = length(vec2(offset));
            vec2 weights = offset == ivec2(0) ? vec2(1.0) : surface_weights(p, q, pixels);
            weights *= KERNEL[abs(x)] * KERNEL[abs(y)];
            Lights tap = lights_at(other);
            add(hf, tap.hf, weights.x);
            add(spec, tap.spec, weights.y * exp(-square(pixels / max(reach, 1e-6))));
        }
    }
    imageStore(target_hf, at, mean(hf, own.hf));
    imageStore(target_spec, at, mean(spec, own.spec));
}
