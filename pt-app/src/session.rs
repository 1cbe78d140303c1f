//! What the commands that run the frame have in common: device, scene, camera.

use crate::cli::{BackendChoice, CameraArgs, CameraChoice, DeviceArgs, LookAt};
use anyhow::{Result, bail};
use pt_core::phases::Phases;
use pt_core::trace::TraceBackend;
use pt_core::{Device, DeviceOptions, Frame};
use pt_lights::LightTables;
use pt_scene::gpu::GpuScene;
use pt_scene::{Camera, Scene, Texture};
use pt_shaders::glam::Vec3;

/// A scene on a device, ready to be rendered.
pub struct Session {
    /// The device.
    pub device: Device,
    /// The scene on the host; its instances move.
    pub scene: Scene,
    /// The scene on the device.
    pub gpu: GpuScene,
    /// Its light lists.
    pub lights: LightTables,
    /// Where the time went since the scene's file was opened; runs on.
    pub load: Phases,
}

impl Session {
    /// Opens the device, then uploads the scene.
    ///
    /// # Errors
    /// No device, or a scene that does not fit.
    pub fn open(args: &DeviceArgs, scene: Scene) -> Result<Self> {
        let mut load = Phases::start();
        load.include(&scene.load_phases);
        let DeviceArgs { backend, device, validation } = args.clone();
        let device = Device::open(&DeviceOptions { device, validation })?;
        load.mark("device");
        let mut gpu = GpuScene::new(&device, &scene, backend.into())?;
        load.include(gpu.load_phases());
        let lights = LightTables::new(&device, &scene)?;
        lights.fill(gpu.record_mut());
        load.mark("lights");
        Ok(Self { device, scene, gpu, lights, load })
    }

    /// What the scene's textures would take without compression, with mips, the environment included.
    pub fn uncompressed_texture_bytes(&self) -> u64 {
        let environment = 16 * self.scene.environment.image.texels.len() as u64;
        self.scene.textures.iter().map(Texture::uncompressed_bytes).sum::<u64>() + environment
    }

    /// Brings the scene to `time`, and what was there in the frame before to `previous` (seconds): on the host, then on the device.
    ///
    /// # Errors
    /// When the frame can't take the uploads.
    pub fn update(&mut self, frame: &mut Frame<'_>, time: f64, previous: f64) -> pt_core::Result<()> {
        self.scene.set_time(time, previous);
        self.lights.update(frame, &self.scene, self.gpu.record_mut())?;
        self.gpu.update(frame, &self.scene)
    }

    /// Device and driver in one line.
    pub fn device_line(&self) -> String {
        let info = self.device.info();
        format!("{} ({})", info.name, info.driver_line())
    }

    /// Fails with what the validation layers said, if they ran and said anything.
    ///
    /// # Errors
    /// Any message.
    pub fn check_validation(&self) -> Result<()> {
        match self.device.validation().map(|log| log.messages()) {
            Some(messages) if !messages.is_empty() => {
                bail!("the validation layers said {} times, first: {}", messages.len(), messages[0])
            }
            _ => Ok(()),
        }
    }
}

impl From<BackendChoice> for TraceBackend {
    fn from(choice: BackendChoice) -> Self {
        match choice {
            BackendChoice::Auto => Self::Auto,
            BackendChoice::Compute => Self::Compute,
            BackendChoice::RayQuery => Self::RayQuery,
            BackendChoice::RtPipeline => Self::RtPipeline,
        }
    }
}

/// The 32 bits of a seed that kernels see; all of its bits count.
pub fn fold_seed(seed: u64) -> u32 {
    (seed as u32) ^ ((seed >> 32) as u32).wrapping_mul(0x9e37_79b9)
}

/// The camera that the arguments name.
///
/// # Errors
/// A name or index that the scene does not have, with those it has.
pub fn choose_camera(scene: &Scene, args: &CameraArgs) -> Result<Camera> {
    let CameraArgs { camera: choice, look, vfov } = args;
    if let Some(LookAt { eye, target }) = *look {
        return Ok(Camera::look_at("look", Vec3::from(eye), Vec3::from(target), vfov.to_radians()));
    }
    let found = match choice {
        None => return Ok(scene.default_camera()),
        Some(CameraChoice::Index(index)) => scene.cameras.get(*index),
        Some(CameraChoice::Name(name)) => scene.cameras.iter().find(|camera| camera.name == *name),
    };
    if let Some(camera) = found {
        return Ok(camera.clone());
    }
    let wanted = match choice {
        Some(CameraChoice::Index(index)) => index.to_string(),
        Some(CameraChoice::Name(name)) => name.clone(),
        None => String::new(),
    };
    let names: Vec<_> =
        scene.cameras.iter().enumerate().map(|(i, c)| format!("{i} \"{}\"", c.name)).collect();
    let there = if names.is_empty() { "none".into() } else { names.join(", ") };
    bail!("camera {wanted}: {} has no such camera; it has {there}", scene.name)
}
