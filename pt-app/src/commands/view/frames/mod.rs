//! The renderer behind the window.

mod files;
mod shown;

use super::args::ViewArgs;
use super::hand_out::{View, camera_words};
use super::pace::Pace;
use super::running::{Running, Times};
use super::truth::Truth;
use crate::args::DEFAULT_VFOV;
use crate::frame::FrameTime;
use crate::frame_capture::FrameCapture;
use crate::params::{FrameParams, check_frame};
use crate::session::{Session, fold_seed};
use anyhow::{Context, Result, bail, ensure};
use pt_core::Image;
use pt_core::settings::{Knobs, apply_sets};
use pt_scene::{Camera, CameraKey, Projection};
use pt_shaders::glam::Vec3;
use pt_view::protocol::{Failure, Frames, Legend, Pose, Request, Status, TruthView};
use std::path::PathBuf;

/// The next frames, on their way into a folder.
struct Capturing {
    frames: FrameCapture,
    folder: PathBuf,
}

/// The frames of a window.
pub(super) struct ViewFrames {
    args: ViewArgs,
    /// Words of the command line that hold for `pt render`, too.
    kept: Vec<String>,
    params: FrameParams,
    running: Option<Running>,
    camera: Camera,
    view: View,
    /// Changes when the camera was put somewhere else here.
    pose_number: u64,
    pace: Pace,
    /// No frame is rendered: the picture that was handed out stays.
    is_frozen: bool,
    /// Frames after which a picture that is rendered anew is handed out.
    hand_out_at: Option<u32>,
    command: Option<(u64, String)>,
    recorded: Option<Vec<CameraKey>>,
    capture: Option<Capturing>,
    look: Option<String>,
    /// Image and frame that are in false colour, and the scale.
    looked_for: Option<(String, u32)>,
    image_legend: Option<Legend>,
    legend: Option<Legend>,
    pixel: Option<[u32; 2]>,
    truth_view: TruthView,
    truth: Option<Truth>,
    /// Pictures that are made on the host: an image in false colour, the ground truth.
    looked_at: Option<Image>,
    truth_image: Option<Image>,
    times: Times,
    message: String,
}

/// Checks that the window can show what the knobs ask for.
///
/// # Errors
/// HDR pictures.
pub(super) fn check_shown(params: &FrameParams) -> Result<()> {
    ensure!(
        !params.post.encoding.is_hdr(),
        "the window shows sRGB; use --set post.encoding=srgb, or pt render for HDR pictures"
    );
    Ok(())
}

/// Where a camera is.
pub(super) fn pose_of(camera: &Camera) -> Pose {
    let vfov = match camera.projection {
        Projection::Perspective { yfov } => yfov.to_degrees(),
        Projection::Orthographic { .. } => DEFAULT_VFOV,
    };
    let (eye, distance) = (camera.position(), camera.focus_distance.clamp(0.1, 1e4));
    Pose { eye: eye.to_array(), target: (eye + camera.forward() * distance).to_array(), vfov }
}

impl ViewFrames {
    /// The frames of a session that has rendered none.
    ///
    /// # Errors
    /// When the device refuses.
    pub(super) fn new(
        args: ViewArgs,
        kept: Vec<String>,
        params: FrameParams,
        mut session: Session,
        camera: Camera,
    ) -> Result<Self> {
        session.camera = camera.clone();
        let running = Running::new(session, &args.frame, &params)?;
        let plays = args.play && !args.frame.accumulate;
        Ok(Self {
            view: View::Asked(camera_words(&args.frame.camera)),
            pace: Pace::new(args.frame.scene.time, plays),
            args,
            kept,
            params,
            running: Some(running),
            camera,
            pose_number: 0,
            is_frozen: false,
            hand_out_at: None,
            command: None,
            recorded: None,
            capture: None,
            look: None,
            looked_for: None,
            image_legend: None,
            legend: None,
            pixel: None,
            truth_view: TruthView::Off,
            truth: None,
            looked_at: None,
            truth_image: None,
            times: Times::default(),
            message: String::new(),
        })
    }

    fn running(&mut self) -> Result<&mut Running> {
        self.running.as_mut().context("the frame could not be made anew")
    }

