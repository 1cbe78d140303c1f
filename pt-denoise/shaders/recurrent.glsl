// What the passes of the recurrent blur share (Zhdanov 2021, "ReBLUR: A Hierarchical Recurrent Denoiser", Ray Tracing Gems II, chapter 49): light of both channels with hit
// distances in alpha (-1: missing), and geometric weights. The kernel declares `push` as RecurrentPush.
#include "checkerboard.glsl"
#include "denoise_images.glsl"
#include "edge_stopping.glsl"

int field_width() { return (int(push.size.x) + 1) / 2; }

bool inside(ivec2 pixel) { return all(greaterThanEqual(pixel, ivec2(0))) && all(lessThan(pixel, ivec2(push.size))); }

struct Lights { vec4 hf; vec4 spec; };

const Lights NO_LIGHTS = Lights(vec4(0.0, 0.0, 0.0, -1.0), vec4(0.0, 0.0, 0.0, -1.0));

struct Blur { vec4 sum; float weights; };

void add(inout Blur blur, vec4 light, float weight) {
    if (light.a < 0.0) return;
    blur.sum += weight * light;
    blur.weights += weight;
}

// Mean of the light; the hit distance stays that of the pixel itself, because the mean of two is that of no surface.
vec4 mean(Blur blur, vec4 own) {
    if (!(blur.weights > 1e-12)) return own;
    vec4 mean = blur.sum / blur.weights;
    return vec4(mean.rgb, own.a < 0.0 ? mean.a : own.a);
}

// Weight of a tap in diffuse and in specular light, of the surfaces alone. The specular lobe is as in atrous.glsl.
vec2 surface_weights(Guide p, Guide q, float pixels) {
    float depth = depth_weight(p, q, max(pixels, 1.0), push.depth), cosine = normal_cosine(p, q);
    float alpha = max(square(min(p.geometry.z, q.geometry.z)), 1e-4);
    float power = clamp(8.0 / square(push.lobe * alpha), push.normal, 1e4);
    float alike = max(0.0, 1.0 - 10.0 * abs(p.geometry.z - q.geometry.z));
    return depth * vec2(pow(cosine, push.normal), alike * pow(cosine, power));
}
