//! Specialisation constants, on all trace backends: values reach every shader of a kernel, mistakes are errors.

use glam::{Affine3A, UVec3, Vec3, Vec4};
use pt_core::error::ConstantError;
use pt_core::frame::Uniforms;
use pt_core::kernel::Constant;
use pt_core::test_support::TestDevice;
use pt_core::texture::TextureTable;
use pt_core::trace::{AccelStructure, BvhQuality, InstancePlacement, MeshGeometry, TraceBackend};
use pt_core::{Buffer, Error, Kernel, Location, Recorder};
use pt_shaders::glam;
use pt_shaders::records::{
    FEATURE_VERTEX_COLOR, InstanceRecord, MATERIAL_MASK, MaterialRecord, MeshRecord, NONE, SceneRecord,
    TextureSlot, VertexRecord,
};

#[allow(dead_code, reason = "each test file runs some of them")]
mod kernels {
    include!(concat!(env!("OUT_DIR"), "/test_kernels.rs"));
}

const POSITIONS: [Vec3; 3] = [Vec3::ZERO, Vec3::X, Vec3::Y];
const INDICES: [UVec3; 1] = [UVec3::new(0, 1, 2)];

/// Runs `variants.trace` on a triangle at z = 0 whose vertices have alpha 0; words of its `VariantResult`.
fn run(device: &TestDevice, backend: TraceBackend, constants: &[(&str, Constant)]) -> [u32; 5] {
    let kernel = Kernel::trace::<()>(device, &kernels::VARIANTS, backend, constants).unwrap();
    let geometry =
        [MeshGeometry { positions: &POSITIONS, indices: &INDICES, first_masked: 0, deforms: false }];
    let mut accel = AccelStructure::new(device, &geometry, 2, backend, BvhQuality::default()).unwrap();
    let rows = [Vec4::X, Vec4::Y, Vec4::Z];
    let instance = InstanceRecord {
        world_from_object: rows,
        object_from_world: rows,
        world_from_object_prev: rows,
        mesh: 0,
        mask: 1,
        mirrored: 0,
        material: NONE,
    };
    let slot = TextureSlot { texture: NONE, flags: 0, transform: [[0.0; 3]; 2] };
    let material = MaterialRecord {
        base_color: Vec4::ONE,
        flags: MATERIAL_MASK,
        alpha_cutoff: 0.5,
        base_color_texture: slot,
        ..bytemuck::Zeroable::zeroed()
    };
    let vertex: VertexRecord = bytemuck::Zeroable::zeroed();
    let buffer = |name: &str, bytes: &[u8]| Buffer::from_slice(device, name, bytes).unwrap();
    let positions = buffer("positions", bytemuck::cast_slice(&POSITIONS));
    let indices = buffer("indices", bytemuck::cast_slice(&INDICES));
    let vertices = buffer("vertices", bytemuck::cast_slice(&[vertex; 3]));
    let colors = buffer("colours", bytemuck::cast_slice(&[Vec3::ONE.extend(0.0); 3]));
    let materials = buffer("materials", bytemuck::bytes_of(&material));
    let triangle_materials = buffer("triangle materials", &[0; 4]);
    let mut mesh = MeshRecord {
        positions: positions.address(),
        positions_prev: positions.address(),
        indices: indices.address(),
        vertices: vertices.address(),
        colors: colors.address(),
        triangle_materials: triangle_materials.address(),
        triangle_count: 1,
        ..bytemuck::Zeroable::zeroed()
    };
    accel.fill_mesh(0, &mut mesh);
    let meshes = buffer("meshes", bytemuck::bytes_of(&mesh));
    let instances = buffer("instances", bytemuck::bytes_of(&instance));
    let mut scene = SceneRecord {
        instances: instances.address(),
        meshes: meshes.address(),
        materials: materials.address(),
        environment_texture: NONE,
        ..bytemuck::Zeroable::zeroed()
    };
    accel.fill_scene(&mut scene);

    let uniforms = Uniforms::new(device, "scene_uniforms").unwrap();
    let textures = TextureTable::new(device, &[]).unwrap();
    let results = Buffer::new(device, "results", 20, Location::Device).unwrap();
    let mut recorder = Recorder::new(device).unwrap();
    let mut frame = recorder.begin().unwrap();
    let placement = InstancePlacement { mesh: 0, mask: 1, world_from_object: Affine3A::IDENTITY };
    accel.update(&mut frame, &[placement]).unwrap();
    uniforms.upload(&mut frame, &scene).unwrap();
    let pass = frame.pass("variants", &kernel).read("scene_uniforms", uniforms.buffer());
    let tables =
        [&positions, &indices, &vertices, &colors, &materials, &triangle_materials, &meshes, &instances];
    let pass =
        tables.into_iter().fold(accel.bind(pass.textures(&textures)), |pass, table| pass.addresses(table));
    pass.write("results", &results).dispatch([1, 1, 1]).unwrap();
    frame.submit().unwrap();
    recorder.finish().unwrap();
    results.read::<u32>().unwrap().try_into().unwrap()
}

