// The shadow ray of a path.
#include "bounce_path.glsl"
#include "channels.glsl"

struct ShadowPath {
    Ray ray;
    vec3 light;   // that it brings if nothing is in its way
    float weight; // of multiple importance sampling; 1 where glass tints the light
};

void store_shadow(uint index, ShadowPath s) {
    BounceTables tables = bounce_tables();
    RowTable(tables.shadow_origins).at[index] = floatBitsToUint(vec4(s.ray.origin, s.ray.t_max));
    RowTable(tables.shadow_directions).at[index] = floatBitsToUint(vec4(s.ray.direction, s.weight));
    PairTable(tables.shadow_lights).at[index] = pack_light(s.light);
}

Ray path_shadow_ray(uint index) {
    vec4 origin = uintBitsToFloat(RowTable(bounce_tables().shadow_origins).at[index]);
    vec4 direction = uintBitsToFloat(RowTable(bounce_tables().shadow_directions).at[index]);
    return Ray(origin.xyz, 0.0, direction.xyz, origin.w);
}

float shadow_weight(uint index) { return uintBitsToFloat(RowTable(bounce_tables().shadow_directions).at[index].w); }
vec3 shadow_light(uint index) { return unpack_light(PairTable(bounce_tables().shadow_lights).at[index]); }

uvec2 shadow_coverage(uint index) {
    if (!scene_has(FEATURE_COVERAGE)) return uvec2(0u);
    return bounce_coverage(imageLoad(ch_rng_seed, path_texel(index)).xy, push.vertex + 1u, BOUNCE_SHADOW_RAY);
}
