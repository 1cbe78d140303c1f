// Single scattering in a homogeneous medium. `density`: extinction coefficient, 1 / m.
#include "math.glsl"

// Share of the scattered light per steradian: Henyey and Greenstein 1941. `cos_theta`: between the way of the light before and after. The
// denominator is 1 + g^2 - 2 g cos_theta, as a sum of what does not cancel for g > 0.
float henyey_greenstein(float cos_theta, float g) {
    float d = square(1.0 - g) + 2.0 * g * (1.0 - cos_theta);
    return (1.0 - g * g) / (4.0 * PI * d * sqrt(d));
}

// 1 - exp(-x): the share of light that a way of optical depth x takes away. With all its digits for thin media.
float opacity(float x) { return x < 1e-2 ? x * (1.0 - x * (0.5 - x * (1.0 / 6.0))) : 1.0 - exp(-x); }

// The inverse: -log(1 - y).
float optical_depth(float y) { return y < 1e-2 ? y * (1.0 + y * (0.5 + y * (1.0 / 3.0))) : -log(1.0 - y); }
