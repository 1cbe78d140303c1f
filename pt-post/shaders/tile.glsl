// Place of the i-th texel of a tile in rows of `width`: exact below 2^20 texels, and cheaper than an integer division.
ivec2 tile_place(int i, int width) {
    int y = int((float(i) + 0.5) / float(width));
    return ivec2(i - y * width, y);
}
