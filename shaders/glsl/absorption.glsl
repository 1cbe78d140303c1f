// Light that passes `length` metres of an absorbing medium (Beer and Lambert), which lets `color` through at `distance`.
vec3 absorption(vec3 color, float distance, float length) {
    return distance > 0.0 ? pow(max(color, vec3(1e-6)), vec3(length / distance)) : vec3(1.0);
}
