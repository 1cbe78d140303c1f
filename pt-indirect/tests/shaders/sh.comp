// Runs sh.glsl on light from two directions.
#include "sh.glsl"
#include "test_records.glsl"

layout(local_size_x = 64) in;
layout(set = 2, binding = 0, scalar) buffer cases { ShRecord sh_case[]; };

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= uint(sh_case.length())) return;
    ShRecord r = sh_case[i];
    ShLight light = sh_encode(r.directions[0], r.radiances[0]);
    ShLight second = sh_encode(r.directions[1], r.radiances[1]);
    light.luma += second.luma;
    light.chroma += second.chroma;
    sh_case[i].irradiance = sh_irradiance(light, r.normal);
    sh_case[i].of_irradiance = sh_irradiance(sh_encode_irradiance(r.directions[0], r.radiances[0], r.directions[1]), r.normal);
    sh_case[i].of_constant = sh_irradiance(sh_constant(r.radiances[0]), r.normal);
    sh_case[i].luma1 = light.luma.xyz;
    sh_case[i].luma0 = light.luma.w;
    sh_case[i].chroma[0] = light.chroma.x;
    sh_case[i].chroma[1] = light.chroma.y;
}
