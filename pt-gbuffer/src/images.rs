//! Private images of the G-buffer stages.

pt_shaders::stage_images! { "gbuffer";
    GODRAYS: "godrays", Rgba32F, SplitPart(2), Frame, RGBA, "linear radiance; m",
        "One pixel of each 2 x 2 of the flat frame: rgb = light scattered towards the camera, mean over the march, a = length of the march.";
}
