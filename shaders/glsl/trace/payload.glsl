// The payload of the ray tracing pipeline: the hit as the driver reports it, and the data of the ray that the any-hit shader needs.
struct TracePayload {
    uint instance; // NONE: nothing was hit
    uint geometry;
    uint primitive;
    uvec2 ray_coverage;
};
