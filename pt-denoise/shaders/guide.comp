// What the variance estimate and the a-trous levels need to know of the surfaces, in one image, which each of them reads. On the split extent.
#include "denoise_images.glsl"
#include "edge_stopping.glsl"
#include "packed_guide.glsl"

layout(local_size_x = 16, local_size_y = 8) in;

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(at, imageSize(im_guide)))) return;
    imageStore(im_guide, at, pack_guide(load_guide(at), imageLoad(ch_bounce_throughput, at).a));
}
