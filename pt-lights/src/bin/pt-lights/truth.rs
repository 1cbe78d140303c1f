//! The direct light of the reference path tracer.

use super::view::View;
use anyhow::Result;
use glam::DVec3;
use pt_reference::records::PathLights;
use pt_reference::{Progressive, ReferenceParams};

/// What all samplers should converge to.
pub struct Truth {
    /// Radiance of each pixel, rows from the top.
    pub mean: Vec<DVec3>,
    /// Variance of `mean`.
    pub variance: Vec<DVec3>,
    /// Root of the expected relative squared error.
    pub relative_error: f64,
}

impl Truth {
    /// Path traces the view: emission, and one reflection of it.
    pub fn trace(view: &mut View, spp: u32) -> Result<Self> {
        // Textures filtered as the G-buffer filters them: it is the light samplers that are compared. On Sponza, whose floor has fine
        // normal and roughness maps, the finest level makes 1 % less light.
        // Lights are picked without the tables of the samplers that are compared.
        let lights = PathLights::PerKind;
        let params = ReferenceParams {
            max_bounces: Some(0),
            spp,
            ray_cones: true,
            lights,
            ..ReferenceParams::default()
        };
        let frame = view.frame_record(0, 0x5eed);
        let View { device, scene, gpu, lights, .. } = view;
        let mut render = Progressive::new(device, gpu, lights, frame, params, None, 0)?;
        while render.next_sample() < spp {
            render.step(scene, gpu, lights, spp)?;
        }
        let estimate = render.state()?.estimate(spp);
        Ok(Self {
            relative_error: estimate.relative_error(),
            mean: estimate.pixels.iter().map(|p| p.mean.as_dvec3()).collect(),
            variance: estimate.pixels.iter().map(|p| p.variance.as_dvec3()).collect(),
        })
    }
}
