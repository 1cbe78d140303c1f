//! Private images of the direct lighting stage: the reservoirs of `sampler=restir-di` (`reservoir.glsl`). A reservoir is two images: the
//! sample, and what it is worth.

pt_shaders::stage_images! { "lights";
    RESTIR_SURFACE: "restir_surface", Rg32Uint, Split, Frame, XY_UINT, "-",
        "x = roughness and share of the specular lobe (2 x 16 bit unorm), y = kinds of light that were on.";
    RESTIR_TEMPORAL_POINT: "restir_temporal_point", Rg32Uint, Split, Frame, XY_UINT, "-",
        "Sample after the reuse of the last frame: x = local light (0xffffffff: none), y = where on it (2 x 16 bit).";
    RESTIR_TEMPORAL_WEIGHT: "restir_temporal_weight", Rg32Uint, Split, Frame, XY_UINT, "bits of a float; candidates",
        "Its weight in x, and how many candidates it stands for in y (0: no reservoir).";
    RESTIR_POINT: "restir_point", Rg32Uint, Split, Frame, XY_UINT, "-",
        "Sample after the reuse of neighbours, which the pixel is shaded with.";
    RESTIR_WEIGHT: "restir_weight", Rg32Uint, Split, Frame, XY_UINT, "bits of a float; candidates",
        "Its weight and candidates.";
    RESTIR_HISTORY_POINT: "restir_history_point", Rg32Uint, Split, Frame, XY_UINT, "-",
        "Sample that the next frame reuses.";
    RESTIR_HISTORY_WEIGHT: "restir_history_weight", Rg32Uint, Split, Frame, XY_UINT, "bits of a float; candidates",
        "Its weight and candidates.";
}
