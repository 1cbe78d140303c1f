// Shadow statistics: for each cluster, local light and direction of the normal (the six sides of a cube) how many shadow rays reached the
// light and how many did not. Lights that are mostly hidden are picked less often (after Ward 1994, "Adaptive Shadow Testing for Ray
// Tracing", as in Quake II RTX). Counts are integers: sums do not depend on the order of the threads.

#include "rng.glsl"
#include "lights/light_tables.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 8) buffer ShadowCountTable { uvec2 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer ShadowKeyTable { uint at[]; };

// Hidden lights keep this share: they may come into view.
const float LEAST_LIT_SHARE = 0.1;
// Entries that a light is looked for in the hash table.
const uint SHADOW_PROBES = 4u;

// Side of a cube that a normal points to: +x, -x, +y, -y, +z, -z.
uint normal_side(vec3 n) {
    vec3 a = abs(n);
    uint axis = a.x >= a.y && a.x >= a.z ? 0u : (a.y >= a.z ? 1u : 2u);
    return 2u * axis + (n[axis] < 0.0 ? 1u : 0u);
}

// Number of a cluster, light and side: its entry, or, in a hash table, what tells it from others. There two may have the same, and share
// their statistics.
uint shadow_key(uint cluster, uint light, vec3 normal) {
    uint side = normal_side(normal);
    if (scene.shadow_counts_hashed != 0u) return pcg(light + pcg(cluster * 6u + side)) | 1u;
    return (cluster * scene.most_local_lights + light) * 6u + side;
}

// Index of an entry's words in `shadow_keys` and `shadow_history`: in a hash table a key and its history lie side by side.
uint shadow_word(uint slot) { return slot << scene.shadow_counts_hashed; }

// Entry for a key in tables with these keys, NONE: it has none.
uint shadow_slot(uint64_t shadow_keys, uint key) {
    if (scene.shadow_counts_hashed == 0u) return key < scene.shadow_count_slots ? key : NONE;
    ShadowKeyTable keys = ShadowKeyTable(shadow_keys);
    uint mask = scene.shadow_count_slots - 1u;
    for (uint i = 0u; i < SHADOW_PROBES; i++) {
        uint slot = (pcg(key) + i) & mask;
        if (keys.at[shadow_word(slot)] == key) return slot;
    }
    return NONE;
}

// Entry of this frame for a key; takes a free one if it has none. First it looks at all entries where the key may be: one that became free
// before it must not hide it.
uint claim_shadow_slot(uint key) {
    uint known = shadow_slot(scene.light_tables.shadow_keys, key);
    if (known != NONE || scene.shadow_counts_hashed == 0u) return known;
    ShadowKeyTable keys = ShadowKeyTable(scene.light_tables.shadow_keys);
    uint mask = scene.shadow_count_slots - 1u;
    for (uint i = 0u; i < SHADOW_PROBES; i++) {
        uint slot = (pcg(key) + i) & mask;
        uint before = atomicCompSwap(keys.at[shadow_word(slot)], 0u, key);
        if (before == 0u || before == key) return slot;
    }
    return NONE;
}

// Share of the shadow rays of the frames before that reached the light; 1 when there were none.
float lit_share(uint cluster, uint light, vec3 normal) {
    if (scene.shadow_count_slots == 0u) return 1.0;
    uint slot = shadow_slot(choice_tables().shadow_keys, shadow_key(cluster, light, normal));
    if (slot == NONE) return 1.0;
    vec2 counts = unpackHalf2x16(UintTable(choice_tables().shadow_history).at[shadow_word(slot)]);
    float sum = counts.x + counts.y;
    return sum > 0.0 ? max(counts.x / sum, LEAST_LIT_SHARE) : 1.0;
}

// Counts a shadow ray. Those of gradient pixels do not count: the last frame has counted the same choice.
void count_shadow_ray(uint cluster, uint light, vec3 normal, bool reached) {
    if (scene.shadow_count_slots == 0u || is_gradient_pixel) return;
    uint slot = claim_shadow_slot(shadow_key(cluster, light, normal));
    if (slot == NONE) return;
    ShadowCountTable counts = ShadowCountTable(scene.shadow_counts);
    if (reached) atomicAdd(counts.at[slot].x, 1u);
    else atomicAdd(counts.at[slot].y, 1u);
}
