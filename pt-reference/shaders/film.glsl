// What a pixel has gathered. Sums are kept in two floats each, 48 bits: what rounding drops from `sum` goes to `rest` (Knuth's
// two-sum; Neumaier 1974), so that a mean does not drift however many samples there are.
#include "reference_records.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 4) buffer FilmTable { FilmPixel at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer FirstHitTable { FirstHitPixel at[]; };

void add_compensated(inout vec3 sum, inout vec3 rest, vec3 x) {
    // `precise`: the error terms are zero in real arithmetic.
    precise vec3 total = sum + x;
    precise vec3 taken = total - sum;
    precise vec3 error = (sum - (total - taken)) + (x - taken);
    rest += error;
    sum = total;
}

void add_sample(inout FilmPixel pixel, vec3 radiance) {
    add_compensated(pixel.sum, pixel.sum_rest, radiance);
    add_compensated(pixel.square, pixel.square_rest, radiance * radiance);
}

// Neither NaN nor so large that its square is infinite.
bool is_countable(vec3 radiance) { return all(lessThan(abs(radiance), vec3(1e19))); }
