//! The passes that the denoisers consist of.

/// Light channels and the images by which a pixel finds its surface in the last frame.
macro_rules! with_surfaces {
    ($($light:ident),* $(; $($more:ident),*)?) => {
        &[
            $(pt_shaders::channels::$light,)*
            pt_shaders::channels::SHADING_POSITION,
            pt_shaders::channels::VERTEX_NORMAL,
            pt_shaders::channels::VIEW_DEPTH,
            pt_shaders::channels::VIEW_DIRECTION,
            pt_shaders::channels::MOTION,
            $($(pt_shaders::channels::$more,)*)?
        ]
    };
}

/// The images by which filters in space tell surfaces apart, and others.
macro_rules! with_guides {
    ($($more:ident),*) => {
        &[
            $($more,)*
            pt_shaders::channels::NORMAL,
            pt_shaders::channels::VIEW_DEPTH,
            pt_shaders::channels::VIEW_DIRECTION,
            pt_shaders::channels::MOTION,
            pt_shaders::channels::METALLIC_ROUGHNESS,
            pt_shaders::channels::BOUNCE_THROUGHPUT,
        ]
    };
}

/// Histories and the images that say which surface they belong to.
macro_rules! with_surfaces_before {
    ($($history:ident),*) => {
        &[
            pt_shaders::channels::VERTEX_NORMAL,
            pt_shaders::channels::VIEW_DEPTH,
            crate::images::SURFACE,
            $($history,)*
        ]
    };
}

mod atrous;
mod gradients;
mod low_frequency;
mod push;
mod recurrent;
mod temporal;
mod variance;

pub use atrous::AtrousParams;
pub(crate) use atrous::{Atrous, AtrousTargets};
pub use gradients::AntilagParams;
pub(crate) use gradients::{Changes, Gradients};
pub use low_frequency::LfParams;
pub(crate) use low_frequency::{LfSpatial, LfTemporal};
pub use recurrent::RecurrentParams;
pub(crate) use recurrent::{Blur, RecurrentBlur};
pub use temporal::TemporalParams;
pub(crate) use temporal::{Form, Temporal};
pub(crate) use variance::Variance;

use pt_core::kernel::Constant;
use pt_core::{Device, Kernel, Result, StageIo};
use pt_shaders::{GpuStruct, ShaderCode};

/// A kernel whose declaration is checked.
fn declared<P: GpuStruct>(
    device: &Device,
    code: &ShaderCode,
    io: &StageIo,
    constants: &[(&str, Constant)],
) -> Result<Kernel> {
    let kernel = Kernel::compute::<P>(device, code, constants)?;
    io.check([&kernel])?;
    Ok(kernel)
}
