// Edge-adaptive spatial upsampling of display codes (sRGB or PQ, 0..1), on the output extent: AMD FidelityFX Super Resolution
// 1, as described in Lottes 2021, "FidelityFX Super Resolution 1.0" (SIGGRAPH, Advances in Real-Time Rendering).
//
// Twelve texels round the position, a 4 x 4 block without its corners, are weighted with a window that approximates
// Lanczos 2. The window is turned to the local edge, stretched along it and narrowed across, by as much as the luma says
// that there is an edge; the result stays within the four nearest texels, so that nothing rings.
#include "post_records.glsl"

layout(local_size_x = 16, local_size_y = 16) in;
layout(push_constant, scalar) uniform Push { EasuPush push; };
layout(set = 2, binding = 0) uniform sampler2D source;
layout(set = 2, binding = 1, rgba16f) uniform writeonly image2D target;

// The texels of a group's 16 x 16 pixels, which are never fewer than they, with the block's border.
const int TILE = 20;
shared vec4 tile[TILE * TILE]; // a = luma

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
    vec2 x = axis(tile[at - 1].a, tile[at].a, tile[at + 1].a);
    vec2 y = axis(tile[at - TILE].a, tile[at].a, tile[at + TILE].a);
    edge.gradient += weight * vec2(x.x, y.x);
    edge.strength += weight * (x.y + y.y);
}

void main() {
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = imageSize(target);
    ivec2 input_size = ivec2(push.input_size);
    vec2 scale = vec2(input_size) / vec2(size);

    ivec2 base = ivec2(floor((vec2(gl_WorkGroupID.xy * 16u) + 0.5) * scale - 0.5)) - 1;
    for (int i = int(gl_LocalInvocationIndex); i < TILE * TILE; i += 256) {
        ivec2 at = clamp(base + ivec2(i % TILE, i / TILE), ivec2(0), input_size - 1);
        vec3 c = texelFetch(source, at, 0).rgb;
        // Green carries most of the luminance; 0..2.
        tile[i] = vec4(c, c.g + 0.5 * (c.r + c.b));
    }
    barrier();
    if (any(greaterThanEqual(p, size))) return;

    vec2 position = (vec2(p) + 0.5) * scale - 0.5;
    ivec2 corner = ivec2(floor(position));
    vec2 f = position - vec2(corner);
    int first = (corner.y - base.y) * TILE + corner.x - base.x;

    Edge edge = Edge(vec2(0.0), 0.0);
    add_edge(edge, first, (1.0 - f.x) * (1.0 - f.y));
    add_edge(edge, first + 1, f.x * (1.0 - f.y));
    add_edge(edge, first + TILE, (1.0 - f.x) * f.y);
    add_edge(edge, first + TILE + 1, f.x * f.y);
    float squared = dot(edge.gradient, edge.gradient);
    vec2 across = squared < FLAT ? vec2(1.0, 0.0) : edge.gradient * inversesqrt(squared);
    float strength = 0.25 * edge.strength * edge.strength; // 0..1

    // A diagonal needs a wider window across: sqrt(2) at 45 degrees. Along the edge it is up to twice as long.
    float diagonal = 1.0 / max(abs(across.x), abs(across.y));
    vec2 squeeze = vec2(mix(1.0, diagonal, strength), 1.0 - 0.5 * strength);
    // Negative lobe: from a full one (window of radius 2 / sqrt 2) on flat ground to nearly none (radius 2) on edges.
    float lobe = mix(0.5, 0.21, strength);
    float end = 1.0 / lobe;

    vec3 sum = vec3(0.0);
    float weights = 0.0;
    for (int i = 1; i < 15; ++i) {
        if (i == 3 || i == 12) continue; // corners, with 0 and 15
        ivec2 tap = ivec2(i % 4, i / 4) - 1;
        vec2 d = vec2(tap) - f;
        d = vec2(dot(d, across), dot(d, vec2(-across.y, across.x))) * squeeze;
        float r = min(dot(d, d), end);
        float base_window = 0.4 * r - 1.0;
        float lobe_window = lobe * r - 1.0;
        float weight = (25.0 / 16.0 * base_window * base_window - 9.0 / 16.0) * lobe_window * lobe_window;
        sum += weight * tile[first + tap.y * TILE + tap.x].rgb;
        weights += weight;
    }
    vec3 a = tile[first].rgb;
    vec3 b = tile[first + 1].rgb;
    vec3 c = tile[first + TILE].rgb;
    vec3 d = tile[first + TILE + 1].rgb;
    vec3 low = min(min(a, b), min(c, d));
    vec3 high = max(max(a, b), max(c, d));
    imageStore(target, p, vec4(clamp(sum / weights, low, high), 1.0));
}
