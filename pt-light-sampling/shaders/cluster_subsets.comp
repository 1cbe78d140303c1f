// The weights of the subsets of some clusters' lists; see lights/subsets.glsl. Extent: one workgroup for a cluster and a side.
#include "lights/cluster_lists.glsl"
#include "local_lights_records.glsl"

layout(local_size_x = 32) in;

layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer BallTable { vec4 at[]; };
layout(push_constant, scalar) uniform Push { ClusterSubsetsPush push; };

shared float weights[MAX_SUBSETS];

const float LEAST_COSINE = 0.05;

// About what a light gives to surfaces of the cluster, `ball`, with normals to that side.
float typical_mass(vec4 ball, vec3 normal, LocalLightRecord l) {
    if ((l.kind & LOCAL_KIND) == LOCAL_ENVIRONMENT) {
        return l.luminance * max(cone_cosine(dot(normal, l.position), l.edge1.xy) + 0.6, LEAST_COSINE);
    }
    bool triangle = (l.kind & LOCAL_KIND) == LOCAL_TRIANGLE;
    vec3 d = l.position - ball.xyz;
    if (triangle) d += (l.edge1 + l.edge2) * (1.0 / 3.0);
    float distance2 = max(dot(d, d), 0.25 * ball.w * ball.w + 1e-12);
    vec3 direction = d * inversesqrt(distance2);
    // Normals of a side are up to 55 degrees from its axis.
    float facing = max(dot(normal, direction) + 0.6, LEAST_COSINE);
    float emission = 1.0;
    if (triangle) {
        float cos_light = -dot(cross(l.edge1, l.edge2), direction);
        float area = 0.5 * length(cross(l.edge1, l.edge2));
        if ((l.kind & LOCAL_DOUBLE_SIDED) != 0u) cos_light = abs(cos_light);
        emission = max(0.5 * cos_light, LEAST_COSINE * area);
    }
    return l.luminance * emission * facing / distance2;
}

void main() {
    uint cluster = push.first + gl_WorkGroupID.y;
    uint side = gl_WorkGroupID.x;
    if (cluster >= push.clusters) return;
    ClusterListRecord list = cluster_list(cluster);
    uint size = cluster_list_size(list), count = cluster_stride(list);
    vec4 ball = BallTable(push.balls).at[cluster];
    vec3 normal = vec3(0.0);
    normal[side / 2u] = (side & 1u) != 0u ? -1.0 : 1.0;
    for (uint subset = gl_LocalInvocationID.x; subset < min(count, MAX_SUBSETS); subset += gl_WorkGroupSize.x) {
        float sum = 0.0;
        for (uint place = subset; place < size; place += count) {
            uint light = cluster_list_light(list, place);
            sum += typical_mass(ball, normal, local_light(light)) * lit_share(cluster, light, normal);
        }
        weights[subset] = sum;
    }
    barrier();
    if (gl_LocalInvocationID.x != 0u) return;
    SubsetTable row = SubsetTable(scene.light_tables.cluster_subsets + uint64_t((cluster * 6u + side) * SUBSET_ROW) * 4ul);
    // Too many of them: uniform.
    row.at[0] = count <= MAX_SUBSETS ? float(count) : 0.0;
    float sum = 0.0;
    for (uint subset = 0u; subset < min(count, MAX_SUBSETS); subset++) {
        sum += weights[subset];
        row.at[1u + subset] = sum;
    }
}
