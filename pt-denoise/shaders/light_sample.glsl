// This frame's light as it comes from the lighting stages, made safe to filter.
#include "channels.glsl"
#include "finite.glsl"
#include "math.glsl"

// Greatest radiance of a sample: squares of it are finite.
const float MAX_RADIANCE = 1e15;

struct LightSample { vec3 hf; vec3 spec; bool known; };

bool is_light(vec3 c) {
    return is_finite(c) && all(greaterThanEqual(c, vec3(0.0))) && all(lessThanEqual(c, vec3(MAX_RADIANCE)));
}

// What is no light - not finite, negative, beyond all measure - is a missing sample. Black would be a statement about the light.
LightSample load_light(ivec2 at, bool surface) {
    vec3 hf = imageLoad(ch_color_hf, at).rgb, spec = imageLoad(ch_color_spec, at).rgb;
    if (!surface || !is_light(hf) || !is_light(spec)) return LightSample(vec3(0.0), vec3(0.0), false);
    return LightSample(hf, spec, true);
}

vec2 luminances(LightSample light) { return vec2(luminance(light.hf), luminance(light.spec)); }

// Mean of some luminances without the brightest, which may itself be a firefly.
struct Surroundings { vec2 sum; vec2 brightest; float count; };

void add(inout Surroundings s, vec2 l) {
    s.sum += min(s.brightest, l);
    s.brightest = max(s.brightest, l);
    s.count += 1.0;
}

vec2 mean(Surroundings s) { return s.sum / max(s.count - 1.0, 1.0); }

vec3 limited(vec3 light, float limit) {
    float l = luminance(light);
    return limit > 0.0 && l > limit ? light * (limit / l) : light;
}
