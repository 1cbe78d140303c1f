// The solids that a point is inside of; they may overlap. Schmidt and Budge 2002, "Simple Nested Dielectrics in Ray Traced Images":
// where solids overlap the strongest is there and the others are not; boundaries of the others inside of it are false hits, which a
// path passes as if they were not. The strongest has the highest priority, of equal ones the highest index of refraction, of equal
// ones the lowest medium index: the same whatever the order in which they were entered. Host twin: pt_reference::oracle::interior.
//
// The list lives in registers and belongs to the path. Pure functions:
//
//     InteriorList EMPTY_INTERIOR                                        vacuum all round
//     Solid interior_top(InteriorList)                                   what is there; word 0: vacuum
//     Crossing interior_crossing(InteriorList, Boundary, bool entering)  what is on both sides of a boundary that is hit
//     bool is_false_hit(Crossing)                                        the same on both: go on straight, with interior_cross()
//     InteriorList interior_cross(InteriorList, Boundary, bool entering) after light has passed it; not after a reflection
//     InteriorList interior_add(InteriorList, Solid)                     for the first point of a path, see below
//
// `entering`: the path goes against the triangle's normal. The list has room for four; when it is full the weakest is dropped, so
// that what is visible stays right until the three stronger ones are left. Leaving a solid that is not in the list (dropped, an open
// mesh, or a camera inside) is a hit on its back, unless something stronger is there.
//
// A camera inside of solids: trace a ray from it to infinity in any direction. With `walked` = EMPTY_INTERIOR, at every boundary of
// a solid: when the side that the ray comes from has a solid that interior_holds(walked, ...) does not know, add it to the
// camera's list with interior_add and not to `walked`; then walked = interior_cross(walked, ...).
#include "records.glsl"

// word: 24 bits of medium + 1, 8 bits of priority below; 0: vacuum.
struct Solid { uint word; float ior; };

const Solid VACUUM = Solid(0u, 1.0);

// The two sides of a surface: the solid behind it, and in front of it VACUUM (or whatever is there), or the solid that ends where
// this one begins (an interface).
struct Boundary { Solid behind; Solid front; };

struct InteriorList { uvec4 words; vec4 iors; };

const InteriorList EMPTY_INTERIOR = InteriorList(uvec4(0u), vec4(1.0));

// Seen along the path.
struct Crossing { Solid here; Solid beyond; };

Solid make_solid(uint medium, uint priority, float ior) { return Solid((medium + 1u) << 8u | min(priority, 255u), ior); }

// NONE for the vacuum.
uint solid_medium(Solid s) { return (s.word >> 8u) - 1u; }

Solid stronger(Solid a, Solid b) {
    uint pa = a.word & 0xffu, pb = b.word & 0xffu;
    bool first = a.word != 0u && (b.word == 0u || pa > pb || pa == pb && (a.ior > b.ior || a.ior == b.ior && a.word < b.word));
    return Solid(first ? a.word : b.word, first ? a.ior : b.ior);
}

Solid interior_top(InteriorList list) {
    return stronger(stronger(Solid(list.words.x, list.iors.x), Solid(list.words.y, list.iors.y)),
                    stronger(Solid(list.words.z, list.iors.z), Solid(list.words.w, list.iors.w)));
}

bool interior_holds(InteriorList list, Solid s) { return any(equal(list.words, uvec4(s.word))); }

// Takes one entry of `s` out, if there is any; VACUUM is none.
InteriorList interior_remove(InteriorList list, Solid s) {
    bvec4 same = equal(list.words, uvec4(s.word));
    bvec4 first = bvec4(same.x, same.y && !same.x, same.z && !(same.x || same.y), same.w && !(same.x || same.y || same.z));
    return InteriorList(mix(list.words, uvec4(0u), first), mix(list.iors, vec4(1.0), first));
}

InteriorList interior_add(InteriorList list, Solid s) {
    if (s.word == 0u) return list;
    // The entry that goes down, through all places, is the weaker of the two each time; the last one falls out.
    for (int i = 0; i < 4; i++) {
        Solid old = Solid(list.words[i], list.iors[i]);
        Solid kept = stronger(s, old);
        if (kept.word == s.word) s = old;
        list.words[i] = kept.word;
        list.iors[i] = kept.ior;
    }
    return list;
}

InteriorList interior_cross(InteriorList list, Boundary b, bool entering) {
    if (entering) return interior_add(interior_remove(list, b.front), b.behind);
    return interior_add(interior_remove(list, b.behind), b.front);
}

Crossing interior_crossing(InteriorList list, Boundary b, bool entering) {
    Solid left = Solid(entering ? b.front.word : b.behind.word, entering ? b.front.ior : b.behind.ior);
    Solid here = interior_top(list);
    if (left.word != 0u && !interior_holds(list, left)) here = stronger(left, here);
    return Crossing(here, interior_top(interior_cross(list, b, entering)));
}

bool is_false_hit(Crossing c) { return c.here.word == c.beyond.word; }
