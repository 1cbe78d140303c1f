// Third kernel of an iteration, the path tracer proper: paths from the camera with next event estimation and multiple importance sampling
// at every vertex (Veach 1997, chapter 9; Kajiya 1986), and Russian roulette (Arvo and Kirk 1990). Extent: the tile's slots.
#include "path_slots.glsl"
#include "path_append.glsl"
#include "path_sort.glsl"
#include "camera.glsl"
#include "camera_view.glsl"
#include "effects.glsl"
#include "path_lights.glsl"
#include "path_medium.glsl"
#include "film.glsl"

layout(local_size_x = SHADE_GROUP) in;

// The effects on the path's first ray from a rough surface that the camera sees: its specular lobes show them, its diffuse base does not. Returns what remains
// of the throughput. What light samples find has passed the effects, as shadow rays do not see them; the same light has to pass them here.
vec3 add_reflected_effects(PathState path, float chord, uint slot) {
    if (!scene_has(FEATURE_EFFECTS) || max_component(path.glossy) <= 0.0) return vec3(1.0);
    EffectsSeen effects = effects_along(path.origin - path.passed * path.direction, path.direction, chord);
    add_radiance(slot, path.throughput * path.glossy * effects.radiance);
    return 1.0 - path.glossy * (1.0 - effects.transmittance);
}

// The path's ray has left the scene. A camera ray brings nothing from a transparent background; its pixel counts it as not covered, because
// add_first_hit() has not been called for it.
void handle_miss(PathState path, uint slot) {
    if (background == BACKGROUND_TRANSPARENT && path.segment == 1u) return;
    add_reflected_effects(path, SKY_DISTANCE, slot);
    add_radiance(slot, path.throughput * medium_transmittance(path.interior, SKY_DISTANCE) * radiance_from_afar(path));
}

// Light that the surface itself emits. `left`: of the throughput, behind effects.
void add_emission(PathState path, PathVertex v, Hit hit, vec3 left, uint slot) {
    bool emits = v.front || (v.flags & MATERIAL_DOUBLE_SIDED) != 0u;
    if (push.emission == 0u || !emits || max_component(v.sampled.emission) <= 0.0) return;
    float light_pdf = 0.0;
    if (kind_on(KIND_EMISSIVE)) {
        uint index = emissive_index(hit.instance, hit.triangle);
        light_pdf = emissive_light_pdf(path, slot, index, v.twice_area, dot(v.face_normal, -path.direction));
    }
    if (light_pdf > 0.0) left = vec3(1.0);
    add_radiance(slot, path.throughput * left * v.sampled.emission * bsdf_sample_weight(path, light_pdf));
}

// Hands a shadow ray on to path_shadow.trace. `radiance`: what arrives if nothing is in its way.
void store_shadow_ray(inout PathState path, Ray ray, vec3 radiance, uint slot) {
    path.shadow_rays++;
    // Where media can change along the ray, path_shadow.trace takes care of them.
    if (scene_has(FEATURE_TRANSMISSION)) {
        straight_table(STRAIGHT_SOLIDS).at[slot] = uintBitsToFloat(path.interior.words);
        straight_table(STRAIGHT_IORS).at[slot] = path.interior.iors;
        straight_table(STRAIGHT_WAY).at[slot].y = uintBitsToFloat(push.max_bounces - path.vertex);
    }
    store_row(ROW_SHADOW_ORIGIN, slot, vec4(ray.origin, ray.t_max));
    store_row(ROW_SHADOW_DIRECTION, slot, ray.direction, path_coverage_seed(path.random, path.segment, 1u));
    store_row(ROW_SHADOW_RADIANCE, slot, vec4(path.throughput * radiance, 0.0));
}

// One sample of one light, whose kind `xi` chooses, and its shadow ray; false: there is none.
bool next_event(inout PathState path, PathVertex v, LightContext c, float xi, uint slot) {
    LightSample light = sample_light(c, xi, random_light(path.random, path.vertex));
    if (light.pdf <= 0.0 || push.strategy == STRATEGY_BSDF && !light.delta) return false;
    BsdfValue bsdf = bsdf_evaluate(v.bsdf, light.direction);
    float weight = light.delta ? 1.0 : light_sample_weight(light.pdf, bsdf.pdf);
    vec3 radiance = bsdf.f_cos * light.radiance * (weight / light.pdf);
    if (max_component(radiance) <= 0.0) return false;
    vec3 side = dot(v.face_normal, light.direction) > 0.0 ? v.face_normal : -v.face_normal;
    Ray ray = shadow_ray(v.position, side, light);
    store_shadow_ray(path, ray, radiance, slot);
    return true;
}

