//! Set-up that all commands share that run the frame: device, scene, camera.

use crate::args::{CameraArgs, CameraChoice, DeviceArgs, LookAt};
use crate::camera_path;
use anyhow::{Result, anyhow, bail, ensure};
use pt_core::console::print_warning;
use pt_core::memory::{check_size, host_free_bytes};
use pt_core::phases::Phases;
use pt_core::settings::close_to;
use pt_core::trace::TraceBackend;
use pt_core::{Device, DeviceOptions, Frame};
use pt_denoise::Denoiser;
use pt_import::LoadOptions;
use pt_light_sampling::LightTables;
use pt_scene::gpu::GpuScene;
use pt_scene::{Camera, Scene, Texture, automatic_camera};
use pt_shaders::NamedEnum;
use pt_shaders::glam::Vec3;
use std::panic::resume_unwind;
use std::path::Path;
use std::thread::{self, ScopedJoinHandle};

/// Larger scenes are uploaded after the search for an automatic camera, not at the same time: each builds a tree, which needs some 200 bytes
/// per triangle during construction.
const MOST_TRIANGLES_BESIDE: usize = 2_000_000;

/// Extensions of files that are no scenes for pt, with what they are and what to do.
const OTHER_FILES: &[(&[&str], &str)] = &[
    (
        &["png", "jpg", "jpeg", "webp", "tga", "bmp"],
        "is an image, not a glTF 2.0 file; give a .gltf or .glb file",
    ),
    (
        &["exr", "hdr"],
        "is an image, not a glTF 2.0 file; an environment is given by --env, and the scene before it",
    ),
    (
        &[
            "obj", "fbx", "blend", "dae", "usd", "usda", "usdc", "usdz", "ply", "stl", "3ds", "abc", "pbrt",
            "xml",
        ],
        "is a scene in another format, not a glTF 2.0 file; convert it, for example with Blender (File, Export, glTF 2.0)",
    ),
];

/// Opens a scene: a glTF or GLB file, or the name of a built-in scene.
///
/// # Errors
/// A file of another kind, with what to do; else those of the importer.
pub fn open_scene(file: &str, options: &LoadOptions) -> Result<Scene> {
    ensure!(
        !file.is_empty(),
        "the name of the scene is empty; give a glTF file or a built-in scene (pt scenes)"
    );
    let path = Path::new(file);
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    let other = OTHER_FILES.iter().find(|(kinds, _)| kinds.contains(&extension.as_str()));
    match other.filter(|_| path.is_file()) {
        Some((_, problem)) => bail!("{file}: {problem}"),
        None => pt_import::open(file, options).map_err(|error| {
            let denoiser = options.variant.as_deref().filter(|name| Denoiser::from_name(name).is_ok());
            match denoiser {
                Some(name) => anyhow!(
                    "{error}; --variant is a material variant of a glTF file, the denoiser is --set denoise.variant={name}"
                ),
                None => error.into(),
            }
        }),
    }
}

/// Longest side of the scene, metres, if it is far from that of things and buildings: perhaps its unit is another.
fn unusual_size(scene: &Scene) -> Option<f32> {
    let side = scene.bounds()?.size().max_element();
    (side > 0.0 && !(1e-2..1e5).contains(&side)).then_some(side)
}

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
    /// The camera that was asked for, along its path where it has one.
    pub camera: Camera,
    /// Where the time went since the scene's file was opened; runs on.
    pub load: Phases,
}

impl Session {
    /// Opens the device and uploads the scene. If the scene has no camera, an automatic one is searched at the same time, or, to save
    /// memory, before.
    ///
    /// # Errors
    /// A camera that the scene does not have, no device, or a scene that does not fit.
    pub fn open(args: &DeviceArgs, camera: &CameraArgs, scene: Scene) -> Result<Self> {
        let DeviceArgs { backend, device, validation } = args.clone();
        let device = || Device::open(&DeviceOptions { device, validation });
        Self::with_device(device, backend, camera, scene)
    }

    /// As [`Session::open`], on a device that is open.
    ///
    /// # Errors
    /// A camera that the scene does not have, or a scene that does not fit.
    pub fn on(device: &Device, backend: TraceBackend, camera: &CameraArgs, scene: Scene) -> Result<Self> {
        Self::with_device(|| Ok(device.clone()), backend, camera, scene)
    }

