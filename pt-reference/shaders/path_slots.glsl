// The slots that hold paths between the kernels of an iteration (advance, trace, shade, shadow): a slot for each pixel of the tile,
// which traces the pixel's samples one after the other, and a list of the slots whose path goes on: Laine, Karras, Aila 2013,
// "Megakernels Considered Harmful: Wavefront Path Tracing on GPUs". Slots stand in blocks of 8 x 4 pixels, so that neighbours in
// the list are neighbours in the image.
//
// The buffer push.paths: three lists (one of live slots that is read, one that is written, one of slots with a shadow ray), then rows of
// 16 bytes a slot, so that threads side by side load side by side. Two rows that are read together stand together: a slot's part of both is a
// sector of memory, which is read in full wherever its neighbours' paths have ended. Scenes with transmission have three rows more, samplers of lights other than per kind two,
// scenes with effects one.
#include "path_state.glsl"
#include "scene.glsl"
#include "ray_list.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 4) buffer TileProgress { ProgressRecord tile; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer SlotList { uint at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) buffer RowTable { vec4 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer LengthTable { float at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) buffer ConeTable { vec2 at[]; };

// Threads of a workgroup.
const uint ADVANCE_GROUP = 64u;
// Wide: NVIDIA's compiler then keeps to 128 registers, and twice as many threads hide the loads.
const uint SHADE_GROUP = 512u;

uint list_read() { return push.iteration & 1u; }
uint list_written() { return list_read() ^ 1u; }

// Rows 2i and 2i + 1 are a pair.
const uint ROW_ORIGIN = 0u;     // w: sample_word()
const uint ROW_DIRECTION = 1u;  // w: progress_word()
const uint ROW_THROUGHPUT = 2u; // w: last_pdf
const uint ROW_HIT = 3u;        // instance, triangle, barycentrics
const uint ROW_SOLIDS = 4u;     // the interior list, if PATH_INSIDE
const uint ROW_IORS = 5u;
const uint ROW_SHADOW_ORIGIN = 6u;    // w: t_max
const uint ROW_SHADOW_DIRECTION = 7u; // w: seed for partial coverage
const uint ROW_RADIANCE = 8u;         // what the path has brought to the pixel
const uint ROW_SHADOW_RADIANCE = 9u;  // what the light brings if nothing is in its way
const uint ROWS = 10u;                // and the length of the ray; if ray_cones, the cone

uvec2 tile_blocks() { return (push.tile_size + uvec2(7u, 3u)) / uvec2(8u, 4u); }

// Rounded up to whole blocks.
uint slot_count() { return tile_blocks().x * tile_blocks().y * 32u; }

// Of the image; outside of the tile for a slot that rounding up has added.
uvec2 slot_pixel(uint slot) {
    uint block = slot / 32u, place = slot % 32u, across = tile_blocks().x;
    return push.tile_origin + uvec2(block % across, block / across) * uvec2(8u, 4u) + uvec2(place % 8u, place / 8u);
}

bool in_tile(uvec2 pixel) { return all(lessThan(pixel - push.tile_origin, push.tile_size)); }

uint pixel_index(uvec2 pixel) { return pixel.y * frame.size.x + pixel.x; }

SlotList slot_list(uint list) { return SlotList(push.paths + uint64_t(4u * list * slot_count())); }

uint list_count(uint list) { return TileProgress(push.progress).tile.lists[list].count; }

// NONE past the end.
uint slot_at(uint place, uint list) { return place < list_count(list) ? slot_list(list).at[place] : NONE; }

// Counts entries of a list as taken; the place of the first.
uint take_slots(uint list, uint count) { return atomicAdd(TileProgress(push.progress).tile.lists[list].taken, count); }

// Where pair number `pair` of rows begins.
RowTable pair_table(uint pair) {
    return RowTable(push.paths + uint64_t(slot_count()) * uint64_t(16u + 32u * pair));
}

uint place_in_pair(uint row, uint slot) { return 2u * slot + (row & 1u); }

vec4 load_row(uint row, uint slot) { return pair_table(row / 2u).at[place_in_pair(row, slot)]; }
void store_row(uint row, uint slot, vec4 value) { pair_table(row / 2u).at[place_in_pair(row, slot)] = value; }
void store_word(uint row, uint slot, uint word) { pair_table(row / 2u).at[place_in_pair(row, slot)].w = uintBitsToFloat(word); }
void store_row(uint row, uint slot, vec3 value, uint word) { store_row(row, slot, vec4(value, uintBitsToFloat(word))); }

// Flags, vertex and segment: 4, 14, 14 bits. No path comes that far: Russian roulette spares at most 95 %.
const uint MAX_RAYS = 0x3fffu;
const uint SAMPLE_BITS = 18u;
uint progress_word(PathState path) { return path.flags | path.vertex << 4u | path.segment << 18u; }
uint load_progress(uint slot) { return floatBitsToUint(load_row(ROW_DIRECTION, slot).w); }

