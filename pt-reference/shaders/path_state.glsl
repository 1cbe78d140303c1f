// The state that a path carries from vertex to vertex, and the weights of multiple importance sampling (light samples and BSDF
// samples): Veach 1997, "Robust Monte Carlo Methods for Light Transport Simulation", section 9.2.
#include "frame.glsl"
#include "interior.glsl"
#include "records.glsl"
#include "reference_records.glsl"

layout(push_constant, scalar) uniform Push { PathPush push; };

// Fixed when the kernels are made (scene.glsl has constant 0), by name.
layout(constant_id = 8) const uint light_kinds = 0xfu; // KIND_* bits of the light that counts and is present
layout(constant_id = 9) const uint sampler_kind = 1u;  // SAMPLER_*
layout(constant_id = 10) const bool energy_compensation = false;
layout(constant_id = 11) const bool ray_cones = false;
layout(constant_id = 12) const bool sort_materials = false;
layout(constant_id = 13) const uint background = BACKGROUND_ENVIRONMENT;

layout(constant_id = 14) const bool merged_lights = false; // PathLights other than PER_KIND

#include "path_random.glsl"

struct PathState {
    vec3 origin;
    vec3 direction;  // unit
    vec3 throughput; // product of the weights f cos / pdf, absorption and survival so far
    float last_pdf;  // density per solid angle with which `direction` was chosen; unused while PATH_DELTA is set
    uint flags;      // PATH_*
    uint vertex;     // scattering events so far
    uint segment;    // rays traced so far, interfaces that were passed through included
    uint shadow_rays;
    uint sample_index;
    InteriorList interior;
    vec2 cone;       // if ray_cones: radius at the origin, metres, and half angle
    float passed;    // way since the last scattering, straight on through surfaces, metres
    vec3 glossy;     // share of the throughput that specular lobes have, which show the effects on this ray; 0: none does
    // Follow from the others; not kept from ray to ray.
    float chord;     // way since the last scattering, metres
    PathRandom random;
};

// No light sampling could have found what this ray finds: it comes from the camera or from a delta lobe.
const uint PATH_DELTA = 1u;
// All scattering so far was delta: the camera sees what this ray finds, perhaps in a mirror.
const uint PATH_SEEN = 2u;
// Inside of a solid: the list is not empty.
const uint PATH_INSIDE = 4u;
// The sample is complete but for its last shadow ray.
const uint PATH_ENDED = 8u;

// Rays that may pass through an interface without scattering (nested dielectrics, edges) before a path is given up.
const uint MAX_SEGMENTS = 256u;

// Weight of the strategy with density `pdf` where the other one's is `other`.
float mis_weight(float pdf, float other) {
    float ratio = other / pdf;
    if (push.heuristic == HEURISTIC_POWER) ratio *= ratio;
    return 1.0 / (1.0 + ratio);
}

float light_sample_weight(float light_pdf, float bsdf_pdf) {
    if (push.strategy != STRATEGY_BOTH) return push.strategy == STRATEGY_LIGHTS ? 1.0 : 0.0;
    return mis_weight(light_pdf, bsdf_pdf);
}

// Of light that the path's own ray meets, for which light sampling has density `light_pdf` (0: it never samples it).
float bsdf_sample_weight(PathState path, float light_pdf) {
    if ((path.flags & PATH_DELTA) != 0u || light_pdf <= 0.0) return 1.0;
    if (push.strategy != STRATEGY_BOTH) return push.strategy == STRATEGY_BSDF ? 1.0 : 0.0;
    return mis_weight(path.last_pdf, light_pdf);
}
