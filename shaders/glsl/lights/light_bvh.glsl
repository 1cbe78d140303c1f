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
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer LightBvhWords { uvec4 at[]; };
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
    float mirror_norm;      // 1 / its integral over the sphere
};

// 1 / integral over the sphere of exp(sharpness (cos - 1)), but for the factor sharpness / (2 pi): in quotients of such norms the factors join.
float gaussian_norm_divisor(float sharpness) {
    // exp(-2 sharpness), as a power of two.
    precise float r = 1.0 - exp2(-2.8853900817779268 * sharpness);
    return r;
}

// The lobe of GGX as a Gaussian about the mirror direction: Wang et al. 2009, "All-Frequency Rendering of Dynamic, Spatially-Varying
// Reflectance", section 4. Alpha is at least 0.05: narrower lobes find lights by sampling the BRDF.
LightBvhPoint light_bvh_point(vec3 position, vec3 normal, vec3 view, float roughness) {
    float alpha = max(square(roughness), 0.05);
    float cos_view = dot(view, normal);
    precise float sharpness = 0.5 / (alpha * alpha * max(cos_view, 0.1));
    precise float norm = 0.5 * INV_PI * sharpness / gaussian_norm_divisor(sharpness);
    precise vec3 mirror = 2.0 * cos_view * normal - view;
    return LightBvhPoint(position, normal, mirror, sharpness, norm);
}

// A sum that is fused by name and not where a compiler sees fit rounds alike in every kernel that has it.
float fused_dot(vec3 a, vec3 b) {
    precise float r = fma(a.x, b.x, fma(a.y, b.y, a.z * b.z));
    return r;
}

// Cosine and sine of max(a - b, 0), of angles from 0 to pi with these cosines and sines.
vec2 light_bvh_less(vec2 a, vec2 b) {
    if (a.x >= b.x) return vec2(1.0, 0.0);
    precise vec2 r = vec2(fma(a.x, b.x, a.y * b.y), fma(a.y, b.x, -a.x * b.y));
    return r;
}

vec2 with_sine(float cosine) {
    precise vec2 r = vec2(cosine, sqrt(max(fma(-cosine, cosine, 1.0), 0.0)));
    return r;
}

// Logarithm to base 2 of the peak of a product of two Gaussians about a and b; `sum`: sharpness of the product. No small difference of large numbers.
float gaussian_product_log2(vec3 a, float sharpness_a, vec3 b, float sharpness_b, float sum) {
    precise vec3 chord = a - b;
    precise float r = -1.4426950408889634 * sharpness_a * sharpness_b * fused_dot(chord, chord) / (sum + sharpness_a + sharpness_b);
    return r;
}

// A vector's length, at least 1e-3, and its reciprocal.
vec2 length_and_inverse(vec3 v) {
    float length2 = max(fused_dot(v, v), 1e-6);
    precise vec2 r = vec2(0.0, inversesqrt(length2));
    r.x = length2 * r.y;
    return r;
}

// The four bytes of a word, each 0 to 255.
vec4 bytes_of(uint word) { return vec4(uvec4(word, word >> 8, word >> 16, word >> 24) & 255u); }

// The box of a node: `middle` from the shading point.
struct LightBvhBox {
    vec3 middle;
    vec3 extent;
    float radius2; // square of half its diagonal
};

// Reflected radiance of a node as one light with a Gaussian distribution of positions and of directions: Tokuyoshi 2015, "Virtual Spherical
// Gaussian Lights for Real-Time Glossy Indirect Illumination", as an importance: Tokuyoshi et al. 2024, "Hierarchical Light Sampling with
// Accurate Spherical Gaussian Lighting". Both factors are Gaussians of the direction from the point; so is their product.
float light_bvh_gaussian(LightBvhPoint p, LightBvhNode node, LightBvhBox box, float power) {
    vec4 mean = bytes_of(node.mean);
    precise vec3 d = fma(fma(vec3(2.0 / 255.0), mean.xyz, vec3(-1.0)), box.extent, box.middle);
    float distance2 = max(fused_dot(d, d), 1e-20);
    // Of one axis.
    precise float variance = max(mean.w * mean.w * (1.0 / (3.0 * 255.0 * 255.0)) * box.radius2, 1e-20);
    precise float sharpness = clamp(distance2 / variance, 1e-3, 1e4);
    precise vec3 direction = d * inversesqrt(distance2);
    // Sharpness of the emission from its mean direction: Banerjee et al. 2005, "Clustering on the Unit Hypersphere".
    vec3 towards = -octahedral_decode(fma(vec2(node.lobe & 31u, node.lobe >> 5u & 31u), vec2(1.0 / 15.5), vec2(-1.0)));
    precise float r = min(float(node.lobe >> 10u & 63u) * (1.0 / 63.0), 0.99), r2 = r * r;
    precise float emission = r * (3.0 - r2) / (1.0 - r2);
    // Their product: about `axis`, of sharpness k.x.
    precise vec3 sum = fma(vec3(emission), towards, sharpness * direction);
    vec2 k = length_and_inverse(sum);
    precise vec3 axis = sum * k.y;
    float peak = exp2(gaussian_product_log2(direction, sharpness, towards, emission, k.x));
    precise float spread_emission = max(emission, 1e-3);
    precise float divisor = gaussian_norm_divisor(k.x);
    precise float arriving = 0.5 * INV_PI * power * sharpness * spread_emission * divisor * peak /
                             (k.x * gaussian_norm_divisor(sharpness) * gaussian_norm_divisor(spread_emission) * (distance2 + variance));
    precise float inverse_divisor = 1.0 / divisor;
    // Mean of the clamped cosine over a normalised Gaussian. Exact for a direction and for a whole sphere (1/4), in between a hyperbola that
    // follows the standard deviation of the cosine. The mean cosine to the axis is coth(k) - 1 / k.
    precise float mean_cosine = fma(2.0 - divisor, inverse_divisor, -k.y);
    precise float x = mean_cosine * fused_dot(p.normal, axis);
    precise float diffuse = 0.5 * INV_PI * (x + sqrt(fma(x, x, 0.25 * max(fma(-mean_cosine, mean_cosine, 1.0), 0.0))));
    vec2 m = length_and_inverse(fma(vec3(p.mirror_sharpness), p.mirror, sum));
    precise float specular = k.x * inverse_divisor * gaussian_norm_divisor(m.x) * m.y * p.mirror_norm *
                             exp2(gaussian_product_log2(axis, k.x, p.mirror, p.mirror_sharpness, m.x));
    precise float value = arriving * fma(LIGHT_BVH_SPECULAR, specular, diffuse);
    return value;
}

