// Picks a local light by a random descent through the light tree (pt_light_sampling::LightBvh): Conty Estevez and Kulla 2018, "Importance Sampling
// of Many Lights with Adaptive Tree Splitting". Host twin: pt_light_sampling::oracle::light_bvh.
//
// The includer defines
//   LIGHT_BVH_NODES     uint64_t, address of LightBvhNode[], the root first
//   LIGHT_BVH_TRAILS    uint64_t, address of uint64_t[]: for each light its branches from the root, from bit 0 on
//   LIGHT_BVH_GAUSSIAN  bool, importance of a node by spherical Gaussians rather than by bounds alone
//
// At a branch each child gets a part of a whole number of steps in proportion to its importance, and the pmf is the product of
// these parts: it is exactly the frequency of the picks, and every light with an importance is reached, however deep it lies.
#include "records.glsl"
#include "math.glsl"
#include "pack.glsl"
#include "rng.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer LightBvhTable { LightBvhNode at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer LightTrailTable { uint64_t at[]; };

// Trail of a light that is not in the tree.
const uint64_t LIGHT_BVH_NO_TRAIL = ~0ul;
// A branch divides at least this many steps, so no part is less than 2^-23.
const uint LIGHT_BVH_MIN_STEPS = 1u << 23;
// Least importance of a node that may contribute.
const float LIGHT_BVH_MIN_IMPORTANCE = 1e-30;
// What rounding may add to a cosine of emission near the ends of its range.
const float LIGHT_BVH_COSINE_ROUNDING = 1e-3;
// Share of the importance by bounds in that by Gaussians: bounds the variance where a Gaussian falls off too fast.
const float LIGHT_BVH_DEFENSIVE_SHARE = 0.1;
// Reflectance of the specular lobe that Gaussians stand for, beside a white diffuse one.
const float LIGHT_BVH_SPECULAR = 0.05;

// What a node's importance depends on.
struct LightBvhPoint {
    vec3 position;
    vec3 normal;
    vec3 mirror;            // direction of mirror reflection
    float mirror_sharpness; // of the Gaussian about it
};

// The lobe of GGX as a Gaussian about the mirror direction: Wang et al. 2009, "All-Frequency Rendering of Dynamic, Spatially-Varying
// Reflectance", section 4. Alpha is at least 0.05: narrower lobes find lights by sampling the BRDF.
LightBvhPoint light_bvh_point(vec3 position, vec3 normal, vec3 view, float roughness) {
    float alpha = max(square(roughness), 0.05);
    float cos_view = dot(view, normal);
    precise float sharpness = 0.5 / (alpha * alpha * max(cos_view, 0.1));
    precise vec3 mirror = 2.0 * cos_view * normal - view;
    return LightBvhPoint(position, normal, mirror, sharpness);
}

// Cosine and sine of max(a - b, 0), of angles from 0 to pi with these cosines and sines.
vec2 light_bvh_less(vec2 a, vec2 b) {
    if (a.x >= b.x) return vec2(1.0, 0.0);
    precise vec2 r = vec2(a.x * b.x + a.y * b.y, a.y * b.x - a.x * b.y);
    return r;
}

vec2 with_sine(float cosine) {
    precise vec2 r = vec2(cosine, sqrt(max(1.0 - cosine * cosine, 0.0)));
    return r;
}

// 1 / integral over the sphere of exp(sharpness (cos - 1)).
float gaussian_norm(float sharpness) {
    precise float r = 0.5 * INV_PI * sharpness / (1.0 - exp(-2.0 * sharpness));
    return r;
}

// Logarithm of the peak of a product of two Gaussians about a and b; `sum`: sharpness of the product. No small difference of large numbers.
float gaussian_product_log(vec3 a, float sharpness_a, vec3 b, float sharpness_b, float sum) {
    vec3 chord = a - b;
    precise float r = -sharpness_a * sharpness_b * dot(chord, chord) / (sum + sharpness_a + sharpness_b);
    return r;
}

