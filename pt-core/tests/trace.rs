//! The trace backends against the native traversal, and against each other.

use glam::{Affine3A, Quat, UVec3, Vec2, Vec3, Vec4};
use pt_core::random::{RandomSource, coverage_number};
use pt_core::rng::{coverage_seed, random4};
use pt_core::test_support::TestDevice;
use pt_core::trace::ray_list::{Coverage, Query, RayScene, Visibility};
use pt_core::trace::{
    BvhQuality, CLEARLY_FASTER, InstancePlacement, MeshGeometry, NativeScene, TraceBackend, choose,
};
use pt_core::{Buffer, Device, Location, Recorder};
use pt_shaders::glam;
use pt_shaders::records::{
    Hit, MATERIAL_BLEND, MATERIAL_MASK, MaterialRecord, NONE, Ray, TextureSlot, VertexRecord,
};

const RAYS: u32 = 4096;
const CUTOFF: f32 = 0.5;
const SEED: u32 = 3;

fn random(stream: u32, index: u32) -> Vec4 {
    Vec4::from_array(random4([index, stream], 0, 0, 0))
}

struct Mesh {
    positions: Vec<Vec3>,
    indices: Vec<UVec3>,
    alphas: Vec<u8>,
    first_masked: u32,
    deforms: bool,
}

impl Mesh {
    /// Triangles without order in the unit cube round the origin; `size` is the length of their edges.
    fn soup(stream: u32, triangles: u32, first_masked: u32, size: f32) -> Self {
        let positions = (0..triangles * 3)
            .map(|i| {
                let center = random(stream, i / 3).truncate() - 0.5;
                center + (random(stream + 1, i).truncate() - 0.5) * size
            })
            .collect();
        let indices = (0..triangles).map(|t| UVec3::new(3 * t, 3 * t + 1, 3 * t + 2)).collect();
        let alphas = (0..triangles * 3).map(|i| (random(stream + 2, i).x * 255.0) as u8).collect();
        Self { positions, indices, alphas, first_masked, deforms: false }
    }

    fn geometry(&self) -> MeshGeometry<'_> {
        MeshGeometry {
            positions: &self.positions,
            indices: &self.indices,
            first_masked: self.first_masked,
            deforms: self.deforms,
        }
    }

    /// The same triangles, twisted about +Y, stretched and shifted by `amount`.
    fn twist(&mut self, amount: f32) {
        for p in &mut self.positions {
            let turn = Quat::from_rotation_y(4.0 * amount * p.y);
            *p = turn * *p * Vec3::new(1.0, 1.0 + amount, 1.0 - 0.8 * amount) + Vec3::X * amount;
        }
    }

    fn alpha(&self, triangle: u32, bary: Vec2) -> f32 {
        let index = self.indices[triangle as usize];
        let alpha = |i: u32| f32::from(self.alphas[i as usize]) / 255.0;
        alpha(index.x) * (1.0 - bary.x - bary.y) + alpha(index.y) * bary.x + alpha(index.z) * bary.y
    }

    /// Masked and blended triangles take turns.
    fn material(triangle: u32) -> u32 {
        triangle % 2
    }

    fn is_covered(&self, instance: u32, triangle: u32, bary: Vec2, coverage_seed: u32) -> bool {
        let alpha = self.alpha(triangle, bary);
        match Self::material(triangle) {
            0 => alpha >= CUTOFF,
            _ => coverage_number(RandomSource::White, [coverage_seed, 0], instance, triangle) < alpha,
        }
    }
}

/// Non-uniform scales, some of them negative, moving with the frame.
fn placements(meshes: u32, count: u32, frame: u32) -> Vec<InstancePlacement> {
    (0..count)
        .map(|i| {
            let (a, b) = (random(90, i), random(91, i));
            let scale =
                Vec3::new(0.3 + a.x, 0.3 + 2.0 * a.y, 0.3 + a.z) * if i % 3 == 1 { -1.0 } else { 1.0 };
            let scale = if i % 4 == 2 { scale * Vec3::new(1.0, -1.0, 1.0) } else { scale };
            let rotation =
                Quat::from_rotation_y(b.x * 6.0 + 0.3 * frame as f32) * Quat::from_rotation_x(b.y * 6.0);
            let shift = (random(92, i).truncate() - 0.5) * 6.0 + Vec3::X * 0.4 * frame as f32;
            InstancePlacement {
                mesh: i % meshes,
                mask: 1 << (i % 3),
                world_from_object: Affine3A::from_scale_rotation_translation(scale, rotation, shift),
            }
        })
        .collect()
}

