// Moves a point off its surface along the unit normal by some 256 units in the last place: Waechter and Binder 2019, "A Fast and
// Robust Method for Avoiding Self-Intersection", Ray Tracing Gems ch. 6. Near the origin, where those units vanish, by a fixed length.
// `near`: what is near, metres (SceneRecord::near_origin).
vec3 offset_point(vec3 p, vec3 n, float near) {
    ivec3 steps = ivec3(256.0 * n);
    ivec3 away_from_zero = mix(steps, -steps, lessThan(p, vec3(0.0)));
    vec3 moved = intBitsToFloat(floatBitsToInt(p) + away_from_zero);
    return mix(moved, p + n * (near * (1.0 / 2048.0)), lessThan(abs(p), vec3(near)));
}
