//! Private images of the denoisers.

pt_shaders::stage_images! { "denoise";
    SURFACE: "surface", Rg32Uint, Split, Frame, XY_UINT, "-; frames",
        "x = what surface and path were seen (0: none), y = number of frames in the history; 0 = there is none. Upper 16 bits of y: 0, or frames of specular light where it has others (65535: none).";
    MOMENTS: "moments", Rgba32F, Split, Frame, XYZW, "linear radiance, and its square",
        "Means of luminance and squared luminance (with denoise.histories=half its variance): of the diffuse channel, then of the specular one.";
    HISTORY_HF: "history_hf", Rgba32F, Split, Frame, RGBA, "linear radiance / albedo",
        "Diffuse light that the next frame continues, a = variance of its luminance where there is one.";
    HISTORY_SPEC: "history_spec", Rgba32F, Split, Frame, RGBA, "linear radiance / max(0.01, F0)",
        "Specular light that the next frame continues, a as in history_hf.";
    GUIDE: "guide", Rgba32Uint, Split, Frame, XYZW_UINT, "metres; -; radians / 1024",
        "What the a-trous levels know of a surface: x = bits of the signed distance, y = bits of the depth range of the pixel (negative: the fields hold two paths), z = shading normal (0: no surface), w = roughness in 16 bits, then half float of the angle between the rays of neighbouring pixels.";
    PING_HF: "ping_hf", Rgba32F, Split, Frame, RGBA, "linear radiance / albedo",
        "Diffuse light between two passes, a = variance of its luminance; -1 = missing.";
    PING_SPEC: "ping_spec", Rgba32F, Split, Frame, RGBA, "linear radiance / max(0.01, F0)",
        "Specular light between two passes, a as in ping_hf.";
    PONG_HF: "pong_hf", Rgba32F, Split, Frame, RGBA, "linear radiance / albedo", "As ping_hf.";
    PONG_SPEC: "pong_spec", Rgba32F, Split, Frame, RGBA, "linear radiance / max(0.01, F0)", "As ping_spec.";
    LEVELS_HF: "levels_hf", Rgba16F, Split, Frame, RGBA, "(linear radiance / albedo)^0.5",
        "Diffuse light between two levels of the a-trous filter, as roots, so that half floats hold light up to 4e9; a = root of the standard deviation of its luminance; -1 = missing.";
    LEVELS_SPEC: "levels_spec", Rgba16F, Split, Frame, RGBA, "(linear radiance / max(0.01, F0))^0.5",
        "Specular light as in levels_hf.";
    LEVELS2_HF: "levels2_hf", Rgba16F, Split, Frame, RGBA, "(linear radiance / albedo)^0.5", "As levels_hf.";
    LEVELS2_SPEC: "levels2_spec", Rgba16F, Split, Frame, RGBA, "(linear radiance / max(0.01, F0))^0.5", "As levels_spec.";
    HISTORY_LF_SH: "history_lf_sh", Rgba32F, Split, Frame, XYZW, "irradiance / albedo",
        "Indirect diffuse light that the next frame continues, as color_lf_sh.";
    HISTORY_LF_COCG: "history_lf_cocg", Rgba32F, Split, Frame, XYZW, "irradiance / albedo; frames; squared luma",
        "xy = chroma as color_lf_cocg, z = number of frames in the history, w = mean of its squared luma (with denoise.histories=half its variance), -1 where there is none.";
    TILES_LF_SH: "tiles_lf_sh", Rgba32F, SplitPart(3), Frame, XYZW, "irradiance / albedo",
        "Indirect diffuse light of 3 x 3 pixels of the flat frame, as color_lf_sh.";
    TILES_LF_COCG: "tiles_lf_cocg", Rg32F, SplitPart(3), Frame, XY, "irradiance / albedo", "As color_lf_cocg.";
    TILES_GUIDE: "tiles_guide", Rgba32Uint, SplitPart(3), Frame, XYZW_UINT, "metres; -",
        "Of the pixel that a tile stands for: xy = bits of distance and depth range as in geometry, z = vertex normal, w = 1 + number of the pixel, 0 = no light.";
    TILES2_LF_SH: "tiles2_lf_sh", Rgba32F, SplitPart(3), Frame, XYZW, "irradiance / albedo", "As tiles_lf_sh.";
    TILES2_LF_COCG: "tiles2_lf_cocg", Rg32F, SplitPart(3), Frame, XY, "irradiance / albedo", "As color_lf_cocg.";
    FILTERED_LF_SH: "filtered_lf_sh", Rgba32F, Split, Frame, XYZW, "irradiance / albedo",
        "Filtered indirect diffuse light, as color_lf_sh.";
    FILTERED_LF_COCG: "filtered_lf_cocg", Rg32F, Split, Frame, XY, "irradiance / albedo", "As color_lf_cocg.";
    // Strata of 3 x 3 or of 5 x 5 pixels; the latter fill a part.
    GRADIENTS: "gradients", Rgba32F, SplitPart(3), Frame, XYZW, "linear radiance",
        "Change of the luminance of gradient pixels and the greater of both luminances: of the diffuse channel, then of the specular one.";
    GRADIENTS2: "gradients2", Rgba32F, SplitPart(3), Frame, XYZW, "linear radiance", "As gradients, between two passes.";
    SUMS_HF: "sums_hf", Rgba32F, SplitPart(3), Frame, XYZW, "linear radiance, and its square",
        "Sums of the luminance of diffuse light over strata: x = this frame, y = the history, z and w = variance of their difference, by this frame and by the history.";
    SUMS2_HF: "sums2_hf", Rgba32F, SplitPart(3), Frame, XYZW, "linear radiance, and its square",
        "As sums_hf, between two passes.";
    SUMS_SPEC: "sums_spec", Rgba32F, SplitPart(3), Frame, XYZW, "linear radiance, and its square",
        "As sums_hf, of specular light.";
    SUMS2_SPEC: "sums2_spec", Rgba32F, SplitPart(3), Frame, XYZW, "linear radiance, and its square",
        "As sums_spec, between two passes.";
    SUMS_LF: "sums_lf", Rgba32F, SplitPart(3), Frame, XYZW, "irradiance / albedo, and its square",
        "As sums_hf, of the luma of indirect diffuse light.";
    SUMS2_LF: "sums2_lf", Rgba32F, SplitPart(3), Frame, XYZW, "irradiance / albedo, and its square",
        "As sums_lf, between two passes.";
}