fn rays() -> Vec<Ray> {
    (0..RAYS)
        .map(|i| {
            let origin = (random(80, i).truncate() - 0.5) * 9.0;
            let target = (random(81, i).truncate() - 0.5) * 5.0;
            // One in eight runs along an axis, one in eight is short.
            let axis = [Vec3::X, Vec3::NEG_Y, Vec3::Z][i as usize % 3];
            let direction = if i % 8 == 0 { axis } else { target - origin };
            Ray { origin, t_min: 0.01, direction, t_max: if i % 8 == 1 { 0.3 } else { 1e4 } }
        })
        .collect()
}

/// A scene on the device with all that the alpha test reads.
fn scene(device: &Device, meshes: &[Mesh], instances: usize, backend: TraceBackend) -> RayScene {
    let geometry: Vec<_> = meshes.iter().map(Mesh::geometry).collect();
    let mut scene = RayScene::new(device, &geometry, instances, backend, Coverage::AlphaTest).unwrap();
    let none = TextureSlot { texture: NONE, flags: 0, transform: [[0.0; 3]; 2] };
    let material = |flags| MaterialRecord {
        base_color: Vec4::ONE,
        flags,
        alpha_cutoff: CUTOFF,
        base_color_texture: none,
        ..bytemuck::Zeroable::zeroed()
    };
    let materials = [MATERIAL_MASK, MATERIAL_BLEND].map(material);
    let materials = Buffer::from_slice(device, "materials", &materials).unwrap();
    let tables: Vec<_> = meshes
        .iter()
        .map(|mesh| {
            let vertices: Vec<VertexRecord> = vec![bytemuck::Zeroable::zeroed(); mesh.alphas.len()];
            let colors: Vec<_> =
                mesh.alphas.iter().map(|&a| Vec3::ONE.extend(f32::from(a) / 255.0)).collect();
            let indices: Vec<_> = (0..mesh.indices.len() as u32).map(Mesh::material).collect();
            let vertices = Buffer::from_slice(device, "vertices", &vertices).unwrap();
            let colors = Buffer::from_slice(device, "colours", &colors).unwrap();
            [vertices, colors, Buffer::from_slice(device, "triangle materials", &indices).unwrap()]
        })
        .collect();
    scene.set_materials(&materials, &tables).unwrap();
    scene
}

struct Tracer {
    scene: RayScene,
    recorder: Recorder,
    rays: Buffer,
    hits: [Buffer; 2],
}

impl Tracer {
    fn new(device: &Device, meshes: &[Mesh], instances: usize, backend: TraceBackend) -> Self {
        Self::with_rays(device, meshes, instances, backend, &rays())
    }

    fn with_rays(
        device: &Device,
        meshes: &[Mesh],
        instances: usize,
        backend: TraceBackend,
        rays: &[Ray],
    ) -> Self {
        let hits = || {
            Buffer::new(device, "hits", u64::from(RAYS) * size_of::<Hit>() as u64, Location::Device).unwrap()
        };
        Self {
            scene: scene(device, meshes, instances, backend),
            recorder: Recorder::new(device).unwrap(),
            rays: Buffer::from_slice(device, "rays", rays).unwrap(),
            hits: [hits(), hits()],
        }
    }

    /// Records one frame: moves the vertices of meshes that deform and the instances, traces the rays both ways.
    fn record(&mut self, meshes: &[Mesh], placements: &[InstancePlacement], mask: u32) {
        let visibility = Visibility { mask, seed: SEED };
        let mut frame = self.recorder.begin().unwrap();
        let moved: Vec<_> =
            (0..).zip(meshes).filter(|(_, m)| m.deforms).map(|(i, m)| (i, &m.positions[..])).collect();
        self.scene.deform(&mut frame, &moved).unwrap();
        self.scene.place(&mut frame, placements).unwrap();
        for (query, hits) in [Query::Closest, Query::Occluded].into_iter().zip(&self.hits) {
            self.scene.trace(&mut frame, query, &self.rays, hits, [RAYS, 100], visibility).unwrap();
        }
        frame.submit().unwrap();
    }

    fn trace(
        &mut self,
        meshes: &[Mesh],
        placements: &[InstancePlacement],
        mask: u32,
    ) -> (Vec<Hit>, Vec<bool>) {
        self.record(meshes, placements, mask);
        let occluded = self.hits[1].read::<Hit>().unwrap().iter().map(|h| h.instance != NONE).collect();
        (self.hits[0].read().unwrap(), occluded)
    }
}

