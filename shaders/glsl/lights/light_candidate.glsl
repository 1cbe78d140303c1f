// A local light as a choice among lights needs it, in 32 bytes: half of what its LocalLightRecord has, and one sector of a cache. Weights and
// probabilities are computed from the same digits, so that choices stay unbiased; the point on the light and its radiance are exact. Digits are lost
// in the edges of triangles and in the direction of spot lights: light_mass() makes up for what that may take away (`CANDIDATE_*`).
#include "scene.glsl"
#include "pack.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer LightCandidateTable { LightCandidateRecord at[]; };

// Triangles with less height than so many steps of 16 bits are read exactly; then the normal is off by at most CANDIDATE_ANGLE.
const float CANDIDATE_STEPS = 256.0;
const float CANDIDATE_ANGLE = 0.008;
// A step of an edge, as a share of the scale of the edges. Rounding takes half a step in each axis.
const float CANDIDATE_STEP = 1.0 / 32767.0;
// Error of the cosine between the axis of a spot light and a direction.
const float CANDIDATE_COSINE = 2e-4;

LightCandidateRecord light_candidate(LocalLightRecord l) {
    uint kind = l.kind;
    uvec3 words = uvec3(0u);
    if ((kind & LOCAL_KIND) == LOCAL_TRIANGLE) {
        vec3 large = max(abs(l.edge1), abs(l.edge2));
        float most = max(large.x, max(large.y, large.z));
        int exponent;
        frexp(most, exponent);
        exponent = clamp(exponent, -120, 120);
        float scale = ldexp(1.0, exponent);
        words = uvec3(packSnorm2x16(l.edge1.xy / scale), packSnorm2x16(vec2(l.edge1.z, l.edge2.x) / scale), packSnorm2x16(l.edge2.yz / scale));
        vec3 third = l.edge2 - l.edge1;
        float longest = sqrt(max(dot(l.edge1, l.edge1), max(dot(l.edge2, l.edge2), dot(third, third))));
        // False for what is not a number, too.
        bool fits = most <= scale && length(cross(l.edge1, l.edge2)) > CANDIDATE_STEPS * CANDIDATE_STEP * scale * longest;
        kind |= uint(exponent + 128) << 16 | (fits ? 0u : LOCAL_EXACT);
    } else if ((kind & LOCAL_KIND) == LOCAL_ENVIRONMENT) {
        words.xy = floatBitsToUint(l.edge1.xy);
    } else {
        float radius = l.edge1.x;
        uint half_radius = packHalf2x16(vec2(radius * 1.001 + (radius > 0.0 ? 1e-7 : 0.0), 0.0));
        kind |= half_radius << 16 | (radius < 6e4 ? 0u : LOCAL_EXACT);
        words = uvec3(pack_unit_vector(l.edge2), floatBitsToUint(l.edge1.yz));
    }
    return LightCandidateRecord(l.position, kind, words, l.luminance);
}

// The light again; what no weight needs is missing. `grain`: a step of the digits of its edges, metres.
LocalLightRecord light_of_candidate(LightCandidateRecord l, out float grain) {
    vec3 edge1, edge2 = vec3(0.0);
    grain = 0.0;
    uint kind = l.kind & LOCAL_KIND;
    if (kind == LOCAL_TRIANGLE) {
        float scale = uintBitsToFloat((l.kind >> 16) - 1u << 23);
        vec2 xy = unpackSnorm2x16(l.words.x), zx = unpackSnorm2x16(l.words.y), yz = unpackSnorm2x16(l.words.z);
        edge1 = vec3(xy, zx.x) * scale;
        edge2 = vec3(zx.y, yz) * scale;
        grain = CANDIDATE_STEP * scale;
    } else if (kind == LOCAL_ENVIRONMENT) {
        edge1 = vec3(uintBitsToFloat(l.words.xy), 0.0);
    } else {
        edge1 = vec3(unpackHalf2x16(l.kind >> 16).x, uintBitsToFloat(l.words.yz));
        if (kind == LOCAL_SPOT) edge2 = unpack_unit_vector(l.words.x);
    }
    return LocalLightRecord(l.position, l.kind & 0xffffu, edge1, l.luminance, edge2, 0u, vec3(0.0), 0u);
}
