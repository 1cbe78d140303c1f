// Temporal anti-aliasing and upscaling, on the output extent: this frame's nearest sample blended into the reprojected
// history. After Karis 2014, "High-Quality Temporal Supersampling" (jitter, longest motion, neighbourhood) and Salvi 2016,
// "An Excursion in Temporal Supersampling" (variance clipping), in the PQ space of Quake II RTX.
//
// History holds PQ codes of the radiance (16 bit unorm: steps of 0.1 % and less from 1e-3 cd/m2 up). Its a packs two bytes:
// the weight of what it holds over the greatest there is, and the square root of the mean absolute deviation of the samples from it, in
// codes: a line that is thinner than a pixel is missed by most frames, whose neighbourhoods would then clip it away. Pixels that are not finite count as missing: they reach neither neighbours nor history.
#include "finite.glsl"
#include "math.glsl"
#include "post_records.glsl"
#include "pq.glsl"
#include "tile.glsl"

// A group does 32 x 16 pixels, each thread TAA_ROWS below each other: what a row of the neighbourhood sums up to is used for three
// output rows and more.
layout(local_size_x = 32, local_size_y = 16 / TAA_ROWS) in;
layout(push_constant, scalar) uniform Push { TaaPush push; };
layout(set = 2, binding = 0) uniform sampler2D color;
layout(set = 2, binding = 1) uniform sampler2D motion;
layout(set = 2, binding = 2) uniform sampler2D history;
layout(set = 2, binding = 3, rgba16) uniform writeonly image2D new_history;
layout(set = 2, binding = 4, rgba16f) uniform writeonly image2D resolved;

const ivec2 GROUP = ivec2(32, 16);
const int THREADS = 32 * 16 / int(TAA_ROWS);
// The input texels of a group's pixels with a border of one, and one for rounding: the output is never smaller.
const ivec2 TILE = GROUP + 3;
// rgb = colour in the space that history is compared in, a = checkerboard flags; negative: missing.
shared vec4 tile_color[TILE.x * TILE.y];
// Its radiance, in half floats.
shared uvec2 tile_radiance[TILE.x * TILE.y];
shared vec2 tile_motion[TILE.x * TILE.y];

// Least weight of a sample, so that pixels far from all samples get some light too.
const float MIN_WEIGHT = 0.02;
const float SPLIT_FLAGS = 6.0;

vec3 encode(vec3 radiance) { return pq_encode(clamp(radiance * (push.pq_scale / 10000.0), 0.0, 1.0)); }

vec3 decode(vec3 code) { return pq_decode(code) * (10000.0 / push.pq_scale); }

// Radiance that can be encoded.
vec3 limited(vec3 radiance) { return clamp(radiance, 0.0, 10000.0 / push.pq_scale); }

vec3 to_blend_space(vec3 radiance) { return push.space == SPACE_RGB ? limited(radiance) : encode(radiance); }

// Blend space to the space in which history is compared with the neighbourhood, and back.
vec3 to_clip_space(vec3 c) {
    if (push.space != SPACE_YCOCG) return c;
    return vec3(0.25 * c.r + 0.5 * c.g + 0.25 * c.b, 0.5 * (c.r - c.b), -0.25 * c.r + 0.5 * c.g - 0.25 * c.b);
}

vec3 from_clip_space(vec3 c) {
    if (push.space != SPACE_YCOCG) return c;
    float t = c.x - c.z;
    return vec3(t + c.y, c.x + c.z, t - c.y);
}

// Where the output pixel's centre lies in the input, texel centres at whole numbers.
vec2 input_position(ivec2 p, vec2 scale) { return (vec2(p) + 0.5) * scale - 0.5; }

ivec2 nearest_sample(ivec2 p, vec2 scale) { return ivec2(floor(input_position(p, scale) - push.jitter + 0.5)); }

// Catmull-Rom interpolation from nine bilinear taps (the two middle texels of each axis in one). `nearest`: the texel there.
vec3 sample_history(vec2 position, vec2 size, vec3 nearest) {
    vec2 centre = floor(position - 0.5) + 0.5;
    vec2 f = position - centre;
    // On a texel centre, as with a camera that stands still, the filter is the texel.
    if (all(lessThan(abs(f), vec2(1e-4)))) return nearest;
    vec2 w0 = f * (-0.5 + f * (1.0 - 0.5 * f));
    vec2 w1 = 1.0 + f * f * (-2.5 + 1.5 * f);
    vec2 w3 = f * f * (-0.5 + 0.5 * f);
    vec2 w2 = 1.0 - w0 - w1 - w3;
    vec2 w12 = w1 + w2;
    vec2 at[3] = vec2[3]((centre - 1.0) / size, (centre + w2 / w12) / size, (centre + 2.0) / size);
    vec2 weight[3] = vec2[3](w0, w12, w3);
    vec3 sum = vec3(0.0);
    for (int y = 0; y < 3; ++y) {
        for (int x = 0; x < 3; ++x) {
            sum += weight[x].x * weight[y].y * textureLod(history, vec2(at[x].x, at[y].y), 0.0).rgb;
        }
    }
    return clamp(sum, 0.0, 1.0);
}

