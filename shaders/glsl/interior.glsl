// What a point lies inside of: solids that overlap, with priorities. Schmidt and Budge 2002, "Simple Nested Dielectrics in Ray Traced
// Images": where solids overlap the one of the highest priority is there and the others are not; their boundaries inside of it are
// false hits, which a path passes as if they were not. Of equal priorities the one entered last is there, so that solids that lie
// whole inside of others need none. Host twin: pt_reference::oracle::interior.
//
// The list lives in registers: four words, the newest first, with 24 bits of (material + 1) and 8 bits of priority; 0: empty. Pure
// functions, the path keeps the list:
//
//     InteriorList EMPTY_INTERIOR                                      vacuum
//     uint interior_top(InteriorList)                                  material that is there, NONE: vacuum
//     bool interior_is_false_hit(InteriorList, material, priority, entering)
//     Crossing interior_crossing(InteriorList, material, priority, entering)   the media on both sides, for a true hit
//     InteriorList interior_cross(InteriorList, material, priority, entering)  after light has passed the boundary, at
//                                                                      true and at false hits; not after a reflection
//     InteriorList interior_found_around(InteriorList, material, priority)     for the first point of a path, see below
//
// Full: the word of the lowest priority (of equal ones the oldest) is dropped, so that what is visible stays right until the solids
// above it are left. Leaving a solid that is not in the list (dropped, or an open mesh, or a camera inside) is a hit on the
// material's own back, unless something of higher priority is there.
//
// A camera inside of solids: trace a ray from it to infinity in any direction. With `walked` = EMPTY_INTERIOR, at every boundary of a
// solid: when it is left and interior_holds(walked, material) is false, the camera's list is interior_found_around(list, ...);
// else walked = interior_cross(walked, ...).
#include "records.glsl"

struct InteriorList { uvec4 words; };

const InteriorList EMPTY_INTERIOR = InteriorList(uvec4(0u));

struct Crossing {
    uint front;  // material on the side that the path comes from, NONE: vacuum
    uint behind; // and on the other
};

uint interior_word(uint material, uint priority) { return (material + 1u) << 8u | min(priority, 255u); }
uint interior_material(uint word) { return (word >> 8u) - 1u; }

// The word that is there: the highest priority, of equal ones the first.
uint interior_top_word(InteriorList list) {
    uvec4 w = list.words;
    uint top = w.x;
    if ((w.y & 0xffu) > (top & 0xffu)) top = w.y;
    if ((w.z & 0xffu) > (top & 0xffu)) top = w.z;
    if ((w.w & 0xffu) > (top & 0xffu)) top = w.w;
    return top;
}

uint interior_top(InteriorList list) { return interior_material(interior_top_word(list)); }

// Place of the newest word equal to `word`; 4: none.
uint interior_find(InteriorList list, uint word) {
    bvec4 same = equal(list.words, uvec4(word));
    return same.x ? 0u : same.y ? 1u : same.z ? 2u : same.w ? 3u : 4u;
}

bool interior_holds(InteriorList list, uint material, uint priority) {
    return interior_find(list, interior_word(material, priority)) < 4u;
}

// Closes the gap of word `place`.
InteriorList interior_without(InteriorList list, uint place) {
    uvec4 w = list.words;
    if (place == 0u) w = uvec4(w.yzw, 0u);
    else if (place == 1u) w = uvec4(w.x, w.zw, 0u);
    else if (place == 2u) w = uvec4(w.xy, w.w, 0u);
    else if (place == 3u) w.w = 0u;
    return InteriorList(w);
}

// Makes room when there is none: drops the word of the lowest priority, of equal ones the oldest.
InteriorList interior_make_room(InteriorList list) {
    uvec4 w = list.words;
    if (w.w == 0u) return list;
    uint place = 3u, least = w.w & 0xffu;
    if ((w.z & 0xffu) < least) { place = 2u; least = w.z & 0xffu; }
    if ((w.y & 0xffu) < least) { place = 1u; least = w.y & 0xffu; }
    if ((w.x & 0xffu) < least) place = 0u;
    return interior_without(list, place);
}

InteriorList interior_cross(InteriorList list, uint material, uint priority, bool entering) {
    uint word = interior_word(material, priority);
    if (!entering) return interior_without(list, interior_find(list, word));
    list = interior_make_room(list);
    return InteriorList(uvec4(word, list.words.xyz));
}

// A solid that was there before all that the list knows.
InteriorList interior_found_around(InteriorList list, uint material, uint priority) {
    uint word = interior_word(material, priority);
    list = interior_make_room(list);
    uvec4 w = list.words;
    if (w.x == 0u) w.x = word;
    else if (w.y == 0u) w.y = word;
    else if (w.z == 0u) w.z = word;
    else w.w = word;
    return InteriorList(w);
}

Crossing interior_crossing(InteriorList list, uint material, uint priority, bool entering) {
    uint top = interior_top(list);
    if (entering) return Crossing(top, interior_top(interior_cross(list, material, priority, true)));
    if (interior_holds(list, material, priority)) return Crossing(top, interior_top(interior_cross(list, material, priority, false)));
    // Left without having been entered.
    bool covered = (interior_top_word(list) & 0xffu) > min(priority, 255u) && top != NONE;
    return Crossing(covered ? top : material, top);
}

// Nothing is there to be seen: the medium is the same on both sides.
bool interior_is_false_hit(InteriorList list, uint material, uint priority, bool entering) {
    Crossing c = interior_crossing(list, material, priority, entering);
    return c.front == c.behind;
}
