//! Private images of the indirect lighting stage: the reservoirs of `reuse=restir-gi` (`reused_bounce.glsl`), with the last frame's.

pt_shaders::stage_images! { "indirect";
    REUSE_SURFACE: "reuse_surface", Rg32Uint, Split, Frame, XY_UINT, "world space, octahedral 2 x 16 bit",
        "Surface that bounces are reused for: x = normal of its triangle, y = its shading normal as the BSDF takes it; 0 = none.";
    REUSE_POINT: "reuse_point", Rgba32Uint, Split, Frame, XYZW_UINT, "m, world space; octahedral 2 x 16 bit",
        "Reservoir: xyz = bits of the position of the hit that it keeps, w = normal of the triangle there, on the side that was seen.";
    REUSE_LIGHT: "reuse_light", Rgba32Uint, Split, Frame, XYZW_UINT, "radiance (packed_light.glsl); m^2 (bits); -",
        "Reservoir: xy = light that leaves the hit, z = weight, w = frames that it stands for (16 bit), least cosine (16 bit unorm).";
}
