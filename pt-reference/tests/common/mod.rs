//! What the test programs of the BSDF share.
#![allow(dead_code, reason = "no test program uses all of it")]

pub mod records;
pub mod renders;

use glam::{DMat3, DVec2, DVec3, Vec2, Vec3, Vec4};
use pt_core::frame::Pass;
use pt_core::test_support::TestDevice;
use pt_core::{Buffer, Kernel, Location, Recorder};
use pt_reference::oracle::bsdf::Bsdf;
use records::{BsdfCase, HistogramPush};

pub mod kernels {
    include!(concat!(env!("OUT_DIR"), "/test_kernels.rs"));
}

pub const SOLID: u32 = 1;
pub const ENERGY_COMPENSATION: u32 = 2;
pub const DELTA: u32 = 1;
pub const TRANSMISSION: u32 = 2;

/// A white metal's lobe, seen along the normal.
pub fn metal(roughness: f32) -> BsdfCase {
    BsdfCase {
        base_color: Vec3::ONE,
        metallic: 1.0,
        alpha: Vec2::splat(roughness * roughness),
        eta: 1.5,
        specular: 1.0,
        specular_color: Vec3::ONE,
        transmission: 0.0,
        coat: 0.0,
        coat_alpha: 0.0,
        coat_normal: Vec3::Z,
        sheen_color: Vec3::ZERO,
        sheen_alpha: 0.1,
        flags: 0,
        face_normal: Vec3::Z,
        wo: Vec3::Z,
        wi: Vec3::Z,
        film: Vec3::new(0.0, 1.3, 400.0),
        pad: [0; 2],
        u: Vec4::ZERO,
    }
}

/// A white dielectric of index 1.5 over a diffuse base.
pub fn plastic(roughness: f32) -> BsdfCase {
    BsdfCase { metallic: 0.0, ..metal(roughness) }
}

/// No lobe but the diffuse one.
pub fn lambertian() -> BsdfCase {
    BsdfCase { specular: 0.0, ..plastic(1.0) }
}

/// A clear interface; `eta`: behind over in front.
pub fn glass(roughness: f32, eta: f32) -> BsdfCase {
    BsdfCase { transmission: 1.0, eta, flags: SOLID, ..plastic(roughness) }
}

/// A unit vector at that angle to +Z, given by its cosine.
pub fn direction(cos: f32, phi: f32) -> Vec3 {
    let sin = (1.0 - cos * cos).sqrt();
    Vec3::new(sin * phi.cos(), sin * phi.sin(), cos)
}

/// The oracle's surface.
pub fn oracle(c: &BsdfCase) -> Bsdf {
    Bsdf {
        frame: DMat3::IDENTITY,
        face_normal: c.face_normal.as_dvec3(),
        coat_normal: c.coat_normal.as_dvec3(),
        base_color: c.base_color.as_dvec3(),
        metallic: c.metallic.into(),
        alpha: c.alpha.as_dvec2(),
        eta: c.eta.into(),
        specular: c.specular.into(),
        specular_color: c.specular_color.as_dvec3(),
        transmission: c.transmission.into(),
        coat: c.coat.into(),
        coat_alpha: c.coat_alpha.into(),
        sheen_color: c.sheen_color.as_dvec3(),
        sheen_alpha: c.sheen_alpha.into(),
        iridescence: c.film.x.into(),
        film_ior: c.film.y.into(),
        film_thickness: c.film.z.into(),
        solid: c.flags & SOLID != 0,
        energy_compensation: c.flags & ENERGY_COMPENSATION != 0,
    }
}

/// Runs `kernel` with `push.count` threads. `bind` declares what it touches; reads `out` back.
pub fn run<T: bytemuck::Pod>(
    device: &TestDevice,
    kernel: &Kernel,
    push: &impl pt_shaders::GpuStruct,
    count: u32,
    out: &Buffer,
    bind: impl for<'f, 'r> FnOnce(Pass<'f, 'r>) -> Pass<'f, 'r>,
) -> Vec<T> {
    let mut recorder = Recorder::new(device).unwrap();
    let mut frame = recorder.begin().unwrap();
    bind(frame.pass("test", kernel).push(push)).dispatch([count, 1, 1]).unwrap();
    frame.submit().unwrap();
    out.read().unwrap()
}

/// Chart of the sphere round a direction, finer where a lobe of that width is.
#[derive(Clone, Copy, Debug)]
pub struct Chart {
    pub axis: Vec3,
    pub width: f32,
}