uint pack_state(float weight, float deviation) {
    uvec2 bytes = uvec2(clamp(vec2(weight, sqrt(deviation)), 0.0, 1.0) * 255.0 + 0.5);
    return bytes.x << 8 | bytes.y;
}

// x = weight, y = deviation.
vec2 unpack_state(float a) {
    uint word = uint(a * 65535.0 + 0.5);
    vec2 state = vec2(word >> 8, word & 255u) / 255.0;
    return vec2(state.x, state.y * state.y);
}

float code_luma(vec3 c) { return 0.25 * c.r + 0.5 * c.g + 0.25 * c.b; }

vec3 rectify(vec3 c, vec3 mean, vec3 extent) {
    if (push.rectify == RECTIFY_OFF) return c;
    vec3 offset = c - mean;
    if (push.rectify == RECTIFY_CLAMP) return mean + clamp(offset, -extent, extent);
    vec3 outside = abs(offset) / max(extent, 1e-7);
    return mean + offset / max(max_component(outside), 1.0);
}

void load_tile(ivec2 base, ivec2 extent, ivec2 input_size) {
    const int BATCH = 3; // texels on their way at a time
    int count = extent.x * extent.y;
    for (int first = int(gl_LocalInvocationIndex); first < count; first += BATCH * THREADS) {
        vec4 c[BATCH];
        vec2 m[BATCH];
        for (int k = 0; k < BATCH; ++k) {
            ivec2 at = clamp(base + tile_place(first + k * THREADS, extent.x), ivec2(0), input_size - 1);
            c[k] = texelFetch(color, at, 0);
            m[k] = texelFetch(motion, at, 0).xy;
        }
        for (int k = 0; k < BATCH; ++k) {
            int i = first + k * THREADS;
            if (i >= count) continue;
            ivec2 place = tile_place(i, extent.x);
            int at = place.y * TILE.x + place.x;
            bool found = is_finite(c[k].rgb);
            vec3 radiance = found ? limited(c[k].rgb) : vec3(0.0);
            vec4 color = vec4(to_clip_space(to_blend_space(radiance)), max(c[k].a, 0.0));
            tile_color[at] = found ? color : vec4(0.0, 0.0, 0.0, -1.0);
            tile_radiance[at] = uvec2(packHalf2x16(radiance.rg), packHalf2x16(vec2(radiance.b, 0.0)));
            tile_motion[at] = m[k];
        }
    }
}

// Three texels of the tile beside each other.
struct Row {
    // Sums over the left and the right one, as far as they are there, of colours and their squares.
    vec3 sides;
    vec3 side_squares;
    float side_count;
    vec4 middle;
    vec2 longest; // motion
};

Row row_at(int middle) {
    vec4 left = tile_color[middle - 1];
    vec4 right = tile_color[middle + 1];
    // Missing ones are black.
    Row row;
    row.sides = left.rgb + right.rgb;
    row.side_squares = left.rgb * left.rgb + right.rgb * right.rgb;
    row.side_count = float(left.a >= 0.0) + float(right.a >= 0.0);
    row.middle = tile_color[middle];
    row.longest = vec2(0.0);
    for (int i = -1; i <= 1; ++i) {
        vec2 m = tile_motion[middle + i];
        // Not true of NaN either.
        if (dot(m, m) > dot(row.longest, row.longest)) row.longest = m;
    }
    return row;
}

vec2 longer(vec2 a, vec2 b) { return dot(b, b) > dot(a, a) ? b : a; }

