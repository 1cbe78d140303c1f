// Adds the light of the photons to the direct light: their irradiance E at the surface, reflected as if it came from their mean direction. A pixel
// looks up to half a cell away, so that cells blend into each other. Extent: split frame.
layout(local_size_x = 16, local_size_y = 8) in;
#include "caustics.glsl"
#include "shading_point.glsl"

// Most by which a bent normal makes a surface brighter.
const float MAX_TILT = 2.0;

// The light at the pixel's surface; E = 0: none.
void arriving_light(GridPlace place, out vec3 irradiance, out vec3 direction) {
    irradiance = direction = vec3(0.0);
    CausticCells cells = CausticCells(push.cells);
    for (uint i = 0u; i < MAX_PROBES; i++) {
        CausticCell cell = cells.at[(place.key + i) & push.cell_mask];
        if (cell.key == 0u) return;
        if (cell.key != place.key) continue;
        irradiance = vec3(cell.flux) * (place.scale * CausticHeads(push.head).head.flux_unit);
        direction = vec3(ivec3(cell.direction));
        return;
    }
}

// Mean distance of light (direct_lighting.glsl) with more of it from infinitely far.
vec4 with_distant(vec4 light, vec3 more) {
    float before = luminance(light.rgb), added = luminance(more);
    float inverse = (light.a > 0.0 ? before / light.a : 0.0) + added / SKY_DISTANCE;
    float distance = inverse > 0.0 ? min((before + added) / inverse, SKY_DISTANCE) : light.a;
    return vec4(light.rgb + more, distance);
}

void main() {
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(p, imageSize(ch_shading_position)))) return;
    vec4 position = imageLoad(ch_shading_position, p);
    if (floatBitsToUint(position.w) == 0u) return;
    uvec2 visible = imageLoad(ch_visibility, p).xy;
    vec3 normal = load_surface(visible.x, visible.y, imageLoad(ch_barycentrics, p).xy).face_normal;
    if (dot(normal, unpack_unit_vector(imageLoad(ch_view_direction, p).x)) > 0.0) normal = -normal;
    vec2 shift = random_numbers(imageLoad(ch_rng_seed, p).xy, DIM_CAUSTIC_PLACE).xy - 0.5;
    vec3 irradiance, direction;
    arriving_light(grid_place(position.xyz, normal, shift), irradiance, direction);
    if (max_component(irradiance) <= 0.0 || dot(direction, direction) <= 0.0) return;
    direction = normalize(direction);

    ShadingPoint s = load_shading_point(p, position);
    // E is that of the triangle; reflected() has the cosine to the shading normal.
    float cos_shading = dot(s.world_from_local[2], direction);
    BrdfValue f = reflected(s, direction);
    vec3 scaled = irradiance / max(dot(normal, direction), cos_shading / MAX_TILT);
    if (cos_shading <= 0.0) return;
    vec4 diffuse = with_distant(imageLoad(ch_color_hf, p), f.diffuse * scaled);
    vec3 demodulated = f.specular * scaled / demodulation(base_color_of(imageLoad(ch_base_color, p)), imageLoad(ch_metallic_roughness, p).x);
    vec4 specular = with_distant(imageLoad(ch_color_spec, p), demodulated);
    imageStore(ch_color_hf, p, diffuse);
    imageStore(ch_color_spec, p, specular);
}
