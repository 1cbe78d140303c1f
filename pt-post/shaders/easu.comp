// EASU in fp32, for devices without fp16 arithmetic.
#define ROWS EASU_ROWS
#include "easu.glsl"

shared vec4 tile[TILE.x * TILE.y];
// Green carries most of the luminance; 0..2. By itself: neighbours then lie in different banks.
shared float tile_luma[TILE.x * TILE.y];

void store_texel(int at, vec3 code) {
    tile[at] = vec4(code, 0.0);
    tile_luma[at] = code.g + 0.5 * (code.r + code.b);
}

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

vec3 upsampled(int first, vec2 f) {
    Edge edge = Edge(vec2(0.0), 0.0);
    add_edge(edge, first, (1.0 - f.x) * (1.0 - f.y));
    add_edge(edge, first + 1, f.x * (1.0 - f.y));
    add_edge(edge, first + TILE.x, (1.0 - f.x) * f.y);
    add_edge(edge, first + TILE.x + 1, f.x * f.y);
    Window w = window_along(edge.gradient, edge.strength);
    float end = 1.0 / w.lobe;

    vec3 sum = vec3(0.0);
    float weights = 0.0;
    for (int y = -1; y <= 2; ++y) {
        for (int x = -1; x <= 2; ++x) {
            if ((x == -1 || x == 2) && (y == -1 || y == 2)) continue;
            vec2 d = vec2(x, y) - f;
            float r = min(d.x * (w.metric.x * d.x + w.metric.z * d.y) + w.metric.y * d.y * d.y, end);
            float base_window = 0.4 * r - 1.0;
            float lobe_window = w.lobe * r - 1.0;
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
