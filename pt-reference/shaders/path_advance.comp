// First kernel of a turn: adds samples that are complete to their pixels, begins the next ones, and lists the slots that go on.
// The first turn of a tile (push.begin) begins the first samples. Extent: the tile's slots.
#include "path_slots.glsl"
#include "path_append.glsl"
#include "path_camera.glsl"
#include "film.glsl"

layout(local_size_x = 64) in;

void finish_sample(uint slot, PathState path) {
    uint index = pixel_index(slot_pixel(slot));
    FilmPixel pixel = FilmTable(push.film).at[index];
    vec3 radiance = path.radiance;
    if (!is_countable(radiance)) {
        atomicAdd(CounterTable(push.dropped).at[0], 1u);
        radiance = vec3(0.0);
    }
    if (push.clamp > 0.0) radiance = min(radiance, vec3(push.clamp));
    add_sample(pixel, radiance);
    pixel.rays += path.segment;
    pixel.shadow_rays += path.shadow_rays;
    FilmTable(push.film).at[index] = pixel;
}

// Whether the slot has a path for the turn's rays.
bool advance(uint slot) {
    uint sample_index = push.first_sample;
    if (push.begin != 0u) {
        if (!in_tile(slot_pixel(slot)) || push.sample_count == 0u) return false;
    } else {
        if ((floatBitsToUint(load_row(ROW_DIRECTION, slot).w) & PATH_ENDED) == 0u) return true;
        PathState path = load_path(slot);
        finish_sample(slot, path);
        sample_index = path.sample_index + 1u;
        if (sample_index == push.first_sample + push.sample_count) return false;
    }
    store_path(slot, start_path(slot_pixel(slot), sample_index));
    return true;
}

void main() {
    uint place = gl_GlobalInvocationID.x;
    // The last turn's shadow rays are done.
    if (place == 0u) ListLengths(push.counts).of[LIST_SHADOW] = 0u;
    uint slot = place;
    if (push.begin == 0u) slot = slot_at(place, push.parity);
    else if (place >= slot_count()) slot = NONE;
    append_slot(slot, 1u - push.parity, slot != NONE && advance(slot));
}
