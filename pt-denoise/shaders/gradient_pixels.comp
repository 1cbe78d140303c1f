// Chooses gradient pixels before the light is computed: Schied, Peters and Dachsbacher 2018, section 4.2. Of each stratum of the flat frame one pixel gets the
// surface and the random seed of the last frame: the lighting stages then take its light samples again. The surface is the same point of the object,
// where it is now. A pixel that was a gradient pixel in the last frame is none again: its seed is that of the frame before. One with a short history is none either.
// Extent: strata.
//
// Backward projection: the pixel is where the motion of its own surface comes from. Forward projection: a random pixel of each stratum of the last frame is
// sought in this frame; a stratum takes one of those that lie in it. They are found without atomics: the stratum looks at those of the 3 x 3 strata around the place
// where the motion of its middle comes from.
#include "surface.glsl"
#include "denoise_records.glsl"
#include "frame.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { GradientPixelsPush push; };
#include "camera.glsl"
#include "history.glsl"
#include "light_sample.glsl"
#include "reprojection.glsl"
#include "rng.glsl"
#include "stratum.glsl"

struct Candidate { ivec2 at; ivec2 from; int number; vec2 luminance; float score; };

const Candidate NO_CANDIDATE = Candidate(ivec2(0), ivec2(0), -1, vec2(0.0), -1.0);

// A shorter history has little to forget, and its pixel needs samples of its own more than a gradient.
const uint LEAST_HISTORY = 4u;

// Whether a pixel of the last frame may be taken again.
bool may_repeat(ivec2 tap) {
    bool is_old = imageLoad(ch_gradient_sample_prev, tap / stratum_side).x == gradient_number(tap);
    return !is_old && history_frames(imageLoad(im_surface_prev, flat_to_split(tap, field_width())).y) >= LEAST_HISTORY;
}

uint random_of(ivec2 stratum) {
    return random4_bits(uvec2(uint(stratum.x) | uint(stratum.y) << 16u, frame.frame_index), DIM_GRADIENT, frame.seed).x;
}

int pixels_of_stratum() { return stratum_side * stratum_side; }

// Light of the last frame.
bool light_before(ivec2 from, out vec2 luminances_before) {
    vec3 hf = imageLoad(ch_color_hf_prev, from).rgb, spec = imageLoad(ch_color_spec_prev, from).rgb;
    luminances_before = vec2(luminance(hf), luminance(spec));
    return is_light(hf) && is_light(spec);
}

// Where the point of the object is now that a pixel showed in the last frame.
vec3 position_now(ivec2 from) {
    uvec2 visible = imageLoad(ch_visibility_prev, from).xy;
    return load_surface(visible.x, visible.y, imageLoad(ch_barycentrics_prev, from).xy).position;
}

// The surface that the pixel showed in the last frame, where it is now, with its random seed. It is seen from where it was seen: how a highlight follows the camera is no
// change of the light.
void take_over(Candidate c) {
    uvec2 visible = imageLoad(ch_visibility_prev, c.from).xy;
    vec2 barycentrics = imageLoad(ch_barycentrics_prev, c.from).xy;
    vec4 before = imageLoad(ch_shading_position_prev, c.from);
    imageStore(ch_rng_seed, c.at, imageLoad(ch_rng_seed_prev, c.from));
    imageStore(ch_visibility, c.at, uvec4(visible, 0u, 0u));
    imageStore(ch_barycentrics, c.at, vec4(barycentrics, 0.0, 0.0));
    imageStore(ch_cluster, c.at, imageLoad(ch_cluster_prev, c.from));
    imageStore(ch_base_color, c.at, imageLoad(ch_base_color_prev, c.from));
    imageStore(ch_metallic_roughness, c.at, imageLoad(ch_metallic_roughness_prev, c.from));
    imageStore(ch_normal, c.at, imageLoad(ch_normal_prev, c.from));
    imageStore(ch_vertex_normal, c.at, imageLoad(ch_vertex_normal_prev, c.from));
    imageStore(ch_shading_position, c.at, vec4(position_now(c.from), before.w));
    imageStore(ch_view_direction, c.at, imageLoad(ch_view_direction_prev, c.from));
}

// Keeps the brighter one; without scores the first one.
void consider(inout Candidate best, Candidate c) {
    if (!light_before(c.from, c.luminance)) return;
    c.score = push.brightest != 0u ? c.luminance.x + c.luminance.y : 0.0;
    if (c.score > best.score) best = c;
}

