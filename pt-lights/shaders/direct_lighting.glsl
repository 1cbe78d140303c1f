// One pixel of the direct lighting pass. For a candidate at direction l with density pdf, of unshadowed radiance L, the estimate of
// the reflected light is f(l) L cos / pdf (one-sample Monte Carlo), with the BRDF's parts kept apart: color_hf gets the diffuse
// part without the albedo, color_spec the specular part divided by demodulation(F0). A kernel that includes this must define
// trace_occluded(Ray, uint, uvec2).
#include "channels.glsl"
#include "frame.glsl"
#include "brdf.glsl"
#include "lights.glsl"
#include "pack.glsl"
#include "random.glsl"
#include "lights_records.glsl"

layout(push_constant, scalar) uniform Push { DirectPush push; };

struct ShadingPoint {
    vec3 position;
    vec3 vertex_normal;
    vec3 view;          // towards the viewer, in the frame of the shading normal
    mat3 world_from_local;
    Brdf brdf;
};

ShadingPoint load_shading_point(ivec2 p, vec3 position) {
    ShadingPoint s;
    s.position = position;
    s.vertex_normal = unpack_unit_vector(imageLoad(ch_vertex_normal, p).x);
    s.world_from_local = basis_around(unpack_unit_vector(imageLoad(ch_normal, p).x));
    s.view = -unpack_unit_vector(imageLoad(ch_view_direction, p).x) * s.world_from_local;
    // The normal is on the viewer's side; what its 16 bits round below the horizon is lifted to grazing.
    s.view.z = max(s.view.z, 1e-4);
    vec2 metallic_roughness = imageLoad(ch_metallic_roughness, p).xy;
    s.brdf = make_brdf(imageLoad(ch_base_color, p), metallic_roughness.x, metallic_roughness.y);
    return s;
}

// Adds a candidate's light. A direction counts when it is above the horizon of both normals.
void add_light(ShadingPoint s, LightSample light, uvec2 ray_coverage, inout BrdfValue sum) {
    if (light.pdf <= 0.0 || dot(s.vertex_normal, light.direction) <= 0.0) return;
    vec3 l = light.direction * s.world_from_local;
    if (l.z <= 0.0 || max_component(light.radiance) <= 0.0) return;
    if (trace_occluded(shadow_ray(s.position, s.vertex_normal, light), push.mask, ray_coverage)) return;
    BrdfValue f = brdf_eval(s.brdf, s.view, l);
    vec3 weight = light.radiance * (l.z / light.pdf);
    sum.diffuse += f.diffuse * weight;
    sum.specular += f.specular * weight;
}

void direct_lighting(ivec2 p) {
    BrdfValue sum = BrdfValue(vec3(0.0), vec3(0.0));
    vec4 position = imageLoad(ch_shading_position, p);
    if (floatBitsToUint(position.w) == 0u) {
        imageStore(ch_color_hf, p, vec4(0.0));
        imageStore(ch_color_spec, p, vec4(0.0));
        return;
    }
    ShadingPoint s = load_shading_point(p, position.xyz);
    uvec2 key = imageLoad(ch_rng_seed, p).xy;
    if ((push.kinds & KIND_SUN) != 0u) {
        add_light(s, sample_sun(random_bits(key, DIM_SUN)), random_coverage(key, DIM_SUN), sum);
    }
    if ((push.kinds & KIND_POSITIONAL) != 0u) {
        LightSample light = sample_positional(s.position, random_bits(key, DIM_POSITIONAL));
        add_light(s, light, random_coverage(key, DIM_POSITIONAL), sum);
    }
    if ((push.kinds & KIND_EMISSIVE) != 0u) {
        LightSample light = sample_emissive(s.position, random_bits(key, DIM_EMISSIVE));
        add_light(s, light, random_coverage(key, DIM_EMISSIVE), sum);
    }
    if ((push.kinds & KIND_ENVIRONMENT) != 0u) {
        LightSample light = sample_environment(random_bits(key, DIM_ENVIRONMENT));
        add_light(s, light, random_coverage(key, DIM_ENVIRONMENT), sum);
    }
    imageStore(ch_color_hf, p, vec4(sum.diffuse, 0.0));
    imageStore(ch_color_spec, p, vec4(sum.specular / demodulation(s.brdf.f0), 0.0));
}
