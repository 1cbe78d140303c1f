//! Host twins of shaders/glsl/pack.glsl: octahedral unit vectors (Cigolle et al. 2014).

use glam::{Vec2, Vec3, Vec4};

/// Place of a unit vector in the octahedral map, -1 to 1.
pub fn octahedral_encode(n: Vec3) -> Vec2 {
    let p = Vec2::new(n.x, n.y) / (n.x.abs() + n.y.abs() + n.z.abs());
    if n.z >= 0.0 {
        return p;
    }
    let sign = |x: f32| if x >= 0.0 { 1.0 } else { -1.0 };
    Vec2::new((1.0 - p.y.abs()) * sign(p.x), (1.0 - p.x.abs()) * sign(p.y))
}

/// Inverse of [`octahedral_encode`].
pub fn octahedral_decode(p: Vec2) -> Vec3 {
    let z = 1.0 - p.x.abs() - p.y.abs();
    let t = (-z).max(0.0);
    let fold = |x: f32| if x >= 0.0 { x - t } else { x + t };
    Vec3::new(fold(p.x), fold(p.y), z).normalize()
}

/// Packs a unit vector into 2 x 16 bit. Never 0, which means "no surface".
pub fn pack_unit_vector(n: Vec3) -> u32 {
    let q = (octahedral_encode(n).clamp(Vec2::NEG_ONE, Vec2::ONE) * 32767.0).round() + 32768.0;
    q.x as u32 | (q.y as u32) << 16
}

/// Inverse of [`pack_unit_vector`]; the angle to the original is below 1e-4 rad.
pub fn unpack_unit_vector(word: u32) -> Vec3 {
    let q = Vec2::new((word & 0xffff) as f32, (word >> 16) as f32);
    octahedral_decode((q - 32768.0) / 32767.0)
}

/// Packs two numbers of 0 to 1 into 2 x 16 bit, as `packUnorm2x16` of GLSL.
pub fn pack_unorm2x16(x: f32, y: f32) -> u32 {
    let word = |x: f32| (x.clamp(0.0, 1.0) * 65535.0).round() as u32;
    word(x) | word(y) << 16
}

/// Packs a unit tangent with the bitangent's sign (`w`, negative or not) into 16 + 15 + 1 bit.
pub fn pack_tangent(tangent: Vec4) -> u32 {
    let p = octahedral_encode(tangent.truncate()).clamp(Vec2::NEG_ONE, Vec2::ONE);
    let x = ((p.x * 32767.0).round() + 32768.0) as u32;
    let y = ((p.y * 16383.0).round() + 16384.0) as u32;
    x | y << 16 | u32::from(tangent.w < 0.0) << 31
}
