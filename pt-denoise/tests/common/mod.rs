//! Frames that the tests make, and the denoiser on the device.

#![allow(dead_code, reason = "each test file uses its part")]

use pt_core::pack::pack_unit_vector;
use pt_core::split::{to_flat, to_split};
use pt_core::test_support::TestDevice;
use pt_core::{ChannelImages, FrameSizes, Image, Recorder, StageInputs};
use pt_denoise::images::{MOMENTS, SURFACE};
use pt_denoise::oracle::{Accumulated, Guided, Light};
use pt_denoise::{DenoiseChain, DenoiseParams, Denoiser};
use pt_shaders::channels::{
    BOUNCE_THROUGHPUT, COLOR_HF, COLOR_SPEC, ChannelId, METALLIC_ROUGHNESS, MOTION, NORMAL, SHADING_POSITION,
    VERTEX_NORMAL, VIEW_DEPTH, VIEW_DIRECTION,
};
use pt_shaders::glam::Vec3;
use pt_shaders::records::FLAG_PRIMARY;

/// The denoiser with its images.
pub struct Bench {
    pub device: TestDevice,
    pub images: ChannelImages,
    pub chain: DenoiseChain,
    pub params: DenoiseParams,
    pub size: [u32; 2],
}

impl Bench {
    pub fn new(size: [u32; 2], params: DenoiseParams) -> Self {
        let device = TestDevice::open();
        let chain = DenoiseChain::new(&device, &params).unwrap();
        let images = ChannelImages::alone(&device, FrameSizes::same(size), chain.io()).unwrap();
        Self { device, images, chain, params, size }
    }

    pub fn of(size: [u32; 2], denoiser: Denoiser) -> Self {
        Self::new(size, DenoiseParams { denoiser, ..DenoiseParams::default() })
    }

    /// Denoises the next frame of flat pixels; returns what the composite gets.
    pub fn next(&mut self, pixels: &[Guided], light: &[Light]) -> Vec<Light> {
        self.images.begin_frame();
        self.load(pixels, light);
        let inputs = StageInputs::new(&self.images);
        let mut recorder = Recorder::new(&self.device).unwrap();
        let mut frame = recorder.begin().unwrap();
        let output = self.chain.record(&mut frame, &inputs, &self.params).unwrap();
        frame.submit().unwrap();
        let [hf, spec] = [output.hf, output.spec].map(|image| self.flat(image));
        let rgb = |c: &[f32; 4]| [c[0], c[1], c[2]];
        hf.iter().zip(&spec).map(|(hf, spec)| Light { hf: rgb(hf), spec: rgb(spec) }).collect()
    }

    fn load(&self, pixels: &[Guided], light: &[Light]) {
        let split = to_split(pixels, self.size, Guided::default());
        let light = to_split(light, self.size, Light::default());
        let has = |id: ChannelId| self.images.ids().any(|other| other == id);
        let floats = |id: ChannelId, texel: &dyn Fn(&Guided) -> Vec<f32>| {
            if has(id) {
                let values: Vec<f32> = split.iter().flat_map(texel).collect();
                self.images.current(id).write_f32(&values).unwrap();
            }
        };
        let words = |id: ChannelId, texel: &dyn Fn(&Guided) -> Vec<u32>| {
            if has(id) {
                let values: Vec<u32> = split.iter().flat_map(texel).collect();
                self.images.current(id).write_u32(&values).unwrap();
            }
        };
        // The alpha of the light is another stage's.
        let colour = |id: ChannelId, of: &dyn Fn(&Light) -> [f32; 3]| {
            let values: Vec<f32> = light.iter().map(of).flat_map(|c| [c[0], c[1], c[2], 7.0]).collect();
            self.images.current(id).write_f32(&values).unwrap();
        };
        colour(COLOR_HF, &|l| l.hf);
        colour(COLOR_SPEC, &|l| l.spec);
        floats(SHADING_POSITION, &|p| vec![1.0, 2.0, 3.0, f32::from_bits(p.material)]);
        floats(VIEW_DEPTH, &|p| vec![p.depth]);
        floats(MOTION, &|p| p.motion.to_vec());
        floats(METALLIC_ROUGHNESS, &|p| vec![0.3, p.roughness]);
        floats(BOUNCE_THROUGHPUT, &|p| vec![1.0, 1.0, 1.0, p.pixel_angle]);
        words(NORMAL, &|p| vec![p.normal]);
        words(VERTEX_NORMAL, &|p| vec![p.vertex_normal]);
        words(VIEW_DIRECTION, &|p| vec![p.normal, p.flags]);
    }

