// trace.glsl for the backends rt-pipeline and rt-reorder: a ray generation shader. One hit group and one miss shader serve all rays: occlusion rays skip the
// closest-hit shader and start out as "hit", which only the miss shader takes back. Only rays that ask for their blocker run it.
#include "trace/payload.glsl"

layout(location = 0) rayPayloadEXT TracePayload payload;

#ifdef TRACE_OPAQUE
const uint TRACE_FLAGS = gl_RayFlagsOpaqueEXT;
#else
const uint TRACE_FLAGS = gl_RayFlagsNoneEXT;
#endif

#ifdef TRACE_RT_REORDER
// Lowest bits of the instance that threads are sorted by.
const uint REORDER_BITS = 8u;
#endif

uvec2 launch_id() { return gl_LaunchIDEXT.xy; }

Hit closest_hit(Ray ray, uint mask, uvec2 ray_coverage, uint flags) {
    payload.ray_coverage = ray_coverage;
#ifdef TRACE_RT_REORDER
    hitObjectNV hit;
    hitObjectTraceRayNV(hit, accelerationStructureEXT(scene.tlas), flags, mask & 0xffu, 0, 0, 0, ray.origin, ray.t_min, ray.direction,
                        ray.t_max, 0);
    uint instance = hitObjectIsHitNV(hit) ? uint(hitObjectGetInstanceCustomIndexNV(hit)) : NONE;
    // One hit group serves all hits: it is the instance that tells materials, and so what is shaded next, apart.
    reorderThreadNV(hit, instance, REORDER_BITS);
    if (instance == NONE) return MISS;
    return triangle_hit(ray, instance, mesh_triangle(instance, uint(hitObjectGetGeometryIndexNV(hit)), uint(hitObjectGetPrimitiveIndexNV(hit))));
#else
    traceRayEXT(accelerationStructureEXT(scene.tlas), flags, mask & 0xffu, 0, 0, 0, ray.origin, ray.t_min, ray.direction,
                ray.t_max, 0);
    if (payload.instance == NONE) return MISS;
    return triangle_hit(ray, payload.instance, mesh_triangle(payload.instance, payload.geometry, payload.primitive));
#endif
}

uint blocker(Ray ray, uint mask, uvec2 ray_coverage, uint flags) {
    payload.ray_coverage = ray_coverage;
    flags |= gl_RayFlagsTerminateOnFirstHitEXT;
    traceRayEXT(accelerationStructureEXT(scene.tlas), flags, mask & 0xffu, 0, 0, 0, ray.origin, ray.t_min, ray.direction, ray.t_max, 0);
    return payload.instance;
}

bool any_hit(Ray ray, uint mask, uvec2 ray_coverage, uint flags) {
    payload.ray_coverage = ray_coverage;
    payload.instance = 0u;
    flags |= gl_RayFlagsTerminateOnFirstHitEXT | gl_RayFlagsSkipClosestHitShaderEXT;
    traceRayEXT(accelerationStructureEXT(scene.tlas), flags, mask & 0xffu, 0, 0, 0, ray.origin, ray.t_min, ray.direction, ray.t_max, 0);
    return payload.instance != NONE;
}
