// What the channels hold that are smaller with gbuffer.format=compact (channels.rs, COMPACT). The host puts their formats into the kernel.
layout(constant_id = 24) const bool compact_gbuffer = false;

// Square roots in 8 bits: the steps of dark colours are finer than those of bright ones.
vec4 base_color_code(vec4 color) { return compact_gbuffer ? sqrt(max(color, vec4(0.0))) : color; }
vec4 base_color_of(vec4 code) { return compact_gbuffer ? code * code : code; }

// Half floats, of which 65504 is the largest.
vec4 motion_code(vec4 motion) { return compact_gbuffer ? clamp(motion, vec4(-65504.0), vec4(65504.0)) : motion; }
