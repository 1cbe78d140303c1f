//! The clock of a GPU, which falls in pauses.

use crate::buffer::{Buffer, Location};
use crate::device::Device;
use crate::error::Result;
use crate::frame::Recorder;
use crate::kernel::Kernel;
use std::time::{Duration, Instant};

/// Work that it takes until the clock is up. An H200 that has had a pause runs the frames of a small picture up to four times slower for most of a second.
const RISES_IN: Duration = Duration::from_millis(1000);
/// Bytes that a pass copies, and passes of a frame: enough to keep a GPU busy while the host records the next frame.
const BYTES: u64 = 16 << 20;
const PASSES: u32 = 32;

/// Keeps a GPU busy until its clock is up, so that what is timed next is not slower for a pause before it. Does nothing on a CPU.
///
/// # Errors
/// When the device fails.
pub fn raise_clock(device: &Device) -> Result<()> {
    if device.info().is_cpu() {
        return Ok(());
    }
    let started = Instant::now();
    let copy = Kernel::compute::<()>(device, &crate::kernels::COPY_WORDS, &[])?;
    let buffer = |name| Buffer::new(device, name, BYTES, Location::Device);
    let (source, target) = (buffer("clock source")?, buffer("clock target")?);
    let mut recorder = Recorder::new(device)?;
    while started.elapsed() < RISES_IN {
        let mut frame = recorder.begin()?;
        for _ in 0..PASSES {
            let pass = frame.pass("raise the clock", &copy).read("source", &source).write("target", &target);
            pass.dispatch([(BYTES / 16) as u32, 1, 1])?;
        }
        frame.submit()?;
    }
    recorder.finish()?;
    Ok(())
}
