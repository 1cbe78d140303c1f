// First kernel of an iteration. When few paths go on (path_shadow.trace decides) it adds the samples that are complete to their pixels and begins
// the next ones there, all in one sweep: rays of one depth have most in common and are traced together. Extent: the tile's slots.
#include "path_slots.glsl"
#include "path_append.glsl"
#include "path_camera.glsl"
#include "film.glsl"

layout(local_size_x = ADVANCE_GROUP) in;

// A FilmPixel. 16 bytes at a time: word by word, a subgroup would write each sector of memory in fourteen parts.
layout(buffer_reference, scalar, buffer_reference_align = 16) buffer FilmWords { uvec4 at[4]; };

FilmPixel load_film(FilmWords film) {
    uvec4 a = film.at[0], b = film.at[1], c = film.at[2], d = film.at[3];
    return FilmPixel(uintBitsToFloat(a.xyz), a.w, uintBitsToFloat(b.xyz), b.w, uintBitsToFloat(c.xyz), uintBitsToFloat(uvec3(c.w, d.xy)), uvec2(0u));
}

void store_film(FilmWords film, FilmPixel pixel) {
    uvec3 rest = floatBitsToUint(pixel.square_rest);
    film.at[0] = uvec4(floatBitsToUint(pixel.sum), pixel.rays);
    film.at[1] = uvec4(floatBitsToUint(pixel.sum_rest), pixel.shadow_rays);
    film.at[2] = uvec4(floatBitsToUint(pixel.square), rest.x);
    film.at[3] = uvec4(rest.yz, 0u, 0u);
}

void finish_sample(uint slot, uint index) {
    FilmWords film = FilmWords(push.film + uint64_t(index) * FILM_PIXEL_BYTES);
    FilmPixel pixel = load_film(film);
    vec3 radiance = load_row(ROW_RADIANCE, slot).xyz;
    if (!is_countable(radiance)) {
        atomicAdd(CounterTable(push.dropped).at[0], 1u);
        radiance = vec3(0.0);
    }
    if (push.clamp > 0.0) radiance = min(radiance, vec3(push.clamp));
    add_sample(pixel, radiance);
    pixel.rays += load_progress(slot) >> 18u;
    pixel.shadow_rays += shadow_rays_of(load_sample_word(slot));
    store_film(film, pixel);
}

void begin_sample(uint slot, uvec2 pixel, uint sample_index) {
    PathState path = start_path(pixel, sample_index);
    // The slot has done its part.
    if (sample_index == push.first_sample + push.sample_count) path.flags = 0u;
    store_path(slot, path);
}

void main() {
    uint slot = gl_GlobalInvocationID.x;
    TileProgress progress = TileProgress(push.progress);
    if (slot == 0u) {
        uvec3 row = uvec3(tile_blocks().x, 1u, 1u);
        progress.tile.lists[list_read()].groups.x = row.x;
        // The last iteration's shadow rays are done.
        progress.tile.lists[LIST_SHADOW] = RayListHead(0u, row, uvec3(1u), 0u);
    }
    if (push.iteration != 0u && progress.tile.sweep == 0u) return;
    uvec2 pixel = slot_pixel(slot);
    bool begins = slot < slot_count() && in_tile(pixel);
    uint sample_index = push.first_sample;
    if (begins && push.iteration != 0u) {
        begins = (load_progress(slot) & PATH_ENDED) != 0u;
        if (begins) {
            finish_sample(slot, pixel_index(pixel));
            sample_index = sample_of(load_sample_word(slot)) + 1u;
        }
    }
    if (begins) begin_sample(slot, pixel, sample_index);
    append_slot(slot, list_read(), begins && sample_index < push.first_sample + push.sample_count);
}
