//! Private images of the denoisers.

pt_shaders::stage_images! { "denoise";
    SURFACE: "surface", Rg32Uint, Split, Frame, XY_UINT, "-; frames",
        "x = what surface and path were seen (0: none), y = number of frames in the history; 0 = there is none.";
    MOMENTS: "moments", Rgba32F, Split, Frame, XYZW, "linear radiance, and its square",
        "Means of luminance and squared luminance: of the diffuse channel, then of the specular one.";
    HISTORY_HF: "history_hf", Rgba32F, Split, Frame, RGBA, "linear radiance / albedo",
        "Diffuse light that the next frame continues, a = variance of its luminance where there is one.";
    HISTORY_SPEC: "history_spec", Rgba32F, Split, Frame, RGBA, "linear radiance / max(0.01, F0)",
        "Specular light that the next frame continues, a as in history_hf.";
    PING_HF: "ping_hf", Rgba32F, Split, Frame, RGBA, "linear radiance / albedo",
        "Diffuse light between two passes, a = variance of its luminance; -1 = missing.";
    PING_SPEC: "ping_spec", Rgba32F, Split, Frame, RGBA, "linear radiance / max(0.01, F0)",
        "Specular light between two passes, a as in ping_hf.";
    PONG_HF: "pong_hf", Rgba32F, Split, Frame, RGBA, "linear radiance / albedo", "As ping_hf.";
    PONG_SPEC: "pong_spec", Rgba32F, Split, Frame, RGBA, "linear radiance / max(0.01, F0)", "As ping_spec.";
}
