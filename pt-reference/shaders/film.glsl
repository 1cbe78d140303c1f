// The sums of a pixel. Sums are kept in two floats each, 48 bits: what rounding drops from `sum` goes to `rest` (Knuth's two-sum;
// Neumaier 1974), so that a mean does not drift however many samples there are.
#include "records.glsl"
#include "reference_records.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 4) buffer CounterTable { uint at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer FirstHitTable { FirstHitPixel at[]; };

// What rounding drops from sum + x.
vec3 rounding_error(vec3 sum, vec3 x) {
    // `precise`: zero in real arithmetic.
    precise vec3 total = sum + x;
    precise vec3 taken = total - sum;
    precise vec3 error = (sum - (total - taken)) + (x - taken);
    return error;
}

void add_sample(inout FilmPixel pixel, vec3 radiance) {
    pixel.sum_rest += rounding_error(pixel.sum, radiance);
    pixel.sum += radiance;
    vec3 square = radiance * radiance;
    pixel.square_rest += rounding_error(pixel.square, square);
    pixel.square += square;
}

// Neither NaN nor so large that its square is infinite.
bool is_countable(vec3 radiance) { return all(lessThan(abs(radiance), vec3(1e19))); }
