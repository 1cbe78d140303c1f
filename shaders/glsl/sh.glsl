// Indirect diffuse light of a point: luma with its direction in spherical harmonics up to l = 1, chroma without.
// Real spherical harmonics and the cosine kernel: Ramamoorthi and Hanrahan 2001, "An Efficient Representation for Irradiance
// Environment Maps". YCoCg by lifting: Malvar and Sullivan 2003, "YCoCg-R: A Color Space with RGB Reversibility and Low Dynamic
// Range". The host twin is pt_indirect::oracle.

// Y_1m / direction component, and Y_00.
const float SH_Y1 = 0.48860251190291992;
const float SH_Y0 = 0.28209479177387814;
// Integrals of the clamped cosine against the band, A_1 = 2 pi / 3 and A_0 = pi, times the basis function.
const float SH_COSINE_Y1 = 1.0233267079464885;
const float SH_COSINE_Y0 = 0.88622692545275801;

// Integrals over directions; sums and averages of these are again light.
struct ShLight {
    vec4 luma;   // xyz: l = 1 along the axes, w: l = 0
    vec2 chroma; // Co, Cg
};

vec3 ycocg_from_rgb(vec3 c) {
    float co = c.r - c.b;
    float t = c.b + 0.5 * co;
    float cg = c.g - t;
    return vec3(t + 0.5 * cg, co, cg);
}

vec3 rgb_from_ycocg(vec3 c) {
    float t = c.x - 0.5 * c.z;
    float b = t - 0.5 * c.y;
    return vec3(b + c.y, c.z + t, b);
}

// Light of one direction. `radiance`: divided by the density per solid angle with which the direction was sampled.
ShLight sh_encode(vec3 direction, vec3 radiance) {
    vec3 c = ycocg_from_rgb(radiance);
    return ShLight(c.x * vec4(SH_Y1 * direction, SH_Y0), c.yz);
}

// Irradiance of a surface facing `normal`. Chroma does not know directions: it keeps its share of the whole luma.
vec3 sh_irradiance(ShLight light, vec3 normal) {
    float y = max(0.0, SH_COSINE_Y1 * dot(light.luma.xyz, normal) + SH_COSINE_Y0 * light.luma.w);
    float whole = light.luma.w / SH_Y0;
    return whole > 0.0 ? rgb_from_ycocg(vec3(y, light.chroma * (y / whole))) : vec3(0.0);
}

// Light of one direction that gives a surface facing `normal` exactly that irradiance. sh_encode() makes 1/4 + cos/2 of a cosine; this
// makes the cosine itself of it for one normal, so that nothing is gained or lost where light is evaluated with the normal of its own
// surface. The direction is above the horizon of `normal`.
ShLight sh_encode_irradiance(vec3 direction, vec3 irradiance, vec3 normal) {
    return sh_encode(direction, irradiance / (0.25 + 0.5 * max(dot(direction, normal), 0.0)));
}

// Light without a direction: every normal gets that irradiance.
ShLight sh_constant(vec3 irradiance) {
    vec3 c = ycocg_from_rgb(irradiance);
    return ShLight(vec4(vec3(0.0), c.x / SH_COSINE_Y0), c.yz / (SH_COSINE_Y0 * SH_Y0));
}
