// The tables by which lights are chosen: those of this frame or, in a gradient pixel, those of the last one.
//
// A gradient pixel has last frame's surface and random seed (Schied, Peters and Dachsbacher 2018, "Gradient Estimation for Real-Time
// Adaptive Temporal Filtering", section 4): it takes the light sample of the last frame again, so that what differs has changed in the
// light and is not noise. All that chooses then reads choice_tables(): the same choice with the same probability. What is evaluated, the
// light's radiance, the point on it, and whether it is seen, is read from scene.light_tables: it is this frame's. A light has the same index
// in both.
#include "scene.glsl"

// Whether the kernel has gradient pixels. Without, last frame's tables need not be there.
layout(constant_id = 7) const bool replays_samples = false;

bool is_gradient_pixel = false;

// Says where the choices of a pixel come from. `seed`: channel rng_seed, (pixel, frame). Without a call, they are those of this frame.
void begin_choices(uvec2 seed, uint frame_index) { is_gradient_pixel = replays_samples && seed.y + 1u == frame_index; }

LightTablesRecord choice_tables() {
    if (replays_samples && is_gradient_pixel) return scene.light_tables_previous;
    return scene.light_tables;
}
