// Passes the hit to the ray generation shader as the driver reports it.
#include "trace/payload.glsl"

layout(location = 0) rayPayloadInEXT TracePayload payload;

void main() {
    payload.instance = uint(gl_InstanceCustomIndexEXT);
    payload.geometry = uint(gl_GeometryIndexEXT);
    payload.primitive = uint(gl_PrimitiveID);
}
