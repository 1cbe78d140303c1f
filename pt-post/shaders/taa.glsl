// Included by taa.comp and taa_pq.comp, which differ in SPACE, the space that history is compared in.
//
// Temporal anti-aliasing and upscaling, on the output extent: this frame's nearest sample blended into the reprojected
// history. After Karis 2014, "High-Quality Temporal Supersampling" (jitter, longest motion, neighbourhood) and Salvi 2016,
// "An Excursion in Temporal Supersampling" (variance clipping), in the PQ space of Quake II RTX.
//
// History holds PQ codes of the radiance (16 bit unorm: steps of 0.1 % and less from 1e-3 cd/m2 up). Its a packs two bytes:
// the weight of what it holds over the greatest there is, and the square root of the mean absolute deviation of the samples from it, in
// codes: a line that is thinner than a pixel is missed by most frames, whose neighbourhoods would then clip it away. Pixels that are not finite count as missing: they reach neither neighbours nor history.
#include "constants.glsl"
#include "finite.glsl"
#include "math.glsl"
#include "post_images.glsl"
#include "post_records.glsl"
#include "pq.glsl"

// A group is a row of threads that go down TAA_ROWS rows of pixels, TAA_COLUMNS wide: each texel of the input is read and
// encoded once, and what a row of the neighbourhood sums up to serves three output rows and more. Without a tile to wait for,
// many groups are under way.
layout(local_size_x = TAA_COLUMNS + 2) in;
layout(push_constant, scalar) uniform Push { TaaPush push; };
layout(set = 2, binding = 0) uniform sampler2D color;
layout(set = 2, binding = 1) uniform sampler2D motion;

// A row of input texels: those of the pixels, as the output is never smaller, and one on either side; a thread each.
const int TEXELS = int(TAA_COLUMNS) + 2;
// Twice: one is read while the next is written. rgb = colour in the space that history is compared in, a = checkerboard flags;
// negative: missing.
shared vec4 row_color[2][TEXELS];
// Its radiance, in half floats.
shared uvec2 row_radiance[2][TEXELS];
shared vec2 row_motion[2][TEXELS];

// Least weight of a sample, so that pixels far from all samples get some light too.
const float MIN_WEIGHT = 0.02;

vec3 encode(vec3 radiance) { return pq_encode(clamp(radiance * (push.pq_scale / 10000.0), 0.0, 1.0)); }

vec3 decode(vec3 code) { return pq_decode(code) * (10000.0 / push.pq_scale); }

// Radiance that can be encoded.
vec3 limited(vec3 radiance) { return clamp(radiance, 0.0, 10000.0 / push.pq_scale); }

vec3 to_blend_space(vec3 radiance) { return SPACE == SPACE_RGB ? limited(radiance) : encode(radiance); }

// Blend space to the space in which history is compared with the neighbourhood, and back.
vec3 to_clip_space(vec3 c) {
    if (SPACE != SPACE_YCOCG) return c;
    return vec3(0.25 * c.r + 0.5 * c.g + 0.25 * c.b, 0.5 * (c.r - c.b), -0.25 * c.r + 0.5 * c.g - 0.25 * c.b);
}

