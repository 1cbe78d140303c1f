// Tone curves: exposed radiance (0 or more) to linear display values. Their results may leave 0..1; the caller clamps.

// Narkowicz 2015, "ACES Filmic Tone Mapping Curve".
vec3 aces_narkowicz(vec3 x) { return x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14); }

// Reinhard et al. 2002, "Photographic Tone Reproduction for Digital Images", eq. 3.
vec3 reinhard(vec3 x) { return x / (1.0 + x); }

// Hill's fit of the ACES reference rendering and sRGB output transforms (in Pettineo's "Baking Lab", 2016): sRGB to the
// rendering space with its desaturation, a rational curve, and back. Rows of the published matrices are columns here.
vec3 aces_hill(vec3 x) {
    const mat3 to_rendering =
        mat3(0.59719, 0.07600, 0.02840, 0.35458, 0.90834, 0.13383, 0.04823, 0.01566, 0.83777);
    const mat3 to_display =
        mat3(1.60475, -0.10208, -0.00327, -0.53108, 1.10813, -0.07276, -0.07367, -0.00605, 1.07602);
    vec3 v = to_rendering * x;
    v = (v * (v + 0.0245786) - 0.000090537) / (v * (0.983729 * v + 0.4329510) + 0.238081);
    return to_display * v;
}

// Half of AgX's contrast curve: a generalised hyperbola that leaves the pivot with slope 2 and reaches `rise` at `run`.
float agx_branch(float x, float run, float rise, float power) {
    float scale = pow(pow(rise, -power) - pow(2.0 * run, -power), -1.0 / power);
    float t = 2.0 * x / scale;
    return scale * t / pow(1.0 + pow(t, power), 1.0 / power);
}

// AgX, base look: Sobotka 2022, "AgX": inset of the primaries, log2 encoding of 10 stops below and 6.5 above middle grey,
// contrast curve (toe power 3, shoulder power 3.25, pivot at half the code), outset; matrices as in Wrensch 2023, "Minimal
// AgX Implementation". Its codes are for a display with a 2.2 power law.
vec3 agx(vec3 x) {
    const mat3 inset = mat3(0.842479062253094, 0.0423282422610123, 0.0423756549057051, 0.0784335999999992,
                            0.878468636469772, 0.0784336, 0.0792237451477643, 0.0791661274605434, 0.879142973793104);
    const mat3 outset = mat3(1.19687900512017, -0.0528968517574562, -0.0529716355144438, -0.0980208811401368,
                             1.15190312990417, -0.0980434501171241, -0.0990297440797205, -0.0989611768448433,
                             1.15107367264116);
    const float pivot = 10.0 / 16.5;
    vec3 v = clamp((log2(max(inset * x, 1e-10) / 0.18) + 10.0) / 16.5, 0.0, 1.0);
    for (int i = 0; i < 3; ++i) {
        v[i] = v[i] < pivot ? 0.5 - agx_branch(pivot - v[i], pivot, 0.5, 3.0)
                            : 0.5 + agx_branch(v[i] - pivot, 1.0 - pivot, 0.5, 3.25);
    }
    return pow(max(outset * v, 0.0), vec3(2.2));
}

// Khronos PBR Neutral tone mapper, specification 1.0 (2024).
vec3 pbr_neutral(vec3 c) {
    const float f90 = 0.04;
    const float start = 0.8 - f90;
    const float desaturation = 0.15;
    float least = min(c.r, min(c.g, c.b));
    c -= least < 2.0 * f90 ? least - least * least / (4.0 * f90) : f90;
    float peak = max(c.r, max(c.g, c.b));
    if (peak <= start) return c;
    float room = 1.0 - start;
    float compressed = 1.0 - room * room / (peak + room - start);
    float to_white = 1.0 - 1.0 / (desaturation * (peak - compressed) + 1.0);
    return mix(c * (compressed / peak), vec3(compressed), to_white);
}

// Highlights of the noise-aware curve: the identity up to `knee`, then a hyperbola that meets it with slope 1 and reaches 1
// at `white`.
vec3 bend(vec3 x, float knee, float white) {
    float w = (knee * (knee - 2.0) + white) / (white - 1.0);
    return mix(x, (w * x - knee * knee) / (x + w - 2.0 * knee), greaterThan(x, vec3(knee)));
}

// Reinhard et al. 2002, eq. 4.
float reinhard_white(float x, float white) { return x * (1.0 + x / (white * white)) / (1.0 + x); }
