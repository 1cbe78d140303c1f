//! Plates, sheets, and what the stages make of them.

use glam::{Affine3A, DVec3, Mat3A, Vec2, Vec3, Vec4};
use pt_core::channels::field_width;
use pt_core::frame::Uniforms;
use pt_core::test_support::TestDevice;
use pt_core::trace::{TraceBackend, TraceVariant};
use pt_core::{ChannelImages, FrameSizes, Recorder, StageInputs};
use pt_gbuffer::{GbufferParams, Jitter, PrimaryRays, ReflectRefract, plane_count};
use pt_scene::gpu::{GpuScene, camera_record};
use pt_scene::{Camera, Instance, Material, Mesh, Projection, Scene};
use pt_shaders::channels::{self, ChannelId};
use pt_shaders::records::{Culling, FrameRecord};

pub const SIZE: [u32; 2] = [32, 24];
pub const IOR: f64 = 1.5;

/// A rectangle in the plane z = 0 that faces +Z.
pub fn rectangle(scene: &mut Scene, half: Vec2, material: Material, place: Affine3A) {
    let corner = |x: f32, y: f32| (half * Vec2::new(x, y)).extend(0.0);
    let positions = vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
    let count = positions.len();
    scene.meshes.push(Mesh {
        name: "rectangle".into(),
        positions,
        normals: vec![Vec3::Z; count],
        tangents: vec![Vec4::X; count],
        uv0: vec![Vec2::ZERO; count],
        uv1: vec![Vec2::ZERO; count],
        colors: vec![Vec4::ONE; count],
        indices: vec![[0, 1, 2], [0, 2, 3]],
        triangle_materials: vec![scene.materials.len() as u32; 2],
        first_masked: 2,
        ..Mesh::default()
    });
    scene.materials.push(material);
    scene.instances.push(Instance::new("rectangle", scene.meshes.len() as u32 - 1, place));
}

pub fn glass(solid: bool) -> Material {
    Material {
        transmission: 1.0,
        roughness: 0.0,
        thickness: f32::from(solid),
        ior: IOR as f32,
        ..Material::diffuse("glass", Vec3::ONE)
    }
}

/// A wide plate whose front face passes through the origin and is turned by `angle` degrees from +Z towards +X.
pub fn plate(material: Material, thickness: f32, angle: f32) -> Scene {
    let mut scene = Scene::default();
    let turn = Mat3A::from_rotation_y(angle.to_radians());
    let side = |about_y: f32, depth: f32| Affine3A {
        matrix3: turn * Mat3A::from_rotation_y(about_y),
        translation: turn * glam::Vec3A::new(0.0, 0.0, -depth),
    };
    rectangle(&mut scene, Vec2::splat(50.0), material.clone(), side(0.0, 0.0));
    rectangle(&mut scene, Vec2::splat(50.0), material, side(std::f32::consts::PI, thickness));
    scene
}

/// A single sheet, turned likewise.
pub fn sheet(material: Material, angle: f32) -> Scene {
    let mut scene = Scene::default();
    rectangle(&mut scene, Vec2::splat(50.0), material, Affine3A::from_rotation_y(angle.to_radians()));
    scene
}

/// Every ray along -Z.
pub fn parallel_rays(eye: Vec3) -> Camera {
    let camera = Camera::look_at("parallel", eye, eye - Vec3::Z, 1.0);
    Camera { projection: Projection::Orthographic { ymag: 0.5 }, ..camera }
}

pub struct Rig {
    pub device: TestDevice,
    pub backend: TraceBackend,
}

/// What the frames left in the channels: one entry a split pixel.
pub struct Frames {
    pub images: ChannelImages,
    /// Mean over the frames.
    pub radiance: Vec<DVec3>,
    /// Mean over the frames of the throughput of pixels that hold a surface.
    pub shaded: Vec<DVec3>,
}

impl Frames {
    pub fn texels(&self, id: ChannelId) -> Vec<f32> {
        self.images.current(id).read_f32().unwrap()
    }

