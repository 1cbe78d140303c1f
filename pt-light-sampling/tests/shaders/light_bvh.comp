// lights/light_bvh.glsl for one shading point: picks with their pmf and that of light_bvh_pmf, or the pmf of every light.
#include "test_records.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Push { LightBvhPush push; };
#define LIGHT_BVH_NODES push.nodes
#define LIGHT_BVH_TRAILS push.trails
#define LIGHT_BVH_GAUSSIAN (push.gaussian != 0u)
#include "lights/light_bvh.glsl"

layout(set = 2, binding = 0, scalar) writeonly buffer samples { SampleRecord sample_at[]; };

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= push.count) return;
    uint light = i;
    float pmf = 0.0;
    if (push.picks != 0u) {
        uvec4 bits = random4_bits(uvec2(i, 0u), 0u, push.seed);
        light = light_bvh_pick(push.position, push.normal, push.view, push.roughness, bits.xy, pmf);
    }
    float again = light_bvh_pmf(push.position, push.normal, push.view, push.roughness, light);
    sample_at[i] = SampleRecord(vec3(0.0), pmf, vec3(0.0), again, vec3(0.0), light);
}
