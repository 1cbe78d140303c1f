// Vertices of all deforming meshes in the pose of this frame, one thread a vertex: morph targets, then linear blend skinning (glTF 2.0,
// sections 3.7.2.2 and 3.7.3). Normals go with the cofactors of the blended matrix, which is its inverse transpose but for
// a factor. Host twin: Mesh::deformed.
#include "records.glsl"
#include "math.glsl"
#include "pack.glsl"
#include "deform_records.glsl"

layout(local_size_x = 64) in;

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer RestTable { DeformVertex at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer DeltaTable { DeltaRecord at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer InfluenceTable { InfluenceRecord at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer JointTable { JointRecord at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer WeightTable { float at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer PositionTable { vec3 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer VertexTable { VertexRecord at[]; };
layout(push_constant, scalar) uniform Push { DeformPush push; };

vec3 unit_or(vec3 v, vec3 otherwise) {
    float length2 = dot(v, v);
    return length2 > 0.0 && !isinf(length2) ? v * inversesqrt(length2) : otherwise;
}

void main() {
    uint index = gl_GlobalInvocationID.y * push.width + gl_GlobalInvocationID.x;
    if (gl_GlobalInvocationID.x >= push.width || index >= push.count) return;
    RestTable rest = RestTable(push.vertices);
    DeformVertex v = rest.at[index];
    vec3 position = v.position, normal = v.normal, tangent = v.tangent.xyz;

    uint end = rest.at[index + 1u].first_delta;
    for (uint i = v.first_delta; i < end; i++) {
        DeltaRecord delta = DeltaTable(push.deltas).at[i];
        float weight = WeightTable(push.weights).at[delta.target];
        position += weight * delta.position;
        normal += weight * delta.normal;
        tangent += weight * delta.tangent;
    }

    end = rest.at[index + 1u].first_influence;
    if (v.first_influence < end) {
        vec4 rows[3] = vec4[3](vec4(0.0), vec4(0.0), vec4(0.0));
        for (uint i = v.first_influence; i < end; i++) {
            InfluenceRecord influence = InfluenceTable(push.influences).at[i];
            JointRecord joint = JointTable(push.joints).at[influence.joint];
            for (int r = 0; r < 3; r++) rows[r] += influence.weight * joint.rows[r];
        }
        position = transform_point(rows, position);
        tangent = transform_vector(rows, tangent);
        vec4 cofactors[3] = vec4[3](vec4(cross(rows[1].xyz, rows[2].xyz), 0.0), vec4(cross(rows[2].xyz, rows[0].xyz), 0.0),
                                    vec4(cross(rows[0].xyz, rows[1].xyz), 0.0));
        // A pose that mirrors keeps normals on their side, as a mirroring instance does.
        float side = dot(cofactors[0].xyz, rows[0].xyz) < 0.0 ? -1.0 : 1.0;
        normal = transform_vector(cofactors, normal) * side;
    }

    PositionTable(push.positions).at[index] = position;
    VertexTable(push.records).at[index].normal = pack_unit_vector(unit_or(normal, v.normal));
    VertexTable(push.records).at[index].tangent = pack_tangent(vec4(unit_or(tangent, v.tangent.xyz), v.tangent.w));
}
