// Hands the hit to the ray generation shader as the driver names it.
#include "trace_payload.glsl"

layout(location = 0) rayPayloadInEXT TracePayload payload;

void main() {
    payload = TracePayload(uint(gl_InstanceCustomIndexEXT), uint(gl_GeometryIndexEXT), uint(gl_PrimitiveID));
}
