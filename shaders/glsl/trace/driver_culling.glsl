// Culling on a driver's traversal, for both of its backends. With CULLING_FLAGS every triangle comes to a shader, which is slow: only rays
// that have met a back face are traced again that way.

Hit find_closest(Ray ray, uint mask, uvec2 ray_coverage) {
    Hit hit = closest_hit(ray, mask, ray_coverage, TRACE_FLAGS);
    if (culls(mask) && hit.instance != NONE && is_culled(hit.instance, hit.triangle, ray.direction)) {
        hit = closest_hit(ray, mask, ray_coverage, CULLING_FLAGS);
    }
    return hit;
}

uint find_blocker(Ray ray, uint mask, uvec2 ray_coverage) {
    uint instance = blocker(ray, mask, ray_coverage, TRACE_FLAGS);
    return instance != NONE && culls(mask) ? blocker(ray, mask, ray_coverage, CULLING_FLAGS) : instance;
}

bool find_any(Ray ray, uint mask, uvec2 ray_coverage) {
    bool hit = any_hit(ray, mask, ray_coverage, TRACE_FLAGS);
    return hit && culls(mask) ? any_hit(ray, mask, ray_coverage, CULLING_FLAGS) : hit;
}
