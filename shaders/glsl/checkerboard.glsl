// Split frame <-> flat frame. The even field (flat x and y of equal parity) is the left half of a split image, the odd
// field the right half; each is `field_width = ceil(W/2)` wide. The host twin is pt_core::split.

// For odd W the last column of one field has no flat pixel: x comes out as W there.
ivec2 split_to_flat(ivec2 split, int field_width) {
    bool odd_field = split.x >= field_width;
    int x = odd_field ? split.x - field_width : split.x;
    return ivec2(2 * x + ((split.y & 1) ^ (odd_field ? 1 : 0)), split.y);
}

ivec2 flat_to_split(ivec2 flat_pixel, int field_width) {
    bool odd_field = ((flat_pixel.x ^ flat_pixel.y) & 1) != 0;
    return ivec2((flat_pixel.x >> 1) + (odd_field ? field_width : 0), flat_pixel.y);
}
