//! Frames that the tests make, and the denoiser on the device.

#![allow(dead_code, reason = "each test file uses its part")]

pub mod renderer;

use pt_core::frame::Uniforms;
use pt_core::pack::pack_unit_vector;
use pt_core::split::{to_flat, to_split};
use pt_core::test_support::TestDevice;
use pt_core::{ChannelImages, Device, FrameSizes, Image, Recorder, StageInputs};
use pt_denoise::images::{MOMENTS, SURFACE};
use pt_denoise::oracle::{Accumulated, GradientSample, Guided, Light, strata};
use pt_denoise::{DenoiseChain, DenoiseParams, Denoiser, HistoryFormat};
use pt_shaders::channels::{
    BOUNCE_THROUGHPUT, COLOR_HF, COLOR_LF_COCG, COLOR_LF_SH, COLOR_SPEC, ChannelId, GRADIENT_SAMPLE,
    METALLIC_ROUGHNESS, MOTION, NORMAL, SHADING_POSITION, VERTEX_NORMAL, VIEW_DEPTH, VIEW_DIRECTION,
};
use pt_shaders::glam::{Mat4, Vec2, Vec3};
use pt_shaders::records::{CameraRecord, FLAG_PRIMARY, FrameRecord};

/// The denoiser with its images.
pub struct Bench {
    device: TestDevice,
    /// The same with the formats of the histories.
    formats: Device,
    pub images: ChannelImages,
    pub chain: DenoiseChain,
    pub params: DenoiseParams,
    pub size: [u32; 2],
    /// Coefficients of indirect diffuse light that the next frame has, of flat pixels.
    pub lf: Vec<[f32; 6]>,
    /// Gradient pixels that the next frame has, of strata; none if it is empty.
    pub samples: Vec<GradientSample>,
    /// Coefficients of indirect diffuse light that the composite got.
    pub filtered_lf: Vec<[f32; 6]>,
    /// Hit distances of both channels, of flat pixels; those of another stage if it is empty.
    pub hits: Vec<[f32; 2]>,
    /// Positions of the surfaces, of flat pixels; all the same if it is empty.
    pub positions: Vec<Vec3>,
    /// Cameras.
    pub frame: FrameRecord,
    uniforms: Uniforms<FrameRecord>,
}

impl Bench {
    pub fn new(size: [u32; 2], params: DenoiseParams) -> Self {
        Self::with(size, params, false)
    }

    /// With indirect light.
    pub fn indirect(size: [u32; 2], params: DenoiseParams) -> Self {
        Self::with(size, params, true)
    }

    fn with(size: [u32; 2], params: DenoiseParams, indirect: bool) -> Self {
        let device = TestDevice::open();
        let formats = device.with_formats(params.histories.others());
        let chain = DenoiseChain::new(&formats, &params, indirect).unwrap();
        let images = ChannelImages::alone(&formats, FrameSizes::same(size), chain.io()).unwrap();
        let lf = vec![[0.0; 6]; count(size)];
        let frame = FrameRecord::new(camera_at(Vec3::ZERO), camera_at(Vec3::ZERO), size, 0, 0);
        let uniforms = Uniforms::new(&device, "frame_uniforms").unwrap();
        let (samples, filtered_lf, hits, positions) = Default::default();
        Self {
            device,
            formats,
            images,
            chain,
            params,
            size,
            lf,
            samples,
            filtered_lf,
            hits,
            positions,
            frame,
            uniforms,
        }
    }

    pub fn of(size: [u32; 2], denoiser: Denoiser) -> Self {
        Self::new(size, DenoiseParams { variant: denoiser, ..DenoiseParams::default() })
    }

