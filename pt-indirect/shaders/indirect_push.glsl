// What every header of the stage reads.
#include "indirect_records.glsl"

layout(push_constant, scalar) uniform Push { IndirectPush push; };