impl Chart {
    /// Round the mirror direction.
    pub fn mirror(c: &BsdfCase, width: f32) -> Self {
        Self { axis: Vec3::new(-c.wo.x, -c.wo.y, c.wo.z), width }
    }
}

/// What bsdf.glsl looks albedos up in.
pub fn tables(device: &TestDevice) -> Buffer {
    Buffer::from_slice(device, "BSDF tables", &pt_scene::bsdf_tables::packed()).unwrap()
}

/// Statistics of surfaces on the device.
pub struct Statistics<'a> {
    device: &'a TestDevice,
    tables: Buffer,
    samples: Kernel,
    densities: Kernel,
}

/// What the samples of a surface did.
pub struct Histogram {
    /// Of each bin of the chart; then: no sample, delta reflections, delta transmissions.
    pub counts: Vec<u64>,
    /// Sum of the weights over the number of samples, and its standard error.
    pub mean: DVec3,
    pub error: f64,
    /// Largest relative difference of weight and f cos / pdf.
    pub worst_weight: f64,
}

/// Integrals over the bins of a chart: value in xyz, density in w.
pub struct Integrals(pub Vec<glam::DVec4>);

impl Integrals {
    pub fn albedo(&self) -> DVec3 {
        self.0.iter().map(|v| v.truncate()).sum()
    }

    pub fn density(&self) -> f64 {
        self.0.iter().map(|v| v.w).sum()
    }
}

pub const BINS: u32 = 24;

impl<'a> Statistics<'a> {
    pub fn new(device: &'a TestDevice) -> Self {
        let kernel = |code| Kernel::compute::<HistogramPush>(device, code, &[]).unwrap();
        Self {
            device,
            tables: tables(device),
            samples: kernel(&kernels::BSDF_SAMPLES),
            densities: kernel(&kernels::BSDF_DENSITIES),
        }
    }

    fn push(chart: Chart, count: u32, per_thread: u32, seed: u32) -> HistogramPush {
        let Chart { axis, width } = chart;
        HistogramPush { axis, width, count, per_thread, seed, bins: BINS, index: 0, pad: [0; 3] }
    }

    pub fn histogram(&self, case: &BsdfCase, chart: Chart, samples: u32, seed: u32) -> Histogram {
        const PER_THREAD: u32 = 64;
        let threads = samples / PER_THREAD;
        let cases = Buffer::from_slice(self.device, "cases", &[*case]).unwrap();
        let counts = vec![0u32; (BINS * BINS + 3) as usize];
        let counts = Buffer::from_slice(self.device, "histogram", &counts).unwrap();
        let sums = Buffer::new(self.device, "sums", u64::from(threads) * 16, Location::Device).unwrap();
        let push = Self::push(chart, threads, PER_THREAD, seed);
        let sums: Vec<Vec4> = run(self.device, &self.samples, &push, threads, &sums, |pass| {
            pass.read("cases", &cases)
                .read("bsdf_tables", &self.tables)
                .update("histogram", &counts)
                .write("sums", &sums)
        });
        let n = f64::from(threads);
        let means = sums.iter().map(|s| s.truncate().as_dvec3() / f64::from(PER_THREAD));
        let mean = means.clone().sum::<DVec3>() / n;
        let variance = means.map(|m| (m - mean).length_squared()).sum::<f64>() / n;
        Histogram {
            counts: counts.read::<u32>().unwrap().into_iter().map(u64::from).collect(),
            mean,
            error: (variance / n).sqrt(),
            worst_weight: sums.iter().map(|s| f64::from(s.w)).fold(0.0, f64::max),
        }
    }

    /// `midpoints`: along each side of a bin.
    pub fn integrals(&self, case: &BsdfCase, chart: Chart, midpoints: u32) -> Integrals {
        let threads = BINS * BINS * midpoints;
        let cases = Buffer::from_slice(self.device, "cases", &[*case]).unwrap();
        let rows = Buffer::new(self.device, "integrals", u64::from(threads) * 16, Location::Device).unwrap();
        let push = Self::push(chart, threads, midpoints, 0);
        let rows: Vec<Vec4> = run(self.device, &self.densities, &push, threads, &rows, |pass| {
            pass.read("cases", &cases).read("bsdf_tables", &self.tables).write("integrals", &rows)
        });
        let bin = |rows: &[Vec4]| rows.iter().map(|r| r.as_dvec4()).sum();
        Integrals(rows.chunks(midpoints as usize).map(bin).collect())
    }
}

/// Isotropic alpha as the oracle takes it.
pub fn isotropic(alpha: f64) -> DVec2 {
    DVec2::splat(alpha)
}
