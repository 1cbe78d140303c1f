//! Private images of the G-buffer stages.

pt_shaders::stage_images! { "gbuffer";
    GODRAYS: "godrays", Rgba32F, SplitPart(2), Frame, RGBA, "linear radiance; m",
        "One pixel of each 2 x 2 of the flat frame: rgb = light scattered towards the camera, mean over the march, a = length of the march.";
    EFFECTS_MOTION: "effects_motion", Rgba32F, Split, Frame, RGBA, "UV of the full frame; linear radiance; 1",
        "xy = previous minus current screen position of the effect that the eye follows, z = luminance of the effects, a = their opacity; all 0: none.";
}
