// trace.glsl for the ray-query backend: VK_KHR_ray_query in a compute kernel.
layout(local_size_x = 8, local_size_y = 4) in;

uvec2 launch_id() { return gl_GlobalInvocationID.xy; }

#ifdef TRACE_OPAQUE
const uint TRACE_FLAGS = gl_RayFlagsOpaqueEXT;
#else
const uint TRACE_FLAGS = gl_RayFlagsNoneEXT;
#endif

void ray_query(rayQueryEXT query, Ray ray, uint mask, uvec2 ray_coverage, uint flags) {
    rayQueryInitializeEXT(query, accelerationStructureEXT(scene.tlas), flags, mask & 0xffu, ray.origin, ray.t_min, ray.direction, ray.t_max);
    while (rayQueryProceedEXT(query)) {
        // Only the masked geometry is not opaque and comes here, and with CULLING_FLAGS all the rest.
        uint instance = rayQueryGetIntersectionInstanceCustomIndexEXT(query, false);
        uint triangle = mesh_triangle(instance, rayQueryGetIntersectionGeometryIndexEXT(query, false),
                                      rayQueryGetIntersectionPrimitiveIndexEXT(query, false));
        if (stops_ray(ray, instance, triangle, ray_coverage, (flags & CULLING_FLAGS) != 0u)) rayQueryConfirmIntersectionEXT(query);
    }
}

Hit closest_hit(Ray ray, uint mask, uvec2 ray_coverage, uint flags) {
    rayQueryEXT query;
    ray_query(query, ray, mask, ray_coverage, flags);
    if (rayQueryGetIntersectionTypeEXT(query, true) == gl_RayQueryCommittedIntersectionNoneEXT) return MISS;
    uint instance = rayQueryGetIntersectionInstanceCustomIndexEXT(query, true);
    uint triangle = mesh_triangle(instance, rayQueryGetIntersectionGeometryIndexEXT(query, true),
                                  rayQueryGetIntersectionPrimitiveIndexEXT(query, true));
    return triangle_hit(ray, instance, triangle);
}

uint blocker(Ray ray, uint mask, uvec2 ray_coverage, uint flags) {
    rayQueryEXT query;
    ray_query(query, ray, mask, ray_coverage, flags | gl_RayFlagsTerminateOnFirstHitEXT);
    if (rayQueryGetIntersectionTypeEXT(query, true) == gl_RayQueryCommittedIntersectionNoneEXT) return NONE;
    return rayQueryGetIntersectionInstanceCustomIndexEXT(query, true);
}

bool any_hit(Ray ray, uint mask, uvec2 ray_coverage, uint flags) { return blocker(ray, mask, ray_coverage, flags) != NONE; }
