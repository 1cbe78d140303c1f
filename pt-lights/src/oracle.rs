//! The mathematics of the kernels on the CPU, plain: what the kernels are tested against. Names are those of packed_light.glsl and rgb9e5.glsl. (Lights and BRDF
//! are in `pt_light_sampling::oracle`.)

const MANTISSA_BITS: i32 = 18;
const MANTISSA_MASK: u64 = (1 << MANTISSA_BITS) - 1;
/// Unit of the mantissas for the smallest normal number.
const LEAST_UNIT: i32 = -126 - MANTISSA_BITS + 1;

fn largest_code() -> f64 {
    MANTISSA_MASK as f64 * 110_f64.exp2()
}

/// Three numbers of 0 or more in 64 bits: mantissas of 18 bits and a common exponent.
pub fn pack_light(v: [f32; 3]) -> [u32; 2] {
    let v = v.map(|x| if x > 0.0 { f64::from(x).min(largest_code()) } else { 0.0 });
    let largest = v.into_iter().fold(0.0, f64::max);
    if largest < f64::from(f32::MIN_POSITIVE) {
        return [0, 0];
    }
    let mantissas = |unit: i32| v.map(|x| (x * f64::from(-unit).exp2()).round_ties_even() as u64);
    // Of numbers that are normal in fp32, the exponent of f64 is exact.
    let mut unit = ((largest.to_bits() >> 52) as i32 - 1023) - MANTISSA_BITS + 1;
    if mantissas(unit).into_iter().any(|m| m > MANTISSA_MASK) {
        unit += 1;
    }
    let [x, y, z] = mantissas(unit);
    let word = x | y << 18 | z << 36 | ((unit - LEAST_UNIT) as u64) << 54;
    [word as u32, (word >> 32) as u32]
}

/// The numbers of a code.
pub fn unpack_light(words: [u32; 2]) -> [f64; 3] {
    let word = u64::from(words[0]) | u64::from(words[1]) << 32;
    let unit = f64::from((word >> 54) as i32 + LEAST_UNIT).exp2();
    [0, 18, 36].map(|shift| (word >> shift & MANTISSA_MASK) as f64 * unit)
}

/// What light is multiplied by before it is stored as RGB9E5.
pub const RGBE_SCALE: f32 = 1.0 / 16.0;

/// Three numbers of 0 or more as RGB9E5 holds them: mantissas of 9 bits and a common exponent. `xi`: numbers in [0, 1) that round; 0.5 rounds to
/// the nearest. In fp32, as the kernel.
pub fn round_rgb9e5(v: [f32; 3], xi: [f32; 3]) -> [f32; 3] {
    let v = v.map(|x| if x > 0.0 { x.min(65408.0) } else { 0.0 });
    let largest = v.into_iter().fold(0.0, f32::max);
    let mut unit = ((largest.to_bits() >> 23) as i32 - 127 - 8).clamp(-24, 7);
    let mantissas =
        |unit: i32| -> [f32; 3] { std::array::from_fn(|i| (v[i] * (-unit as f32).exp2() + xi[i]).floor()) };
    if mantissas(unit).into_iter().any(|m| m > 511.0) && unit < 7 {
        unit += 1;
    }
    mantissas(unit).map(|m| m.min(511.0) * (unit as f32).exp2())
}