// Mean of the clamped cosine over a normalised Gaussian whose axis has the cosine `cosine`. Exact for a direction and for a whole sphere
// (1/4), in between a hyperbola that follows the standard deviation of the cosine.
float gaussian_clamped_cosine(float cosine, float sharpness) {
    float e = exp(-2.0 * sharpness);
    float mean_cosine = (1.0 + e) / (1.0 - e) - 1.0 / sharpness;
    float x = mean_cosine * cosine;
    precise float r = 0.5 * (x + sqrt(x * x + 0.25 * max(1.0 - mean_cosine * mean_cosine, 0.0)));
    return r;
}

// A node of the tree, unpacked.
struct LightBvhBounds {
    vec3 center;
    vec3 extent;
    float power;
};

LightBvhBounds light_bvh_bounds(LightBvhNode node) {
    // 2^(exponent - 128); a box without extent has no exponent.
    float scale = node.extent == 0u ? 0.0 : uintBitsToFloat((node.extent >> 24) - 1u << 23);
    vec3 extent = vec3(uvec3(node.extent, node.extent >> 8, node.extent >> 16) & 255u) * scale;
    return LightBvhBounds(node.center, extent, uintBitsToFloat(node.lobe & 0xffff0000u));
}

// Reflected radiance of a node as one light with a Gaussian distribution of positions and of directions: Tokuyoshi 2015, "Virtual Spherical
// Gaussian Lights for Real-Time Glossy Indirect Illumination", as an importance: Tokuyoshi et al. 2024, "Hierarchical Light Sampling with
// Accurate Spherical Gaussian Lighting". Both factors are Gaussians of the direction from the point; so is their product.
float light_bvh_gaussian(LightBvhPoint p, LightBvhNode node, LightBvhBounds bounds, float radius2) {
    vec4 mean = unpackUnorm4x8(node.mean);
    vec3 d = (bounds.center - p.position) + (2.0 * mean.xyz - 1.0) * bounds.extent;
    float distance2 = max(dot(d, d), 1e-20);
    // Of one axis.
    float variance = max(mean.w * mean.w * radius2 / 3.0, 1e-20);
    float sharpness = clamp(distance2 / variance, 1e-3, 1e4);
    vec3 direction = d * inversesqrt(distance2);
    // Sharpness of the emission from its mean direction: Banerjee et al. 2005, "Clustering on the Unit Hypersphere".
    vec3 towards = -octahedral_decode(vec2(node.lobe & 31u, node.lobe >> 5u & 31u) / 15.5 - 1.0);
    float r = min(float(node.lobe >> 10u & 63u) / 63.0, 0.99);
    float emission = r * (3.0 - r * r) / (1.0 - r * r);
    vec3 axis = sharpness * direction + emission * towards;
    float k = max(length(axis), 1e-3);
    axis /= k;
    float peak = exp(gaussian_product_log(direction, sharpness, towards, emission, k));
    float arriving = bounds.power * gaussian_norm(sharpness) * gaussian_norm(max(emission, 1e-3)) * peak /
                     (gaussian_norm(k) * (distance2 + variance));
    float diffuse = INV_PI * gaussian_clamped_cosine(dot(p.normal, axis), k);
    float m = max(length(k * axis + p.mirror_sharpness * p.mirror), 1e-3);
    float specular = gaussian_norm(k) * gaussian_norm(p.mirror_sharpness) / gaussian_norm(m) *
                     exp(gaussian_product_log(axis, k, p.mirror, p.mirror_sharpness, m));
    precise float value = arriving * (diffuse + LIGHT_BVH_SPECULAR * specular);
    return value;
}

