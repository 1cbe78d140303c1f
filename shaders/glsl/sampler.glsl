// Numbers for Monte Carlo integration as a pure function of (pixel, sample, dimension, seed). Host twin: pt_reference::oracle::sampler.
//
//     Sampler make_sampler(uint kind, uvec2 pixel, uint sample_index, uint seed, uint log2_spp)
//     float sample_1d(inout Sampler), vec2 sample_2d(inout Sampler), vec4 sample_4d(inout Sampler)     numbers in [0, 1)
//     uvec4 sample_bits(inout Sampler)                                                                 4 x 32 bits of the same
//
// Every call is a dimension of its own, independent of the others (padding: Kollig and Keller 2002, "Efficient Multidimensional
// Sampling"); sampler.dimension may be set, so that a vertex of a path always draws from the same place. Kinds:
//
// SAMPLER_PCG: a hash (Jarzynski and Olano 2020); independent of everything, the yardstick of the others.
// SAMPLER_SOBOL: Sobol's sequence in four dimensions (direction numbers of Joe and Kuo 2008), its order and values scrambled as
// Owen 1995 does, by hashing: Burley 2020, "Practical Hash-based Owen Scrambling" (alg. 1-4), with the hash of Laine and Karras
// 2011, "Stratified Sampling for Stochastic Transparency", as improved by Vegdahl 2021. Any number of samples, best at
// powers of two; pixels are independent.
// SAMPLER_BLUE_NOISE: one such sequence over the whole image, samples of a pixel in a row and pixels in the order of a scrambled Morton
// curve, so that neighbours share the strata of longer stretches and their errors differ: Ahmed and Wonka 2020, "Screen-Space
// Blue-Noise Diffusion of Monte Carlo Sampling Error via Hierarchical Ordering of Pixels". Every pixel takes 2^log2_spp samples;
// further ones begin again with other scrambles. 2^(16 - log2_spp / 2) pixels along each side are one sequence, the next ones another.
#include "records.glsl"
#include "rng.glsl"

struct Sampler {
    uint kind;
    uint index;     // in the sequence
    uint scramble;  // hash of what the sequence belongs to: seed, and pixel or tile
    uint dimension; // of the next call
};

// Dimensions 2 to 4 of Sobol's sequence by the bits of the index; the first is the index with its bits turned round. Written
// out: a table that is indexed goes to memory on most devices.
#define SOBOL_BIT(k, a, b, c) x ^= uvec3(a, b, c) & uint(bitfieldExtract(int(index), int(k), 1));
uvec4 sobol(uint index) {
    uvec3 x = uvec3(0u);
    SOBOL_BIT(0u, 0x80000000u, 0x80000000u, 0x80000000u) SOBOL_BIT(1u, 0xc0000000u, 0xc0000000u, 0xc0000000u)
    SOBOL_BIT(2u, 0xa0000000u, 0x60000000u, 0x20000000u) SOBOL_BIT(3u, 0xf0000000u, 0x90000000u, 0x50000000u)
    SOBOL_BIT(4u, 0x88000000u, 0xe8000000u, 0xf8000000u) SOBOL_BIT(5u, 0xcc000000u, 0x5c000000u, 0x74000000u)
    SOBOL_BIT(6u, 0xaa000000u, 0x8e000000u, 0xa2000000u) SOBOL_BIT(7u, 0xff000000u, 0xc5000000u, 0x93000000u)
    SOBOL_BIT(8u, 0x80800000u, 0x68800000u, 0xd8800000u) SOBOL_BIT(9u, 0xc0c00000u, 0x9cc00000u, 0x25400000u)
    SOBOL_BIT(10u, 0xa0a00000u, 0xee600000u, 0x59e00000u) SOBOL_BIT(11u, 0xf0f00000u, 0x55900000u, 0xe6d00000u)
    SOBOL_BIT(12u, 0x88880000u, 0x80680000u, 0x78080000u) SOBOL_BIT(13u, 0xcccc0000u, 0xc09c0000u, 0xb40c0000u)
    SOBOL_BIT(14u, 0xaaaa0000u, 0x60ee0000u, 0x82020000u) SOBOL_BIT(15u, 0xffff0000u, 0x90550000u, 0xc3050000u)
    SOBOL_BIT(16u, 0x80008000u, 0xe8808000u, 0x208f8000u) SOBOL_BIT(17u, 0xc000c000u, 0x5cc0c000u, 0x51474000u)
    SOBOL_BIT(18u, 0xa000a000u, 0x8e606000u, 0xfbea2000u) SOBOL_BIT(19u, 0xf000f000u, 0xc5909000u, 0x75d93000u)
    SOBOL_BIT(20u, 0x88008800u, 0x6868e800u, 0xa0858800u) SOBOL_BIT(21u, 0xcc00cc00u, 0x9c9c5c00u, 0x914e5400u)
    SOBOL_BIT(22u, 0xaa00aa00u, 0xeeee8e00u, 0xdbe79e00u) SOBOL_BIT(23u, 0xff00ff00u, 0x5555c500u, 0x25db6d00u)
    SOBOL_BIT(24u, 0x80808080u, 0x8000e880u, 0x58800080u) SOBOL_BIT(25u, 0xc0c0c0c0u, 0xc0005cc0u, 0xe54000c0u)
    SOBOL_BIT(26u, 0xa0a0a0a0u, 0x60008e60u, 0x79e00020u) SOBOL_BIT(27u, 0xf0f0f0f0u, 0x9000c590u, 0xb6d00050u)
    SOBOL_BIT(28u, 0x88888888u, 0xe8006868u, 0x800800f8u) SOBOL_BIT(29u, 0xccccccccu, 0x5c009c9cu, 0xc00c0074u)
    SOBOL_BIT(30u, 0xaaaaaaaau, 0x8e00eeeeu, 0x200200a2u) SOBOL_BIT(31u, 0xffffffffu, 0xc5005555u, 0x50050093u)
    return uvec4(bitfieldReverse(index), x);
}

