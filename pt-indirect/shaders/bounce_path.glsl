// What the passes of indirect lighting tell each other. Every texel whose light is traced in a frame has a path, with a place in each table;
// threads side by side load side by side. A pass does one step for all paths that a list names:
//
//     origins        uvec4: where the ray begins; w = radius of its cone there, metres
//     directions     uvec4: its direction; w = half angle of its cone (fp16), PATH_* above, narrowness of the path (13 bits) above that
//     throughputs    uvec4: throughput of the path without the first scattering; w = last_pdf. From the second ray on, and if PATH_INSIDE
//     solids         uvec4: the solids that the ray begins in, if PATH_INSIDE
//     passed         float: way since the last scattering up to the ray's origin, metres, if PATH_INSIDE
//     hits           uvec4: instance, triangle and barycentrics of what the ray meets; in the memory of shadow_origins
//     firsts         first_word(): what the surface of the G-buffer does with the light of the path; all 0: there is no path
//     first_directions   direction of the first ray (pack_unit_vector)
//     lights         uvec4: light that has come along the first ray, by all that reflects it; w = length of that ray, metres
//     reflected      packed_light.glsl: more light of which only the specular lobes give
//     shadow_origins     uvec4: where the shadow ray begins; w = its length
//     shadow_directions  uvec4: its direction; w = weight of its light where no glass tints it
//     shadow_lights      packed_light.glsl: light that it brings if nothing is in its way
//     heads          RayListHead of each list of each vertex
//
// and where bounces are reused (reused_bounce.glsl):
//
//     reusable       uvec4: light that has come along the first ray and can be reused, not among `lights`; w = density per solid angle of the first
//                    ray, 0: it has no light, -1: its surface takes no part
//     shares         uvec4: shares of light that can be reused, of the light sample of the first vertex and of what comes later (6 x 16 bit unorm); w =
//                    reusable_cosine() of that vertex
//     points         uvec4: position of that vertex, w = normal of its triangle (pack_unit_vector); after the reuse: the light that the surface gets
//                    (packed_light.glsl), its direction, and its distance
//
// "choose bounces" begins the paths; for each vertex "bounce rays" finds what they meet, "bounce lights" shades that and draws the next rays,
// "bounce shadow rays" and "bounce glass" add the light of the samples; "indirect lighting" gives it to the channels.
#include "bounce_random.glsl"
#include "frame.glsl"
#include "indirect_push.glsl"
#include "media.glsl"
#include "pack.glsl"
#include "packed_light.glsl"
#include "ray_list.glsl"
#include "ray_offset.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer Bounces { BounceTables tables; };
layout(buffer_reference, scalar, buffer_reference_align = 16) buffer RowTable { uvec4 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) buffer PairTable { uvec2 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer WordTable { uint at[]; };

// Whether bounces are reused.
layout(constant_id = 9) const bool reuses_bounces = false;

// Light samples at the last vertex cannot find what the ray meets.
const uint PATH_DELTA = 1u;
// They have found it already: they go straight on through glass (`lights.glass_shadows`).
const uint PATH_COVERED = 2u;
// The list of solids is not empty.
const uint PATH_INSIDE = 4u;

struct BouncePath {
    Ray ray;
    vec3 throughput;
    float last_pdf;   // density per solid angle with which the direction was drawn
    uint flags;       // PATH_*
    vec2 cone;        // radius at the origin, metres, and half angle
    float narrowness; // narrowed() by each of its scatterings
    float passed;     // way since the last scattering up to the origin, metres
    InteriorList interior;
};

BounceTables bounce_tables() { return Bounces(push.tables).tables; }

// The place of a texel of the launch over the frame, and the texel of the split frame at a place.
uint path_index(uvec2 launch) { return launch.y * push.width + launch.x; }
ivec2 path_texel(uint index) {
    ivec2 p = ivec2(index % push.width, index / push.width);
    // The row beside it is traced in the next frame.
    if (push.half_rows != 0u) p.y = 2 * p.y + int(frame.frame_index & 1u);
    return p;
}

// Lists of paths: those with a ray, those with a shadow ray, those whose shadow ray meets glass.
const uint LIST_RAYS = 0u, LIST_SHADOW_RAYS = 1u, LIST_GLASS = 2u;

RayListCount list_head(uint list, uint vertex) {
    return RayListCount(bounce_tables().heads + uint64_t((vertex * BOUNCE_LISTS + list) * RAY_LIST_HEAD_BYTES));
}

WordTable list_entries(uint list, uint vertex) {
    BounceTables tables = bounce_tables();
    if (list == LIST_SHADOW_RAYS) return WordTable(tables.shadow_list);
    // Those with glass are listed when the rays of their vertex are done, in the place of their list.
    return WordTable((vertex & 1u) == 0u ? tables.even_list : tables.odd_list);
}

// NONE past the end.
uint listed_path(uint list, uint place) {
    return place < list_head(list, push.vertex).head.count ? list_entries(list, push.vertex).at[place] : NONE;
}

Hit load_hit(uint index) {
    uvec4 row = RowTable(bounce_tables().hits).at[index];
    return Hit(row.x, row.y, uintBitsToFloat(row.zw), 0.0);
}

void store_hit(uint index, Hit hit) {
    RowTable(bounce_tables().hits).at[index] = uvec4(hit.instance, hit.triangle, floatBitsToUint(hit.barycentrics));
}

Ray path_ray(uvec4 origin, uvec4 direction) {
    return Ray(uintBitsToFloat(origin.xyz), 0.0, uintBitsToFloat(direction.xyz), SKY_DISTANCE);
}

Ray load_path_ray(uint index) {
    return path_ray(RowTable(bounce_tables().origins).at[index], RowTable(bounce_tables().directions).at[index]);
}

// Of the last word of its direction.
uint path_flags(uint word) { return word >> 16u & 7u; }

bool is_path_inside(uint index) { return (path_flags(RowTable(bounce_tables().directions).at[index].w) & PATH_INSIDE) != 0u; }

BouncePath load_path(uint index) {
    BounceTables tables = bounce_tables();
    uvec4 origin = RowTable(tables.origins).at[index], direction = RowTable(tables.directions).at[index];
    BouncePath path;
    path.ray = path_ray(origin, direction);
    path.cone = vec2(uintBitsToFloat(origin.w), unpackHalf2x16(direction.w).x);
    path.flags = path_flags(direction.w);
    path.narrowness = float(direction.w >> 19u) / 8191.0;
    path.throughput = vec3(1.0);
    path.last_pdf = 0.0;
    if (push.vertex > 0u || scene_has(FEATURE_TRANSMISSION) && (path.flags & PATH_INSIDE) != 0u) {
        uvec4 throughput = RowTable(tables.throughputs).at[index];
        path.throughput = uintBitsToFloat(throughput.xyz);
        path.last_pdf = uintBitsToFloat(throughput.w);
    }
    path.interior = EMPTY_INTERIOR;
    path.passed = 0.0;
    if (scene_has(FEATURE_TRANSMISSION) && (path.flags & PATH_INSIDE) != 0u) {
        path.interior = interior_of(RowTable(tables.solids).at[index]);
        path.passed = uintBitsToFloat(WordTable(tables.passed).at[index]);
    }
    return path;
}

// Of a first ray that begins in no solid: with a throughput of 1.
void store_ray(uint index, BouncePath path) {
    BounceTables tables = bounce_tables();
    RowTable(tables.origins).at[index] = floatBitsToUint(vec4(path.ray.origin, path.cone.x));
    uint word = packHalf2x16(vec2(min(path.cone.y, 65504.0), 0.0)) | path.flags << 16u | uint(path.narrowness * 8191.0 + 0.5) << 19u;
    RowTable(tables.directions).at[index] = uvec4(floatBitsToUint(path.ray.direction), word);
}

void store_path(uint index, BouncePath path) {
    BounceTables tables = bounce_tables();
    path.flags &= ~PATH_INSIDE;
    if (is_inside(path.interior)) {
        path.flags |= PATH_INSIDE;
        RowTable(tables.solids).at[index] = path.interior.words;
        WordTable(tables.passed).at[index] = floatBitsToUint(path.passed);
    }
    store_ray(index, path);
    RowTable(tables.throughputs).at[index] = floatBitsToUint(vec4(path.throughput, path.last_pdf));
}

// What the path brings, before the surface of the G-buffer reflects it.
vec4 load_light(uint index) { return uintBitsToFloat(RowTable(bounce_tables().lights).at[index]); }
void store_light(uint index, vec4 light) { RowTable(bounce_tables().lights).at[index] = floatBitsToUint(light); }

// What of it can be reused, and the density of the first ray.
vec4 load_reusable(uint index) { return uintBitsToFloat(RowTable(bounce_tables().reusable).at[index]); }
void store_reusable(uint index, vec4 light) { RowTable(bounce_tables().reusable).at[index] = floatBitsToUint(light); }

// `sampled`: of the light sample of the first vertex, `later`: of the rest of the path.
void store_shares(uint index, vec3 sampled, vec3 later, float least_cosine) {
    RowTable(bounce_tables().shares).at[index] =
        uvec4(packUnorm2x16(sampled.xy), packUnorm2x16(vec2(sampled.z, later.x)), packUnorm2x16(later.yz), floatBitsToUint(least_cosine));
}

// Share of the light that this pass adds.
vec3 reusable_share(uint index) {
    uvec3 words = RowTable(bounce_tables().shares).at[index].xyz;
    vec2 middle = unpackUnorm2x16(words.y);
    return push.vertex == 0u ? vec3(unpackUnorm2x16(words.x), middle.x) : vec3(middle.y, unpackUnorm2x16(words.z));
}

void add_light(uint index, vec3 light) {
    if (reuses_bounces) {
        vec3 part = reusable_share(index) * light;
        store_reusable(index, load_reusable(index) + vec4(part, 0.0));
        light -= part;
    }
    store_light(index, load_light(index) + vec4(light, 0.0));
}

// The cone of a ray is as wide as the solid angle that the sample stands for, 1 / pdf (Bekaert et al. 2003), times push.texture_spread^2.
float cone_angle(float before, float pdf) { return max(before, push.texture_spread * inversesqrt(PI * pdf)); }

// A sample of density `pdf` stands for the solid angle 1 / pdf, and that for a cone: where its half angle, by the same approximation, is above 1
// radian, the path is the less narrow by it.
float narrowed(float before, float pdf) { return before * min(1.0, sqrt(PI * pdf)); }

// What the knob `firefly` leaves of light that a path brings with a weight: its mean over the channels is at most the knob times the narrowness.
vec3 without_fireflies(vec3 light, float weight, float narrowness) {
    float limit = push.firefly * narrowness, mean = weight * dot(light, vec3(1.0 / 3.0));
    return push.firefly > 0.0 && mean > limit ? light * (limit / mean) : light;
}

// Solids that a ray has come through when it meets a boundary: a path may have begun inside of a solid, which the G-buffer does not tell, but
// the solid's back.
InteriorList interior_before(InteriorList interior, Crossing c) {
    return c.here.word == interior_top(interior).word ? interior : interior_add(EMPTY_INTERIOR, c.here);
}

// A ray's number for partial coverage. `vertex`: whose decision the ray follows from.
uvec2 bounce_coverage(uvec2 key, uint vertex, uint decision) {
    return scene_has(FEATURE_COVERAGE) ? random_coverage(key, bounce_dimension(vertex, decision)) : uvec2(0u);
}
