// Codes of light and what they stand for.
#include "packed_light.glsl"
#include "test_records.glsl"

layout(local_size_x = 64) in;
layout(set = 2, binding = 0, scalar) readonly buffer cases { vec3 case_at[]; };
layout(set = 2, binding = 1, scalar) writeonly buffer codes { PackedRecord code_at[]; };

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= uint(case_at.length())) return;
    uvec2 code = pack_light(case_at[i]);
    code_at[i] = PackedRecord(code, unpack_light(code));
}
