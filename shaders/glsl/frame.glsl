// The frame's uniforms, bound as "frame_uniforms" in every kernel that includes this.
#include "records.glsl"

layout(set = 0, binding = 0, scalar) uniform frame_uniforms { FrameRecord frame; };
