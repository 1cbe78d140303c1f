// EASU in fp16: pairs of half floats take one instruction, and a texel of the tile is half as large. What a display shows of the codes has 8 or 10 bits;
// half floats have 11.
#define ROWS EASU_HALF_ROWS
#include "easu.glsl"
#include "half.glsl"

// Code and luma, 0..2: green carries most of the luminance.
shared f16vec4 tile[TILE.x * TILE.y];

void store_texel(int at, vec3 code) { tile[at] = f16vec4(vec4(code, code.g + 0.5 * (code.r + code.b))); }

struct Edge { f16vec2 gradient, strength; };

// Both axes in one: the gradients, and how much of an edge each is: 1 on a slope, 0 where the gradient reverses (a thin line).
void add_edge(inout Edge edge, f16vec2 before, float16_t here, f16vec2 after, float16_t weight) {
    const float16_t LEAST = 1.0hf / 4096.0hf;
    f16vec2 change = after - before;
    f16vec2 steepest = max(abs(after - here), abs(here - before));
    f16vec2 slope = min(abs(change) * reciprocal(max(steepest, f16vec2(LEAST))), 1.0hf);
    edge.gradient += weight * change;
    edge.strength += weight * (slope * slope);
}

struct Sum { f16vec2 rg, b_luma, weights; };

// Adds two texels beside each other: x of their offsets from the position, and y.
void add_taps(inout Sum sum, f16vec4 left, f16vec4 right, f16vec2 x, float16_t y, f16vec3 metric, float16_t lobe, float16_t end) {
    f16vec2 r = min(x * (metric.x * x + metric.z * y) + metric.y * y * y, end);
    f16vec2 base_window = 0.4hf * r - 1.0hf;
    f16vec2 lobe_window = lobe * r - 1.0hf;
    f16vec2 weight = (25.0hf / 16.0hf * base_window * base_window - 9.0hf / 16.0hf) * (lobe_window * lobe_window);
    sum.rg += weight.x * left.rg;
    sum.b_luma += weight.x * left.ba;
    sum.rg += weight.y * right.rg;
    sum.b_luma += weight.y * right.ba;
    sum.weights += weight;
}

vec3 upsampled(int first, vec2 position) {
    // Rows from the top: b c, e f g h, i j k l, n o, as Lottes names them.
    f16vec4 b = tile[first - TILE.x], c = tile[first - TILE.x + 1];
    f16vec4 e = tile[first - 1], f = tile[first], g = tile[first + 1], h = tile[first + 2];
    f16vec4 i = tile[first + TILE.x - 1], j = tile[first + TILE.x], k = tile[first + TILE.x + 1], l = tile[first + TILE.x + 2];
    f16vec4 n = tile[first + 2 * TILE.x], o = tile[first + 2 * TILE.x + 1];

    f16vec2 at = f16vec2(position);
    f16vec2 across = f16vec2(1.0hf - at.x, at.x);
    f16vec2 upper = across * (1.0hf - at.y), lower = across * at.y;
    Edge edge = Edge(f16vec2(0.0hf), f16vec2(0.0hf));
    add_edge(edge, f16vec2(e.a, b.a), f.a, f16vec2(g.a, j.a), upper.x);
    add_edge(edge, f16vec2(f.a, c.a), g.a, f16vec2(h.a, k.a), upper.y);
    add_edge(edge, f16vec2(i.a, f.a), j.a, f16vec2(k.a, n.a), lower.x);
    add_edge(edge, f16vec2(j.a, g.a), k.a, f16vec2(l.a, o.a), lower.y);
    Window w = window_along(vec2(edge.gradient), float(edge.strength.x + edge.strength.y));
    f16vec3 metric = f16vec3(w.metric);
    float16_t lobe = float16_t(w.lobe), end = float16_t(1.0 / w.lobe);

    Sum sum = Sum(f16vec2(0.0hf), f16vec2(0.0hf), f16vec2(0.0hf));
    f16vec2 middle = f16vec2(0.0hf, 1.0hf) - at.x, left = middle - 1.0hf, right = middle + 1.0hf;
    add_taps(sum, b, c, middle, -1.0hf - at.y, metric, lobe, end);
    add_taps(sum, e, f, left, -at.y, metric, lobe, end);
    add_taps(sum, g, h, right, -at.y, metric, lobe, end);
    add_taps(sum, i, j, left, 1.0hf - at.y, metric, lobe, end);
    add_taps(sum, k, l, right, 1.0hf - at.y, metric, lobe, end);
    add_taps(sum, n, o, middle, 2.0hf - at.y, metric, lobe, end);

    f16vec4 low = min(min(f, g), min(j, k)), high = max(max(f, g), max(j, k));
    float16_t factor = float16_t(1.0 / float(sum.weights.x + sum.weights.y));
    return vec3(clamp(f16vec3(sum.rg, sum.b_luma.x) * factor, low.rgb, high.rgb));
}