// Output pixel p, whose neighbourhood is three rows round the input texel `sampled`.
void resolve(ivec2 p, ivec2 output_size, ivec2 input_size, ivec2 sampled, Row above, Row here, Row below,
             uvec2 packed_radiance) {
    vec2 scale = vec2(input_size) / vec2(output_size);
    vec2 longest = longer(longer(above.longest, here.longest), below.longest);
    vec2 previous = vec2(p) + 0.5 + longest * vec2(output_size);
    vec3 past = vec3(0.0);
    vec2 state = vec2(0.0);
    bool inside = all(greaterThan(previous, vec2(0.0))) && all(lessThan(previous, vec2(output_size)));
    if (push.reset == 0u && inside) {
        vec4 nearest = texelFetch(history, ivec2(previous), 0);
        past = sample_history(previous, vec2(output_size), nearest.rgb);
        state = unpack_state(nearest.a);
    }

    bool found = here.middle.a >= 0.0;
    vec3 up = above.middle.rgb;
    vec3 down = below.middle.rgb;
    vec3 first = above.sides + up + here.sides + below.sides + down;
    vec3 second = above.side_squares + up * up + here.side_squares + below.side_squares + down * down;
    float count = above.side_count + here.side_count + below.side_count
                + float(above.middle.a >= 0.0) + float(below.middle.a >= 0.0);
    vec3 centre = from_clip_space(here.middle.rgb);
    vec3 radiance = vec3(unpackHalf2x16(packed_radiance.x), unpackHalf2x16(packed_radiance.y).x);
    if (count > 0.0) {
        vec3 mean = from_clip_space(first / count);
        vec3 changed = found ? centre : mean;
        if (push.sparkle_limit > 0.0) changed = min(changed, push.sparkle_limit * mean);
        if (changed != centre) radiance = decode(changed);
        centre = changed;
    }

    // Moments with the centre as it is now.
    vec3 middle = to_clip_space(centre);
    count += 1.0;
    vec3 mean = (first + middle) / count;
    vec3 deviation = sqrt(max((second + middle * middle) / count - mean * mean, 0.0));
    float flags = max(here.middle.a, 0.0);
    float sigma = push.sigma * (flags == SPLIT_FLAGS ? push.split_sigma : 1.0);

    if (push.space == SPACE_RGB) past = decode(past);
    vec3 extent = sigma * deviation;
    if (push.space == SPACE_PQ) extent = max(extent, push.temporal * state.y);
    if (push.space == SPACE_YCOCG) extent = max(extent, push.temporal * state.y * vec3(1.0, 0.5, 0.5));
    past = from_clip_space(rectify(to_clip_space(past), mean, extent));
    // Against history as it is kept: what was rejected must not widen the box.
    float change = push.space == SPACE_RGB ? 0.0 : abs(code_luma(centre) - code_luma(past));

    // A sample counts fully within the pixel, less beyond, by its distance in output pixels; when things move it always does.
    vec2 offset = (vec2(clamp(sampled, ivec2(0), input_size - 1)) + push.jitter - input_position(p, scale)) / scale;
    float moved = smoothstep(0.0, 1.0, length(longest * vec2(output_size)));
    float weight = clamp(max(moved, 2.0 - 2.0 * max(abs(offset.x), abs(offset.y))), MIN_WEIGHT, 1.0);
    // A full history is a mean of more frames where nothing moves.
    float greatest = 1.0 / min(push.blend, push.blend_still);
    float total = min(state.x * greatest + weight, mix(1.0 / push.blend_still, 1.0 / push.blend, moved));
    float share = min(weight / total, 1.0);
    // The first sample has nothing to deviate from, and what moves leaves nothing to the ground behind it.
    float deviation_now = state.x > 0.0 ? (1.0 - moved) * mix(state.y, change, share) : 0.0;
    // Codes are mixed as they are, or decoded first.
    bool codes = push.space != SPACE_RGB && push.blend_linear == 0u;
    if (push.space != SPACE_RGB && !codes) {
        past = decode(clamp(past, 0.0, 1.0));
        centre = radiance;
    }
    vec3 blended = max(mix(past, centre, share), 0.0);
    vec3 code = codes ? min(blended, 1.0) : encode(blended);
    imageStore(new_history, p, vec4(code, float(pack_state(total / greatest, deviation_now)) / 65535.0));
    imageStore(resolved, p, vec4(codes ? decode(code) : blended, 1.0));
}

void main() {
    ivec2 output_size = imageSize(resolved);
    ivec2 input_size = textureSize(color, 0);
    vec2 scale = vec2(input_size) / vec2(output_size);
    ivec2 corner = ivec2(gl_WorkGroupID.xy) * GROUP;
    ivec2 base = nearest_sample(corner, scale) - 1;
    load_tile(base, min(nearest_sample(corner + GROUP - 1, scale) + 2 - base, TILE), input_size);
    barrier();

    ivec2 p = corner + ivec2(gl_LocalInvocationID.xy) * ivec2(1, TAA_ROWS);
    if (p.x >= output_size.x) return;
    ivec2 sampled = nearest_sample(p, scale);
    int at = (sampled.y - base.y) * TILE.x + sampled.x - base.x;
    Row above = row_at(at - TILE.x);
    Row here = row_at(at);
    Row below = row_at(at + TILE.x);
    for (int i = 0; i < int(TAA_ROWS) && p.y < output_size.y; ++i, ++p.y) {
        int y = nearest_sample(p, scale).y;
        for (; sampled.y < y; ++sampled.y) {
            at += TILE.x;
            above = here;
            here = below;
            below = row_at(at + TILE.x);
        }
        resolve(p, output_size, input_size, sampled, above, here, below, tile_radiance[at]);
    }
}