    /// Denoises the next frame of flat pixels; returns what the composite gets.
    pub fn next(&mut self, pixels: &[Guided], light: &[Light]) -> Vec<Light> {
        self.images.begin_frame();
        self.load(pixels, light);
        let inputs = StageInputs { uniforms: Some(&self.uniforms), ..StageInputs::new(&self.images) };
        let mut recorder = Recorder::new(&self.device).unwrap();
        let mut frame = recorder.begin().unwrap();
        self.uniforms.upload(&mut frame, &self.frame).unwrap();
        let output = self.chain.record(&mut frame, &inputs, &self.params).unwrap();
        frame.submit().unwrap();
        self.frame.frame_index += 1;
        let [hf, spec] = [output.hf, output.spec].map(|image| self.flat(image));
        self.filtered_lf = output.lf.map_or(Vec::new(), |lf| self.coefficients(lf.sh, lf.cocg));
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
        let hits = if self.hits.is_empty() { vec![[7.0; 2]; pixels.len()] } else { self.hits.clone() };
        let hits = to_split(&hits, self.size, [0.0; 2]);
        let colour = |id: ChannelId, of: &dyn Fn(&Light) -> [f32; 3], channel: usize| {
            let texel = |(l, hit): (&Light, &[f32; 2])| {
                let c = of(l);
                [c[0], c[1], c[2], hit[channel]]
            };
            let values: Vec<f32> = light.iter().zip(&hits).flat_map(texel).collect();
            self.images.current(id).write_f32(&values).unwrap();
        };
        if has(COLOR_LF_SH) {
            let lf = to_split(&self.lf, self.size, [0.0; 6]);
            let luma: Vec<f32> = lf.iter().flat_map(|l| l[..4].to_vec()).collect();
            let chroma: Vec<f32> = lf.iter().flat_map(|l| l[4..].to_vec()).collect();
            self.images.current(COLOR_LF_SH).write_f32(&luma).unwrap();
            self.images.current(COLOR_LF_COCG).write_f32(&chroma).unwrap();
        }
        if has(GRADIENT_SAMPLE) {
            let side = self.params.antilag.stratum.side();
            let none = vec![GradientSample::default(); strata(self.size, side).iter().product()];
            let samples = if self.samples.is_empty() { &none } else { &self.samples };
            let image = self.images.current(GRADIENT_SAMPLE);
            let [across, down] = strata(self.size, side);
            let mut texels = vec![0.0; (4 * image.extent()[0] * image.extent()[1]) as usize];
            for (stratum, s) in samples.iter().enumerate() {
                assert!(stratum / across < down);
                let at = 4 * (stratum / across * image.extent()[0] as usize + stratum % across);
                texels[at..at + 3].copy_from_slice(&[s.number as f32, s.luminance[0], s.luminance[1]]);
            }
            image.write_f32(&texels).unwrap();
        }
        colour(COLOR_HF, &|l| l.hf, 0);
        colour(COLOR_SPEC, &|l| l.spec, 1);
        if has(SHADING_POSITION) {
            let everywhere = vec![Vec3::new(1.0, 2.0, 3.0); pixels.len()];
            let positions = if self.positions.is_empty() { &everywhere } else { &self.positions };
            let positions = to_split(positions, self.size, Vec3::ZERO);
            let texel = |(at, p): (&Vec3, &Guided)| [at.x, at.y, at.z, f32::from_bits(p.material)];
            let values: Vec<f32> = positions.iter().zip(&split).flat_map(texel).collect();
            self.images.current(SHADING_POSITION).write_f32(&values).unwrap();
        }
        floats(VIEW_DEPTH, &|p| vec![p.depth]);
        floats(MOTION, &|p| p.motion.to_vec());
        floats(METALLIC_ROUGHNESS, &|p| vec![0.3, p.roughness]);
        floats(BOUNCE_THROUGHPUT, &|p| vec![1.0, 1.0, 1.0, p.pixel_angle]);
        words(NORMAL, &|p| vec![p.normal]);
        words(VERTEX_NORMAL, &|p| vec![p.vertex_normal]);
        words(VIEW_DIRECTION, &|p| vec![p.normal, p.flags]);
    }

    /// Coefficients of indirect diffuse light in flat order.
    pub fn coefficients(&self, sh: &Image, cocg: &Image) -> Vec<[f32; 6]> {
        let chroma = cocg.read_f32().unwrap();
        // A history has its length beside the chroma.
        let components = chroma.len() * 4 / sh.read_f32().unwrap().len();
        let chroma: Vec<[f32; 2]> = chroma.chunks_exact(components).map(|c| [c[0], c[1]]).collect();
        let chroma = to_flat(&chroma, self.size);
        let luma = self.flat(sh);
        luma.iter().zip(&chroma).map(|(a, b)| [a[0], a[1], a[2], a[3], b[0], b[1]]).collect()
    }

