// Mirrors and glass: traces one more ray; the surface that it finds replaces the old one in the G-buffer. The first glass of a path
// is split over the checkerboard: one field reflects, the other refracts, each with twice its light, so that their mean is right;
// every other choice is drawn in proportion to the light that it carries. The last pass of a frame sees no transmissive instances,
// so that its ray ends on something that can be shaded; glass all the same (a mesh that is opaque elsewhere) and mirrors are shaded
// as regular surfaces then. Extent: split frame.
// reflect_refract.trace is the kernel; that of scenes with effects is reflect_refract_effects.trace.
// With `has_planes` the frame runs once for each lobe of that first glass instead (planes.glsl).
#include "frame.glsl"
#include "trace.glsl"
#include "camera.glsl"
#include "camera_view.glsl"
#include "checkerboard.glsl"
#include "random.glsl"
#include "smooth_surface.glsl"
#include "path_segment.glsl"
#include "highlight.glsl"
#include "gbuffer_records.glsl"

layout(push_constant, scalar) uniform Push { ReflectRefractPush push; };

const float MIRROR_METALLIC = 0.99;

#include "planes.glsl"
const uint NO_LOBE = 3u; // the path goes on from a camera whose view the surface shows

struct LobeChoice { uint lobe; float probability; };

LobeChoice choose_lobe(InterfaceLobes lobes, bool split, bool reflecting_field, float xi) {
    vec3 carried = vec3(luminance(lobes.reflection), luminance(lobes.transmission), luminance(lobes.diffuse));
    if (split) {
        if (reflecting_field) return LobeChoice(LOBE_REFLECTION, 0.5);
        float transmitted = carried.y / (carried.y + carried.z);
        return xi < transmitted ? LobeChoice(LOBE_TRANSMISSION, 0.5 * transmitted) : LobeChoice(LOBE_DIFFUSE, 0.5 - 0.5 * transmitted);
    }
    float total = carried.x + carried.y + carried.z;
    if (total <= 0.0 || xi * total < carried.x) return LobeChoice(LOBE_REFLECTION, total > 0.0 ? carried.x / total : 1.0);
    bool transmit = xi * total < carried.x + carried.y || carried.z <= 0.0;
    return transmit ? LobeChoice(LOBE_TRANSMISSION, carried.y / total) : LobeChoice(LOBE_DIFFUSE, carried.z / total);
}

// Share of the light of all lobes that one of them carries.
float lobe_share(InterfaceLobes lobes, vec3 lobe) {
    return luminance(lobe) / max(luminance(lobes.reflection + lobes.transmission + lobes.diffuse), 1e-20);
}

// Normal of the surface's triangle in the last frame, on the side of `s.face_normal`.
vec3 face_normal_prev(SeenSurface s) {
    InstanceRecord i = scene_instance(s.hit.instance);
    vec3 e1 = transform_vector(i.world_from_object_prev, transform_vector(i.object_from_world, s.geometry.e1));
    vec3 e2 = transform_vector(i.world_from_object_prev, transform_vector(i.object_from_world, s.geometry.e2));
    vec3 now = cross(s.geometry.e1, s.geometry.e2);
    return normalize(cross(e1, e2)) * sign(dot(now, s.face_normal));
}

vec3 mirrored(vec3 point, vec3 plane_point, vec3 normal) { return point - 2.0 * dot(point - plane_point, normal) * normal; }

// The vertex of the path after `from`. For the sky only the direction counts.
struct NextVertex { bool sky; vec3 direction; vec3 position; vec3 position_prev; float inverse_depth_range; };

// Where the camera sees what is found by way of `from`. A plane mirror shows an image behind it; what is seen through glass counts where it is.
// The latter needs a path without mirrors so far: then the G-buffer's depth is the distance of `from` itself. In all other cases the image of
// `from` stands for what is found.
const uint SEEN_AT_SURFACE = 0u, SEEN_THROUGH = 1u, SEEN_MIRRORED = 2u;