    fn with_device(
        open: impl FnOnce() -> pt_core::Result<Device>,
        backend: TraceBackend,
        camera: &CameraArgs,
        scene: Scene,
    ) -> Result<Self> {
        let mut load = Phases::start();
        load.include(&scene.load_phases);
        let mut camera = choose_camera(&scene, camera)?;
        if let (None, Some(size)) = (&camera, unusual_size(&scene)) {
            print_warning(&format!(
                "the scene measures {size:e} m, glTF's unit is the metre; it has no camera, an automatic one frames it"
            ));
        }
        // The choice of a backend is measured, which wants the processor for itself.
        let is_large = scene.statistics().triangles > MOST_TRIANGLES_BESIDE;
        if backend == TraceBackend::Auto || is_large {
            camera = camera.or_else(|| Some(automatic_camera(&scene)));
            load.mark("automatic camera");
        }
        let (device, gpu, lights, camera) = thread::scope(|threads| {
            let camera = threads.spawn(|| camera.unwrap_or_else(|| automatic_camera(&scene)));
            let device = open()?;
            load.mark("device");
            let mut gpu = GpuScene::new(&device, &scene, backend)?;
            load.include(gpu.load_phases());
            let lights = LightTables::new(&device, &scene)?;
            lights.attach(&mut gpu);
            load.mark("lights");
            let camera = join(camera);
            load.mark("automatic camera");
            Ok::<_, pt_core::Error>((device, gpu, lights, camera))
        })?;
        Ok(Self { device, scene, gpu, lights, camera, load })
    }

    /// Bytes of the scene's textures without compression, with mips, including the environment.
    pub fn uncompressed_texture_bytes(&self) -> u64 {
        let environment = 16 * self.scene.environment.image.texels.len() as u64;
        self.scene.textures.iter().map(Texture::uncompressed_bytes).sum::<u64>() + environment
    }

    /// Moves the scene to `time` (seconds), first on the host, then on the device. `previous`: time of the last frame.
    ///
    /// # Errors
    /// When the frame can't take the uploads.
    pub fn update(&mut self, frame: &mut Frame<'_>, time: f64, previous: f64) -> pt_core::Result<()> {
        self.scene.set_time(time, previous);
        self.lights.update(frame, &self.scene, &mut self.gpu)
    }

    /// Device and driver in one line.
    pub fn device_line(&self) -> String {
        let info = self.device.info();
        format!("{} ({})", info.name, info.driver_line())
    }

    /// Fails if the validation layers reported anything.
    ///
    /// # Errors
    /// Any message.
    pub fn check_validation(&self) -> Result<()> {
        match self.device.validation().map(|log| log.messages()) {
            Some(messages) if !messages.is_empty() => {
                bail!("{} validation messages, the first: {}", messages.len(), messages[0])
            }
            _ => Ok(()),
        }
    }
}

/// Checks that the host has memory for an image of `size` pixels with `per_pixel` bytes each, before the work begins.
///
/// # Errors
/// What would fit.
pub fn check_host_memory(what: &'static str, size: [u32; 2], per_pixel: u64) -> pt_core::Result<()> {
    let bytes = size.iter().map(|&side| u64::from(side)).product::<u64>() * per_pixel;
    host_free_bytes().map_or(Ok(()), |free| check_size(what, size, bytes, "the host", free))
}

/// Joins a thread and returns its result; forwards its panic.
pub(crate) fn join<T>(thread: ScopedJoinHandle<'_, T>) -> T {
    thread.join().unwrap_or_else(|panic| resume_unwind(panic))
}

/// The 32 bits of a seed that kernels see; all of its bits count.
pub fn fold_seed(seed: u64) -> u32 {
    (seed as u32) ^ ((seed >> 32) as u32).wrapping_mul(0x9e37_79b9)
}

/// The camera that the arguments select, or the scene's first one; `None` if it has none.
///
/// # Errors
/// A camera that the scene does not have, with those that it has.
pub fn choose_camera(scene: &Scene, args: &CameraArgs) -> Result<Option<Camera>> {
    let CameraArgs { camera: choice, look, vfov, camera_path } = args;
    if let Some(path) = camera_path {
        return camera_path::read(path).map(Some);
    }
    if let Some(LookAt { eye, target }) = *look {
        let camera = Camera::look_at("look", Vec3::from(eye), Vec3::from(target), vfov.to_radians());
        return Ok(Some(camera));
    }
    let found = match choice {
        None => return Ok(scene.cameras.first().cloned()),
        Some(CameraChoice::Index(index)) => scene.camera(*index),
        Some(CameraChoice::Name(name)) => scene.cameras.iter().find(|camera| camera.name == *name),
    };
    if let Some(camera) = found {
        return Ok(Some(camera.clone()));
    }
    let wanted = match choice {
        Some(CameraChoice::Index(index)) => index.to_string(),
        Some(CameraChoice::Name(name)) => name.clone(),
        None => String::new(),
    };
    let cameras = scene.cameras.iter().enumerate();
    let names: Vec<_> = cameras.map(|(i, c)| format!("{} \"{}\"", c.index.unwrap_or(i), c.name)).collect();
    let there = if names.is_empty() { "none".into() } else { names.join(", ") };
    let closest = close_to(&wanted, scene.cameras.iter().map(|camera| camera.name.as_str()));
    bail!("camera {wanted}: {} has no such camera{closest}; it has {there}", scene.name)
}
