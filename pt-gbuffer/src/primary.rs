use crate::camera_interior::CameraInterior;
use crate::records::PrimaryPush;
use crate::{GbufferParams, Jitter, frame_jitter, kernels};
use pt_core::frame::RayCount;
use pt_core::trace::TraceVariant;
use pt_core::{Device, Frame, Kernel, StageInputs, StageIo};
use pt_shaders::channels;
use pt_shaders::records::{CULL_BACK_FACES, MASK_OPAQUE, MASK_TRANSMISSIVE};

/// The primary ray stage.
pub struct PrimaryRays {
    kernel: Kernel,
    /// Where the scene has solids.
    camera_interior: Option<CameraInterior>,
}

impl PrimaryRays {
    /// The images that the stage accesses.
    pub const IO: StageIo = StageIo {
        writes: &[
            channels::RNG_SEED,
            channels::VISIBILITY,
            channels::BARYCENTRICS,
            channels::CLUSTER,
            channels::BASE_COLOR,
            channels::METALLIC_ROUGHNESS,
            channels::NORMAL,
            channels::VERTEX_NORMAL,
            channels::VIEW_DEPTH,
            channels::MOTION,
            channels::SHADING_POSITION,
            channels::VIEW_DIRECTION,
            channels::THROUGHPUT,
            channels::BOUNCE_THROUGHPUT,
            channels::TRANSPARENT,
            channels::INTERIOR,
        ],
        ..StageIo::of("primary rays")
    };

    /// Compiles the kernel.
    pub fn new(device: &Device, variant: TraceVariant) -> pt_core::Result<Self> {
        let kernel = Kernel::trace::<PrimaryPush>(
            device,
            &kernels::PRIMARY_RAYS,
            variant.backend,
            &variant.constants(),
        )?;
        Self::IO.check([&kernel])?;
        Ok(Self { kernel, camera_interior: CameraInterior::new(device, variant)? })
    }

    /// Records the pass; in scenes with transmission after one that finds the solids that the camera is inside of.
    ///
    /// # Errors
    /// When the pass does not fit into the frame.
    pub fn record(
        &self,
        frame: &mut Frame<'_>,
        inputs: &StageInputs<'_>,
        params: &GbufferParams,
    ) -> pt_core::Result<()> {
        let interior = self.camera_interior.as_ref();
        if let Some(interior) = interior {
            interior.record(frame, inputs)?;
        }
        let push = PrimaryPush {
            camera_solids: interior.map_or(0, CameraInterior::address),
            jitter: frame_jitter(params.jitter, frame.index()).into(),
            jitter_per_pixel: u32::from(params.jitter == Jitter::Pixel),
            lod_scale: params.texture_lod_bias.exp2(),
            mask: MASK_OPAQUE | MASK_TRANSMISSIVE | CULL_BACK_FACES,
            pad: 0,
        };
        let pass = inputs.pass(frame, "primary rays", &self.kernel, &Self::IO);
        interior
            .into_iter()
            .fold(pass, |pass, interior| interior.bind(pass))
            .rays(RayCount::Threads)
            .push(&push)
            .dispatch(inputs.split_threads())
    }
}