#[test]
fn constants_have_their_values_on_all_backends() {
    let device = TestDevice::open();
    for backend in TraceBackend::available(&device) {
        let words = |count: u32, shift: i32, scale: f32, flag: u32, t: f32| {
            [count, shift as u32, scale.to_bits(), flag, t.to_bits()]
        };
        assert_eq!(run(&device, backend, &[]), words(1, -2, 0.5, 0, -1.0), "{backend}: declarations");
        // In another order than they are declared in, and not all of them.
        let some = [("flag", true.into()), ("count", 7u32.into()), ("scale", 2.25f32.into())];
        assert_eq!(run(&device, backend, &some), words(7, -2, 2.25, 1, -1.0), "{backend}");
        assert_eq!(run(&device, backend, &[("shift", 9i32.into())]), words(1, 9, 0.5, 0, -1.0), "{backend}");
        // Decided by the any-hit shader of a ray tracing pipeline.
        let opaque = [("scene_features", (!FEATURE_VERTEX_COLOR).into())];
        assert_eq!(run(&device, backend, &opaque), words(1, -2, 0.5, 0, 3.0), "{backend}: opaque vertices");
    }
}

#[test]
fn mistaken_constants_are_errors() {
    let device = TestDevice::open();
    for backend in TraceBackend::available(&device) {
        let error = |constants: &[(&str, Constant)]| match Kernel::trace::<()>(
            &device,
            &kernels::VARIANTS,
            backend,
            constants,
        )
        .err()
        {
            Some(Error::Constant(error)) => error,
            other => panic!("{backend}: {other:?}"),
        };
        let unknown = error(&[("scales", 1.0f32.into())]);
        let of_backend = if backend == TraceBackend::Compute { "gpu_traversal, " } else { "" };
        assert!(matches!(unknown, ConstantError::Unknown { .. }), "{backend}: {unknown:?}");
        assert_eq!(
            unknown.to_string(),
            format!(
                "kernel variants has no specialisation constant \"scales\"; it has: count, culling, flag, {of_backend}random_source, scale, \
                 scene_features, shift"
            )
        );
        let wrong: [(&str, Constant, &str); 5] = [
            ("count", 1i32.into(), "uint"),
            ("shift", 1u32.into(), "int"),
            ("scale", true.into(), "float"),
            ("flag", 1u32.into(), "bool"),
            ("scene_features", 1.0f32.into(), "uint"),
        ];
        for (name, value, ty) in wrong {
            let expected = ConstantError::Type {
                kernel: "variants".into(),
                constant: name.into(),
                declared: ty,
                given: value.ty().name(),
            };
            assert_eq!(error(&[(name, value)]), expected, "{backend}");
        }
        let twice = error(&[("count", 1u32.into()), ("count", 1u32.into())]);
        assert!(matches!(twice, ConstantError::Repeated { .. }), "{backend}: {twice:?}");
    }
    let none = Kernel::compute::<()>(&device, &kernels::HISTORY, &[("count", 1u32.into())]).err().unwrap();
    assert!(none.to_string().ends_with("it has: none"), "{none}");
}
