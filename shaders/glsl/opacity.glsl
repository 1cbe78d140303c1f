// Opacity tables (pt-scene/src/opacity.rs): each edge of an alpha-tested triangle is cut into OPACITY_SIDE parts, which makes OPACITY_SIDE^2
// micro-triangles. They are numbered along the first edge, row by row; a row has those that stand as the triangle does on even places, the
// others between them.

uint opacity_state(MeshRecord mesh, uint triangle, vec2 bary) {
    vec2 at = bary * float(OPACITY_SIDE);
    uvec2 cell = uvec2(clamp(floor(at), vec2(0.0), vec2(float(OPACITY_SIDE) - 1.0)));
    cell.x = min(cell.x, OPACITY_SIDE - 1u - cell.y);
    bool between = cell.x + cell.y + 1u < OPACITY_SIDE && at.x + at.y > float(cell.x + cell.y + 1u);
    uint number = cell.y * (2u * OPACITY_SIDE - cell.y) + 2u * cell.x + (between ? 1u : 0u);
    uint word = UintTable(mesh.opacity).at[4u * (triangle - mesh.first_masked) + number / 16u];
    return word >> 2u * (number % 16u) & 3u;
}
