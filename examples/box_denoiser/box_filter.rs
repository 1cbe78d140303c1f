//! The mean over 5 x 5 pixels.

use super::{Changes, Variant, ping};
use crate::{DenoiseParams, images::PING_HF, images::PING_SPEC, kernels};
use pt_core::{Device, Frame, Kernel, Result, SplitLight, StageInputs, StageIo};
use pt_shaders::channels::{COLOR_HF, COLOR_SPEC};

pub(super) struct BoxFilter(Kernel);

impl BoxFilter {
    pub(super) const IO: StageIo =
        StageIo { reads: &[COLOR_HF, COLOR_SPEC], writes: &[PING_HF, PING_SPEC], ..StageIo::of("denoise box") };

    pub(super) fn new(device: &Device) -> Result<Self> {
        let kernel = Kernel::compute::<()>(device, &kernels::BOX_FILTER, &[])?;
        Self::IO.check([&kernel])?;
        Ok(Self(kernel))
    }
}

impl Variant for BoxFilter {
    fn record<'a>(
        &self,
        frame: &mut Frame<'_>,
        inputs: &StageInputs<'a>,
        _: Option<Changes<'_>>,
        _: &DenoiseParams,
    ) -> Result<SplitLight<'a>> {
        inputs.pass(frame, "denoise box", &self.0, &Self::IO).dispatch(inputs.split_threads())?;
        Ok(ping(inputs.images))
    }
}
