//! The renderer behind the window.

use super::args::ViewArgs;
use super::hand_out::{Picture, View, camera_words};
use super::looking::{self, Codes};
use super::pace::Pace;
use super::running::{Running, Times};
use super::truth::{MOST_FLIP, Truth};
use crate::aov;
use crate::args::DEFAULT_VFOV;
use crate::camera_path;
use crate::frame::FrameTime;
use crate::params::{FrameParams, check_frame, differences, resolve};
use crate::session::{Session, fold_seed};
use anyhow::{Context, Result, bail, ensure};
use pt_core::Image;
use pt_core::settings::{Knobs, apply_sets};
use pt_scene::{Camera, CameraKey, Projection};
use pt_shaders::channels::{DISPLAY, Format};
use pt_shaders::glam::Vec3;
use pt_view::protocol::{Failure, Frames, Legend, Pose, Request, Status, TruthView};
use std::path::PathBuf;

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

    /// A picture that no command line can say is rendered anew first.
    fn begin_hand_out(&mut self) -> Result<()> {
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

    fn hand_out(&mut self) {
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

    fn save(&mut self) -> Result<()> {
        let Some(running) = &self.running else { return Ok(()) };
        let png = self.free_name("view", "png");
        let exr = png.with_extension("exr");
        pt_post::write_picture(&png, running.full.images(), self.params.post.encoding)?;
        aov::layers(&running.full, &self.params, &[])?.write_exr(&exr)?;
        self.message = format!("wrote {} and {}", png.display(), exr.display());
        Ok(())
    }

    fn record(&mut self, begins: bool) -> Result<()> {
        if begins {
            // Scene time is the clock of the way.
            self.pace.play(true);
            self.recorded = Some(Vec::new());
            self.message = "the way of the camera is recorded".into();
            return Ok(());
        }
        let Some(keys) = self.recorded.take() else { return Ok(()) };
        ensure!(keys.len() >= 2, "the way of the camera has fewer than two frames; nothing is written");
        let path = self.free_name("camera-path", "json");
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
    fn free_name(&self, stem: &str, extension: &str) -> PathBuf {
        let name = |number: u32| self.args.folder.join(format!("{stem}-{number}.{extension}"));
        (1..).map(name).find(|path| !path.exists()).unwrap_or_else(|| name(0))
    }

    fn render(&mut self) -> Result<()> {
        let [time, previous] = self.pace.next(self.args.frame.scene.fps);
        let seed = fold_seed(self.args.frame.seed);
        let time_step = self.args.frame.time_step();
        let params = self.params.clone();
        self.times = self.running()?.render(FrameTime { time, previous, seed, time_step }, &params)?;
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

    /// The pictures that are made on the host.
    fn look(&mut self) -> Result<()> {
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

    fn status(&mut self) -> Result<Status> {
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
            frames: self.pace.frames(),
            time,
            playing: self.pace.is_playing(),
            recording: self.recorded.is_some(),
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