fn native_hits(meshes: &[Mesh], placements: &[InstancePlacement], mask: u32) -> Vec<Hit> {
    let geometry: Vec<_> = meshes.iter().map(Mesh::geometry).collect();
    let native = NativeScene::new(&geometry, placements, BvhQuality::Fast).unwrap();
    let hit = |(i, ray): (u32, &Ray)| {
        let seed = coverage_seed([i, 0], 0, 0, SEED);
        let coverage = |instance: u32, triangle: u32, bary: Vec2| {
            let mesh = &meshes[placements[instance as usize].mesh as usize];
            mesh.is_covered(instance, triangle, bary, seed)
        };
        native.closest(ray, mask, Some(&coverage))
    };
    (0..RAYS).zip(&rays()).map(hit).collect()
}

fn same_triangle(a: &Hit, b: &Hit) -> bool {
    a.instance == b.instance && (a.instance == NONE || a.triangle == b.triangle)
}

/// Rounding decides at edges and at the alpha cutoff: a ray in a thousand may fall to the other side.
fn assert_agree(what: &str, a: &[Hit], b: &[Hit]) {
    let wrong: Vec<_> = a.iter().zip(b).enumerate().filter(|(_, (a, b))| !same_triangle(a, b)).collect();
    assert!(
        wrong.len() * 1000 <= a.len(),
        "{what}: {} of {} differ, first {:?}",
        wrong.len(),
        a.len(),
        wrong[0]
    );
}

/// Traces some frames with every backend. After the first, the meshes that deform are twisted a little more in each.
fn compare(meshes: &mut [Mesh], instances: u32, frames: u32, ray_mask: u32, least_hits: usize) {
    let device = TestDevice::open();
    let mut tracers: Vec<_> = TraceBackend::available(&device)
        .into_iter()
        .map(|backend| (backend.to_string(), Tracer::new(&device, meshes, instances as usize, backend)))
        .collect();
    let gpu = device.with_gpu_traversal(true);
    let tracer = Tracer::new(&gpu, meshes, instances as usize, TraceBackend::Compute);
    tracers.push(("compute, as on a GPU".into(), tracer));
    for frame in 0..frames {
        if frame > 0 {
            meshes.iter_mut().filter(|m| m.deforms).for_each(|m| m.twist(0.3));
        }
        let meshes = &*meshes;
        let placed = placements(meshes.len() as u32, instances, frame);
        let native = native_hits(meshes, &placed, ray_mask);
        let found = native.iter().filter(|h| h.instance != NONE).count();
        assert!(found >= least_hits, "the test's rays must hit something: {found}");
        let mut first: Option<Vec<Hit>> = None;
        for (backend, tracer) in &mut tracers {
            let (hits, occluded) = tracer.trace(meshes, &placed, ray_mask);
            assert_agree(&format!("{backend} and native, frame {frame}"), &native, &hits);
            for (hit, native) in
                hits.iter().zip(&native).filter(|(a, b)| a.instance != NONE && same_triangle(a, b))
            {
                assert!(
                    (hit.t - native.t).abs() <= 1e-4 * native.t.max(1.0),
                    "{backend}: {hit:?} {native:?}"
                );
                assert!(
                    hit.barycentrics.abs_diff_eq(native.barycentrics, 2e-3),
                    "{backend}: {hit:?} {native:?}"
                );
            }
            let inconsistent =
                hits.iter().zip(&occluded).filter(|(h, o)| (h.instance != NONE) != **o).count();
            assert!(
                inconsistent * 1000 <= hits.len(),
                "{backend}: {inconsistent} shadow rays contradict closest hits"
            );
            let Some(first) = &first else {
                first = Some(hits);
                continue;
            };
            assert_agree(&format!("{backend} and compute, frame {frame}"), first, &hits);
            for (a, b) in first.iter().zip(&hits).filter(|(a, b)| a.instance != NONE && same_triangle(a, b)) {
                assert_eq!(a, b, "{backend}: other bits than compute");
            }
        }
    }
}

