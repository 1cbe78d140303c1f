// Scene radiance to unquantized codes: sRGB or PQ for the upscaler, PQ or scRGB for HDR output.
#define TARGET_FORMAT rgba16f
#define store(code, p) code
#include "tonemap.glsl"