uint seen_where(float depth, bool first, SeenSurface from, uint lobe) {
    float from_depth = project(frame.camera, from.geometry.position).z;
    if (lobe == LOBE_TRANSMISSION && abs(abs(depth) - from_depth) < 1e-4 * from_depth) return SEEN_THROUGH;
    bool own_motion = (MaterialTable(scene.materials).at[from.geometry.material].flags & MATERIAL_OWN_MOTION) != 0u;
    bool plane_mirror = lobe == LOBE_REFLECTION && first && !own_motion && dot(from.normal, from.face_normal) > 0.99999;
    return plane_mirror ? SEEN_MIRRORED : SEEN_AT_SURFACE;
}

// A point in a plane mirror, now and in the last frame.
vec3 image_of(SeenSurface from, vec3 position) { return mirrored(position, from.geometry.position, from.face_normal); }
vec3 image_of_prev(SeenSurface from, vec3 position) { return mirrored(position, from.position_prev, face_normal_prev(from)); }

// Depth and motion of a replaced surface, both negative in depth.
void store_depth_and_motion(ivec2 p, bool first, SeenSurface from, uint lobe, NextVertex next) {
    float depth = imageLoad(ch_view_depth, p).x;
    vec4 motion = imageLoad(ch_motion, p);
    uint where = seen_where(depth, first, from, lobe);
    vec3 direction = next.direction, direction_prev = next.direction;
    vec3 position = next.position, position_prev = next.position_prev;
    if (where == SEEN_MIRRORED) {
        direction = reflect(direction, from.face_normal);
        direction_prev = reflect(direction_prev, face_normal_prev(from));
        position = image_of(from, position);
        position_prev = image_of_prev(from, position_prev);
    }
    if (where == SEEN_AT_SURFACE) {
        if (first) { depth = -depth; motion.z = -motion.z; }
        if (next.sky) depth = -SKY_DISTANCE;
    } else if (next.sky) {
        depth = -SKY_DISTANCE;
        motion.xyz = vec3(project_direction(frame.camera_prev, direction_prev) - project_direction(frame.camera, direction), 0.0);
    } else {
        vec3 now = project(frame.camera, position), before = project(frame.camera_prev, position_prev);
        depth = -now.z;
        motion.xyz = vec3(before.xy - now.xy, now.z - before.z);
    }
    motion.w = next.inverse_depth_range;
    imageStore(ch_view_depth, p, vec4(depth));
    imageStore(ch_motion, p, motion_code(motion));
}

bool is_replaced(MaterialRecord m, vec2 metallic_roughness, float specular) {
    if ((m.flags & MATERIAL_UNLIT) != 0u) return false;
    if (shows_camera(m)) return true;
    // What a pass has decided to shade: the diffuse base of a glass (see main).
    if (specular == 0.0 && metallic_roughness.y == 1.0) return false;
    // A black dielectric reflects like a mirror, but less; where specular is 0 not at all.
    bool is_coat = max_component(m.base_color.rgb) <= 0.0 && m.transmission == 0.0 && specular > 0.0;
    if (metallic_roughness.x >= MIRROR_METALLIC || is_coat) return metallic_roughness.y < push.mirror_roughness;
    return m.transmission > 0.0 && metallic_roughness.y <= push.glass_roughness;
}

// Blends the effects on the ray from `from` over what it meets. `share`: of the light of all lobes there, that of the ray's. `probability`: that the path took
// it. Before store_depth_and_motion(), as it looks at the depth of `from`.
void blend_effects(ivec2 p, bool first, SeenSurface from, uint lobe, Ray ray, float share, float probability, inout vec3 throughput, inout vec3 overlay);

