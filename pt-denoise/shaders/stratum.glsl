// Strata: squares of stratum_side x stratum_side pixels of the flat frame, of which one may be a gradient pixel. The kernel declares `push` with `size`.
layout(constant_id = 8) const int stratum_side = 3;

ivec2 stratum_count() { return (ivec2(push.size) + stratum_side - 1) / stratum_side; }

// Pixel of a stratum with a number, counted in rows.
ivec2 stratum_pixel(ivec2 stratum, int number) {
    return stratum * stratum_side + ivec2(number % stratum_side, number / stratum_side);
}

// What channel gradient_sample says of a stratum whose gradient pixel this is: 1 + its number.
float gradient_number(ivec2 pixel) {
    ivec2 within = pixel % stratum_side;
    return float(1 + within.y * stratum_side + within.x);
}