// The sample among those of the push constants, and its shadow rays (one a vertex at most): 18, 14 bits.
uint sample_word(PathState path) { return path.sample_index - push.first_sample | path.shadow_rays << SAMPLE_BITS; }
uint load_sample_word(uint slot) { return floatBitsToUint(load_row(ROW_ORIGIN, slot).w); }
uint sample_of(uint word) { return push.first_sample + (word & (1u << SAMPLE_BITS) - 1u); }
uint shadow_rays_of(uint word) { return word >> SAMPLE_BITS; }

// Adds to what the path has brought to the pixel. Most vertices bring nothing: the sum stays in memory.
void add_radiance(uint slot, vec3 radiance) {
    store_row(ROW_RADIANCE, slot, vec4(load_row(ROW_RADIANCE, slot).xyz + radiance, 0.0));
}

// What the ray alone needs: origin, direction, progress, sample.
void load_ray(inout PathState path, uint slot) {
    vec4 origin = load_row(ROW_ORIGIN, slot), direction = load_row(ROW_DIRECTION, slot);
    uint word = floatBitsToUint(direction.w);
    path.origin = origin.xyz;
    path.sample_index = sample_of(floatBitsToUint(origin.w));
    path.shadow_rays = shadow_rays_of(floatBitsToUint(origin.w));
    path.direction = direction.xyz;
    path.flags = word & 15u;
    path.vertex = word >> 4u & MAX_RAYS;
    path.segment = word >> 18u;
    path.random = path_random(slot_pixel(slot), path.sample_index);
}

LengthTable length_table() { return LengthTable(pair_table(ROWS / 2u)); }
ConeTable cone_table() { return ConeTable(uint64_t(length_table()) + uint64_t(4u * slot_count())); }

// What the shadow ray needs to go straight on through surfaces: the solids that it begins in, their indices, and x: PathState::passed,
// y: how many surfaces it may pass.
const uint STRAIGHT_SOLIDS = 0u, STRAIGHT_IORS = 1u, STRAIGHT_WAY = 2u;
RowTable straight_table(uint row) {
    uint64_t first = uint64_t(cone_table()) + (ray_cones ? uint64_t(8u * slot_count()) : 0ul);
    return RowTable(first + uint64_t(slot_count()) * uint64_t(16u * row));
}

// A KeptContext of each slot (path_lights.glsl).
RowTable light_table() { return straight_table(scene_has(FEATURE_TRANSMISSION) ? 3u : 0u); }

// PathState::glossy.
RowTable effects_table() { return RowTable(uint64_t(light_table()) + (merged_lights ? uint64_t(32u * slot_count()) : 0ul)); }

PathState load_path(uint slot) {
    PathState path;
    load_ray(path, slot);
    vec4 throughput = load_row(ROW_THROUGHPUT, slot);
    path.throughput = throughput.xyz;
    path.last_pdf = throughput.w;
    path.interior = EMPTY_INTERIOR;
    if (scene_has(FEATURE_TRANSMISSION) && (path.flags & PATH_INSIDE) != 0u) {
        path.interior = InteriorList(floatBitsToUint(load_row(ROW_SOLIDS, slot)), load_row(ROW_IORS, slot));
    }
    path.cone = vec2(0.0);
    if (ray_cones) path.cone = cone_table().at[slot];
    path.passed = 0.0;
    if (scene_has(FEATURE_TRANSMISSION)) path.passed = straight_table(STRAIGHT_WAY).at[slot].x;
    path.chord = 0.0;
    path.glossy = vec3(0.0);
    if (scene_has(FEATURE_EFFECTS)) path.glossy = effects_table().at[slot].xyz;
    return path;
}

void store_path(uint slot, PathState path) {
    path.flags &= ~PATH_INSIDE;
    if (scene_has(FEATURE_TRANSMISSION) && any(notEqual(path.interior.words, uvec4(0u)))) {
        path.flags |= PATH_INSIDE;
        store_row(ROW_SOLIDS, slot, uintBitsToFloat(path.interior.words));
        store_row(ROW_IORS, slot, path.interior.iors);
    }
    store_row(ROW_ORIGIN, slot, path.origin, sample_word(path));
    store_row(ROW_DIRECTION, slot, path.direction, progress_word(path));
    store_row(ROW_THROUGHPUT, slot, vec4(path.throughput, path.last_pdf));
    if (ray_cones) cone_table().at[slot] = path.cone;
    if (scene_has(FEATURE_TRANSMISSION)) straight_table(STRAIGHT_WAY).at[slot].x = path.passed;
    if (scene_has(FEATURE_EFFECTS)) effects_table().at[slot] = vec4(path.glossy, 0.0);
}

// Of a path that has ended: what path_advance.comp asks for.
void store_end(uint slot, PathState path) {
    store_word(ROW_ORIGIN, slot, sample_word(path));
    store_word(ROW_DIRECTION, slot, progress_word(path));
}

Hit load_hit(uint slot) {
    vec4 row = load_row(ROW_HIT, slot);
    return Hit(floatBitsToUint(row.x), floatBitsToUint(row.y), row.zw, length_table().at[slot]);
}

void store_hit(uint slot, Hit hit) {
    store_row(ROW_HIT, slot, vec4(uintBitsToFloat(hit.instance), uintBitsToFloat(hit.triangle), hit.barycentrics));
    length_table().at[slot] = hit.t;
}
