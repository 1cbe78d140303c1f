//! Rays that start on surfaces: offset_point() at scales from millimetres to thousands of kilometres.

use glam::{Affine3A, UVec3, Vec3};
use pt_core::rng::random4;
use pt_core::test_support::TestDevice;
use pt_core::trace::ray_list::{Coverage, Query, RayScene, Visibility};
use pt_core::trace::{InstancePlacement, MeshGeometry, TraceBackend};
use pt_core::{Buffer, Kernel, Location, Recorder};
use pt_shaders::glam;
use pt_shaders::records::{Hit, NONE, Ray};
use std::f32::consts::TAU;

mod offset_records {
    include!("common/offset_records.rs");
}
#[allow(dead_code, reason = "each test file runs some of them")]
mod kernels {
    include!(concat!(env!("OUT_DIR"), "/test_kernels.rs"));
}
use offset_records::{OffsetPush, OffsetStart};

const RAYS: u32 = 4096;

/// A closed ball of about that radius round a point, convex and without slivers: an octahedron, subdivided.
fn ball(radius: f32, center: Vec3) -> (Vec<Vec3>, Vec<UVec3>) {
    const N: i32 = 12;
    let (mut positions, mut indices) = (Vec::new(), Vec::new());
    for octant in 0..8 {
        let sign = Vec3::new(
            1.0 - 2.0 * (octant & 1) as f32,
            1.0 - (octant & 2) as f32,
            1.0 - (octant >> 1 & 2) as f32,
        );
        let corner = |i: i32, j: i32| {
            let p = Vec3::new(i as f32, j as f32, (N - i - j) as f32).normalize() * sign;
            center + radius * p
        };
        let mut add = |corners: [Vec3; 3]| {
            let first = positions.len() as u32;
            positions.extend(corners);
            let outwards =
                (corners[1] - corners[0]).cross(corners[2] - corners[0]).dot(corners[0] - center) > 0.0;
            let [b, c] = if outwards { [1, 2] } else { [2, 1] };
            indices.push(UVec3::new(first, first + b, first + c));
        };
        for i in 0..N {
            for j in 0..N - i {
                add([corner(i, j), corner(i + 1, j), corner(i, j + 1)]);
                if i + j + 1 < N {
                    add([corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)]);
                }
            }
        }
    }
    (positions, indices)
}

struct Tracer {
    scene: RayScene,
    recorder: Recorder,
    placement: InstancePlacement,
    hits: Buffer,
}

impl Tracer {
    fn trace(&mut self, rays: &Buffer) -> Vec<Hit> {
        let mut frame = self.recorder.begin().unwrap();
        self.scene.place(&mut frame, &[self.placement]).unwrap();
        let visibility = Visibility { mask: 1, seed: 0 };
        self.scene.trace(&mut frame, Query::Closest, rays, &self.hits, [RAYS, 64], visibility).unwrap();
        frame.submit().unwrap();
        self.hits.read().unwrap()
    }
}

/// From points of the ball, outwards and inwards, down to grazing angles: no ray meets its own surface, and none that goes
/// in gets out. The ball is as large as it is far from the origin; its mesh has that size, or its transform.
#[test]
fn no_self_hits_and_no_leaks_at_any_scale() {
    let device = TestDevice::open();
    let offset = Kernel::compute::<OffsetPush>(&device, &kernels::OFFSET_RAYS, &[]).unwrap();
    for (case, scale) in [1e-3f32, 1.0, 1e3, 1e6].into_iter().enumerate() {
        for transformed in [false, true] {
            let (size, transform) = match transformed {
                false => (scale, Affine3A::IDENTITY),
                true => {
                    let turn = glam::Quat::from_rotation_y(0.7) * glam::Quat::from_rotation_x(0.3);
                    (
                        1.0,
                        Affine3A::from_scale_rotation_translation(Vec3::splat(scale), turn, Vec3::Y * scale),
                    )
                }
            };
            let (positions, indices) = ball(size, Vec3::new(2.0, -0.5, 0.01) * size);
            let mesh = MeshGeometry {
                positions: &positions,
                indices: &indices,
                first_masked: u32::MAX,
                deforms: false,
            };
            let backend = TraceBackend::Compute;
            let mut tracer = Tracer {
                scene: RayScene::new(&device, &[mesh], 1, backend, Coverage::Opaque).unwrap(),
                recorder: Recorder::new(&device).unwrap(),
                placement: InstancePlacement { mesh: 0, mask: 1, world_from_object: transform },
                hits: Buffer::new(
                    &device,
                    "hits",
                    u64::from(RAYS) * size_of::<Hit>() as u64,
                    Location::Device,
                )
                .unwrap(),
            };
            for side in [1.0f32, -1.0] {
                let starts: Vec<(u32, OffsetStart)> = (0..RAYS)
                    .map(|i| {
                        let [a, b, c, d] = random4([i, case as u32], 0, 0, 1);
                        let triangle = (a * indices.len() as f32) as u32;
                        let index = indices[triangle as usize];
                        let [p, q, r] = [index.x, index.y, index.z].map(|k| positions[k as usize]);
                        let (u, v) = if b + c > 1.0 { (1.0 - b, 1.0 - c) } else { (b, c) };
                        let position = transform.transform_point3((1.0 - u - v) * p + u * q + v * r);
                        let [p, q, r] = [p, q, r].map(|p| transform.transform_point3(p));
                        let normal = (q - p).cross(r - p).normalize() * side;
                        // Half of them within a degree of the surface.
                        let height = if i % 2 == 0 { d } else { 0.001 + 0.016 * d };
                        let (tangent, bitangent) = normal.any_orthonormal_pair();
                        let (sin, cos) = (TAU * (a * 977.0).fract()).sin_cos();
                        let flat = (1.0 - height * height).sqrt();
                        let direction = normal * height + (tangent * cos + bitangent * sin) * flat;
                        (triangle, OffsetStart { position, direction, normal })
                    })
                    .collect();
                let records: Vec<_> = starts.iter().map(|s| s.1).collect();
                let records = Buffer::from_slice(&device, "starts", &records).unwrap();
                let rays =
                    Buffer::new(&device, "rays", u64::from(RAYS) * size_of::<Ray>() as u64, Location::Device)
                        .unwrap();
                let mut recorder = Recorder::new(&device).unwrap();
                let mut frame = recorder.begin().unwrap();
                let pass = frame.pass("offset", &offset).push(&OffsetPush { count: RAYS });
                pass.read("starts", &records).write("rays", &rays).dispatch([RAYS, 1, 1]).unwrap();
                frame.submit().unwrap();
                recorder.finish().unwrap();
                let hits = tracer.trace(&rays);
                let own =
                    starts.iter().zip(&hits).filter(|(s, h)| h.instance != NONE && h.triangle == s.0).count();
                let missed = hits.iter().filter(|h| h.instance == NONE).count();
                let what = format!("scale {scale}, transformed {transformed}, side {side}");
                assert_eq!(own, 0, "{what}: rays that meet their own triangle");
                if side > 0.0 {
                    assert_eq!(missed, RAYS as usize, "{what}: rays that leave a convex body meet it");
                } else {
                    // Of rays that run along an edge to the next triangle some start outside of it.
                    assert!(missed * 1000 <= RAYS as usize, "{what}: {missed} rays leak out");
                }
            }
        }
    }
}
