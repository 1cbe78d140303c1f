//! The edge-avoiding a-trous filter.

use super::declared;
use super::push::rounding;
use crate::histories::holds_roots;
use crate::images::{GUIDE, LEVELS_HF, LEVELS_SPEC, LEVELS2_HF, LEVELS2_SPEC};
use crate::kernels;
use crate::records::{AtrousKernel, AtrousPush, Schedule};
use pt_core::{Device, Frame, Kernel, Result, SplitLight, StageInputs, StageIo, knobs};

knobs! {
    /// Knobs of the a-trous filter and of the variance that guides it.
    pub struct AtrousParams {
        /// Levels of the filter; the taps of each are twice as far apart as those of the one before.
        pub iterations: u32 = 5, in 1..=7, source "Schied et al. 2017, section 4.4";
        /// Taps of a level and their weights: 5x5 takes twice the time and reaches twice as far.
        pub kernel: AtrousKernel = AtrousKernel::Three, source "Dammertz et al. 2010" => structural;
        /// Whether the first level's output is the history of the next frame, as in the paper; otherwise history is not filtered in space, which keeps
        /// shadows sharper while nothing moves.
        pub feedback: bool = false, source "Schied et al. 2017, section 4.1";
        /// Tolerance of differences in distance, in units of what the slope of the surface explains.
        pub depth: f32 = 1.0, in 0.01..=100.0, source "Schied et al. 2017, eq. 3";
        /// Sharpness of the weight by the angle between the shading normals, which is close to the exponent of a cosine; that of the specular channel grows with the smoothness
        /// of the surface.
        pub normal: f32 = 128.0, in 1.0..=1024.0, source "Schied et al. 2017, eq. 4";
        /// Tolerance of differences in diffuse luminance.
        pub luminance_hf: f32 = 4.0, in 0.01..=1000.0, unit "standard deviations", source "Schied et al. 2017, eq. 5";
        /// Tolerance of differences in specular luminance.
        pub luminance_spec: f32 = 4.0, in 0.01..=1000.0, unit "standard deviations", source "Schied et al. 2017, eq. 5";
        /// Width of the specular filter in units of the surface's lobe: how far the direction of view may turn, over alpha = roughness^2.
        pub lobe: f32 = 0.5, in 0.01..=10.0, unit "radians";
        /// Length from which on the variance comes from the history rather than from the pixels around.
        pub min_length: u32 = 4, in 2..=64, unit "frames", source "Schied et al. 2017, section 4.2";
        /// In which order the pixels of a level are filtered; the result is the same.
        pub schedule: Schedule = Schedule::Permuted, source "Dolp, Hanika and Dachsbacher 2024" => structural;
    }
}

/// Pixels that a group of the permuted schedule filters, as in `atrous_permuted.glsl`.
const GROUP: [u32; 2] = [16, 8];

/// The kernels of the levels.
pub(crate) struct Atrous {
    /// Writes light.
    kernel: Kernel,
    /// Writes roots of light, in half floats.
    roots: Kernel,
    schedule: Schedule,
}

/// What the levels write besides the images between them.
#[derive(Clone, Copy)]
pub(crate) struct AtrousTargets<'a> {
    /// Of the first level, where its output is kept.
    pub first: Option<SplitLight<'a>>,
    /// Of the last level.
    pub last: SplitLight<'a>,
}

impl Atrous {
    const LEVEL: StageIo = StageIo { reads: &[GUIDE], ..StageIo::of("denoise a-trous") };
    const BETWEEN: StageIo = StageIo {
        writes: &[LEVELS_HF, LEVELS_SPEC, LEVELS2_HF, LEVELS2_SPEC],
        ..StageIo::of("denoise a-trous")
    };
    /// The images that it accesses besides source and targets.
    pub(crate) const IO: [StageIo; 2] = [Self::LEVEL, Self::BETWEEN];

    /// Creates the kernels.
    pub(crate) fn new(device: &Device, params: &AtrousParams) -> Result<Self> {
        let (code, roots) = match (params.schedule, params.kernel) {
            (Schedule::Permuted, AtrousKernel::Three) => (&kernels::ATROUS_3X3, &kernels::ATROUS_3X3_ROOTS),
            (Schedule::Permuted, AtrousKernel::Five) => (&kernels::ATROUS_5X5, &kernels::ATROUS_5X5_ROOTS),
            (Schedule::Dilated, AtrousKernel::Three) => {
                (&kernels::ATROUS_DILATED_3X3, &kernels::ATROUS_DILATED_3X3_ROOTS)
            }
            (Schedule::Dilated, AtrousKernel::Five) => {
                (&kernels::ATROUS_DILATED_5X5, &kernels::ATROUS_DILATED_5X5_ROOTS)
            }
        };
        let kernel = |code| declared::<AtrousPush>(device, code, &Self::LEVEL, &[]);
        Ok(Self { kernel: kernel(code)?, roots: kernel(roots)?, schedule: params.schedule })
    }

    /// Adds all levels to the frame and returns the last one's output. `source`: light with variances in alpha.
    pub(crate) fn record<'a>(
        &self,
        frame: &mut Frame<'_>,
        inputs: &StageInputs<'a>,
        source: SplitLight<'a>,
        targets: AtrousTargets<'a>,
        params: &AtrousParams,
    ) -> Result<SplitLight<'a>> {
        let images = inputs.images;
        let size = images.size();
        let between = [[LEVELS_HF, LEVELS_SPEC], [LEVELS2_HF, LEVELS2_SPEC]].map(|[hf, spec]| SplitLight {
            hf: images.current(hf),
            spec: images.current(spec),
            lf: None,
        });
        let mut source = source;
        for level in 0..params.iterations {
            let step = 1 << level;
            let (target, to_history) = match targets.first {
                Some(first) if level == 0 => (first, true),
                _ if level + 1 == params.iterations => (targets.last, false),
                _ => (between[level as usize % 2], false),
            };
            let push = AtrousPush {
                size: size.into(),
                step,
                depth: params.depth,
                normal: params.normal,
                luminance_hf: params.luminance_hf,
                luminance_spec: params.luminance_spec,
                lobe: params.lobe,
                roots: holds_roots(source.hf).into(),
                to_history: to_history.into(),
                rounding: rounding(inputs),
            };
            let threads = match self.schedule {
                // Whole groups for each of the lattices that a level consists of.
                Schedule::Permuted => {
                    [0, 1].map(|i| size[i].div_ceil(step).div_ceil(GROUP[i]) * step * GROUP[i])
                }
                Schedule::Dilated => size,
            };
            let kernel = if holds_roots(target.hf) { &self.roots } else { &self.kernel };
            inputs
                .pass(frame, &format!("denoise a-trous {level}"), kernel, &Self::LEVEL)
                .sample("source_hf", source.hf)
                .sample("source_spec", source.spec)
                .write("target_hf", target.hf)
                .write("target_spec", target.spec)
                .push(&push)
                .dispatch([threads[0], threads[1], 1])?;
            source = target;
        }
        Ok(source)
    }
}
