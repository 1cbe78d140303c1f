// Replaces the radiance of an image by that of another one of the same size; alpha stays, as stages keep flags in it. FORMAT: that of the
// target.
layout(local_size_x = 16, local_size_y = 16) in;
layout(set = 2, binding = 0) uniform sampler2D source;
layout(set = 2, binding = 1, FORMAT) uniform image2D target;

void main() {
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(p, imageSize(target)))) return;
    imageStore(target, p, vec4(texelFetch(source, p, 0).rgb, imageLoad(target, p).a));
}