// Counts a bounce and draws whether the path goes on after it. `xi`: for Russian roulette.
bool goes_on(inout PathState path, float xi) {
    path.vertex++;
    if (path.vertex > push.roulette_start) {
        float survival = clamp(max_component(path.throughput), 0.05, 0.95);
        if (xi >= survival) return false;
        path.throughput /= survival;
    }
    return path.segment < MAX_RAYS;
}

// Part of f cos in the direction of a sample that is not the diffuse base.
vec3 specular_share(PathVertex v, BsdfSample s) {
    vec3 all = s.weight * s.pdf;
    vec3 diffuse = bsdf_diffuse_cos(v.bsdf, s.direction) * v.bsdf.base_color * ((1.0 - v.bsdf.metallic) * (1.0 - v.bsdf.transmission));
    return clamp(1.0 - diffuse / max(all, vec3(1e-20)), 0.0, 1.0);
}

// Chooses how the path goes on; false: it ends. `xi`: for Russian roulette.
bool scatter(inout PathState path, PathVertex v, LightContext c, float xi, uint slot) {
    BsdfSample s = bsdf_sample(v.bsdf, random_bsdf(path.random, path.vertex));
    if (s.pdf <= 0.0 || max_component(s.weight) <= 0.0) return false;
    path.throughput *= s.weight;
    bool transmitted = (s.flags & SAMPLE_TRANSMISSION) != 0u;
    // Light sampling finds what is straight behind a surface too: for its weight the path comes from the vertex before.
    bool straight = transmitted && interface_transmits_straight(v.bsdf);
    path.passed = straight ? path.chord : 0.0;
    path.direction = straight ? path.direction : s.direction;
    if (!straight) path.last_pdf = s.pdf;
    if (merged_lights && !straight) keep_light_context(slot, c);
    bool bounces = (path.flags & PATH_SEEN) != 0u && (s.flags & SAMPLE_DELTA) == 0u && path.vertex < push.max_bounces;
    path.glossy = scene_has(FEATURE_EFFECTS) && bounces ? specular_share(v, s) : vec3(0.0);
    // A sample stands for a solid angle of 1 / pdf (Bekaert et al. 2003, "A Custom Designed Density Estimation Method for Light
    // Transport"); mirrors are taken for plane.
    if ((s.flags & SAMPLE_DELTA) == 0u) path.cone.y = max(path.cone.y, inversesqrt(PI * s.pdf));
    if (!straight) path.flags = (s.flags & SAMPLE_DELTA) != 0u ? path.flags | PATH_DELTA : 0u;
    path.origin = offset_point(v.position, transmitted ? -v.face_normal : v.face_normal, scene.near_origin);
    if (transmitted) cross_interface(path, v);
    return goes_on(path, xi);
}

// The channel that goes on where dispersion parts the colours: each with the same probability, or the only one that is left.
uint parted_channel(PathState path) {
    bvec3 lit = greaterThan(path.throughput, vec3(0.0));
    if (lit.x && !lit.y && !lit.z) return 0u;
    if (!lit.x && !lit.y && lit.z) return 2u;
    if (!lit.x && lit.y && !lit.z) return 1u;
    return min(uint(3.0 * random_choices(path.random, path.vertex).z), 2u);
}

void keep_channel(inout PathState path, uint channel) {
    bvec3 lit = greaterThan(path.throughput, vec3(0.0));
    float others = float(lit.x) + float(lit.y) + float(lit.z) > 1.0 ? 3.0 : 1.0;
    vec3 kept = vec3(0.0);
    kept[channel] = others * path.throughput[channel];
    path.throughput = kept;
}

// What the camera ray sees, for denoisers: from the image's own rays, so that they find its antialiasing, depth of field and coverage.
void add_first_hit(PathVertex v, Hit hit, uint slot) {
    FirstHitTable table = FirstHitTable(push.first_hit);
    uint index = pixel_index(slot_pixel(slot));
    FirstHitPixel sum = table.at[index];
    vec3 before = previous_position(hit.instance, hit.triangle, hit.barycentrics);
    sum.albedo += v.sampled.base_color;
    sum.normal += v.bsdf.frame[2];
    sum.depth += hit.t;
    sum.motion += project(frame.camera_prev, before).xy - project(frame.camera, v.position).xy;
    sum.hits += 1.0;
    table.at[index] = sum;
}

