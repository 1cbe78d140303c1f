//! The edge-avoiding a-trous filter.

use super::declared;
use crate::images::GEOMETRY;
use crate::kernels;
use crate::records::{AtrousKernel, AtrousPush, Schedule};
use pt_core::{Device, Frame, Kernel, Result, SplitLight, StageInputs, StageIo, knobs};
use pt_shaders::channels::NORMAL;

knobs! {
    /// Knobs of the a-trous filter and of the variance that guides it.
    pub struct AtrousParams {
        /// Levels of the filter; the taps of each are twice as far apart as those of the one before.
        pub iterations: u32 = 5, in 1..=7, source "Schied et al. 2017, section 4.4";
        /// Taps of a level and their weights: 3x3 takes a third of the time and reaches half as far.
        pub kernel: AtrousKernel = AtrousKernel::Five, source "Dammertz et al. 2010" => structural;
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

/// One kernel for all levels.
pub(crate) struct Atrous {
    kernel: Kernel,
    /// Pixels that a group filters; `None`: neighbours are filtered together.
    group: Option<[u32; 2]>,
}

impl Atrous {
    /// The images that it accesses besides source and target.
    pub(crate) const IO: StageIo = StageIo { reads: &[NORMAL, GEOMETRY], ..StageIo::of("denoise a-trous") };

    /// Creates the kernel.
    pub(crate) fn new(device: &Device, params: &AtrousParams) -> Result<Self> {
        let (code, group) = match (params.schedule, params.kernel) {
            (Schedule::Permuted, AtrousKernel::Three) => (&kernels::ATROUS_3X3, Some([16, 8])),
            (Schedule::Permuted, AtrousKernel::Five) => (&kernels::ATROUS_5X5, Some([8, 8])),
            (Schedule::Dilated, AtrousKernel::Three) => (&kernels::ATROUS_DILATED_3X3, None),
            (Schedule::Dilated, AtrousKernel::Five) => (&kernels::ATROUS_DILATED_5X5, None),
        };
        Ok(Self { kernel: declared::<AtrousPush>(device, code, &Self::IO, &[])?, group })
    }

    /// Adds all levels to the frame and returns the last one's output. `source` is what the first level reads, with variances in alpha;
    /// `targets` are written in turn: the first by the first level, and by no other if there are three.
    pub(crate) fn record<'a>(
        &self,
        frame: &mut Frame<'_>,
        inputs: &StageInputs<'a>,
        source: SplitLight<'a>,
        targets: &[SplitLight<'a>],
        params: &AtrousParams,
    ) -> Result<SplitLight<'a>> {
        let size = inputs.images.size();
        let mut source = source;
        // A first target of its own is not overwritten.
        let (first, ring) = if targets.len() > 2 { targets.split_at(1) } else { (&targets[..0], targets) };
        let order = first.iter().chain(ring.iter().cycle());
        for (level, &target) in (0..params.iterations).zip(order) {
            let step = 1 << level;
            let push = AtrousPush {
                size: size.into(),
                step,
                depth: params.depth,
                normal: params.normal,
                luminance_hf: params.luminance_hf,
                luminance_spec: params.luminance_spec,
                lobe: params.lobe,
            };
            let threads = match self.group {
                // Whole groups for each of the lattices that a level consists of.
                Some(group) => [0, 1].map(|i| size[i].div_ceil(step).div_ceil(group[i]) * step * group[i]),
                None => size,
            };
            inputs
                .pass(frame, &format!("denoise a-trous {level}"), &self.kernel, &Self::IO)
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
