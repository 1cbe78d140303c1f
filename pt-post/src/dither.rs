//! The noise that dithers 8-bit codes, made from the blue-noise mask.

use half::f16;
use pt_core::blue_noise::{SIDE, blue_noise};
use pt_core::{Buffer, Device, Result};

/// Where in the mask red, green and blue look, so that their errors differ.
const SHIFTS: [[usize; 2]; 3] = [[0, 0], [23, 41], [47, 11]];

/// Triangular noise of -1..1 for three channels, four half floats a texel.
pub(crate) fn noise_buffer(device: &Device) -> Result<Buffer> {
    let tile = blue_noise();
    let triangular = |x: usize, y: usize| {
        let t = 2.0 * tile[y % SIDE * SIDE + x % SIDE] - 1.0;
        f16::from_f32(t.signum() * (1.0 - (1.0 - t.abs()).sqrt())).to_bits()
    };
    let texels: Vec<[u16; 4]> = (0..SIDE * SIDE)
        .map(|i| {
            let [r, g, b] = SHIFTS.map(|[x, y]| triangular(i % SIDE + x, i / SIDE + y));
            [r, g, b, 0]
        })
        .collect();
    Buffer::from_slice(device, "blue_noise", &texels)
}