// Importance of a node: above 0 wherever one of its lights may contribute; 0 if all are below the horizon of the normal or face away.
// From its bounds: upper bounds of both cosines (same paper, section 4.2), over the squared distance to the centre. The radiant intensity is the
// power over the solid angle that the node's cone says, so that a lamp that shines to one side is not taken for one that shines to all.
float light_bvh_importance(LightBvhPoint p, LightBvhNode node) {
    LightBvhBounds bounds = light_bvh_bounds(node);
    if (bounds.power <= 0.0) return 0.0;
    vec3 extent = bounds.extent;
    vec3 d = bounds.center - p.position;
    // Height of the highest corner above the surface.
    precise float above = dot(p.normal, d) + dot(abs(p.normal), extent);
    if (above <= 0.0) return 0.0;
    vec4 cone = unpackUnorm4x8(node.cone);
    vec2 half_sine = cone.zw;
    vec2 spread = vec2(1.0 - 2.0 * half_sine.x * half_sine.x, 2.0 * half_sine.x * sqrt(1.0 - half_sine.x * half_sine.x));
    float cos_emission = 1.0 - 2.0 * half_sine.y * half_sine.y;
    vec3 axis = octahedral_decode(2.0 * cone.xy - 1.0);
    float distance2 = dot(d, d), radius2 = dot(extent, extent);
    float cos_surface = 1.0, cos_light = 1.0;
    if (distance2 > radius2) {
        // Angles to the centre of the bounding sphere, less its angular radius.
        float scale = inversesqrt(distance2);
        float sin2 = radius2 / distance2;
        vec2 radius = vec2(sqrt(1.0 - sin2), sqrt(sin2));
        cos_surface = light_bvh_less(with_sine(dot(p.normal, d) * scale), radius).x;
        cos_light = light_bvh_less(light_bvh_less(with_sine(-dot(axis, d) * scale), spread), radius).x;
        precise float facing = cos_light - cos_emission;
        if (facing < -LIGHT_BVH_COSINE_ROUNDING) return 0.0;
    }
    // The box bounds the cosines too: greatest height over least distance.
    vec3 gap = max(abs(d) - extent, 0.0);
    float nearest2 = dot(gap, gap);
    if (nearest2 > 0.0) {
        float scale = inversesqrt(nearest2);
        cos_surface = min(cos_surface, above * scale);
        float front = max(dot(abs(axis), extent) - dot(axis, d), 0.0);
        if (spread.x >= 0.0) cos_light = min(cos_light, front * scale * spread.x + spread.y);
    }
    float solid_angle = PI * (2.0 * (1.0 - spread.x) + 0.5 * (1.0 - cos_emission * cos_emission) * (1.0 + spread.x));
    float intensity = bounds.power / max(solid_angle, 1e-4);
    precise float value = INV_PI * intensity * max(cos_surface, 0.0) * max(cos_light, 0.0) / max(max(distance2, radius2), 1e-12);
    if (LIGHT_BVH_GAUSSIAN) value = light_bvh_gaussian(p, node, bounds, radius2) + LIGHT_BVH_DEFENSIVE_SHARE * value;
    return clamp(value, LIGHT_BVH_MIN_IMPORTANCE, 1.0 / LIGHT_BVH_MIN_IMPORTANCE);
}

// A branch: how many of `steps` (2^23 to 2^31) go to the first child, and the links of the children. NONE: neither may contribute.
struct LightBvhBranch {
    uint first_steps;
    uint links[2];
};

LightBvhBranch light_bvh_branch(LightBvhPoint p, uint link, uint steps) {
    LightBvhTable nodes = LightBvhTable(LIGHT_BVH_NODES);
    LightBvhNode first = nodes.at[link], second = nodes.at[link + 1u];
    float a = light_bvh_importance(p, first), b = light_bvh_importance(p, second);
    uint cut;
    if (a <= 0.0 && b <= 0.0) cut = NONE;
    else if (a <= 0.0) cut = 0u;
    else if (b <= 0.0) cut = steps;
    else {
        precise float share = a / (a + b) * float(steps);
        cut = clamp(uint(share), 1u, steps - 1u);
    }
    return LightBvhBranch(cut, uint[2](first.link, second.link));
}

