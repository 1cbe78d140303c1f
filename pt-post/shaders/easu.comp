// Edge-adaptive spatial upsampling of display codes (sRGB or PQ, 0..1), on the output extent: AMD FidelityFX Super Resolution
// 1, as described in Lottes 2021, "FidelityFX Super Resolution 1.0" (SIGGRAPH, Advances in Real-Time Rendering).
//
// Twelve texels round the position, a 4 x 4 block without its corners, are weighted with a window that approximates
// Lanczos 2. The window is turned to the local edge, stretched along it and narrowed across, by as much as the luma says
// that there is an edge; the result stays within the four nearest texels, so that nothing rings.
#include "post_records.glsl"
#include "tile.glsl"

// A group does 32 x 16 pixels, each thread EASU_ROWS below each other.
layout(local_size_x = 32, local_size_y = 16 / EASU_ROWS) in;
layout(push_constant, scalar) uniform Push { EasuPush push; };
layout(set = 2, binding = 0) uniform sampler2D source;
layout(set = 2, binding = 1, rgba16f) uniform writeonly image2D target;

const ivec2 GROUP = ivec2(32, 16);
const int THREADS = 32 * 16 / int(EASU_ROWS);
// The texels of a group's pixels, which are never fewer than they, with the block's border and one for rounding.
const ivec2 TILE = GROUP + 4;
shared vec4 tile[TILE.x * TILE.y];
// Green carries most of the luminance; 0..2. By itself: neighbours then lie in different banks.
shared float tile_luma[TILE.x * TILE.y];

// Below this squared gradient there is no direction.
const float FLAT = 1.0 / 32768.0;

struct Edge { vec2 gradient; float strength; };

// One axis: the gradient, and how much of an edge it is: 1 on a slope, 0 where the gradient reverses (a thin line).
vec2 axis(float before, float here, float after) {
    float change = after - before;
    float steepest = max(abs(after - here), abs(here - before));
    float edge = steepest > 0.0 ? min(abs(change) / steepest, 1.0) : 0.0;
    return vec2(change, edge * edge);
}

void add_edge(inout Edge edge, int at, float weight) {
    vec2 x = axis(tile_luma[at - 1], tile_luma[at], tile_luma[at + 1]);
    vec2 y = axis(tile_luma[at - TILE.x], tile_luma[at], tile_luma[at + TILE.x]);
    edge.gradient += weight * vec2(x.x, y.x);
    edge.strength += weight * (x.y + y.y);
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
            int at = place.y * TILE.x + place.x;
            tile[at] = vec4(c[k], 0.0);
            tile_luma[at] = c[k].g + 0.5 * (c[k].r + c[k].b);
        }
    }
}

// The pixel at f in 0..1 between the texel `first` of the tile and its right, lower and diagonal neighbours.
vec3 upsampled(int first, vec2 f) {
    Edge edge = Edge(vec2(0.0), 0.0);
    add_edge(edge, first, (1.0 - f.x) * (1.0 - f.y));
    add_edge(edge, first + 1, f.x * (1.0 - f.y));
    add_edge(edge, first + TILE.x, (1.0 - f.x) * f.y);
    add_edge(edge, first + TILE.x + 1, f.x * f.y);
    float squared = dot(edge.gradient, edge.gradient);
    vec2 across = squared < FLAT ? vec2(1.0, 0.0) : edge.gradient * inversesqrt(squared);
    float strength = 0.25 * edge.strength * edge.strength; // 0..1

    // A diagonal needs a wider window across: sqrt(2) at 45 degrees. Along the edge it is up to twice as long.
    float diagonal = 1.0 / max(abs(across.x), abs(across.y));
    vec2 squeeze = vec2(mix(1.0, diagonal, strength), 1.0 - 0.5 * strength);
    squeeze *= squeeze;
    // The squared distance, turned and squeezed: metric.x x^2 + metric.y y^2 + metric.z x y.
    vec3 metric = vec3(dot(squeeze, across * across), dot(squeeze, across.yx * across.yx),
                       2.0 * (squeeze.x - squeeze.y) * across.x * across.y);
    // Negative lobe: from a full one (window of radius 2 / sqrt 2) on flat ground to nearly none (radius 2) on edges.
    float lobe = mix(0.5, 0.21, strength);
    float end = 1.0 / lobe;

    vec3 sum = vec3(0.0);
    float weights = 0.0;
    for (int y = -1; y <= 2; ++y) {
        for (int x = -1; x <= 2; ++x) {
            if ((x == -1 || x == 2) && (y == -1 || y == 2)) continue;
            vec2 d = vec2(x, y) - f;
            float r = min(d.x * (metric.x * d.x + metric.z * d.y) + metric.y * d.y * d.y, end);
            float base_window = 0.4 * r - 1.0;
            float lobe_window = lobe * r - 1.0;
            float weight = (25.0 / 16.0 * base_window * base_window - 9.0 / 16.0) * lobe_window * lobe_window;
            sum += weight * tile[first + y * TILE.x + x].rgb;
            weights += weight;
        }
    }
    vec3 a = tile[first].rgb;
    vec3 b = tile[first + 1].rgb;
    vec3 c = tile[first + TILE.x].rgb;
    vec3 d = tile[first + TILE.x + 1].rgb;
    vec3 low = min(min(a, b), min(c, d));
    vec3 high = max(max(a, b), max(c, d));
    return clamp(sum / weights, low, high);
}

void main() {
    ivec2 size = imageSize(target);
    vec2 scale = vec2(push.input_size) / vec2(size);
    ivec2 corner = ivec2(gl_WorkGroupID.xy) * GROUP;
    ivec2 base = ivec2(floor(input_position(corner, scale))) - 1;
    ivec2 end = ivec2(floor(input_position(corner + GROUP - 1, scale))) + 3;
    load_tile(base, min(end - base, TILE));
    barrier();

    ivec2 p = corner + ivec2(gl_LocalInvocationID.xy) * ivec2(1, EASU_ROWS);
    if (p.x >= size.x) return;
    for (int i = 0; i < int(EASU_ROWS) && p.y < size.y; ++i, ++p.y) {
        vec2 position = input_position(p, scale);
        ivec2 texel = ivec2(floor(position));
        vec3 code = upsampled((texel.y - base.y) * TILE.x + texel.x - base.x, position - vec2(texel));
        imageStore(target, p, vec4(code, 1.0));
    }
}
