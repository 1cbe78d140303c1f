// Where the surface of a pixel was in the last frame: Schied et al. 2017, section 4.1. Each of the four pixels round that place is tested by
// itself, in whichever checkerboard field it lies. The kernel declares `push` with `size`, `depth`, `normal` and `reset`.
#include "channels.glsl"
#include "checkerboard.glsl"
#include "denoise_images.glsl"
#include "finite.glsl"
#include "pack.glsl"

// Pixels of the split frame, with the bilinear weights of those that show the same surface; 0: another surface.
struct Taps { ivec2 at[4]; float weight[4]; };

bool inside(ivec2 at) { return all(greaterThanEqual(at, ivec2(0))) && all(lessThan(at, ivec2(push.size))); }

int field_width() { return (int(push.size.x) + 1) / 2; }

bool is_surface(ivec2 at) { return floatBitsToUint(imageLoad(ch_shading_position, at).w) != 0u; }

// What identifies the surface and its path; 0 = none. Materials beyond 2^29 would only share numbers.
uint surface_word(ivec2 at, uint flags) {
    uint material = floatBitsToUint(imageLoad(ch_shading_position, at).w);
    return material == 0u ? 0u : max(material << 3 | flags, 1u);
}

struct Reprojection {
    vec2 place;      // of the surface in the last frame, pixels of the flat frame
    float depth;     // its distance there, metres
    float tolerance; // of that distance
    vec3 normal;     // vertex normal
    uint word;       // surface_word()
    bool two_paths;  // the fields show two paths
    bool valid;
};

Reprojection reproject(ivec2 pixel, ivec2 at, uint word, uint flags) {
    Reprojection r;
    vec4 motion = imageLoad(ch_motion, at);
    r.place = vec2(pixel) + motion.xy * vec2(push.size);
    r.depth = imageLoad(ch_view_depth, at).x + motion.z;
    r.tolerance = push.depth * abs(r.depth) + 2.0 / max(motion.w, 1e-18);
    r.normal = unpack_unit_vector(imageLoad(ch_vertex_normal, at).x);
    r.word = word;
    r.two_paths = bitCount(flags) > 1;
    // Far outside an integer could overflow.
    r.valid = word != 0u && push.reset == 0u && is_finite(motion.xyz) && all(lessThanEqual(abs(r.place), vec2(1e6)));
    return r;
}

// Whether `tap` of the last frame's flat pixels shows the surface of `pixel`.
bool shows_surface(Reprojection r, ivec2 pixel, ivec2 tap) {
    if (!inside(tap) || r.two_paths && ((tap.x ^ tap.y ^ pixel.x ^ pixel.y) & 1) != 0) return false;
    ivec2 from = flat_to_split(tap, field_width());
    if (imageLoad(im_surface_prev, from).x != r.word) return false;
    if (!(abs(imageLoad(ch_view_depth_prev, from).x - r.depth) <= r.tolerance)) return false;
    return dot(unpack_unit_vector(imageLoad(ch_vertex_normal_prev, from).x), r.normal) >= push.normal;
}

Taps find_taps(Reprojection r, ivec2 pixel) {
    Taps taps = Taps(ivec2[4](ivec2(0), ivec2(0), ivec2(0), ivec2(0)), float[4](0.0, 0.0, 0.0, 0.0));
    if (!r.valid) return taps;
    ivec2 corner = ivec2(floor(r.place));
    vec2 f = r.place - vec2(corner);
    for (int i = 0; i < 4; ++i) {
        ivec2 offset = ivec2(i & 1, i >> 1), tap = corner + offset;
        float weight = (offset.x == 1 ? f.x : 1.0 - f.x) * (offset.y == 1 ? f.y : 1.0 - f.y);
        if (weight < 1e-3 || !shows_surface(r, pixel, tap)) continue;
        taps.at[i] = flat_to_split(tap, field_width());
        taps.weight[i] = weight;
    }
    return taps;
}
