//! Indirect diffuse light: its history, and its filter at a third of the resolution.

use super::declared;
use super::push::push;
use crate::DenoiseParams;
use crate::histories::holds_roots;
use crate::images::{
    FILTERED_LF_COCG, FILTERED_LF_SH, HISTORY_LF_COCG, HISTORY_LF_SH, TILES_GUIDE, TILES_LF_COCG,
    TILES_LF_SH, TILES2_LF_COCG, TILES2_LF_SH,
};
use crate::kernels;
use crate::records::{LfPush, TemporalPush};
use pt_core::{
    ChannelImages, Device, Frame, Image, Kernel, LowFrequencyLight, Result, StageInputs, StageIo, knobs,
};
use pt_shaders::channels::{ChannelId, MOTION, VERTEX_NORMAL, VIEW_DEPTH, VIEW_DIRECTION};

knobs! {
    /// Knobs of the filter of indirect diffuse light, at a third of the resolution.
    pub struct LfParams {
        /// Levels of the a-trous filter; the taps of each are twice as far apart as those of the one before, and those of the first 3 pixels.
        pub iterations: u32 = 3, in 0..=6, source "Dammertz et al. 2010";
        /// Tolerance of differences in distance, in units of what the slope of the surface explains.
        pub depth: f32 = 1.0, in 0.01..=100.0, source "Schied et al. 2017, eq. 3";
        /// Exponent on the cosine between the vertex normals.
        pub normal: f32 = 8.0, in 1.0..=1024.0, source "Schied et al. 2017, eq. 4";
        /// Before the levels, the luma of a tile is limited to this many times the mean of the tiles around it, and what exceeds the limit is lost; none is no
        /// limit.
        pub deflicker: Option<f32> = None, in 1.0..=100.0;
        /// Whether the last level takes less from tiles that are more than twice as bright or as dark, against leaks through thin walls, and nothing from those six times
        /// as bright; the sum of the light stays.
        pub leak_guard: bool = false;
    }
}

/// Pixels of the flat frame along a side of a tile.
const TILE_SIDE: u32 = 3;

/// This frame's indirect diffuse light into its history.
pub(crate) struct LfTemporal {
    kernel: Kernel,
    io: StageIo,
}

impl LfTemporal {
    /// The images that it accesses.
    pub(crate) const IO: StageIo = StageIo {
        reads: with_surfaces![COLOR_LF_SH, COLOR_LF_COCG],
        reads_previous: with_surfaces_before![HISTORY_LF_SH, HISTORY_LF_COCG],
        writes: &[HISTORY_LF_SH, HISTORY_LF_COCG],
        ..StageIo::of("denoise temporal lf")
    };
    /// The same of the kernel that follows changes of the light.
    pub(crate) const IO_ANTILAG: StageIo =
        StageIo { reads: with_surfaces![COLOR_LF_SH, COLOR_LF_COCG; GRADIENT_SAMPLE], ..Self::IO };

    /// Creates the kernel; `antilag`: it follows changes of the light.
    pub(crate) fn new(device: &Device, antilag: bool, params: &DenoiseParams) -> Result<Self> {
        let constants = [params.antilag.stratum_constant()];
        let (code, io, constants) = match antilag {
            true => (&kernels::TEMPORAL_LF_ANTILAG, Self::IO_ANTILAG, &constants[..]),
            false => (&kernels::TEMPORAL_LF, Self::IO, &[][..]),
        };
        Ok(Self { kernel: declared::<TemporalPush>(device, code, &io, constants)?, io })
    }

    /// Adds its pass to the frame and returns the history. `sums`: of a kernel that follows changes of the light.
    pub(crate) fn record<'a>(
        &self,
        frame: &mut Frame<'_>,
        inputs: &StageInputs<'a>,
        sums: Option<&Image>,
        params: &DenoiseParams,
    ) -> Result<LowFrequencyLight<'a>> {
        let images = inputs.images;
        let mut pass = inputs.pass(frame, "denoise temporal lf", &self.kernel, &self.io);
        if let Some(sums) = sums {
            pass = pass.sample("sums_lf", sums);
        }
        pass.push(&push(params, inputs)).dispatch(inputs.flat_threads())?;
        Ok(light(images, HISTORY_LF_SH, HISTORY_LF_COCG))
    }
}

fn light(images: &ChannelImages, sh: ChannelId, cocg: ChannelId) -> LowFrequencyLight<'_> {
    LowFrequencyLight { sh: images.current(sh), cocg: images.current(cocg) }
}