// A permutation in which every bit depends on those below it alone.
uint laine_karras(uint x, uint seed) {
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16u) | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return x;
}

// Owen's scrambling: every bit depends on those above it alone.
uint owen_scramble(uint x, uint seed) { return bitfieldReverse(laine_karras(bitfieldReverse(x), seed)); }

// The bits of x at even places.
uint spread_bits(uint x) {
    x = (x | x << 8u) & 0x00ff00ffu;
    x = (x | x << 4u) & 0x0f0f0f0fu;
    x = (x | x << 2u) & 0x33333333u;
    return (x | x << 1u) & 0x55555555u;
}

Sampler make_sampler(uint kind, uvec2 pixel, uint sample_index, uint seed, uint log2_spp) {
    Sampler s = Sampler(kind, sample_index, pcg(pixel.x + pcg(pixel.y + pcg(seed))), 0u);
    if (kind == SAMPLER_BLUE_NOISE) {
        uint side_bits = 16u - (log2_spp + 1u) / 2u;
        uvec2 tile = pixel >> side_bits;
        uvec2 place = pixel & ((1u << side_bits) - 1u);
        s.index = (spread_bits(place.x) | spread_bits(place.y) << 1u) << log2_spp | sample_index & ((1u << log2_spp) - 1u);
        s.scramble = pcg(tile.x + pcg(tile.y + pcg(seed + pcg(sample_index >> log2_spp))));
    }
    return s;
}

// Point `index` of Sobol's sequence with its order and its values scrambled.
uvec4 scrambled_sobol(uint index, uvec4 seeds) {
    uvec4 x = sobol(owen_scramble(index, pcg(seeds.x ^ seeds.w)));
    return uvec4(owen_scramble(x.x, seeds.x), owen_scramble(x.y, seeds.y), owen_scramble(x.z, seeds.z), owen_scramble(x.w, seeds.w));
}

uvec4 sample_bits(inout Sampler s) {
    uvec4 seeds = pcg4d(uvec4(s.scramble, s.dimension, s.kind, s.kind == SAMPLER_PCG ? s.index : 0u));
    s.dimension++;
    if (s.kind == SAMPLER_PCG) return seeds;
    // For the blue noise the order of the points is the order of the pixels too.
    return scrambled_sobol(s.index, seeds);
}

vec4 sample_4d(inout Sampler s) { return unit_from_bits(sample_bits(s)); }
vec2 sample_2d(inout Sampler s) { return sample_4d(s).xy; }
float sample_1d(inout Sampler s) { return sample_4d(s).x; }
