// What the three passes of direct lighting tell each other. Every texel has a slot for each shadow ray of a light sample; slots stand in the
// order in which their light is added up. Tables of slots have all texels of slot 0 first, then those of slot 1, so that threads side by
// side load side by side:
//
//     ends     xyz = where the ray ends, or its direction; w = end_word()
//     lights   the light that the ray brings if nothing is in its way: diffuse part in xy, specular part in zw (packed_light.glsl)
//     head     RayListHead of the list
//     list     slots that have a ray, in no particular order: the slot in the upper 4 bits, the texel in the lower 28
//     states   of each texel: STATE_*, a bit for each slot
//     shares   of each texel: the part of the specular light of its emissive triangle that bounce rays find, if shares_are_late()
//     sums     of each texel: the light of the samples before, with `samples` above 1
//
// "choose lights" fills them, "shadow rays" marks what is hidden, "direct lighting" adds up.
#include "channels.glsl"
#include "frame.glsl"
#include "glass.glsl"
#include "lights/light_sample.glsl"
#include "lights_records.glsl"
#include "pack.glsl"
#include "packed_light.glsl"
#include "random.glsl"
#include "ray_list.glsl"

layout(push_constant, scalar) uniform Push { DirectPush push; };
layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer ShadowRays { ShadowRayTables tables; };
layout(buffer_reference, scalar, buffer_reference_align = 16) buffer SlotTable { uvec4 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer StateTable { uint at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer ShareTable { float at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer RayList { uint at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) buffer SumTable { vec4 at[]; };
// Whether local lights have one candidate together.
layout(constant_id = 8) const bool merged_rays = true;

// The candidates of a light sample: one of each kind of light, and a direction that the surface reflects to the environment. Local lights are
// those of the two kinds before, as one.
const uint CANDIDATE_SUN = 0u, CANDIDATE_POSITIONAL = 1u, CANDIDATE_EMISSIVE = 2u, CANDIDATE_LOCAL = 3u, CANDIDATE_ENVIRONMENT = 4u,
           CANDIDATE_REFLECTION = 5u;
const uint CANDIDATES = 6u;
const uint CANDIDATE_DIMENSIONS[CANDIDATES] =
    uint[](DIM_SUN, DIM_POSITIONAL, DIM_EMISSIVE, DIM_LIGHT, DIM_ENVIRONMENT, DIM_REFLECTION);

const uint MAX_SLOTS = 5u;
uint slot_count() { return merged_rays ? 4u : 5u; }

uint slot_candidate(uint slot) {
    if (merged_rays) return slot == 0u ? CANDIDATE_SUN : slot + 2u;
    return slot < 3u ? slot : slot + 1u;
}

// The slot that may hold a sample of an emissive triangle.
bool is_emissive_slot(uint slot) { return slot_candidate(slot) == (merged_rays ? CANDIDATE_LOCAL : CANDIDATE_EMISSIVE); }

// With caustics photons carry the light of directional lights that smooth glass bends or mirrors. Shadow rays look for glass, which stops that light.
layout(constant_id = 11) const bool has_caustics = false;

bool is_caustic_slot(uint slot) { return has_caustics && slot_candidate(slot) == CANDIDATE_SUN; }
bool slot_looks_for_glass(uint slot) { return is_caustic_slot(slot) || glass_tints(push.glass_shadows); }
// What stops the ray of a slot, whatever it is made of.
uint slot_mask(uint slot) { return is_caustic_slot(slot) ? MASK_OPAQUE : push.mask; }

// Bounce rays leave the light behind glass alone: they do not go straight on. Where shadow rays are tinted, what bounce rays find is known
// after the rays have been traced.
bool shares_are_late() {
    return glass_tints(push.glass_shadows) && push.emission_share != EMISSION_SHARE_LIGHT_SAMPLES;
}

// First bits of the slots in the state of a texel.
// STATE_NEAR: its end says more than that the light is infinitely far away, a distance or a local light.
const uint STATE_TRACED = 0u, STATE_HIDDEN = 8u, STATE_GLASS = 16u, STATE_NEAR = 24u;

bool has_state(uint state, uint what, uint slot) { return (state >> (what + slot) & 1u) != 0u; }

const uint TEXEL_BITS = 28u;

// What an entry of the list names.
uint entry_slot(uint entry) { return entry >> TEXEL_BITS; }
uint entry_texel(uint entry) { return entry & ((1u << TEXEL_BITS) - 1u); }

const uint END_FINITE = 0x80000000u, END_LIGHT = 0x7fffffffu;

// `local`: the local light, or NONE.
uint end_word(bool finite, uint local) { return (finite ? END_FINITE : 0u) | (local & END_LIGHT); }
const uvec4 FAR_END = uvec4(0u, 0u, 0u, END_LIGHT);
uint end_light(uint word) { return (word & END_LIGHT) == END_LIGHT ? NONE : word & END_LIGHT; }

ShadowRayTables shadow_ray_tables() { return ShadowRays(push.shadow_rays).tables; }

ivec2 split_size() { return imageSize(ch_shading_position); }

uint texel_index(ivec2 p) { return uint(p.y * split_size().x + p.x); }

// Place of a slot in its table.
uint slot_place(uint slot, uint texel) { return slot * uint(split_size().x * split_size().y) + texel; }

uvec2 sample_key(ivec2 p) {
    uvec2 seed = imageLoad(ch_rng_seed, p).xy;
    return uvec2(seed.x, seed.y * push.samples + push.light_sample);
}

// The shadow ray of a slot of the texel at p, and the numbers that decide what covers it.
Ray slot_ray(ivec2 p, uvec4 end) {
    LightSample s = NO_LIGHT_SAMPLE;
    s.finite = (end.w & END_FINITE) != 0u;
    s.target = s.direction = uintBitsToFloat(end.xyz);
    return shadow_ray(imageLoad(ch_shading_position, p).xyz, unpack_unit_vector(imageLoad(ch_vertex_normal, p).x), s);
}

uvec2 slot_coverage(ivec2 p, uint slot) {
    if (!scene_has(FEATURE_COVERAGE)) return uvec2(0u);
    return random_coverage(sample_key(p), CANDIDATE_DIMENSIONS[slot_candidate(slot)]);
}
