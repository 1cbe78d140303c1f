// Which part of the specular light of an emissive triangle bounce rays find (pt-indirect); direct lighting, which samples the triangles,
// takes the rest. Both stages call this with the same surface and the same point of the triangle: their parts add up to 1, so that no
// light is lost or counts twice, whichever sampler picks the lights. Diffuse light is direct lighting's alone.
//
// EMISSION_SHARE_MIS is the power heuristic (Veach 1997, section 9.2.2) for two densities that both stages can evaluate: that of a
// reflection at a visible normal, and that of a point of the triangle when lights are picked by their power. They make the weights
// alone: samples are divided by the densities with which they were drawn.
#include "bsdf/ggx.glsl"
#include "lights.glsl"

// `world_from_local`: frame of the shading normal; `view`: to the viewer, in it. `roughness`: perceptual, of the smoothest lobe.
// `light_pdf`: emissive_pdf().
float emission_bounce_share(uint share, mat3 world_from_local, vec3 view, vec3 direction, float roughness, float light_pdf) {
    if (share == EMISSION_SHARE_CROSSOVER) return 1.0 - smoothstep(0.16, 0.2, roughness);
    if (share != EMISSION_SHARE_MIS) return 0.0;
    vec3 l = direction * world_from_local;
    float bounce_pdf = l.z > 0.0 ? ggx_reflection_pdf(vec3(view.xy, max(view.z, 1e-4)), l, max(roughness * roughness, 1e-3)) : 0.0;
    return bounce_pdf > 0.0 ? 1.0 / (1.0 + square(light_pdf / bounce_pdf)) : 0.0;
}

// emissive_pdf() of a sample of the triangle with index `light`.
float emissive_sample_pdf(LightSample s, uint light, vec3 position) {
    LocalLightRecord l = local_light(light);
    vec3 area = cross(l.edge1, l.edge2);
    float twice_area = length(area);
    return emissive_pdf(light, twice_area, distance(s.target, position), abs(dot(area, s.direction)) / max(twice_area, 1e-30));
}