    /// The texels of an image of strata.
    pub fn strata(&self, id: ChannelId) -> Vec<[f32; 4]> {
        let image = self.images.current(id);
        let texels = image.read_f32().unwrap();
        let row = 4 * image.extent()[0] as usize;
        let [across, down] = strata(self.size, self.params.antilag.stratum.side());
        let texel = |x: usize, y: usize| [0, 1, 2, 3].map(|k| texels[y * row + 4 * x + k]);
        (0..down).flat_map(|y| (0..across).map(move |x| [x, y])).map(|[x, y]| texel(x, y)).collect()
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

    /// The same between two levels of the a-trous filter, which are roots.
    pub fn roots(&self, hf: ChannelId, spec: ChannelId) -> Vec<Accumulated> {
        let squared = |c: [f64; 3]| c.map(|v| v * v);
        let variance = |v: f64| if v < 0.0 { -1.0 } else { v.powi(4) };
        let one = |l: Accumulated| Accumulated {
            hf: squared(l.hf),
            spec: squared(l.spec),
            variance: l.variance.map(variance),
        };
        self.light(hf, spec).into_iter().map(one).collect()
    }

    /// Lengths of the histories in flat order.
    pub fn lengths(&self) -> Vec<u32> {
        let words = self.images.current(SURFACE).read_u32().unwrap();
        let lengths: Vec<u32> = words.chunks_exact(2).map(|c| c[1] & 0xffff).collect();
        to_flat(&lengths, self.size)
    }

    /// The same of specular light.
    pub fn specular_lengths(&self) -> Vec<u32> {
        let words = self.images.current(SURFACE).read_u32().unwrap();
        let own = |word: u32| match word >> 16 {
            0 => word & 0xffff,
            0xffff => 0,
            other => other,
        };
        let lengths: Vec<u32> = words.chunks_exact(2).map(|c| own(c[1])).collect();
        to_flat(&lengths, self.size)
    }

    pub fn moments(&self) -> Vec<[f64; 4]> {
        let stored = self.flat(self.images.current(MOMENTS)).into_iter().map(|m| m.map(f64::from));
        match self.params.histories {
            HistoryFormat::Full => stored.collect(),
            // Variances.
            HistoryFormat::Half => {
                stored.map(|m| [m[0], m[1] + m[0] * m[0], m[2], m[3] + m[2] * m[2]]).collect()
            }
        }
    }
}

/// A camera that looks along -Z; the picture is as wide as it is high, 90 degrees.
pub fn camera_at(eye: Vec3) -> CameraRecord {
    let world_from_view = Mat4::from_translation(eye);
    CameraRecord {
        view_from_world: world_from_view.inverse(),
        world_from_view,
        half_extent: Vec2::ONE,
        lens_radius: 0.0,
        focus_distance: 1.0,
        projection: 0,
        pad: [0; 3],
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

    /// One sample in n is n times as bright as the others.
    pub fn heavy_tailed(&mut self, n: u32) -> f32 {
        if self.unit() * (n as f32) < 1.0 { n as f32 } else { 1.0 }
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

/// Two surfaces, glass, sky, bent normals, slopes.
pub fn guide(size: [u32; 2], random: &mut Random, frame: u32) -> Vec<Guided> {
    let shift = [0.0, 0.37, -1.21, 0.0, 0.6][frame as usize % 5];
    (0..count(size))
        .map(|i| {
            let [x, y] = [i as u32 % size[0], i as u32 / size[0]];
            let far = (x / 5 + y / 4) % 3 == 0;
            if x % 11 == 7 && y % 3 == 1 {
                return Guided::default();
            }
            let bend = |random: &mut Random| 0.2 * (random.unit() - 0.5);
            let bent = normal(bend(random), bend(random), 1.0);
            Guided {
                material: 1 + u32::from(far),
                flags: if (x / 7) % 2 == 1 { 6 } else { 1 },
                depth: if far { 5.0 } else { 2.0 + 0.01 * x as f32 },
                motion: [
                    (shift + 0.1 * random.unit()) / size[0] as f32,
                    (0.5 * shift + 0.1 * random.unit()) / size[1] as f32,
                    0.01 * random.unit(),
                    20.0 + 30.0 * random.unit(),
                ],
                normal: bent,
                vertex_normal: if random.unit() < 0.1 {
                    normal(1.0, 0.0, 0.1)
                } else {
                    normal(0.0, 0.0, 1.0)
                },
                // Neighbours differ by less than what parts them, or by more.
                roughness: ([6554.0, 32768.0, 58982.0][(y / 3) as usize % 3] + (i * 1699 % 5000) as f32)
                    / 65535.0,
                pixel_angle: (1.0 + 0.25 * (i * 5 % 4) as f32) / 1024.0,
            }
        })
        .collect()
}
