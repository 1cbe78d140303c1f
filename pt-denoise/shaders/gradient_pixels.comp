// Chooses gradient pixels before the light is computed: Schied, Peters and Dachsbacher 2018, section 4.2. Of each stratum of 3 x 3 pixels of the flat
// frame one pixel gets the surface and the random seed of the last frame: the lighting stages then take its light samples again. The surface is the
// same point of the object, where it is now (backward projection: the pixel is where the motion of its own surface comes from). A pixel that
// was a gradient pixel in the last frame is none again: its seed is that of the frame before. Extent: strata.
#include "surface.glsl"
#include "denoise_records.glsl"
#include "frame.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { GradientPixelsPush push; };
#include "light_sample.glsl"
#include "reprojection.glsl"
#include "rng.glsl"

struct Candidate { ivec2 at; ivec2 from; int number; vec2 luminance; float score; };

bool was_gradient_pixel(ivec2 tap) {
    ivec2 within = tap % 3;
    return imageLoad(ch_gradient_sample_prev, tap / 3).x == float(1 + within.y * 3 + within.x);
}

// Light of the last frame.
bool light_before(ivec2 from, out vec2 luminances_before) {
    vec3 hf = imageLoad(ch_color_hf_prev, from).rgb, spec = imageLoad(ch_color_spec_prev, from).rgb;
    luminances_before = vec2(luminance(hf), luminance(spec));
    return is_light(hf) && is_light(spec);
}

// The surface that the pixel showed in the last frame, where it is now, with its random seed.
void take_over(Candidate c) {
    uvec2 visible = imageLoad(ch_visibility_prev, c.from).xy;
    vec2 barycentrics = imageLoad(ch_barycentrics_prev, c.from).xy;
    vec4 before = imageLoad(ch_shading_position_prev, c.from);
    vec3 now = load_surface(visible.x, visible.y, barycentrics).position;
    uvec2 direction = imageLoad(ch_view_direction_prev, c.from).xy;
    vec4 camera = frame.camera.world_from_view[3];
    // Where nothing moves, the direction of the last frame is the same to the bit.
    bool moves = now != before.xyz || camera != frame.camera_prev.world_from_view[3];
    if (moves && direction.y == FLAG_PRIMARY && frame.camera.projection == 0u) {
        direction.x = pack_unit_vector(normalize(now - camera.xyz));
    }
    imageStore(ch_rng_seed, c.at, imageLoad(ch_rng_seed_prev, c.from));
    imageStore(ch_visibility, c.at, uvec4(visible, 0u, 0u));
    imageStore(ch_barycentrics, c.at, vec4(barycentrics, 0.0, 0.0));
    imageStore(ch_cluster, c.at, imageLoad(ch_cluster_prev, c.from));
    imageStore(ch_base_color, c.at, imageLoad(ch_base_color_prev, c.from));
    imageStore(ch_metallic_roughness, c.at, imageLoad(ch_metallic_roughness_prev, c.from));
    imageStore(ch_normal, c.at, imageLoad(ch_normal_prev, c.from));
    imageStore(ch_vertex_normal, c.at, imageLoad(ch_vertex_normal_prev, c.from));
    imageStore(ch_shading_position, c.at, vec4(now, before.w));
    imageStore(ch_view_direction, c.at, uvec4(direction, 0u, 0u));
}

void main() {
    ivec2 stratum = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(stratum, (ivec2(push.size) + 2) / 3))) return;
    uint random = random4_bits(uvec2(uint(stratum.x) | uint(stratum.y) << 16u, frame.frame_index), DIM_GRADIENT, frame.seed).x;
    Candidate best = Candidate(ivec2(0), ivec2(0), -1, vec2(0.0), -1.0);
    for (int i = 0; i < 9; ++i) {
        // From a random one on, so that of several that are alike each may be chosen.
        int number = (i + int(random % 9u)) % 9;
        ivec2 pixel = stratum * 3 + ivec2(number % 3, number / 3);
        if (!inside(pixel)) continue;
        ivec2 at = flat_to_split(pixel, field_width());
        uint flags = imageLoad(ch_view_direction, at).y;
        Reprojection r = reproject(pixel, at, surface_word(at, flags), flags);
        if (!r.valid) continue;
        ivec2 tap = ivec2(floor(r.place + 0.5));
        if (!shows_surface(r, pixel, tap) || was_gradient_pixel(tap)) continue;
        Candidate c = Candidate(at, flat_to_split(tap, field_width()), number, vec2(0.0), 0.0);
        if (!light_before(c.from, c.luminance)) continue;
        // The first one is as random as any.
        if (push.brightest != 0u) c.score = c.luminance.x + c.luminance.y;
        if (c.score > best.score) best = c;
        if (push.brightest == 0u) break;
    }
    if (best.number >= 0) take_over(best);
    imageStore(ch_gradient_sample, stratum, vec4(float(best.number + 1), best.luminance, 0.0));
}
