// Local lights (emissive triangles, quads of the environment, point and spot lights) from a shading point: how much one may contribute, and
// a sample of it.
// All have an index in one table (LocalLightRecord); the tables are made each frame, from where the lights are then.
#include "lights/light_sample.glsl"
#include "lights/environment_quads.glsl"
#include "lights/light_candidate.glsl"
#include "lights/light_tables.glsl"
#include "sampling.glsl"
#include "lights/triangle_sampling.glsl"

// What samplers know of a shading point. All that is used of the material is its roughness and how much of it is specular.
struct LightContext {
    vec3 position;
    vec3 normal;     // of shading, on the viewer's side
    vec3 view;       // unit, to the viewer
    uint cluster;    // cluster_of(position)
    float roughness;
    float specular;  // share of the specular lobe, 0 to 0.9
    uint64_t tile;   // address of the NeeAtTile that has learned about the point's lights, 0: none
};

LocalLightRecord local_light(uint light) { return LocalLightTable(scene.light_tables.local_lights).at[light]; }

// The light as choices see it.
LocalLightRecord choice_light(uint light) { return LocalLightTable(choice_tables().local_lights).at[light]; }

// KIND_* bit of a local light.
uint kind_of_light(uint light) {
    if (light < scene.emissive_count) return KIND_EMISSIVE;
    return environment_is_listed() && light < first_positional_light() ? KIND_ENVIRONMENT : KIND_POSITIONAL;
}

// Probability with which the power distribution picks a light.
float power_pmf(uint light) { return AliasTable(choice_tables().local_alias).at[light].pmf; }

// Solid angle of a triangle with first corner `a`, as seen from the origin: Van Oosterom and Strackee 1983, eq. 8. In fewer steps than
// triangle_solid_angle(), for weights that need few digits.
float rough_solid_angle(vec3 a, vec3 e1, vec3 e2) {
    vec3 b = a + e1, c = a + e2;
    vec3 l = vec3(length(a), length(b), length(c));
    return 2.0 * atan(abs(dot(a, cross(e1, e2))), l.x * l.y * l.z + dot(a, b) * l.z + dot(b, c) * l.x + dot(c, a) * l.y);
}

// Phong lobe that stands for the specular one, towards the light's middle.
float phong_lobe(LightContext c, vec3 direction) {
    float alpha2 = square(square(c.roughness));
    float exponent = max(0.01, 2.0 / (alpha2 + 1e-4) - 2.0);
    float scale = min(100.0, INV_PI / max(alpha2, 1e-6));
    vec3 h = normalize(direction + c.view);
    return scale * pow(max(dot(h, c.normal), 1e-6), exponent);
}

// Upper bound of the cosine at a surface over a cone of directions. `cos_angle`: between normal and axis; `spread`: cosine and sine of the
// cone's half angle. 0: the cone is below the horizon.
float cone_cosine(float cos_angle, vec2 spread) {
    if (cos_angle >= spread.x) return 1.0;
    return max(cos_angle * spread.x + sqrt(max(1.0 - cos_angle * cos_angle, 0.0)) * spread.y, 0.0);
}

// light_mass() of a quad: irradiance x bound of the cosine x Phong mix. The lobe is that of the direction of the cone that is nearest to the
// mirror direction, and at most what a lobe within the cone gives.
float quad_mass(LightContext c, LocalLightRecord l) {
    vec3 axis = l.position;
    vec2 spread = l.edge1.xy;
    float cosine = cone_cosine(dot(axis, c.normal), spread);
    if (cosine <= 0.0) return 0.0;
    float lobe = 1.0;
    if (c.specular > 0.0) {
        vec3 mirror = 2.0 * dot(c.view, c.normal) * c.normal - c.view;
        vec3 aside = mirror - dot(mirror, axis) * axis;
        bool within = dot(mirror, axis) >= spread.x || dot(aside, aside) < 1e-12;
        vec3 nearest = within ? mirror : spread.x * axis + spread.y * normalize(aside);
        // Opposite to the view there is no half vector.
        if (dot(nearest, c.view) < -0.9999) nearest = axis;
        lobe = min(phong_lobe(c, nearest), 0.5 / max(1.0 - spread.x, 1e-6));
    }
    return l.luminance * cosine * mix(1.0, lobe, c.specular);
}