void main() {
    ivec2 p = ivec2(launch_id());
    if (p.x >= 2 * int(frame.field_width) || p.y >= int(frame.size.y)) return;
    uvec2 visible = imageLoad(ch_visibility, p).xy;
    if (visible.x == NONE) { end_in_plane(p); return; }
    MaterialRecord m = MaterialTable(scene.materials).at[floatBitsToUint(imageLoad(ch_shading_position, p).w) - 1u];
    if (!is_replaced(m, imageLoad(ch_metallic_roughness, p).xy, base_color_of(imageLoad(ch_base_color, p)).a)) { end_in_plane(p); return; }

    uvec2 view = imageLoad(ch_view_direction, p).xy;
    vec3 direction = unpack_unit_vector(view.x);
    bool parted = has_parted(view.y);
    uint flags = has_planes ? view.y & ~FLAG_PARTED : view.y;
    vec4 throughput = imageLoad(ch_throughput, p);
    float path_length = exp2(throughput.a);
    float half_cone_angle = imageLoad(ch_bounce_throughput, p).a;
    uvec2 key = imageLoad(ch_rng_seed, p).xy;
    vec4 random = random_numbers(key, DIM_REFLECT_REFRACT + push.bounce);

    Hit hit = Hit(visible.x, visible.y, imageLoad(ch_barycentrics, p).xy, 0.0);
    float radius = cone_radius(frame.camera, half_cone_angle, path_length, frame.size.y);
    SeenSurface from = seen_surface(key, hit, direction, radius, push.lod_scale);
    InteriorList interior = EMPTY_INTERIOR;
    if (scene_has(FEATURE_TRANSMISSION)) interior = interior_of(imageLoad(ch_interior, p));
    bool solid = is_solid(m);
    float eta = surface_eta(interior, m.ior);
    if (solid) eta = medium_eta(interior_crossing(interior, medium_boundary(from.geometry.material), from.front));
    bool rough = from.material.roughness >= push.mirror_roughness;
    InterfaceLobes lobes = interface_lobes(from, m, direction, eta, solid, rough, push.double_refraction != 0u, random.yz);

    // What comes before the parting of the planes counts in plane 0.
    bool counts = !has_planes || push.plane == 0u || parted;
    vec4 overlay = counts ? imageLoad(ch_transparent, p) : vec4(0.0);
    uvec2 covered = random_coverage(key, DIM_REFLECT_REFRACT + push.bounce);
    if (rough && counts && m.transmission > 0.0 && push.light_kinds != 0u) {
        uvec4 bits = random_bits(key, DIM_HIGHLIGHT + push.bounce);
        overlay.rgb += throughput.rgb * highlight(from, direction, eta, push.light_kinds, random.w, bits, covered);
    }

    bool first = flags == FLAG_PRIMARY;
    bool odd_field = p.x >= int(frame.field_width);
    if (push.alternate_fields != 0u && (frame.frame_index & 1u) != 0u) odd_field = !odd_field;
    bool split = !has_planes && m.transmission > 0.0 && bitCount(flags) == 1 && max_component(lobes.reflection) > 0.0 &&
                 max_component(lobes.transmission + lobes.diffuse) > 0.0;
    LobeChoice choice = choose_lobe(lobes, split, !odd_field, random.x);
    CameraRay other;
    if (shows_camera(m)) {
        // Its back shows nothing: the surface is black.
        if (!from.front && (m.flags & MATERIAL_DOUBLE_SIDED) == 0u) { end_in_plane(p); return; }
        other = camera_view_ray(m, from.geometry);
        choice = LobeChoice(NO_LOBE, 1.0);
        lobes.transmitted = other.direction;
        lobes.transmission = vec3(1.0);
    }
    if (split) flags = FLAG_REFLECTION | FLAG_REFRACTION;
    else if (first && choice.lobe != LOBE_DIFFUSE) flags = choice.lobe == LOBE_REFLECTION ? FLAG_REFLECTION : FLAG_REFRACTION;
    if (has_planes) {
        bool leaves = !parted && push.plane > 0u && is_last_pass();
        if (!parted && parts_here(m, lobes, rough)) {
            choice = LobeChoice(push.plane, 1.0);
            flags = push.plane == LOBE_REFLECTION ? FLAG_REFLECTION : FLAG_REFRACTION;
            parted = true;
            leaves = lobe_light(lobes, push.plane) <= 0.0;
        }
        if (leaves) { leave_plane(p, view.x, flags, overlay); return; }
    }

    if (choice.lobe == LOBE_DIFFUSE) {
        // A Lambertian base, which is_replaced() knows by its values: the specular part is the reflection's.
        imageStore(ch_base_color, p, base_color_code(vec4(from.material.base_color, 0.0)));
        imageStore(ch_metallic_roughness, p, vec4(0.0, 1.0, 0.0, 0.0));
        imageStore(ch_view_direction, p, uvec4(view.x, handed_on(flags, parted), 0, 0));
        imageStore(ch_throughput, p, vec4(throughput.rgb * lobes.diffuse / choice.probability, throughput.a));
        imageStore(ch_transparent, p, overlay);
        return;
    }

    bool reflected = choice.lobe == LOBE_REFLECTION;
    vec3 onward = reflected ? lobes.reflected : lobes.transmitted;
    throughput.rgb *= (reflected ? lobes.reflection : lobes.transmission * lobes.spread) / choice.probability;
    vec3 side = reflected ? from.face_normal : -from.face_normal;
    Ray ray = Ray(offset_point(from.geometry.position, side, scene.near_origin), 0.0, onward, SKY_DISTANCE);
    if (choice.lobe == NO_LOBE) {
        ray.origin = other.origin;
        interior = EMPTY_INTERIOR;
    }
    if (solid && !reflected) interior = interior_cross(interior, medium_boundary(from.geometry.material), from.front);
    PathSegment segment;
    if ((push.mask & MASK_TRANSMISSIVE) != 0u) segment = trace_segment(ray, interior, push.mask, covered);
    else segment = trace_last_segment(ray, interior, push.mask, covered);
    hit = segment.hit;
    throughput.rgb *= segment.transmittance;
    ray.t_max = segment.reach;
    float share = lobe_share(lobes, reflected ? lobes.reflection : lobes.transmission);
    blend_effects(p, first, from, choice.lobe, ray, share, choice.probability, throughput.rgb, overlay.rgb);
    imageStore(ch_interior, p, segment.interior.words);

    imageStore(ch_view_direction, p, uvec4(pack_unit_vector(onward), handed_on(flags, parted), 0, 0));
    if (hit.instance == NONE) {
        throughput.a = log2(SKY_DISTANCE);
        store_no_surface(p);
        NextVertex sky = NextVertex(true, onward, vec3(0.0), vec3(0.0), 1.0 / SKY_DISTANCE);
        store_depth_and_motion(p, first, from, choice.lobe, sky);
        vec3 radiance = environment_radiance(onward);
        // Light samples find the sun by way of rough glass: see highlight().
        if (!rough || choice.lobe == NO_LOBE) radiance += disc_radiance(onward);
        overlay = vec4(overlay.rgb + throughput.rgb * radiance, 1.0);
    } else {
        path_length += segment.reach;
        throughput.a = log2(path_length);
        radius = cone_radius(frame.camera, half_cone_angle, path_length, frame.size.y);
        SeenSurface s = seen_surface(key, hit, onward, radius, push.lod_scale);
        store_surface(p, s);
        NextVertex next = NextVertex(false, onward, s.geometry.position, s.position_prev, s.inverse_depth_range);
        store_depth_and_motion(p, first, from, choice.lobe, next);
        overlay = vec4(overlay.rgb + throughput.rgb * s.overlay.rgb, s.overlay.a);
    }
    imageStore(ch_throughput, p, throughput);
    imageStore(ch_transparent, p, overlay);
}
