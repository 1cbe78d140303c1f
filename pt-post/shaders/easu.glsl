// What both precisions of EASU share: `easu.comp` in fp32, `easu_half.comp` in fp16. AMD FidelityFX Super Resolution 1, as described in Lottes 2021,
// "FidelityFX Super Resolution 1.0" (SIGGRAPH, Advances in Real-Time Rendering).
//
// Edge-adaptive spatial upsampling of display codes (sRGB or PQ, 0..1), on the output extent. Twelve texels round the position, a 4 x 4 block without
// its corners, are weighted with a window that approximates Lanczos 2. The window is turned to the local edge, stretched along it and narrowed across,
// by as much as the luma says that there is an edge; the result stays within the four nearest texels, so that nothing rings.
//
// The including kernel defines ROWS, declares the tile, and defines store_texel() and upsampled().
#include "post_records.glsl"
#include "tile.glsl"

// A group does 32 x 16 pixels, each thread ROWS below each other.
layout(local_size_x = 32, local_size_y = 16 / ROWS) in;
layout(push_constant, scalar) uniform Push { EasuPush push; };
layout(set = 2, binding = 0) uniform sampler2D source;
layout(set = 2, binding = 1, rgba16f) uniform writeonly image2D target;

const ivec2 GROUP = ivec2(32, 16);
const int THREADS = 32 * 16 / int(ROWS);
// The texels of a group's pixels, which are never fewer than they, with the block's border and one for rounding.
const ivec2 TILE = GROUP + 4;

// Below this squared gradient there is no direction.
const float FLAT = 1.0 / 32768.0;

// Sets the texel `at` of the tile.
void store_texel(int at, vec3 code);

// The pixel at f in 0..1 between the texel `first` of the tile and its right, lower and diagonal neighbours.
vec3 upsampled(int first, vec2 f);

// The shape of the window: `metric` gives the squared distance, turned and squeezed, metric.x x^2 + metric.y y^2 + metric.z x y; `lobe` how deep the
// negative lobe is, from a full one (0.5: window of radius 2 / sqrt 2) on flat ground to nearly none (0.21: radius 2) on edges.
struct Window { vec3 metric; float lobe; };

// `edge`: sum over both axes of how much of an edge there is, 0..2.
Window window_along(vec2 gradient, float edge) {
    float squared = dot(gradient, gradient);
    vec2 across = squared < FLAT ? vec2(1.0, 0.0) : gradient * inversesqrt(squared);
    float strength = 0.25 * edge * edge; // 0..1
    // A diagonal needs a wider window across: sqrt(2) at 45 degrees. Along the edge it is up to twice as long.
    float diagonal = 1.0 / max(abs(across.x), abs(across.y));
    vec2 squeeze = vec2(mix(1.0, diagonal, strength), 1.0 - 0.5 * strength);
    squeeze *= squeeze;
    vec3 metric = vec3(dot(squeeze, across * across), dot(squeeze, across.yx * across.yx), 2.0 * (squeeze.x - squeeze.y) * across.x * across.y);
    return Window(metric, mix(0.5, 0.21, strength));
}

// Where the output pixel's centre lies in the input, texel centres at whole numbers.
vec2 input_position(ivec2 p, vec2 scale) { return (vec2(p) + 0.5) * scale - 0.5; }

void load_tile(ivec2 base, ivec2 extent) {
    const int BATCH = 2; // texels on their way at a time
    int count = extent.x * extent.y;
    ivec2 last = ivec2(push.input_size) - 1;
    for (int first = int(gl_LocalInvocationIndex); first < count; first += BATCH * THREADS) {
        vec3 c[BATCH];
        for (int k = 0; k < BATCH; ++k) {
            c[k] = texelFetch(source, clamp(base + tile_place(first + k * THREADS, extent.x), ivec2(0), last), 0).rgb;
        }
        for (int k = 0; k < BATCH; ++k) {
            int i = first + k * THREADS;
            if (i >= count) continue;
            ivec2 place = tile_place(i, extent.x);
            store_texel(place.y * TILE.x + place.x, c[k]);
        }
    }
}

void main() {
    ivec2 size = imageSize(target);
    vec2 scale = vec2(push.input_size) / vec2(size);
    ivec2 corner = ivec2(gl_WorkGroupID.xy) * GROUP;
    ivec2 base = ivec2(floor(input_position(corner, scale))) - 1;
    ivec2 end = ivec2(floor(input_position(corner + GROUP - 1, scale))) + 3;
    load_tile(base, min(end - base, TILE));
    barrier();

    ivec2 p = corner + ivec2(gl_LocalInvocationID.xy) * ivec2(1, ROWS);
    if (p.x >= size.x) return;
    for (int i = 0; i < int(ROWS) && p.y < size.y; ++i, ++p.y) {
        vec2 position = input_position(p, scale);
        ivec2 texel = ivec2(floor(position));
        vec3 code = upsampled((texel.y - base.y) * TILE.x + texel.x - base.x, position - vec2(texel));
        imageStore(target, p, vec4(code, 1.0));
    }
}
