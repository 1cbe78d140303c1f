// First kernel of a turn. When no path goes on it adds the samples, which are complete, to their pixels and begins the next ones, of all
// pixels at once: rays of one depth, which have most in common, are traced together. Extent: the tile's slots.
#include "path_slots.glsl"
#include "path_append.glsl"
#include "path_camera.glsl"
#include "film.glsl"

layout(local_size_x = 64) in;

void finish_sample(uint slot, uint index) {
    FilmPixel pixel = FilmTable(push.film).at[index];
    vec4 row = load_row(ROW_RADIANCE, slot);
    vec3 radiance = row.xyz;
    if (!is_countable(radiance)) {
        atomicAdd(CounterTable(push.dropped).at[0], 1u);
        radiance = vec3(0.0);
    }
    if (push.clamp > 0.0) radiance = min(radiance, vec3(push.clamp));
    add_sample(pixel, radiance);
    pixel.rays += load_segment(slot);
    pixel.shadow_rays += floatBitsToUint(row.w);
    FilmTable(push.film).at[index] = pixel;
}

void main() {
    uint slot = gl_GlobalInvocationID.x;
    TileProgress progress = TileProgress(push.progress);
    // The last turn's shadow rays are done.
    if (slot == 0u) progress.tile.listed[LIST_SHADOW] = 0u;
    if (!turn_begins_sample()) return;
    uvec2 pixel = slot_pixel(slot);
    bool exists = slot < slot_count() && in_tile(pixel);
    uint begun = push.turn == 0u ? 0u : progress.tile.begun;
    if (exists && push.turn != 0u && begun > progress.tile.finished) finish_sample(slot, pixel_index(pixel));
    bool begins = exists && begun < push.sample_count;
    if (begins) store_path(slot, start_path(pixel, push.first_sample + begun));
    append_slot(slot, list_read(), begins);
}
