//! Private images of the post stages.

pt_shaders::stage_images! { "post";
    RESOLVED: "resolved", Rgba16F, Resolved, Frame, RGBA, "linear radiance",
        "The anti-aliased frame, at most 10000 / pq_scale, finite and not negative.";
    TAA_HISTORY: "taa_history", Rgba16Unorm, Resolved, Frame, RGBA, "PQ codes; bits",
        "rgb = what the pixel has shown so far, a = weight of that and deviation (see taa.glsl).";
    ACCUMULATE_RESIDUAL: "accumulate_residual", Rgba32F, Flat, Carried, RGBA, "linear radiance",
        "What fp32 drops of the running mean in accumulated.";
    COVERAGE: "coverage", Rg32F, Flat, Carried, XY, "frames",
        "Frames so far in which the pixel's camera ray met a surface, and all frames.";
    MATTE: "matte", Rgba32F, Flat, Frame, RGBA, "linear radiance; 0 to 1",
        "rgb = radiance of the surfaces alone, a = share of the frames that met one.";
    BLOOM_QUARTER: "bloom_quarter", Rgba16F, ResolvedPart(4), Frame, RGBA, "linear radiance",
        "The frame at a quarter of its sides, then blurred.";
    BLOOM_BLUR: "bloom_blur", Rgba16F, ResolvedPart(4), Frame, RGBA, "linear radiance",
        "Between the horizontal and the vertical blur.";
    BLOOM_1: "bloom_1", Rgba16F, ResolvedPart(2), Frame, RGBA, "linear radiance", "Level 1 of the bloom chain.";
    BLOOM_2: "bloom_2", Rgba16F, ResolvedPart(4), Frame, RGBA, "linear radiance", "Level 2 of the bloom chain.";
    BLOOM_3: "bloom_3", Rgba16F, ResolvedPart(8), Frame, RGBA, "linear radiance", "Level 3 of the bloom chain.";
    BLOOM_4: "bloom_4", Rgba16F, ResolvedPart(16), Frame, RGBA, "linear radiance", "Level 4 of the bloom chain.";
    BLOOM_5: "bloom_5", Rgba16F, ResolvedPart(32), Frame, RGBA, "linear radiance", "Level 5 of the bloom chain.";
    BLOOM_6: "bloom_6", Rgba16F, ResolvedPart(64), Frame, RGBA, "linear radiance", "Level 6 of the bloom chain.";
    BLOOM_7: "bloom_7", Rgba16F, ResolvedPart(128), Frame, RGBA, "linear radiance", "Level 7 of the bloom chain.";
    BLOOM_8: "bloom_8", Rgba16F, ResolvedPart(256), Frame, RGBA, "linear radiance", "Level 8 of the bloom chain.";
    BLOOM_9: "bloom_9", Rgba16F, ResolvedPart(512), Frame, RGBA, "linear radiance", "Level 9 of the bloom chain.";
    BLOOM_10: "bloom_10", Rgba16F, ResolvedPart(1024), Frame, RGBA, "linear radiance", "Level 10 of the bloom chain.";
    BLOOMED: "bloomed", Rgba16F, Resolved, Frame, RGBA, "linear radiance",
        "The frame with its bloom; only where no tone map mixes them.";
    DISPLAY_CODES: "display_codes", Rgba16F, Resolved, Frame, RGBA, "sRGB or PQ codes",
        "The tone-mapped frame before it is upscaled and sharpened.";
    UPSCALED_CODES: "upscaled_codes", Rgba16F, Output, Frame, RGBA, "sRGB or PQ codes",
        "The upscaled picture before it is sharpened.";
}
