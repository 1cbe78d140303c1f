// trace.glsl for the ray-query backend: VK_KHR_ray_query in a compute kernel.
layout(local_size_x = 8, local_size_y = 4) in;

uvec2 launch_id() { return gl_GlobalInvocationID.xy; }

#ifdef TRACE_OPAQUE
const uint TRACE_FLAGS = gl_RayFlagsOpaqueEXT;
#else
const uint TRACE_FLAGS = gl_RayFlagsNoneEXT;
#endif

void ray_query(rayQueryEXT query, Ray ray, uint mask, uvec2 ray_coverage, uint flags) {
    rayQueryInitializeEXT(query, accelerationStructureEXT(scene.tlas), flags, mask, ray.origin, ray.t_min, ray.direction, ray.t_max);
    while (rayQueryProceedEXT(query)) {
        // Only the masked geometry is not opaque and comes here.
        uint instance = rayQueryGetIntersectionInstanceCustomIndexEXT(query, false);
        MeshRecord mesh = scene_mesh(scene_instance(instance).mesh);
        uint triangle = mesh.first_masked + rayQueryGetIntersectionPrimitiveIndexEXT(query, false);
        if (is_hit_covered(ray, instance, triangle, ray_coverage)) rayQueryConfirmIntersectionEXT(query);
    }
}

Hit trace_closest(Ray ray, uint mask, uvec2 ray_coverage) {
    rayQueryEXT query;
    ray_query(query, ray, mask, ray_coverage, TRACE_FLAGS);
    if (rayQueryGetIntersectionTypeEXT(query, true) == gl_RayQueryCommittedIntersectionNoneEXT) return MISS;
    uint instance = rayQueryGetIntersectionInstanceCustomIndexEXT(query, true);
    uint triangle = mesh_triangle(instance, rayQueryGetIntersectionGeometryIndexEXT(query, true),
                                  rayQueryGetIntersectionPrimitiveIndexEXT(query, true));
    return triangle_hit(ray, instance, triangle);
}

bool trace_occluded(Ray ray, uint mask, uvec2 ray_coverage) {
    rayQueryEXT query;
    ray_query(query, ray, mask, ray_coverage, TRACE_FLAGS | gl_RayFlagsTerminateOnFirstHitEXT);
    return rayQueryGetIntersectionTypeEXT(query, true) != gl_RayQueryCommittedIntersectionNoneEXT;
}
