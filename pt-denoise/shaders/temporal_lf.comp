#define ANTILAG 0
#include "temporal_lf.glsl"
