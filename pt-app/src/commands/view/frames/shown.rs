//! What the window shows of a frame: pictures that are made on the host, and the state of the panel.

use super::{ViewFrames, pose_of};
use crate::commands::view::hand_out::View;
use crate::commands::view::looking::{self, Codes};
use crate::commands::view::running::Running;
use crate::commands::view::truth::{MOST_FLIP, Truth};
use anyhow::Result;
use pt_core::Image;
use pt_shaders::channels::{DISPLAY, Format};
use pt_view::protocol::{Legend, Status, TruthView};

impl ViewFrames {
    /// The pictures that are made on the host.
    pub(super) fn look(&mut self) -> Result<()> {
        let Some(running) = &self.running else { return Ok(()) };
        match &self.look {
            Some(name) if self.looked_for == Some((name.clone(), self.pace.frames())) => {}
            Some(name) => {
                let (codes, legend) = looking::false_color(running.full.images(), name)?;
                put(&mut self.looked_at, &running.session.device, &codes)?;
                self.image_legend = Some(legend);
                self.looked_for = Some((name.clone(), self.pace.frames()));
            }
            None => (self.looked_at, self.image_legend, self.looked_for) = (None, None, None),
        }
        self.legend = self.image_legend.clone();
        if self.truth_view == TruthView::Off {
            (self.truth, self.truth_image) = (None, None);
            return Ok(());
        }
        let session = &running.session;
        let truth = self.truth.get_or_insert_with(|| Truth::new(&session.device, session.gpu.backend()));
        let time = self.pace.time();
        let camera = self.camera.at(time);
        let codes =
            truth.advance(&session.scene, &camera, time, &running.full, &self.params, self.truth_view)?;
        if let Some(codes) = codes {
            put(&mut self.truth_image, &session.device, &codes)?;
        }
        if self.truth_view == TruthView::Difference {
            let meaning = "FLIP of the frame against the truth".into();
            let range = [0.0, MOST_FLIP];
            self.legend = Some(Legend { name: "difference".into(), meaning, range, is_color: false });
        }
        Ok(())
    }

    pub(super) fn status(&mut self) -> Result<Status> {
        let pixel = match (self.pixel, &self.running) {
            (Some(pixel), Some(running)) => self.values(running, pixel)?,
            _ => Vec::new(),
        };
        let time = self.pace.time();
        if !matches!(self.view, View::Free(_)) && (self.camera.path.is_some() || self.camera.motion.is_some())
        {
            self.pose_number += 1;
        }
        let running = self.running.as_ref();
        let picture = running.map(|running| running.full.images().current(DISPLAY).clone());
        Ok(Status {
            picture: self.looked_at.clone().or(picture),
            truth: self.truth_image.clone(),
            is_resting: self.is_frozen,
            frames: self.pace.frames(),
            time,
            playing: self.pace.is_playing(),
            recording: self.recorded.is_some(),
            capture: self.capture.as_ref().map(|capture| [capture.frames.frames(), self.args.frames]),
            pose: Some((self.pose_number, pose_of(&self.camera.at(time)))),
            passes: self.times.passes.clone(),
            frame_ms: self.times.frame_ms,
            pixel,
            legend: self.legend.clone(),
            images: running.map(|running| looking::names(running.full.images())).unwrap_or_default(),
            truth_state: self.truth.as_ref().map(Truth::state).unwrap_or_default(),
            message: self.message.clone(),
            command: self.command.clone(),
        })
    }

    /// Values at a pixel of what is shown.
    fn values(&self, running: &Running, pixel: [u32; 2]) -> Result<Vec<(String, String)>> {
        let images = running.full.images();
        let shown = self.looked_at.as_ref().map_or(images.output_size(), Image::extent);
        let size = images.size();
        let pixel = [0, 1].map(|axis| {
            let scaled = u64::from(pixel[axis]) * u64::from(size[axis]) / u64::from(shown[axis].max(1));
            (scaled as u32).min(size[axis] - 1)
        });
        let at = ("pixel".to_owned(), format!("{} {}", pixel[0], pixel[1]));
        Ok(std::iter::once(at).chain(looking::pixel(images, pixel)?).collect())
    }
}

/// Puts codes into an image, a new one where the size is another.
fn put(image: &mut Option<Image>, device: &pt_core::Device, codes: &Codes) -> Result<()> {
    if codes.texels.is_empty() {
        return Ok(());
    }
    let fits = image.as_ref().is_some_and(|image| image.extent() == codes.size);
    if !fits {
        *image = Some(Image::new(device, "shown in the window", Format::Rgba8Unorm, codes.size)?);
    }
    image.as_ref().map_or(Ok(()), |image| Ok(image.write(&codes.texels)?))
}
