// What the ray tracing pipeline's shaders pass to each other: the hit as the driver names it, and what the
// any-hit shader needs to know of the ray.
struct TracePayload {
    uint instance; // NONE: nothing was hit
    uint geometry;
    uint primitive;
    uvec2 ray_coverage;
};