// Importance of a node: above 0 wherever one of its lights may contribute; 0 if all are below the horizon of the normal or face away.
// From its bounds: upper bounds of both cosines (same paper, section 4.2), over the squared distance to the centre. The radiant intensity is the
// power over the solid angle that the node's cone says, so that a lamp that shines to one side is not taken for one that shines to all.
//
// Most of the time of a choice is spent in this arithmetic, not in loads. So sums are fused, quotients join into one, and no norm is computed twice.
float light_bvh_importance(LightBvhPoint p, LightBvhNode node) {
    float power = uintBitsToFloat(node.lobe & 0xffff0000u);
    // 2^(exponent - 128); a box without extent has no exponent.
    float scale = node.extent == 0u ? 0.0 : uintBitsToFloat((node.extent >> 24) - 1u << 23);
    vec3 extent = bytes_of(node.extent).xyz * scale;
    precise vec3 d = node.center - p.position;
    float height = fused_dot(p.normal, d);
    // Height of the highest corner above the surface.
    precise float above = height + fused_dot(abs(p.normal), extent);
    if (power <= 0.0 || above <= 0.0) return 0.0;
    vec4 cone = bytes_of(node.cone);
    vec2 half_sine = cone.zw * (1.0 / 255.0);
    // Squares of the sines of half the angles of spread and emission.
    precise float half_spread = half_sine.x * half_sine.x, half_emission = half_sine.y * half_sine.y;
    precise vec2 spread = vec2(fma(-2.0, half_spread, 1.0), 2.0 * half_sine.x * sqrt(max(1.0 - half_spread, 0.0)));
    vec3 axis = octahedral_decode(fma(cone.xy, vec2(2.0 / 255.0), vec2(-1.0)));
    float distance2 = fused_dot(d, d), radius2 = fused_dot(extent, extent), along = fused_dot(axis, d);
    precise float cos_surface = 1.0, cos_light = 1.0;
    if (distance2 > radius2) {
        // Angles to the centre of the bounding sphere, less its angular radius.
        precise float inverse = inversesqrt(distance2);
        precise float sine = sqrt(radius2) * inverse;
        vec2 radius = vec2(with_sine(sine).y, sine);
        cos_surface = light_bvh_less(with_sine(height * inverse), radius).x;
        cos_light = light_bvh_less(light_bvh_less(with_sine(-along * inverse), spread), radius).x;
        precise float facing = cos_light - fma(-2.0, half_emission, 1.0);
        if (facing < -LIGHT_BVH_COSINE_ROUNDING) return 0.0;
    }
    // The box bounds the cosines too: greatest height over least distance.
    precise vec3 gap = max(abs(d) - extent, 0.0);
    float nearest2 = fused_dot(gap, gap);
    if (nearest2 > 0.0) {
        precise float inverse = inversesqrt(nearest2);
        cos_surface = min(cos_surface, above * inverse);
        precise float front = max(fused_dot(abs(axis), extent) - along, 0.0);
        precise float bound = fma(front * inverse, spread.x, spread.y);
        if (spread.x >= 0.0) cos_light = min(cos_light, bound);
    }
    precise float solid_angle = 4.0 * PI * fma(half_emission * (1.0 - half_emission), 1.0 - half_spread, half_spread);
    precise float value = INV_PI * power * max(cos_surface, 0.0) * max(cos_light, 0.0) /
                          (max(solid_angle, 1e-4) * max(max(distance2, radius2), 1e-12));
    if (LIGHT_BVH_GAUSSIAN) {
        float gaussian = light_bvh_gaussian(p, node, LightBvhBox(d, extent, radius2), power);
        value = fma(LIGHT_BVH_DEFENSIVE_SHARE, value, gaussian);
    }
    return clamp(value, LIGHT_BVH_MIN_IMPORTANCE, 1.0 / LIGHT_BVH_MIN_IMPORTANCE);
}

// A node in two loads of 16 bytes.
LightBvhNode light_bvh_node(uint index) {
    LightBvhWords words = LightBvhWords(LIGHT_BVH_NODES);
    uvec4 a = words.at[2u * index], b = words.at[2u * index + 1u];
    return LightBvhNode(uintBitsToFloat(a.xyz), a.w, b.x, b.y, b.z, b.w);
}

// A branch: how many of `steps` (2^23 to 2^31) go to the first child, and the links of the children. NONE: neither may contribute.
struct LightBvhBranch {
    uint first_steps;
    uint links[2];
};

LightBvhBranch light_bvh_branch(LightBvhPoint p, uint link, uint steps) {
    LightBvhNode first = light_bvh_node(link), second = light_bvh_node(link + 1u);
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
