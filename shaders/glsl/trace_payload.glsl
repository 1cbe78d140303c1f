// What the ray tracing pipeline's shaders pass to each other: the hit as the driver names it.
struct TracePayload {
    uint instance; // NONE: nothing was hit
    uint geometry;
    uint primitive;
};