/// Two BLEND sheets of a mesh, twice behind each other: every ray sees one with the probability of the
/// "over" operator, whatever it is that finds the hits, and shadow rays pass with the product of what is left.
#[test]
fn mean_of_stochastic_transparency_is_over() {
    let device = TestDevice::open();
    let sheet = |z: f32| [Vec3::new(-9.0, -9.0, z), Vec3::new(9.0, -9.0, z), Vec3::new(0.0, 18.0, z)];
    // The odd triangles blend.
    let positions: Vec<_> = [50.0, 0.0, 51.0, -1.0].into_iter().flat_map(sheet).collect();
    let alphas: Vec<_> = [255u8, 102, 255, 51].into_iter().flat_map(|a| [a; 3]).collect();
    let indices = (0..4).map(|t| UVec3::new(3 * t, 3 * t + 1, 3 * t + 2)).collect();
    let meshes = [Mesh { positions, indices, alphas, first_masked: 0, deforms: false }];
    let place = |z| InstancePlacement {
        mesh: 0,
        mask: 1,
        world_from_object: Affine3A::from_translation(Vec3::Z * z),
    };
    let placed = [place(0.0), place(-10.0)];
    let ray = |i| {
        let origin = Vec3::new(random(70, i).x - 0.5, random(71, i).x - 0.5, 5.0);
        Ray { origin, t_min: 0.0, direction: Vec3::NEG_Z, t_max: 30.0 }
    };
    let rays: Vec<_> = (0..RAYS).map(ray).collect();
    let mut first: Option<Vec<Hit>> = None;
    for backend in TraceBackend::available(&device) {
        let mut tracer = Tracer::with_rays(&device, &meshes, 2, backend, &rays);
        let (hits, occluded) = tracer.trace(&meshes, &placed, 1);
        let n = f64::from(RAYS);
        let is = |want: f64, count: usize, what: &str| {
            let sigma = (want * (1.0 - want) / n).sqrt();
            let share = count as f64 / n;
            assert!((share - want).abs() < 4.0 * sigma, "{backend}, {what}: {share} instead of {want}");
        };
        let (near, far) = (0.4, 0.2);
        let left = (1.0 - near) * (1.0 - far);
        for (instance, triangle, want) in
            [(0, 1, near), (0, 3, (1.0 - near) * far), (1, 1, left * near), (1, 3, left * (1.0 - near) * far)]
        {
            let seen = hits.iter().filter(|h| (h.instance, h.triangle) == (instance, triangle)).count();
            is(want, seen, "share of a sheet");
        }
        is(left * left, hits.iter().filter(|h| h.instance == NONE).count(), "share of what lies behind");
        // A shadow ray decides as the ray with the same seed does.
        assert!(hits.iter().zip(&occluded).all(|(h, o)| (h.instance != NONE) == *o), "{backend}");
        let first = first.get_or_insert_with(|| hits.clone());
        let same = |(a, b): (&Hit, &Hit)| a == b || a.instance == NONE && b.instance == NONE;
        assert!(first.iter().zip(&hits).all(same), "{backend}: other bits than compute");
    }
}

#[test]
fn moving_instances_with_masks_and_alpha() {
    let empty = Mesh { positions: vec![], indices: vec![], alphas: vec![], first_masked: 0, deforms: false };
    let mut meshes =
        [Mesh::soup(10, 1500, 1000, 0.2), Mesh::soup(20, 200, 0, 0.5), empty, Mesh::soup(30, 40, 40, 0.8)];
    compare(&mut meshes, 24, 3, 0b011, 500);
}

/// Sheets of two layers, which on a GPU are the two triangles of a leaf. Rays meet both, and either may be transparent or opaque there.
#[test]
fn layers_of_one_leaf() {
    let layers = |first_masked| {
        let mut mesh = Mesh::soup(60, 600, first_masked, 0.4);
        for (upper, lower) in (0..1800).map(|i| (i, i + 3)).filter(|(i, _)| i % 6 < 3) {
            mesh.positions[lower] = mesh.positions[upper] + 0.002;
        }
        mesh
    };
    for first_masked in [0, 301, 600] {
        compare(&mut [layers(first_masked)], 1, 1, 0xff, 60);
        compare(&mut [layers(first_masked)], 9, 1, 0b011, 200);
    }
}

#[test]
fn lone_instance() {
    compare(&mut [Mesh::soup(40, 5000, 4000, 0.3)], 1, 2, 0xff, 60);
}

#[test]
fn deforming_meshes_are_refitted() {
    let deforming = |mesh: Mesh| Mesh { deforms: true, ..mesh };
    let mut meshes = [
        deforming(Mesh::soup(110, 3000, 2500, 0.2)),
        Mesh::soup(120, 200, 100, 0.5),
        // The smallest trees: a root with one leaf, and with less than eight.
        deforming(Mesh::soup(130, 1, 1, 0.9)),
        deforming(Mesh::soup(140, 7, 3, 0.9)),
    ];
    compare(&mut meshes, 12, 4, 0b011, 200);
}