// Weight of a light in the choice among a cluster's candidates: solid angle x Phong mix x luminance. 0 only when the point gets nothing
// from it: the light is below the horizon, faces away, or is dark. `grain`: a step of the digits of a candidate (light_candidate.glsl), 0: the light is
// exact.
float light_mass(LightContext c, LocalLightRecord l, float grain) {
    if (environment_is_listed() && (l.kind & LOCAL_KIND) == LOCAL_ENVIRONMENT) return quad_mass(c, l);
    vec3 middle = l.position - c.position;
    float mass;
    if ((l.kind & LOCAL_KIND) == LOCAL_TRIANGLE) {
        vec3 v0 = middle, v1 = middle + l.edge1, v2 = middle + l.edge2;
        float above = max(dot(v0, c.normal), max(dot(v1, c.normal), dot(v2, c.normal)));
        vec3 front = cross(l.edge1, l.edge2);
        middle = (v0 + v1 + v2) * (1.0 / 3.0);
        // What the digits may take away from the cosine at the light, times twice its area.
        float area = length(front), aside = grain > 0.0 ? CANDIDATE_ANGLE * area : 0.0;
        bool faces = (l.kind & LOCAL_DOUBLE_SIDED) != 0u || dot(v0, front) < aside * length(v0);
        if (above <= -grain || !faces) return 0.0;
        // Not 0 where rounding leaves nothing of the angle.
        mass = max(rough_solid_angle(v0, l.edge1, l.edge2), max(0.5 * aside / (dot(middle, middle) + area), 1e-12));
    } else {
        float radius = l.edge1.x;
        if (dot(middle, c.normal) + radius <= 0.0) return 0.0;
        float distance2 = max(dot(middle, middle), 1e-12);
        float attenuation = 1.0;
        if ((l.kind & LOCAL_KIND) == LOCAL_SPOT) {
            float cos_axis = -dot(l.edge2, middle) * inversesqrt(distance2);
            attenuation = square(clamp((cos_axis + CANDIDATE_COSINE) * l.edge1.y + l.edge1.z, 0.0, 1.0));
            // From the rim of a sphere the cone may still reach the point.
            if (radius > 0.0) attenuation = max(attenuation, 1e-2);
        }
        mass = attenuation / max(distance2, radius * radius);
    }
    float lobe = c.specular > 0.0 ? phong_lobe(c, normalize(middle)) : 1.0;
    return mass * l.luminance * mix(1.0, lobe, c.specular);
}

float light_mass(LightContext c, LocalLightRecord l) { return light_mass(c, l, 0.0); }

// The same of a light as choices see it, from its candidate.
float candidate_mass(LightContext c, uint light) {
    LightCandidateRecord candidate = LightCandidateTable(choice_tables().light_candidates).at[light];
    if ((candidate.kind & LOCAL_EXACT) != 0u) return light_mass(c, choice_light(light));
    float grain;
    LocalLightRecord l = light_of_candidate(candidate, grain);
    return light_mass(c, l, grain);
}

// What a point of an emissive triangle radiates, with texture and coverage.
vec3 emitted_radiance(LocalLightRecord l, uint light, vec2 bary) {
    if ((l.kind & LOCAL_TEXTURED) == 0u) return l.radiance;
    EmissiveRecord e = EmissiveTable(scene.emissives).at[light];
    InstanceRecord instance = scene_instance(e.instance);
    MeshRecord mesh = scene_mesh(instance.mesh);
    vec3 radiance = l.radiance * coverage(mesh, e.triangle, bary);
    TextureSlot slot = MaterialTable(scene.materials).at[material_of(instance, mesh, e.triangle)].emissive_texture;
    if (slot.texture != NONE) {
        uvec3 index = IndexTable(mesh.indices).at[e.triangle];
        vec2 uv = transform_uv(slot, triangle_uv(mesh, index, bary, slot));
        radiance *= textureLod(textures[nonuniformEXT(slot.texture)], uv, 0.0).rgb;
    }
    return radiance;
}