Candidate backward(ivec2 stratum) {
    int first = int(random_of(stratum) % uint(pixels_of_stratum()));
    Candidate best = NO_CANDIDATE;
    for (int i = 0; i < pixels_of_stratum(); ++i) {
        // From a random one on, so that of several that are alike each may be chosen.
        int number = (i + first) % pixels_of_stratum();
        ivec2 pixel = stratum_pixel(stratum, number);
        if (!inside(pixel)) continue;
        ivec2 at = flat_to_split(pixel, field_width());
        uint flags = imageLoad(ch_view_direction, at).y;
        Reprojection r = reproject(pixel, at, surface_word(at, flags), flags);
        if (!r.valid) continue;
        ivec2 tap = ivec2(floor(r.place + 0.5));
        if (!shows_surface(r, pixel, tap) || !may_repeat(tap)) continue;
        consider(best, Candidate(at, flat_to_split(tap, field_width()), number, vec2(0.0), -1.0));
        // The first one is as random as any.
        if (push.brightest == 0u && best.number >= 0) break;
    }
    return best;
}

// The pixel that shows the surface of pixel `tap` of the last frame, if it lies in the stratum. Paths over mirrors and glass have no projection.
bool lands_in(ivec2 stratum, ivec2 tap, out Candidate c) {
    c = NO_CANDIDATE;
    c.from = flat_to_split(tap, field_width());
    uint word = imageLoad(im_surface_prev, c.from).x;
    if (word == 0u || !may_repeat(tap) || imageLoad(ch_view_direction_prev, c.from).y != FLAG_PRIMARY) return false;
    vec3 place = project(frame.camera, position_now(c.from));
    vec2 at = place.xy * vec2(push.size);
    if (!is_finite(place) || any(greaterThan(abs(at), vec2(1e6)))) return false;
    ivec2 pixel = ivec2(floor(at));
    if (!inside(pixel) || pixel / stratum_side != stratum) return false;
    c.at = flat_to_split(pixel, field_width());
    uint flags = imageLoad(ch_view_direction, c.at).y;
    // Something else may be in front of it now.
    float tolerance = push.depth * place.z + 2.0 / max(imageLoad(ch_motion, c.at).w, 1e-18);
    vec3 before = unpack_unit_vector(imageLoad(ch_vertex_normal_prev, c.from).x);
    if (surface_word(c.at, flags) != word || !(abs(imageLoad(ch_view_depth, c.at).x - place.z) <= tolerance)) return false;
    c.number = int(gradient_number(pixel)) - 1;
    return dot(unpack_unit_vector(imageLoad(ch_vertex_normal, c.at).x), before) >= push.normal;
}

Candidate forward(ivec2 stratum) {
    Candidate best = NO_CANDIDATE;
    ivec2 middle = min(stratum_pixel(stratum, pixels_of_stratum() / 2), ivec2(push.size) - 1);
    ivec2 at = flat_to_split(middle, field_width());
    uint flags = imageLoad(ch_view_direction, at).y;
    Reprojection r = reproject(middle, at, surface_word(at, flags), flags);
    if (!r.valid) return best;
    ivec2 was = ivec2(floor(r.place + 0.5)) / stratum_side;
    int first = int(random_of(stratum) % 9u);
    for (int i = 0; i < 9; ++i) {
        int k = (i + first) % 9;
        ivec2 other = was + ivec2(k % 3, k / 3) - 1;
        if (any(lessThan(other, ivec2(0))) || any(greaterThanEqual(other, stratum_count()))) continue;
        ivec2 tap = stratum_pixel(other, int(random_of(other) % uint(pixels_of_stratum())));
        Candidate c;
        if (!inside(tap) || !lands_in(stratum, tap, c)) continue;
        consider(best, c);
        if (push.brightest == 0u && best.number >= 0) break;
    }
    return best;
}

void main() {
    ivec2 stratum = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(stratum, stratum_count()))) return;
    Candidate best;
    if (push.forward != 0u) best = forward(stratum);
    else best = backward(stratum);
    if (best.number >= 0) take_over(best);
    imageStore(ch_gradient_sample, stratum, vec4(float(best.number + 1), best.luminance, 0.0));
}