    pub fn flags(&self) -> Vec<u32> {
        self.images.current(channels::VIEW_DIRECTION).read_u32().unwrap().chunks(2).map(|c| c[1]).collect()
    }

    /// Means over the even and the odd field.
    pub fn fields(values: &[DVec3]) -> [DVec3; 2] {
        let width = field_width(SIZE[0]) as usize;
        let mut sums = [DVec3::ZERO; 2];
        for (i, value) in values.iter().enumerate() {
            sums[usize::from(i % (2 * width) >= width)] += *value;
        }
        sums.map(|sum| sum / (values.len() / 2) as f64)
    }
}

impl Rig {
    pub fn new(backend: TraceBackend) -> Option<Self> {
        let device = TestDevice::open();
        match backend.missing(&device) {
            Some(why) => {
                println!("skipped: {why}");
                None
            }
            None => Some(Self { device, backend }),
        }
    }

    pub fn render(&self, scene: &Scene, cameras: [&Camera; 2], params: &GbufferParams, count: u32) -> Frames {
        self.render_plane(scene, cameras, params, count, 0)
    }

    pub fn render_plane(
        &self,
        scene: &Scene,
        cameras: [&Camera; 2],
        params: &GbufferParams,
        count: u32,
        plane: u32,
    ) -> Frames {
        let mut gpu = GpuScene::new(&self.device, scene, self.backend).unwrap();
        // Without the culling of the knobs: the tests look at the backs of sheets.
        let variant = TraceVariant { culling: Culling::None, ..params.variant(gpu.variant()) };
        let primary = PrimaryRays::new(&self.device, variant).unwrap();
        let stage =
            ReflectRefract::new(&self.device, variant, plane_count(scene, params) > 1, params.effect_layers)
                .unwrap();
        let images = ChannelImages::alone(&self.device, FrameSizes::same(SIZE), &[PrimaryRays::IO]).unwrap();
        let uniforms = Uniforms::new(&self.device, "frame_uniforms").unwrap();
        let mut recorder = Recorder::new(&self.device).unwrap();
        let texels = (2 * field_width(SIZE[0]) * SIZE[1]) as usize;
        let (mut radiance, mut shaded) = (vec![DVec3::ZERO; texels], vec![DVec3::ZERO; texels]);
        for index in 0..count {
            let record = FrameRecord::new(
                camera_record(cameras[0], SIZE),
                camera_record(cameras[1], SIZE),
                SIZE,
                index,
                7,
            );
            let mut frame = recorder.begin().unwrap();
            gpu.update(&mut frame, scene).unwrap();
            uniforms.upload(&mut frame, &record).unwrap();
            let inputs = StageInputs { scene: Some(&gpu), uniforms: Some(&uniforms), images: &images };
            primary.record(&mut frame, &inputs, params).unwrap();
            for bounce in 0..params.reflect_refract {
                stage.record(&mut frame, &inputs, params, 0, bounce, plane).unwrap();
            }
            frame.submit().unwrap();
            recorder.finish().unwrap();
            let overlay = images.current(channels::TRANSPARENT).read_f32().unwrap();
            let throughput = images.current(channels::THROUGHPUT).read_f32().unwrap();
            let rgb =
                |v: &[f32], i: usize| DVec3::from_array(std::array::from_fn(|k| f64::from(v[4 * i + k])));
            for i in 0..texels {
                radiance[i] += rgb(&overlay, i) / f64::from(count);
                if overlay[4 * i + 3] == 0.0 {
                    shaded[i] += rgb(&throughput, i) / f64::from(count);
                }
            }
        }
        let passes = recorder.pass_table().iter().filter(|p| p.kernel.contains("reflect")).count();
        assert_eq!(passes as u32, params.reflect_refract, "passes in the table");
        Frames { images, radiance, shaded }
    }
}

pub fn follow(reflect_refract: u32) -> GbufferParams {
    GbufferParams { jitter: Jitter::None, reflect_refract, ..Default::default() }
}

pub fn near(actual: DVec3, expected: DVec3, tolerance: f64) {
    assert!((actual - expected).abs().max_element() <= tolerance, "{actual} for {expected}");
}