#[test]
fn lone_deforming_instance() {
    compare(&mut [Mesh { deforms: true, ..Mesh::soup(150, 2000, 2000, 0.3) }], 1, 4, 0xff, 60);
}

#[test]
fn hidden_lone_instance_and_no_instance() {
    let device = TestDevice::open();
    let meshes = [Mesh::soup(50, 100, 100, 0.5)];
    for backend in TraceBackend::available(&device) {
        let mut tracer = Tracer::new(&device, &meshes, 1, backend);
        for (placed, mask) in [(placements(1, 1, 0), 0b10), (Vec::new(), 0xff)] {
            let (hits, occluded) = tracer.trace(&meshes, &placed, mask);
            assert!(hits.iter().all(|h| h.instance == NONE) && !occluded.contains(&true), "{backend}");
        }
        let (hits, _) = tracer.trace(&meshes, &placements(1, 1, 0), 0b01);
        assert!(hits.iter().any(|h| h.instance != NONE), "{backend}");
    }
}

#[test]
fn frames_in_their_stride_create_nothing() {
    let device = TestDevice::open();
    let mut meshes = [Mesh { deforms: true, ..Mesh::soup(60, 300, 200, 0.3) }];
    for backend in TraceBackend::available(&device) {
        let mut tracer = Tracer::new(&device, &meshes, 9, backend);
        for frame in 0..6 {
            meshes[0].twist(0.1);
            tracer.record(&meshes, &placements(1, 9, frame), 0xff);
        }
        for timing in tracer.recorder.finish().unwrap().iter().filter(|t| t.frame > 2) {
            assert_eq!((timing.created.pipelines, timing.created.allocations), (0, 0), "{backend}");
        }
    }
}

#[test]
fn auto_takes_a_backend_that_no_other_clearly_beats() {
    let device = TestDevice::open();
    let mesh = Mesh::soup(70, 2000, 2000, 0.1);
    let choice = choose(&device, &[mesh.geometry()], &placements(1, 2, 0)).unwrap();
    let available = TraceBackend::available(&device);
    assert_eq!(choice.missing.len() + available.len(), TraceBackend::CONCRETE.len());
    assert!(available.contains(&choice.backend));
    if device.info().kind == "cpu" {
        assert_eq!(
            (choice.backend, choice.mrays_per_s.len()),
            (TraceBackend::Compute, 0),
            "nothing is measured"
        );
        return;
    }
    let rate = |b| choice.mrays_per_s.iter().find(|(other, _)| *other == b).map_or(0.0, |(_, rate)| *rate);
    for backend in available.into_iter().filter(|&b| b != TraceBackend::RtReorder) {
        assert!(rate(backend) > 0.0 && rate(backend) <= CLEARLY_FASTER * rate(choice.backend));
    }
}

#[test]
fn names_round_trip_and_bad_ones_are_named() {
    for backend in TraceBackend::CONCRETE.into_iter().chain([TraceBackend::Auto]) {
        assert_eq!(backend.to_string().parse(), Ok(backend));
    }
    let error = "rtx".parse::<TraceBackend>().unwrap_err().to_string();
    assert!(error.contains("\"rtx\"") && error.contains("rt-pipeline"), "{error}");
}

#[test]
fn bad_geometry_is_an_error() {
    let device = TestDevice::open();
    let positions = [Vec3::ZERO, Vec3::X, Vec3::Y];
    let outside = [UVec3::new(0, 1, 3)];
    let bad = MeshGeometry { positions: &positions, indices: &outside, first_masked: 1, deforms: false };
    for backend in TraceBackend::available(&device) {
        let error =
            RayScene::new(&device, &[bad], 1, backend, Coverage::Opaque).err().expect("an error").to_string();
        assert!(error.contains("triangle 0: vertex 3 does not exist"), "{error}");
    }
    // Vertices that are not finite are left out by the trees.
    let positions = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::NAN];
    let indices = [UVec3::new(0, 1, 3), UVec3::new(0, 1, 2)];
    let mesh = MeshGeometry { positions: &positions, indices: &indices, first_masked: 2, deforms: false };
    let placed = [InstancePlacement { mesh: 0, mask: 1, world_from_object: Affine3A::IDENTITY }];
    let native = NativeScene::new(&[mesh], &placed, BvhQuality::Medium).unwrap();
    let ray = Ray { origin: Vec3::new(0.2, 0.2, 1.0), t_min: 0.0, direction: Vec3::NEG_Z, t_max: 9.0 };
    assert_eq!(native.closest(&ray, 1, None).triangle, 1);
    assert!(native.occluded(&ray, 1, None));
}
