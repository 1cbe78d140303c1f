// Scene radiance to 8-bit sRGB codes, dithered.
#define DITHERED
#include "display_codes.glsl"
#define TARGET_FORMAT rgba8
#define store(code, p) to_8_bits(code, p, push.dither != 0u)
#include "tonemap.glsl"
