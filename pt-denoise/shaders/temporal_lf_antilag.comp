#define ANTILAG 1
#include "temporal_lf.glsl"
