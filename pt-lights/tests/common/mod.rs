//! What the test programs share.
#![allow(dead_code, reason = "no test program uses all of it")]

pub mod records;
pub mod scene;
pub mod view;

use glam::Vec3;
use pt_core::SceneResources;
use pt_core::frame::Pass;
use pt_core::test_support::TestDevice;
use pt_core::{Buffer, Kernel, Location, Recorder};
use records::{SampleRecord, SamplerPush};
use scene::Uploaded;

pub mod kernels {
    include!(concat!(env!("OUT_DIR"), "/test_kernels.rs"));
}

/// Runs a kernel that fills `samples` for `push.count` threads. `bind` declares what else it touches.
pub fn run_sampler<'a>(
    device: &TestDevice,
    kernel: &'a Kernel,
    push: &SamplerPush,
    mut scene: Option<&mut Uploaded>,
    bind: impl for<'f, 'r> FnOnce(Pass<'f, 'r>) -> Pass<'f, 'r>,
) -> Vec<SampleRecord> {
    let size = u64::from(push.count) * size_of::<SampleRecord>() as u64;
    let samples = Buffer::new(device, "samples", size, Location::Device).unwrap();
    let mut recorder = Recorder::new(device).unwrap();
    let mut frame = recorder.begin().unwrap();
    if let Some(Uploaded { scene, gpu, lights }) = &mut scene {
        lights.update(&mut frame, scene, gpu).unwrap();
    }
    let mut pass = frame.pass("samples", kernel).write("samples", &samples).push(push);
    if let Some(Uploaded { gpu, .. }) = scene {
        pass = gpu.bind(pass);
    }
    bind(pass).dispatch([push.count, 1, 1]).unwrap();
    frame.submit().unwrap();
    samples.read().unwrap()
}

pub fn close(actual: Vec3, expected: glam::DVec3, tolerance: f64) -> bool {
    (actual.as_dvec3() - expected).abs().max_element() <= tolerance * expected.abs().max_element().max(1.0)
}