    /// The texels of a split image in flat order.
    pub fn flat(&self, image: &Image) -> Vec<[f32; 4]> {
        let texels = image.read_f32().unwrap();
        let texels: Vec<[f32; 4]> = texels.chunks_exact(4).map(|c| [c[0], c[1], c[2], c[3]]).collect();
        to_flat(&texels, self.size)
    }

    /// Light between two passes.
    pub fn light(&self, hf: ChannelId, spec: ChannelId) -> Vec<Accumulated> {
        let [hf, spec] = [hf, spec].map(|id| self.flat(self.images.current(id)));
        let rgb = |c: &[f32; 4]| [c[0], c[1], c[2]].map(f64::from);
        let pair = |(a, b): (&[f32; 4], &[f32; 4])| Accumulated {
            hf: rgb(a),
            spec: rgb(b),
            variance: [a[3], b[3]].map(f64::from),
        };
        hf.iter().zip(&spec).map(pair).collect()
    }

    /// Lengths of the histories in flat order.
    pub fn lengths(&self) -> Vec<u32> {
        let words = self.images.current(SURFACE).read_u32().unwrap();
        let lengths: Vec<u32> = words.chunks_exact(2).map(|c| c[1]).collect();
        to_flat(&lengths, self.size)
    }

    pub fn moments(&self) -> Vec<[f64; 4]> {
        self.flat(self.images.current(MOMENTS)).into_iter().map(|m| m.map(f64::from)).collect()
    }
}

pub fn normal(x: f32, y: f32, z: f32) -> u32 {
    pack_unit_vector(Vec3::new(x, y, z).normalize())
}

/// A pixel of a wall that faces the camera, three metres away.
pub fn wall_pixel() -> Guided {
    let front = normal(0.0, 0.0, 1.0);
    Guided {
        material: 1,
        flags: FLAG_PRIMARY,
        depth: 3.0,
        motion: [0.0, 0.0, 0.0, 100.0],
        normal: front,
        vertex_normal: front,
        roughness: 32768.0 / 65535.0,
        pixel_angle: 1.0 / 1024.0,
    }
}

pub fn wall(size: [u32; 2]) -> Vec<Guided> {
    vec![wall_pixel(); count(size)]
}

pub fn count(size: [u32; 2]) -> usize {
    (size[0] * size[1]) as usize
}

/// The same light in both channels.
pub fn grey(v: f32) -> Light {
    Light { hf: [v; 3], spec: [v; 3] }
}

pub fn constant(size: [u32; 2], v: f32) -> Vec<Light> {
    vec![grey(v); count(size)]
}

/// Random numbers: the same in every run (Steele et al. 2014, SplitMix64).
pub struct Random(pub u64);

impl Random {
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// From 0 up to 1.
    pub fn unit(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / (1u64 << 24) as f32
    }

    /// Mean 1, variance 1.
    pub fn exponential(&mut self) -> f32 {
        -(1.0 - self.unit()).ln()
    }

    /// Mean 1: `n` for one in n samples, else nothing.
    pub fn sparse(&mut self, n: u32) -> f32 {
        if self.unit() * (n as f32) < 1.0 { n as f32 } else { 0.0 }
    }
}

/// A frame of independent noise in both channels.
pub fn noise(size: [u32; 2], mut sample: impl FnMut() -> f32) -> Vec<Light> {
    (0..count(size)).map(|_| Light { hf: [sample(); 3], spec: [sample(); 3] }).collect()
}

/// Mean and variance over pixels of the red of a channel.
pub fn statistics(values: impl IntoIterator<Item = f32>) -> [f64; 2] {
    let values: Vec<f64> = values.into_iter().map(f64::from).collect();
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / values.len() as f64;
    [mean, variance]
}

pub fn hf(light: &[Light]) -> Vec<f32> {
    light.iter().map(|l| l.hf[0]).collect()
}

pub fn spec(light: &[Light]) -> Vec<f32> {
    light.iter().map(|l| l.spec[0]).collect()
}