/// The filter in space: to tiles of 3 x 3 pixels, a-trous over these, and back to all pixels.
pub(crate) struct LfSpatial {
    downsample: Kernel,
    deflicker: Kernel,
    atrous: Kernel,
    upsample: Kernel,
}

impl LfSpatial {
    const DOWNSAMPLE: StageIo = StageIo {
        reads: &[VERTEX_NORMAL, VIEW_DEPTH, VIEW_DIRECTION, MOTION],
        writes: &[TILES_GUIDE],
        ..StageIo::of("denoise lf")
    };
    const LEVEL: StageIo = StageIo { reads: &[TILES_GUIDE], ..StageIo::of("denoise lf") };
    const UPSAMPLE: StageIo = StageIo {
        reads: &[VERTEX_NORMAL, VIEW_DEPTH, VIEW_DIRECTION, MOTION, TILES_GUIDE],
        writes: &[FILTERED_LF_SH, FILTERED_LF_COCG],
        ..StageIo::of("denoise lf")
    };
    /// Images that its passes take in turn.
    const TILES: StageIo = StageIo {
        writes: &[TILES_LF_SH, TILES_LF_COCG, TILES2_LF_SH, TILES2_LF_COCG],
        ..StageIo::of("denoise lf")
    };
    /// The declarations of its passes, without their source.
    pub(crate) const IO: [StageIo; 4] = [Self::TILES, Self::DOWNSAMPLE, Self::LEVEL, Self::UPSAMPLE];

    /// Creates the kernels.
    pub(crate) fn new(device: &Device) -> Result<Self> {
        let kernel = |code, io| declared::<LfPush>(device, code, io, &[]);
        let downsample = kernel(&kernels::LF_DOWNSAMPLE, &Self::DOWNSAMPLE)?;
        let deflicker = kernel(&kernels::LF_DEFLICKER, &Self::LEVEL)?;
        let atrous = kernel(&kernels::LF_ATROUS, &Self::LEVEL)?;
        let upsample = kernel(&kernels::LF_UPSAMPLE, &Self::UPSAMPLE)?;
        Ok(Self { downsample, deflicker, atrous, upsample })
    }

    /// Adds its passes to the frame and returns the filtered light.
    pub(crate) fn record<'a>(
        &self,
        frame: &mut Frame<'_>,
        inputs: &StageInputs<'a>,
        source: LowFrequencyLight<'a>,
        params: &LfParams,
    ) -> Result<LowFrequencyLight<'a>> {
        let images = inputs.images;
        let size = images.size();
        let constants = |step: u32, guard: bool| LfPush {
            size: size.into(),
            step,
            depth: params.depth,
            normal: params.normal,
            limit: params.deflicker.unwrap_or(f32::INFINITY),
            guard: guard.into(),
            roots: holds_roots(source.sh).into(),
        };
        let tiles = [size[0].div_ceil(TILE_SIDE), size[1].div_ceil(TILE_SIDE), 1];
        let mut now = light(images, TILES_LF_SH, TILES_LF_COCG);
        let mut next = light(images, TILES2_LF_SH, TILES2_LF_COCG);
        let mut pass = |name: &str,
                        kernel,
                        io,
                        source: LowFrequencyLight<'_>,
                        target: LowFrequencyLight<'_>,
                        push,
                        threads| {
            inputs
                .pass(frame, name, kernel, io)
                .sample("source_sh", source.sh)
                .sample("source_cocg", source.cocg)
                .write("target_sh", target.sh)
                .write("target_cocg", target.cocg)
                .push(&push)
                .dispatch(threads)
        };
        let pixels = inputs.flat_threads();
        let once = constants(1, false);
        pass("denoise lf downsample", &self.downsample, &Self::DOWNSAMPLE, source, now, once, pixels)?;
        if params.deflicker.is_some() {
            pass("denoise lf deflicker", &self.deflicker, &Self::LEVEL, now, next, once, tiles)?;
            std::mem::swap(&mut now, &mut next);
        }
        for i in 0..params.iterations {
            let name = format!("denoise lf a-trous {i}");
            let push = constants(1 << i, params.leak_guard && i + 1 == params.iterations);
            pass(&name, &self.atrous, &Self::LEVEL, now, next, push, tiles)?;
            std::mem::swap(&mut now, &mut next);
        }
        inputs
            .pass(frame, "denoise lf upsample", &self.upsample, &Self::UPSAMPLE)
            .sample("source_sh", source.sh)
            .sample("source_cocg", source.cocg)
            .sample("tiles_sh", now.sh)
            .sample("tiles_cocg", now.cocg)
            .push(&once)
            .dispatch(pixels)?;
        Ok(light(images, FILTERED_LF_SH, FILTERED_LF_COCG))
    }
}
