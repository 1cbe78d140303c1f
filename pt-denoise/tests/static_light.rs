//! Where nothing changes, gradients keep their hands off: asvgf is as smooth as svgf, and as bright as its input.

use crate::common::renderer::{Draw, Renderer};
use crate::common::{Bench, Random, count, hf, spec, statistics, wall};
use pt_denoise::{DenoiseParams, Denoiser};

/// R1 and R13: of noise of one kind in all pixels.
#[test]
fn noise_is_no_change() {
    let size = [48, 36];
    let mut renderer = Renderer::new(size, |_, _| 1.0);
    let mut random = Random(5);
    let mut benches = [Denoiser::Asvgf, Denoiser::Svgf]
        .map(|variant| Bench::indirect(size, DenoiseParams { variant, ..DenoiseParams::default() }));
    let mut out = [[0.0; 4]; 2];
    for frame in 0..32 {
        let (light, samples) = renderer.frame(frame);
        let lf: Vec<_> = (0..count(size)).map(|_| [0.0, 0.0, 0.0, random.sparse(8), 0.0, 0.0]).collect();
        for (bench, out) in benches.iter_mut().zip(&mut out) {
            bench.lf = lf.clone();
            bench.samples = samples.clone();
            let light = bench.next(&wall(size), &light);
            let [mean, variance] = statistics(hf(&light));
            let [mean_lf, variance_lf] = statistics(bench.filtered_lf.iter().map(|l| l[3]));
            *out = [mean, variance, mean_lf, variance_lf];
        }
        // Of each pixel a ninth of the frames is left out, never two on end.
        let short = benches[0].lengths().iter().filter(|n| 2 * **n < frame as u32 + 1).count();
        assert!(short < count(size) / 50, "frame {frame}: {short} short histories");
    }
    println!("asvgf {:?}, svgf {:?}", out[0], out[1]);
    for k in [0, 2] {
        assert!((out[0][k] / out[1][k] - 1.0).abs() < 0.02, "energy, {k}: {out:?}");
        assert!(out[0][k + 1] < 1.25 * out[1][k + 1], "variance, {k}: {out:?}");
    }
}

/// Light whose energy comes from few samples: a frame, or a part of one, that has none of them is no darker light. Of direct and of indirect light.
#[test]
fn rare_bright_samples_keep_their_energy() {
    let size = [64, 48];
    let of = |variant| DenoiseParams { variant, ..DenoiseParams::default() };
    let mut still = of(Denoiser::Asvgf);
    (still.antilag.hf, still.antilag.spec, still.antilag.lf) = (0.0, 0.0, 0.0);
    // The rarest samples are so few that what asvgf and svgf count differs by them: a repeated one counts twice in svgf.
    let draws: [(Draw, DenoiseParams); 2] =
        [(|random| random.heavy_tailed(100), of(Denoiser::Svgf)), (|random| random.heavy_tailed(600), still)];
    for (draw, other) in draws {
        let mut renderer = Renderer::new(size, |_, _| 1.0).drawing(draw);
        let is_svgf = other.variant == Denoiser::Svgf;
        let mut benches = [of(Denoiser::Asvgf), other].map(|params| Bench::indirect(size, params));
        // Of the input, as a running mean of that weight has it, and of the outputs: diffuse, specular, indirect. Then the error of the outputs.
        let mut mean = [0.0; 3];
        let (mut wanted, mut energy, mut error) = ([0.0; 3], [[0.0; 3]; 2], [[0.0; 3]; 2]);
        for frame in 0..32 {
            let (light, samples) = renderer.frame(frame);
            // Bounce rays of gradient pixels are taken again, too.
            let lf: Vec<_> = hf(&light).into_iter().map(|v| [0.0, 0.0, 0.0, v, 0.0, 0.0]).collect();
            let input = [hf(&light), spec(&light), lf.iter().map(|l| l[3]).collect()];
            let share = (1.0 / (frame as f64 + 1.0)).max(0.05);
            for (channel, values) in input.into_iter().enumerate() {
                mean[channel] += share * (statistics(values)[0] - mean[channel]);
            }
            for (k, bench) in benches.iter_mut().enumerate() {
                bench.lf = lf.clone();
                bench.samples = samples.clone();
                let out = bench.next(&wall(size), &light);
                let indirect: Vec<f32> = bench.filtered_lf.iter().map(|l| l[3]).collect();
                for (channel, values) in [hf(&out), spec(&out), indirect].into_iter().enumerate() {
                    let [bright, variance] = statistics(values);
                    if frame >= 4 {
                        energy[k][channel] += bright;
                        error[k][channel] += variance + (bright - mean[channel]).powi(2);
                    }
                }
            }
            if frame >= 4 {
                (0..3).for_each(|channel| wanted[channel] += mean[channel]);
            }
        }
        for channel in 0..3 {
            let [adaptive, plain] = [0, 1].map(|k| energy[k][channel] / wanted[channel]);
            let worse = error[0][channel] / error[1][channel];
            let name = if is_svgf { "svgf" } else { "asvgf without antilag" };
            println!(
                "channel {channel}: energy of asvgf {adaptive:.4}, {name} {plain:.4}; error over its {worse:.3}"
            );
            assert!(!is_svgf || (adaptive - 1.0).abs() < 0.02, "channel {channel}: {adaptive}");
            assert!((adaptive / plain - 1.0).abs() < 0.02, "channel {channel}: {adaptive}, {plain}");
            assert!(worse < 1.1, "channel {channel}: {worse}");
        }
    }
}