// The number of steps that all choices together have: those that the tree does not take are left to lights outside of it.
const uint LIGHT_BVH_STEPS = 1u << 31;

// A light of the tree, or NONE with pmf 0. The tree, with some importance, has the first `steps` of all steps, of which number `place` is ours;
// `more_bits` go on where its bits are used up.
uint light_bvh_descend(LightBvhPoint p, uint steps, uint place, uint more_bits, out float pmf) {
    pmf = 0.0;
    uint link = LightBvhTable(LIGHT_BVH_NODES).at[0].link, used = 0u;
    float product = float(steps) / float(LIGHT_BVH_STEPS);
    // The random numbers that lead to a node are `steps` consecutive ones; ours is number `place` of them.
    while ((link & LIGHT_BVH_LEAF) == 0u) {
        for (; steps < LIGHT_BVH_MIN_STEPS; used++) {
            uint word = used < 4u ? more_bits >> (8u * used) : pcg(more_bits + used);
            steps <<= 8;
            place = place << 8 | word & 255u;
        }
        LightBvhBranch branch = light_bvh_branch(p, link, steps);
        if (branch.first_steps == NONE) return NONE;
        bool second = place >= branch.first_steps;
        uint taken = second ? steps - branch.first_steps : branch.first_steps;
        if (second) place -= branch.first_steps;
        product *= float(taken) / float(steps);
        steps = taken;
        link = branch.links[second ? 1 : 0];
    }
    pmf = product;
    return link & ~LIGHT_BVH_LEAF;
}

// Probability with which light_bvh_descend returns a light.
float light_bvh_descend_pmf(LightBvhPoint p, uint steps, uint light) {
    uint64_t trail = LightTrailTable(LIGHT_BVH_TRAILS).at[light];
    if (trail == LIGHT_BVH_NO_TRAIL) return 0.0;
    uint link = LightBvhTable(LIGHT_BVH_NODES).at[0].link;
    float product = float(steps) / float(LIGHT_BVH_STEPS);
    for (; (link & LIGHT_BVH_LEAF) == 0u; trail >>= 1) {
        while (steps < LIGHT_BVH_MIN_STEPS) steps <<= 8;
        LightBvhBranch branch = light_bvh_branch(p, link, steps);
        if (branch.first_steps == NONE) return 0.0;
        bool second = (trail & 1ul) != 0ul;
        uint taken = second ? steps - branch.first_steps : branch.first_steps;
        if (taken == 0u) return 0.0;
        product *= float(taken) / float(steps);
        steps = taken;
        link = branch.links[second ? 1 : 0];
    }
    return product;
}

float light_bvh_root_importance(LightBvhPoint p) { return light_bvh_importance(p, LightBvhTable(LIGHT_BVH_NODES).at[0]); }

// A light, or NONE with pmf 0, of 64 random bits. `view`: unit, to the viewer.
uint light_bvh_pick(vec3 position, vec3 normal, vec3 view, float roughness, uvec2 bits, out float pmf) {
    pmf = 0.0;
    LightBvhPoint p = light_bvh_point(position, normal, view, roughness);
    if (light_bvh_root_importance(p) <= 0.0) return NONE;
    return light_bvh_descend(p, LIGHT_BVH_STEPS, bits.x >> 1, bits.y, pmf);
}

// Probability with which light_bvh_pick returns a light.
float light_bvh_pmf(vec3 position, vec3 normal, vec3 view, float roughness, uint light) {
    LightBvhPoint p = light_bvh_point(position, normal, view, roughness);
    if (light == NONE || light_bvh_root_importance(p) <= 0.0) return 0.0;
    return light_bvh_descend_pmf(p, LIGHT_BVH_STEPS, light);
}