// A point of an emissive triangle, drawn as `method` (AREA_SAMPLING_*) says; `normal`: of the shading point.
LightSample sample_triangle_light(vec3 position, vec3 normal, LocalLightRecord l, uint light, uint method, vec2 xi) {
    TrianglePoint p = sample_triangle_point(method, position, normal, l.position, l.edge1, l.edge2, xi);
    if (p.pdf <= 0.0) return NO_LIGHT_SAMPLE;
    vec3 front = cross(l.edge1, l.edge2);
    float cos_light = -dot(front, p.direction);
    if ((l.kind & LOCAL_DOUBLE_SIDED) != 0u && cos_light < 0.0) {
        cos_light = -cos_light;
        front = -front;
    }
    if (cos_light <= 0.0) return NO_LIGHT_SAMPLE;
    vec3 point = l.position + p.barycentrics.x * l.edge1 + p.barycentrics.y * l.edge2;
    LightSample s = NO_LIGHT_SAMPLE;
    s.finite = true;
    s.direction = p.direction;
    s.target = offset_point(point, normalize(front), scene.near_origin);
    s.pdf = p.pdf;
    s.radiance = emitted_radiance(l, light, (l.kind & LOCAL_SWAPPED) != 0u ? p.barycentrics.yx : p.barycentrics);
    return s;
}

// Angular attenuation recommended by KHR_lights_punctual. `direction`: from the light.
float spot_attenuation(LightRecord light, vec3 direction) {
    if (light.kind != LIGHT_SPOT) return 1.0;
    return square(clamp(dot(light.direction, direction) * light.spot_scale + light.spot_offset, 0.0, 1.0));
}

// A point or spot light. With a radius it is a sphere of constant radiance whose projected disk gives the nominal candela:
// I = L pi radius^2, sampled in the cone that it fills. Inside the sphere there is no light.
LightSample sample_positional_light(vec3 position, LightRecord light, vec2 xi) {
    vec3 d = light.position - position;
    float distance2 = dot(d, d);
    float radius2 = light.radius * light.radius;
    if (distance2 <= radius2) return NO_LIGHT_SAMPLE;
    float distance = sqrt(distance2);
    LightSample s = NO_LIGHT_SAMPLE;
    s.finite = true;
    s.direction = d / distance;
    s.delta = light.radius <= 0.0;
    if (s.delta) {
        s.target = light.position;
        s.radiance = light.intensity / distance2;
        s.pdf = 1.0;
    } else {
        float sin2_max = radius2 / distance2;
        float one_minus_cos = sin2_max / (1.0 + sqrt(1.0 - sin2_max));
        vec3 local = sample_cone(xi, one_minus_cos);
        s.direction = basis_around(s.direction) * local;
        float reach = distance * local.z - sqrt(max(0.0, radius2 - distance2 * dot(local.xy, local.xy)));
        s.target = position + reach * s.direction;
        s.radiance = light.intensity * INV_PI / radius2;
        s.pdf = cone_pdf(one_minus_cos);
    }
    s.radiance *= spot_attenuation(light, -s.direction);
    return s;
}

// How points of emissive triangles are drawn (AREA_SAMPLING_*).
layout(constant_id = 4) const uint area_sampling = AREA_SAMPLING_UNIFORM;

// A sample of a local light as it is in these tables; its pdf leaves the choice of the light out.
LightSample sample_light_of(LightTablesRecord tables, LightContext c, uint light, vec2 xi) {
    LocalLightRecord l = LocalLightTable(tables.local_lights).at[light];
    uint kind = l.kind & LOCAL_KIND;
    if (kind == LOCAL_TRIANGLE) return sample_triangle_light(c.position, c.normal, l, light, area_sampling, xi);
    if (environment_is_listed() && kind == LOCAL_ENVIRONMENT) return sample_environment_quad(l, light - first_environment_light(), xi);
    return sample_positional_light(c.position, LightTable(tables.lights).at[tables.sun_count + light - first_positional_light()], xi);
}

// A sample of a local light that has been chosen, as it is in this frame.
LightSample sample_local_light(LightContext c, uint light, vec2 xi) { return sample_light_of(scene.light_tables, c, light, xi); }
