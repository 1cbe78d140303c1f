//! What the window hands out: command lines, pictures, ways of the camera, captures.

use super::{Capturing, ViewFrames, pose_of};
use crate::aov;
use crate::camera_path;
use crate::commands::view::hand_out::{Picture, View};
use crate::commands::view::running::Running;
use crate::frame_capture::FrameCapture;
use crate::params::{check_one_plane, differences, resolve};
use anyhow::{Result, ensure};
use pt_scene::Camera;
use pt_shaders::glam::Vec3;
use std::path::PathBuf;

impl ViewFrames {
    /// A picture that no command line can say is rendered anew first.
    pub(super) fn begin_hand_out(&mut self) -> Result<()> {
        ensure!(
            self.capture.is_none(),
            "frames are being captured; the command line can be copied after them"
        );
        if self.pace.whole_from().is_some() {
            self.hand_out();
            return Ok(());
        }
        let fps = self.args.frame.scene.fps;
        self.pace = self.pace.anew(self.args.frames, fps);
        // A camera that was found for the scene may be another one at another time.
        let is_found = self.view == View::Asked(Vec::new());
        if is_found && self.running()?.session.scene.cameras.is_empty() {
            self.free_camera();
        }
        let Some(running) = self.running.take() else { return Ok(()) };
        self.running =
            Some(running.anew(&self.args.frame, &self.params, self.camera.clone(), self.pace.time())?);
        self.hand_out_at = Some(self.args.frames);
        self.is_frozen = false;
        self.message = format!("the picture is rendered anew, {} frames", self.args.frames);
        Ok(())
    }

    fn free_camera(&mut self) {
        let pose = pose_of(&self.camera);
        let (eye, target) = (Vec3::from(pose.eye), Vec3::from(pose.target));
        (self.camera, self.view) =
            (Camera::look_at("look", eye, target, pose.vfov.to_radians()), View::Free(pose));
    }

    pub(super) fn hand_out(&mut self) {
        let Some(time) = self.pace.whole_from() else { return };
        let Ok(base) = resolve(None, &[], self.args.frame.accumulate) else { return };
        let command = Picture {
            scene: &self.args.frame.scene.file,
            kept: &self.kept,
            view: &self.view,
            time,
            holds: !self.pace.is_playing() && !self.args.frame.accumulate,
            frames: self.pace.frames(),
            sets: &differences(&base, &self.params),
        }
        .command();
        let number = self.command.as_ref().map_or(0, |(number, _)| *number) + 1;
        self.message = format!("copied: {command}");
        self.command = Some((number, command));
        self.is_frozen = true;
    }

    pub(super) fn save(&mut self) -> Result<()> {
        let Some(running) = &self.running else { return Ok(()) };
        let png = self.free_name("view", ".png");
        let exr = png.with_extension("exr");
        pt_post::write_picture(&png, running.full.images(), self.params.post.encoding)?;
        aov::layers(&running.full, &self.params, &[])?.write_exr(&exr)?;
        self.message = format!("wrote {} and {}", png.display(), exr.display());
        Ok(())
    }

    pub(super) fn record(&mut self, begins: bool) -> Result<()> {
        if begins {
            // Scene time is the clock of the way.
            self.pace.play(true);
            self.recorded = Some(Vec::new());
            self.message = "the way of the camera is recorded".into();
            return Ok(());
        }
        let Some(keys) = self.recorded.take() else { return Ok(()) };
        ensure!(keys.len() >= 2, "the way of the camera has fewer than two frames; nothing is written");
        let path = self.free_name("camera-path", ".json");
        camera_path::write(&path, pose_of(&self.camera).vfov, &keys)?;
        let from = keys.first().map_or(0.0, |key| key.time);
        self.message = format!(
            "wrote {}; pt render --camera-path {} --time={from} --frames={} plays it",
            path.display(),
            path.display(),
            keys.len()
        );
        Ok(())
    }

    /// A name in the folder that no file has.
    fn free_name(&self, stem: &str, ending: &str) -> PathBuf {
        let name = |number: u32| self.args.folder.join(format!("{stem}-{number}{ending}"));
        (1..).map(name).find(|path| !path.exists()).unwrap_or_else(|| name(0))
    }

    /// Begins to capture the next frames, or ends it early.
    pub(super) fn capture(&mut self, begins: bool) -> Result<()> {
        if !begins {
            self.end_capture("");
            return Ok(());
        }
        ensure!(self.capture.is_none(), "frames are being captured already");
        let Some(running) = &self.running else { return Ok(()) };
        let scene = &running.session.scene;
        check_one_plane(&self.params, scene, "a capture")?;
        let folder = self.free_name("capture", "");
        let size = self.args.frame.output_size();
        let frames = FrameCapture::create(&folder, &scene.name, size, self.args.frame.accumulate)?;
        self.message = format!("{} frames are captured in {}", self.args.frames, folder.display());
        self.capture = Some(Capturing { frames, folder });
        Ok(())
    }

    /// Ends the capture, if one is running; what it has stays. `why`: what ended it.
    pub(super) fn end_capture(&mut self, why: &str) {
        let Some(Capturing { frames, folder }) = self.capture.take() else { return };
        let (count, folder) = (frames.frames(), folder.display());
        self.message = match count {
            0 => format!("no frame was captured{why}"),
            _ => format!(
                "wrote {folder}, {count} frames{why}; pt replay {folder} --from=denoise -o frame_#.exr runs stages on them"
            ),
        };
    }

    /// Adds the last frame to the capture.
    pub(super) fn add_to_capture(&mut self, has_history: bool) -> Result<()> {
        let (Some(capture), Some(running)) = (&mut self.capture, &self.running) else { return Ok(()) };
        let Running { session, full, .. } = running;
        capture.frames.add(session, full, &self.params, has_history, self.pace.time(), None)?;
        if capture.frames.frames() == self.args.frames {
            self.end_capture("");
        }
        Ok(())
    }
}
