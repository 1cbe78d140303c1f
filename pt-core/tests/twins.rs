//! Functions that exist on both sides give the same results.

use glam::Vec3;
use pt_core::test_support::TestDevice;
use pt_core::{Buffer, Kernel, Recorder, pack, rng};

#[allow(dead_code, reason = "each test file runs some of them")]
mod kernels {
    include!(concat!(env!("OUT_DIR"), "/test_kernels.rs"));
}

#[test]
fn pack_and_random_numbers_agree_with_the_gpu() {
    let device = TestDevice::open();
    let count = 4096u32;
    let mut vectors: Vec<Vec3> = (0..count)
        .map(|i| {
            let [x, y, z, _] = rng::random4([i, 1], 2, 3, 4);
            (Vec3::new(x, y, z) - 0.5).normalize()
        })
        .collect();
    vectors[..6].copy_from_slice(&[Vec3::X, Vec3::Y, Vec3::Z, Vec3::NEG_X, Vec3::NEG_Y, Vec3::NEG_Z]);

    let input = Buffer::from_slice(&device, "vectors", &vectors).unwrap();
    let words = Buffer::from_slice(&device, "words", &vec![0u32; count as usize]).unwrap();
    let decoded = Buffer::from_slice(&device, "decoded", &vectors).unwrap();
    let randoms = Buffer::from_slice(&device, "randoms", &vec![[0f32; 4]; count as usize]).unwrap();
    let kernel = Kernel::compute::<()>(&device, &kernels::TWINS, &[]).unwrap();
    let mut recorder = Recorder::new(&device).unwrap();
    let mut frame = recorder.begin().unwrap();
    frame
        .pass("twins", &kernel)
        .read("vectors", &input)
        .write("words", &words)
        .write("decoded", &decoded)
        .write("randoms", &randoms)
        .dispatch([count, 1, 1])
        .unwrap();
    frame.submit().unwrap();
    recorder.finish().unwrap();

    let gpu_words = words.read::<u32>().unwrap();
    let gpu_vectors = decoded.read::<Vec3>().unwrap();
    let gpu_randoms = randoms.read::<[f32; 4]>().unwrap();
    for (i, &v) in vectors.iter().enumerate() {
        // A rounding tie may fall either way: one code apart in one component.
        let host = pack::pack_unit_vector(v);
        let apart = |shift: u32| ((host >> shift) & 0xffff).abs_diff((gpu_words[i] >> shift) & 0xffff);
        assert!(apart(0) <= 1 && apart(16) <= 1, "{v}: {host:x} {:x}", gpu_words[i]);
        assert_ne!(host, 0);
        assert!(gpu_vectors[i].distance(v) < 1e-4, "{v} came back as {}", gpu_vectors[i]);
        assert!(pack::unpack_unit_vector(host).distance(v) < 1e-4);
        let i = i as u32;
        assert_eq!(gpu_randoms[i as usize], rng::random4([i, 7], i * 3, 5, 11));
    }
    assert_eq!(pack::unpack_unit_vector(pack::pack_unit_vector(Vec3::NEG_Z)), Vec3::NEG_Z, "axes are exact");
}
