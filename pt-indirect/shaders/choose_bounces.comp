// Draws the first ray of each path, for one of the lobes of the surface of the G-buffer; it carries light for all of them. Extent: split
// frame; with half_rows every other row, each in every other frame.
layout(local_size_x = 16, local_size_y = 8) in;
#include "first_surface.glsl"
#include "first_words.glsl"
#include "list_append.glsl"

// Whether bounces are reused for the surface: it draws directions above its whole horizon, and the light is not absorbed on its way.
bool takes_part(FirstSurface s) {
    return s.bsdf.local_wo.z > 0.0 && first_probabilities(s).diffuse > 0.0 && !is_inside(s.interior);
}

// Whether the path has a ray. `density`: of its direction, per solid angle; 0: it has none, -1: bounces are not reused for its surface.
bool begin_path(ivec2 p, uint index, out float density) {
    density = -1.0;
    vec4 position = imageLoad(ch_shading_position, p);
    uint material = floatBitsToUint(position.w);
    store_first(index, NO_PATH);
    if (material == 0u || (MaterialTable(scene.materials).at[material - 1u].flags & MATERIAL_UNLIT) != 0u) return false;
    FirstSurface s = load_first_surface(p, position);
    if (reuses_bounces && takes_part(s)) density = 0.0;
    FirstBounce first = first_bounce(s, random_numbers(imageLoad(ch_rng_seed, p).xy, DIM_INDIRECT));
    if (!(first.pdf > 0.0)) return false;
    uvec4 words = pack_first(FirstFactors(first.specular, first.diffuse, s.roughness, first.is_specular));
    if (!is_path(words)) return false;
    if (density == 0.0) density = first.pdf;
    store_first(index, words);
    WordTable(bounce_tables().first_directions).at[index] = pack_unit_vector(first.direction);
    BouncePath path;
    path.ray.origin = offset_point(s.position, s.bsdf.face_normal, scene.near_origin);
    path.ray.direction = first.direction;
    path.cone = vec2(s.cone.x, cone_angle(s.cone.y, first.pdf));
    path.flags = 0u;
    path.narrowness = narrowed(1.0, first.pdf);
    if (is_inside(s.interior)) {
        path.interior = s.interior;
        path.throughput = vec3(1.0);
        path.last_pdf = 0.0;
        path.passed = 0.0;
        store_path(index, path);
    } else {
        store_ray(index, path);
    }
    return true;
}

void main() {
    // No thread returns before the barriers.
    uvec2 launch = gl_GlobalInvocationID.xy;
    uint index = path_index(launch);
    ivec2 p = path_texel(index);
    bool inside = launch.x < push.width && all(lessThan(p, imageSize(ch_shading_position)));
    float density;
    bool has_ray = inside && begin_path(p, index, density);
    if (reuses_bounces && inside) store_reusable(index, vec4(vec3(0.0), density));
    uint place = append_to_list(list_head(LIST_RAYS, 0u), push.columns, has_ray);
    if (has_ray) list_entries(LIST_RAYS, 0u).at[place] = index;
}
