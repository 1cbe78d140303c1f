// No hit.
#include "records.glsl"
#include "trace/payload.glsl"

layout(location = 0) rayPayloadInEXT TracePayload payload;

void main() { payload.instance = NONE; }
