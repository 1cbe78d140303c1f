//! Plots how the error of the path tracer falls with the number of samples, for every sampler:
//! `cargo run --release -p pt-reference --example convergence -- cornell docs/convergence.svg`.

use anyhow::{Context, Result};
use plotters::prelude::*;
use pt_core::trace::TraceBackend;
use pt_core::{Device, DeviceOptions};
use pt_light_sampling::LightTables;
use pt_reference::{Estimate, Progressive, ReferenceParams, SamplerKind};
use pt_scene::Scene;
use pt_scene::gpu::{GpuScene, camera_record};
use pt_shaders::records::FrameRecord;

const SIZE: [u32; 2] = [48, 48];
/// Base-2 logarithm of the largest number of samples; the truth has 64 times as many.
const LOG2_SPP: u32 = 8;

struct Stage {
    device: Device,
    scene: Scene,
    gpu: GpuScene,
    lights: LightTables,
}

impl Stage {
    fn render(&mut self, sampler: SamplerKind, seed: u32, spp: u32) -> Result<Estimate> {
        let camera = camera_record(&self.scene.default_camera(), SIZE);
        let frame = FrameRecord::new(camera, camera, SIZE, 0, seed);
        let params = ReferenceParams { sampler, spp, ..ReferenceParams::default() };
        let Self { device, scene, gpu, lights } = self;
        params.prepare_lights(device, scene, gpu, lights)?;
        let mut render = Progressive::new(device, gpu, lights, frame, params, None, 0)?;
        while render.next_sample() < spp {
            render.step(scene, gpu, lights, spp)?;
        }
        Ok(render.state()?.estimate(spp))
    }
}

/// Mean over pixels and channels of the squared distance.
fn mse(a: &Estimate, b: &Estimate) -> f64 {
    let square = |(a, b): (&pt_reference::EstimatePixel, &pt_reference::EstimatePixel)| {
        f64::from((a.mean - b.mean).length_squared()) / 3.0
    };
    a.pixels.iter().zip(&b.pixels).map(square).sum::<f64>() / a.pixels.len() as f64
}

fn main() -> Result<()> {
    let mut args = std::env::args().skip(1);
    let (scene, path) = args.next().zip(args.next()).context("usage: convergence SCENE OUT.svg")?;
    let scene = pt_scene::builtin(&scene).with_context(|| format!("no built-in scene {scene}"))?;
    let device = Device::open(&DeviceOptions::default())?;
    let mut gpu = GpuScene::new(&device, &scene, TraceBackend::Compute)?;
    let lights = LightTables::new(&device, &scene)?;
    lights.attach(&mut gpu);
    let mut stage = Stage { device, scene, gpu, lights };

    let truth = stage.render(SamplerKind::Sobol, 1000, 64 << LOG2_SPP)?;
    let mut curves = Vec::new();
    for (name, sampler) in
        [("PCG", SamplerKind::Pcg), ("Sobol", SamplerKind::Sobol), ("blue noise", SamplerKind::BlueNoise)]
    {
        let mut points = Vec::new();
        for k in 0..=LOG2_SPP {
            let error = mse(&stage.render(sampler, k, 1 << k)?, &truth);
            println!("{name:<10} {:>5} spp   MSE {error:.4e}", 1 << k);
            points.push((f64::from(1 << k), error));
        }
        curves.push((name, points));
    }
    draw(&path, &stage.scene.name, &curves)
}

fn draw(path: &str, scene: &str, curves: &[(&str, Vec<(f64, f64)>)]) -> Result<()> {
    let errors = || curves.iter().flat_map(|(_, points)| points.iter().map(|p| p.1));
    let (least, most) = (errors().fold(f64::MAX, f64::min), errors().fold(0.0, f64::max));
    let area = SVGBackend::new(path, (720, 480)).into_drawing_area();
    area.fill(&WHITE)?;
    let mut chart = ChartBuilder::on(&area)
        .caption(format!("{scene}: error of the path tracer"), ("sans-serif", 20))
        .margin(12)
        .x_label_area_size(42)
        .y_label_area_size(72)
        .build_cartesian_2d(
            (1.0..f64::from(1 << LOG2_SPP)).log_scale(),
            (least * 0.5..most * 2.0).log_scale(),
        )?;
    chart
        .configure_mesh()
        .x_desc("samples a pixel")
        .y_desc("mean squared error")
        .x_label_formatter(&|x| format!("{x:.0}"))
        .y_label_formatter(&|y| format!("{y:.0e}"))
        .draw()?;
    // 1 / N, through the first point of the first curve.
    let start = curves[0].1[0].1;
    let ideal = (0..=LOG2_SPP).map(|k| (f64::from(1 << k), start / f64::from(1 << k)));
    chart
        .draw_series(LineSeries::new(ideal, BLACK.mix(0.4)))?
        .label("1 / N")
        .legend(|(x, y)| PathElement::new([(x, y), (x + 18, y)], BLACK.mix(0.4)));
    for ((name, points), color) in curves.iter().zip([RED, BLUE, GREEN]) {
        chart
            .draw_series(LineSeries::new(points.iter().copied(), color.stroke_width(2)).point_size(3))?
            .label(*name)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], color));
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::LowerLeft)
        .background_style(WHITE.mix(0.8))
        .border_style(BLACK.mix(0.3))
        .draw()?;
    area.present()?;
    println!("{path}");
    Ok(())
}