// The path goes on from the camera whose view the surface shows, which counts as a bounce; false: it ends, and the surface is black. The camera is
// taken to be outside of all solids.
bool enter_view(inout PathState path, PathVertex v, MaterialRecord m, Hit hit) {
    if (path.vertex >= push.max_bounces || !(v.front || (v.flags & MATERIAL_DOUBLE_SIDED) != 0u)) return false;
    CameraRay view = camera_view_ray(m, load_surface(hit.instance, hit.triangle, hit.barycentrics));
    path.origin = view.origin;
    path.direction = view.direction;
    path.interior = EMPTY_INTERIOR;
    path.passed = 0.0;
    return goes_on(path, random_choices(path.random, path.vertex).y);
}

// The path's ray has met a surface; false: the path ends there. `shadow`: whether it has a shadow ray.
bool handle_hit(inout PathState path, Hit hit, uint slot, out bool shadow) {
    shadow = false;
    path.chord = path.passed + hit.t;
    path.cone.x += hit.t * path.cone.y;
    path.throughput *= medium_transmittance(path.interior, hit.t);
    uint channel = parted_channel(path);
    PathVertex v = load_vertex(path, hit, channel);
    if (v.disperses) keep_channel(path, channel);
    if (path.segment == 1u) add_first_hit(v, hit, slot);
    if (v.is_passed) {
        path.origin = offset_point(v.position, -v.face_normal, scene.near_origin);
        path.passed = path.chord;
        cross_interface(path, v);
        return path.segment < MAX_SEGMENTS;
    }
    vec3 left = add_reflected_effects(path, path.chord, slot);
    if ((v.flags & MATERIAL_UNLIT) != 0u) {
        // Has the colour that the camera sees, in mirrors too, and lights nothing.
        if ((path.flags & PATH_SEEN) != 0u && push.emission != 0u) add_radiance(slot, path.throughput * v.sampled.base_color);
        return false;
    }
    MaterialRecord m = MaterialTable(scene.materials).at[v.material];
    if (shows_camera(m) && (path.flags & PATH_SEEN) != 0u) return enter_view(path, v, m, hit);
    add_emission(path, v, hit, left, slot);
    path.throughput *= left;
    if (path.vertex > push.max_bounces) return false;
    vec3 xi = random_choices(path.random, path.vertex);
    LightContext c = light_context(v);
    if (!bsdf_is_delta(v.bsdf)) shadow = next_event(path, v, c, xi.x, slot);
    return scatter(path, v, c, xi.y, slot);
}

// The medium has scattered the path's ray, which ends it; false: without a shadow ray.
bool scatter_in_medium(inout PathState path, float t, uint slot) {
    Ray ray;
    vec3 radiance;
    if (!scattered_light(path, t, ray, radiance)) return false;
    store_shadow_ray(path, ray, radiance, slot);
    return true;
}

// The effects that the path's ray has passed, seen by the camera, perhaps in a mirror.
void add_effects(inout PathState path, float reach, uint slot) {
    if (!scene_has(FEATURE_EFFECTS) || (path.flags & PATH_SEEN) == 0u) return;
    EffectsSeen effects = effects_along(path.origin, path.direction, reach);
    add_radiance(slot, path.throughput * effects.radiance);
    path.throughput *= effects.transmittance;
}

struct Onward { bool path, shadow; };

// Which rays the slot has next.
Onward shade(uint slot) {
    PathState path = load_path(slot);
    Hit hit = load_hit(slot);
    // Here and not where the sample begins: light that waits for a shadow ray is written to the same sectors of memory.
    if (path.segment == 0u) store_row(ROW_RADIANCE, slot, vec4(0.0));
    path.segment++;
    Onward onward = Onward(false, false);
    float reach = hit.instance == NONE ? SKY_DISTANCE : hit.t, t;
    bool scattered = is_scattered(path, reach, t);
    add_effects(path, scattered ? t : reach, slot);
    if (scattered) onward.shadow = scatter_in_medium(path, t, slot);
    else if (hit.instance == NONE) handle_miss(path, slot);
    else onward.path = handle_hit(path, hit, slot, onward.shadow);
    if (onward.path) {
        store_path(slot, path);
    } else {
        path.flags |= PATH_ENDED;
        store_end(slot, path);
    }
    return onward;
}

void main() {
    uint place = gl_GlobalInvocationID.x;
    uint slot = slot_at(place, list_read());
    if (sort_materials) slot = sort_by_material(slot);
    Onward onward = Onward(false, false);
    if (slot != NONE) onward = shade(slot);
    append_slot(slot, list_written(), onward.path);
    append_slot(slot, LIST_SHADOW, onward.shadow);
}
