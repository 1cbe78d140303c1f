// Sharpening into unquantized codes, for HDR output.
#define TARGET_FORMAT rgba16f
#define store(code, p) code
#include "rcas.glsl"
