//! What the variants do with indirect diffuse light.

use crate::passes::{Changes, LfSpatial, LfTemporal};
use crate::{DenoiseParams, Denoiser};
use pt_core::{Device, Frame, LowFrequencyLight, Result, SplitLight, StageInputs, StageIo};

/// The passes over indirect diffuse light of a variant.
pub(super) struct LowFrequency {
    temporal: Option<LfTemporal>,
    spatial: Option<LfSpatial>,
}

impl LowFrequency {
    /// Whether the variant accumulates over frames, and whether it filters in space.
    const fn passes(variant: Denoiser) -> [bool; 2] {
        match variant {
            Denoiser::Off | Denoiser::Oidn => [false, false],
            Denoiser::Accumulate => [true, false],
            Denoiser::Svgf | Denoiser::Asvgf | Denoiser::Recurrent => [true, true],
            Denoiser::Atrous => [false, true],
        }
    }

    /// The declarations of the passes, in order.
    pub(super) fn io(variant: Denoiser) -> Vec<StageIo> {
        let [temporal, spatial] = Self::passes(variant);
        let mut all = vec![SplitLight::UNFILTERED_INDIRECT];
        if variant == Denoiser::Asvgf {
            all.push(LfTemporal::IO_ANTILAG);
        } else if temporal {
            all.push(LfTemporal::IO);
        }
        if spatial {
            all.extend(LfSpatial::IO);
        }
        if spatial && !temporal {
            // The filter's last pass reads its source too.
            all.push(SplitLight::UNFILTERED_INDIRECT);
        }
        all
    }

    pub(super) fn new(device: &Device, params: &DenoiseParams) -> Result<Self> {
        let variant = params.variant;
        let [temporal, spatial] = Self::passes(variant);
        let adaptive = variant == Denoiser::Asvgf;
        Ok(Self {
            temporal: temporal.then(|| LfTemporal::new(device, adaptive, params)).transpose()?,
            spatial: spatial.then(|| LfSpatial::new(device)).transpose()?,
        })
    }

    /// Whether it filters nothing.
    pub(super) fn hands_on(&self) -> bool {
        self.temporal.is_none() && self.spatial.is_none()
    }

    /// Adds the passes to the frame and returns the light for the composite. It comes before the passes over the other channels.
    pub(super) fn record<'a>(
        &self,
        frame: &mut Frame<'_>,
        inputs: &StageInputs<'a>,
        source: LowFrequencyLight<'a>,
        changes: Option<Changes<'_>>,
        params: &DenoiseParams,
    ) -> Result<LowFrequencyLight<'a>> {
        let mut light = source;
        if let Some(temporal) = &self.temporal {
            let sums = changes.and_then(|changes| changes.sums_lf);
            light = temporal.record(frame, inputs, sums, params)?;
        }
        match &self.spatial {
            Some(spatial) => spatial.record(frame, inputs, light, &params.lf),
            None => Ok(light),
        }
    }
}