    fn follow(&mut self, request: Request) -> Result<()> {
        let only_looks = matches!(
            request,
            Request::Pixel(_) | Request::Look(_) | Request::Truth(_) | Request::HandOut | Request::Save
        );
        if !only_looks {
            // Whatever else it is, the picture goes on.
            (self.is_frozen, self.hand_out_at) = (false, None);
        }
        // A replay knows the knobs of the first frame alone, and no histories that were forgotten.
        if matches!(
            request,
            Request::Knobs(_) | Request::SceneCamera(_) | Request::Seek(_) | Request::ResetHistories
        ) {
            self.end_capture(", until something else than time and camera changed");
        }
        match request {
            Request::Camera(pose) => {
                let (eye, target) = (Vec3::from(pose.eye), Vec3::from(pose.target));
                self.put_camera(
                    Camera::look_at("look", eye, target, pose.vfov.to_radians()),
                    View::Free(pose),
                )?;
            }
            Request::SceneCamera(index) => self.scene_camera(index)?,
            Request::Knobs(changes) => self.set_knobs(&changes)?,
            Request::Play(plays) => self.pace.play(plays && !self.args.frame.accumulate),
            Request::Step => {
                self.pace.play(false);
                let time = self.pace.time() + 1.0 / self.args.frame.scene.fps;
                self.pace.seek(time);
            }
            Request::Seek(time) => {
                self.pace.seek(time);
                self.running()?.full.reset_history();
            }
            Request::ResetHistories => {
                self.pace.changed();
                self.running()?.full.reset_history();
            }
            Request::Look(name) => self.look = name,
            Request::Pixel(pixel) => self.pixel = pixel,
            Request::Truth(view) => self.truth_view = view,
            Request::HandOut => self.begin_hand_out()?,
            Request::Save => self.save()?,
            Request::Record(begins) => self.record(begins)?,
            Request::Capture(begins) => self.capture(begins)?,
        }
        Ok(())
    }

    fn put_camera(&mut self, camera: Camera, view: View) -> Result<()> {
        self.pace.changed();
        self.running()?.session.camera = camera.clone();
        (self.camera, self.view) = (camera, view);
        Ok(())
    }

    fn scene_camera(&mut self, index: usize) -> Result<()> {
        let scene = &self.running()?.session.scene;
        let Some(camera) = scene.cameras.get(index).cloned() else { return Ok(()) };
        let by_index = camera.index.unwrap_or(index);
        let by_name = scene.cameras.iter().find(|other| other.name == camera.name);
        let name = if scene.camera(by_index) == Some(&camera) {
            by_index.to_string()
        } else if by_name == Some(&camera) {
            camera.name.clone()
        } else {
            bail!("camera {}: neither its name nor its index tells it from the others", camera.name);
        };
        self.put_camera(camera, View::OfScene(name))?;
        self.pose_number += 1;
        self.running()?.full.reset_history();
        Ok(())
    }

    /// Knobs that do not fit together leave all as they were.
    fn set_knobs(&mut self, changes: &[(String, String)]) -> Result<()> {
        let mut params = self.params.clone();
        let sets: Vec<_> = changes.iter().map(|(key, value)| format!("{key}={value}")).collect();
        apply_sets(&mut params, &sets)?;
        check_frame(&params, self.args.frame.accumulate)?;
        check_shown(&params)?;
        self.pace.changed();
        let before = std::mem::replace(&mut self.params, params);
        if before.structural_difference(&self.params).is_none() {
            return Ok(());
        }
        let (args, params) = (self.args.frame.clone(), self.params.clone());
        if let Err(error) = self.running()?.remake(&args, &params) {
            self.params = before;
            return Err(error);
        }
        Ok(())
    }

    fn render(&mut self) -> Result<()> {
        let [time, previous] = self.pace.next(self.args.frame.scene.fps);
        let seed = fold_seed(self.args.frame.seed);
        let time_step = self.args.frame.time_step();
        let params = self.params.clone();
        let running = self.running.as_mut().context("the frame could not be made anew")?;
        let has_history = running.full.images().has_frame();
        let begun = match &mut self.capture {
            Some(capture) if capture.frames.frames() == 0 => capture.frames.begin(&running.full),
            _ => Ok(()),
        };
        self.times = running.render(FrameTime { time, previous, seed, time_step }, &params)?;
        if let Err(error) = begun.and_then(|()| self.add_to_capture(has_history)) {
            self.end_capture(&format!(", then: {error:#}"));
        }
        if let Some(keys) = &mut self.recorded
            && keys.last().is_none_or(|last| last.time < time)
        {
            let pose = pose_of(&self.camera.at(time));
            keys.push(CameraKey { time, position: pose.eye.into(), target: pose.target.into() });
        }
        if self.hand_out_at == Some(self.pace.frames()) {
            self.hand_out_at = None;
            self.hand_out();
        }
        Ok(())
    }
}

impl Frames for ViewFrames {
    fn next(&mut self, requests: Vec<Request>) -> Result<Status, Failure> {
        for request in requests {
            if let Err(error) = self.follow(request) {
                // What can't be is said, and all goes on.
                self.message = format!("{error:#}");
            }
        }
        if !self.is_frozen {
            self.render()?;
        }
        if let Err(error) = self.look() {
            // Other knobs may have taken the image away.
            self.message = format!("{error:#}");
            self.look = None;
        }
        Ok(self.status()?)
    }
}
