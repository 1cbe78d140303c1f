// What the rays of the paths have met: its emission, one light sample (next event estimation) and the next ray. Emission and light samples are
// combined by multiple importance sampling where both can find a light (Veach 1997, section 9.2). Extent: the list of rays.
#include "bounce_emission.glsl"
#include "bounce_light.glsl"
#include "first_words.glsl"
#include "list_append.glsl"
#include "lights/emission_share.glsl"

layout(local_size_x = RAY_LIST_SHADING_GROUP) in;

// No ray looks for lights from the next vertex, but for what delta lobes show.
layout(constant_id = 8) const bool last_vertex = false;

// The emission that the first ray meets is direct light, which direct lighting samples: it counts where that leaves it.
void store_first_light(uint index, ivec2 p, BouncePath path, Emission met, float reach) {
    vec3 specular = vec3(0.0), light = vec3(0.0);
    met.radiance = without_fireflies(met.radiance, 1.0, path.narrowness);
    if (max_component(met.radiance) > 0.0) {
        if (met.is_sampled) {
            mat3 world_from_local = basis_around(unpack_unit_vector(imageLoad(ch_normal, p).x));
            vec3 view = -unpack_unit_vector(imageLoad(ch_view_direction, p).x) * world_from_local;
            float roughness = unpack_first(load_first(index)).roughness;
            vec3 direction = path.ray.direction;
            specular = emission_bounce_share(push.emission_share, world_from_local, view, direction, roughness, met.light_pdf) * met.radiance;
        } else {
            light = met.radiance;
        }
    }
    if (reuses_bounces) {
        store_reusable(index, vec4(light, load_reusable(index).w));
        light = vec3(0.0);
    }
    store_light(index, vec4(light, reach));
    PairTable(bounce_tables().reflected).at[index] = pack_light(specular);
}

// Draws the next ray; false: the path ends. `radius`: of the cone at the vertex. `share`: what of the light that it brings can be reused, if bounces
// are.
bool scatter(inout BouncePath path, BounceVertex v, uvec2 key, uint vertex, float radius, out vec3 share) {
    share = vec3(0.0);
    // The light samples of the last vertex have found everything but what a delta lobe shows.
    if (last_vertex && !bsdf_has_delta(v.bsdf)) return false;
    vec4 xi = random_numbers(key, bounce_dimension(vertex, BOUNCE_DIRECTION));
    BsdfSample s;
    if (last_vertex) s = bsdf_draw(v.bsdf, xi);
    else s = bsdf_sample(v.bsdf, xi);
    bool delta = (s.flags & SAMPLE_DELTA) != 0u, transmitted = (s.flags & SAMPLE_TRANSMISSION) != 0u;
    if (!(s.pdf > 0.0) || !(max_component(s.weight) > 0.0) || last_vertex && !delta) return false;
    path.throughput *= s.weight;
    if (reuses_bounces && !delta && !transmitted) share = least_diffuse_share(v.bsdf, s.direction, s.weight * s.pdf);
    // Light samples of the vertex before have gone straight on through this one, if there were any: not of a delta lobe.
    if (transmitted && is_passed(v)) path.flags = (path.flags & PATH_DELTA) != 0u ? PATH_DELTA : PATH_COVERED;
    else path.flags = delta ? PATH_DELTA : 0u;
    if (transmitted) {
        if (v.solid) path.interior = interior_cross(path.interior, medium_boundary(v.material), v.front);
    }
    path.last_pdf = s.pdf;
    path.passed = 0.0;
    if (!delta) path.narrowness = narrowed(path.narrowness, s.pdf);
    path.cone = vec2(radius, delta ? path.cone.y : cone_angle(path.cone.y, s.pdf));
    vec3 side = transmitted ? -v.bsdf.face_normal : v.bsdf.face_normal;
    path.ray.origin = offset_point(v.position, side, scene.near_origin);
    path.ray.direction = s.direction;
    if (vertex <= push.roulette_start) return true;
    // Russian roulette (Arvo and Kirk 1990).
    float survival = clamp(max_component(path.throughput), 0.05, 0.95);
    path.throughput /= survival;
    return bounce_choices(key, vertex).y < survival;
}

const Emission NO_EMISSION = Emission(vec3(0.0), false, 0.0);

// x: whether the path has a next ray, y: whether it has a shadow ray.
bvec2 shade(uint index) {
    ivec2 p = path_texel(index);
    bool first = push.vertex == 0u;
    uvec2 key = imageLoad(ch_rng_seed, p).xy;
    begin_choices(key, frame.frame_index);
    BouncePath path = load_path(index);
    Hit hit = load_hit(index);
    if (hit.instance == NONE) {
        if (first) store_first_light(index, p, path, NO_EMISSION, SKY_DISTANCE);
        else if (hit.triangle == NONE) {
            vec3 light = path.throughput * medium_transmittance(path.interior, SKY_DISTANCE) * radiance_from_afar(path);
            add_light(index, without_fireflies(light, 1.0, path.narrowness));
        }
        return bvec2(false);
    }
    BounceVertex v = load_bounce_vertex(path, hit, bounce_texture_random(key, push.vertex + 1u));
    path.throughput *= medium_transmittance(v.medium, v.distance);
    float chord = path.passed + v.distance;
    bool unlit = (v.flags & MATERIAL_UNLIT) != 0u;
    Emission met = NO_EMISSION;
    if (!unlit) met = met_emission(path, v, hit, chord);
    met.radiance *= path.throughput;
    if (first) store_first_light(index, p, path, met, chord);
    else if (max_component(met.radiance) > 0.0) {
        float weight = ray_weight(path, met.light_pdf * kind_pmf());
        add_light(index, weight * without_fireflies(met.radiance, weight, path.narrowness));
    }
    if (unlit || push.vertex == push.bounces) return bvec2(false);

    uint vertex = push.vertex + 1u;
    float reach = chord;
    if (!first && push.sun_range > 0.0) reach = load_light(index).w;
    ShadowPath shadow;
    float light_pdf;
    vec3 sampled_share, later_share;
    bool lit = light_at(v, key, vertex, last_vertex, reach, shadow, light_pdf, sampled_share);
    if (lit) {
        shadow.light = without_fireflies(path.throughput * shadow.light, shadow.weight, narrowed(path.narrowness, light_pdf));
        store_shadow(index, shadow);
    }
    bool goes_on = scatter(path, v, key, vertex, v.radius, later_share);
    if (reuses_bounces && first) {
        RowTable(bounce_tables().points).at[index] = uvec4(floatBitsToUint(v.position), pack_unit_vector(v.bsdf.face_normal));
        store_shares(index, sampled_share, later_share, reusable_cosine(v));
    }
    if (goes_on) store_path(index, path);
    return bvec2(goes_on, lit);
}

void main() {
    uint place = (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * RAY_LIST_SHADING_GROUP + gl_LocalInvocationIndex;
    // No thread returns before the barriers.
    uint index = listed_path(LIST_RAYS, place);
    bvec2 listed = bvec2(false);
    if (index != NONE) listed = shade(index);
    uint shadow_place = append_to_list(list_head(LIST_SHADOW_RAYS, push.vertex), push.columns, listed.y);
    if (listed.y) list_entries(LIST_SHADOW_RAYS, push.vertex).at[shadow_place] = index;
    uint next = push.vertex + 1u;
    uint ray_place = append_to_list(list_head(LIST_RAYS, next), push.columns, listed.x);
    if (listed.x) list_entries(LIST_RAYS, next).at[ray_place] = index;
}