vec3 from_clip_space(vec3 c) {
    if (SPACE != SPACE_YCOCG) return c;
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
            sum += weight[x].x * weight[y].y * textureLod(tex_taa_history_prev, vec2(at[x].x, at[y].y), 0.0).rgb;
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

struct Texel { vec4 color; vec2 motion; };

Texel fetch(ivec2 at) {
    ivec2 inside = clamp(at, ivec2(0), textureSize(color, 0) - 1);
    return Texel(texelFetch(color, inside, 0), texelFetch(motion, inside, 0).xy);
}

void keep(Texel texel, int row) {
    int i = int(gl_LocalInvocationIndex);
    bool found = is_finite(texel.color.rgb);
    vec3 radiance = found ? limited(texel.color.rgb) : vec3(0.0);
    vec4 color = vec4(to_clip_space(to_blend_space(radiance)), max(texel.color.a, 0.0));
    row_color[row & 1][i] = found ? color : vec4(0.0, 0.0, 0.0, -1.0);
    row_radiance[row & 1][i] = uvec2(packHalf2x16(radiance.rg), packHalf2x16(vec2(radiance.b, 0.0)));
    row_motion[row & 1][i] = texel.motion;
}

// Sums of colours and their squares over the texels that are there.
struct Sums { vec3 first; vec3 second; float count; };

// Three texels beside each other.
struct Row {
    Sums sides;
    vec4 middle;
    uvec2 radiance; // of the middle
    vec2 longest;   // motion
};

Sums sum_of(vec4 a, vec4 b) {
    // Missing ones are black.
    return Sums(a.rgb + b.rgb, a.rgb * a.rgb + b.rgb * b.rgb, float(a.a >= 0.0) + float(b.a >= 0.0));
}

Sums sum_of(Row row) {
    vec3 c = row.middle.rgb;
    return Sums(row.sides.first + c, row.sides.second + c * c, row.sides.count + float(row.middle.a >= 0.0));
}

// The first of two of equal length, and not what is NaN.
vec2 longer(vec2 a, vec2 b) { return dot(b, b) > dot(a, a) ? b : a; }

// The row of input texels at.y, of which `texel` is this thread's, round the texel `middle`; fetches the next one.
Row advance(inout Texel texel, ivec2 at, int middle) {
    keep(texel, at.y);
    texel = fetch(at + ivec2(0, 1));
    barrier();
    int parity = at.y & 1;
    Row row;
    row.sides = sum_of(row_color[parity][middle - 1], row_color[parity][middle + 1]);
    row.middle = row_color[parity][middle];
    row.radiance = row_radiance[parity][middle];
    row.longest = vec2(0.0);
    for (int i = -1; i <= 1; ++i) row.longest = longer(row.longest, row_motion[parity][middle + i]);
    return row;
}

// Output pixel p, the neighbourhood of whose sample is three rows. `up` and `up_longest` are of the first. `near`: weight of the
// sample by its distance.
void resolve(ivec2 p, vec2 output_size, float near, Sums up, vec2 up_longest, Row here, Row below) {
    vec2 longest = longer(longer(up_longest, here.longest), below.longest);
    vec2 previous = vec2(p) + 0.5 + longest * output_size;
    vec3 past = vec3(0.0);
    vec2 state = vec2(0.0);
    bool inside = all(greaterThan(previous, vec2(0.0))) && all(lessThan(previous, output_size));
    if (push.reset == 0u && inside) {
        vec4 nearest = texelFetch(tex_taa_history_prev, ivec2(previous), 0);
        past = sample_history(previous, output_size, nearest.rgb);
        state = unpack_state(nearest.a);
    }

    bool found = here.middle.a >= 0.0;
    Sums down = sum_of(below);
    vec3 first = up.first + here.sides.first + down.first;
    vec3 second = up.second + here.sides.second + down.second;
    float count = up.count + here.sides.count + down.count;
    vec3 centre = from_clip_space(here.middle.rgb);
    vec3 radiance = vec3(unpackHalf2x16(here.radiance.x), unpackHalf2x16(here.radiance.y).x);
    if (count > 0.0 && (!found || push.sparkle_limit > 0.0)) {
        vec3 mean = from_clip_space(first / count);
        if (!found) centre = mean;
        if (push.sparkle_limit > 0.0) centre = min(centre, push.sparkle_limit * mean);
        radiance = decode(centre);
    }

    // Moments with the centre as it is now.
    vec3 middle = to_clip_space(centre);
    count += 1.0;
    vec3 mean = (first + middle) / count;
    vec3 deviation = sqrt(max((second + middle * middle) / count - mean * mean, 0.0));
    float flags = max(here.middle.a, 0.0);
    float sigma = push.sigma * (flags == float(SPLIT_FLAGS) ? push.split_sigma : 1.0);

    if (SPACE == SPACE_RGB) past = decode(past);
    vec3 extent = sigma * deviation;
    if (SPACE == SPACE_PQ) extent = max(extent, push.temporal * state.y);
    if (SPACE == SPACE_YCOCG) extent = max(extent, push.temporal * state.y * vec3(1.0, 0.5, 0.5));
    past = from_clip_space(rectify(to_clip_space(past), mean, extent));
    // Against history as it is kept: what was rejected must not widen the box.
    float change = SPACE == SPACE_RGB ? 0.0 : abs(code_luma(centre) - code_luma(past));

    // When something moves the sample always counts.
    float moved = smoothstep(0.0, 1.0, length(longest * output_size));
    float weight = max(moved, near);
    // A full history is a mean of more frames where nothing moves.
    float greatest = 1.0 / min(push.blend, push.blend_still);
    float total = min(state.x * greatest + weight, mix(1.0 / push.blend_still, 1.0 / push.blend, moved));
    float share = min(weight / total, 1.0);
    // The first sample has nothing to deviate from, and what moves leaves nothing to the ground behind it.
    float deviation_now = state.x > 0.0 ? (1.0 - moved) * mix(state.y, change, share) : 0.0;
    // Codes are mixed as they are, or decoded first.
    bool codes = SPACE != SPACE_RGB && push.blend_linear == 0u;
    if (SPACE != SPACE_RGB && !codes) {
        past = decode(clamp(past, 0.0, 1.0));
        centre = radiance;
    }
    vec3 blended = max(mix(past, centre, share), 0.0);
    vec3 code = codes ? min(blended, 1.0) : encode(blended);
    imageStore(im_taa_history, p, vec4(code, float(pack_state(total / greatest, deviation_now)) / 65535.0));
    imageStore(im_resolved, p, vec4(codes ? decode(code) : blended, 1.0));
}

void main() {
    ivec2 output_size = imageSize(im_resolved);
    ivec2 input_size = textureSize(color, 0);
    vec2 scale = vec2(input_size) / vec2(output_size);
    ivec2 corner = ivec2(gl_WorkGroupID.xy) * ivec2(TAA_COLUMNS, TAA_ROWS);
    int thread = int(gl_LocalInvocationIndex);
    ivec2 p = corner + ivec2(thread, 0);
    ivec2 sampled = nearest_sample(p, scale);
    ivec2 at = nearest_sample(corner, scale) + ivec2(thread - 1, -1);
    int middle = min(sampled.x - (at.x - thread), TEXELS - 2);

    Texel texel = fetch(at);
    Row above = advance(texel, at, middle);
    Row here = advance(texel, at + ivec2(0, 1), middle);
    Row below = advance(texel, at + ivec2(0, 2), middle);
    at.y += 3;
    Sums up = sum_of(above);
    vec2 up_longest = above.longest;
    bool shown = thread < int(TAA_COLUMNS) && p.x < output_size.x;
    // Distance of the sample in output pixels.
    float across = abs(float(clamp(sampled.x, 0, input_size.x - 1)) + push.jitter.x - input_position(p, scale).x) / scale.x;
    int end = min(corner.y + int(TAA_ROWS), output_size.y);
    for (; p.y < end; ++p.y) {
        // The same in all threads.
        int y = nearest_sample(p, scale).y;
        for (; sampled.y < y; ++sampled.y, ++at.y) {
            up = sum_of(here);
            up_longest = here.longest;
            here = below;
            below = advance(texel, at, middle);
        }
        float along = abs(float(clamp(y, 0, input_size.y - 1)) + push.jitter.y - input_position(p, scale).y) / scale.y;
        // A sample counts fully within the pixel, less beyond.
        float near = clamp(2.0 - 2.0 * max(across, along), MIN_WEIGHT, 1.0);
        if (shown) resolve(p, vec2(output_size), near, up, up_longest, here, below);
    }
}
