//! Cost against the number of lights: a hall with more and more emissive triangles.

use super::Args;
use super::contestant::{Choice, Contestant};
use super::lamps;
use super::view::{View, open_device};
use anyhow::{Result, bail};
use glam::Vec3;
use pt_core::trace::TraceBackend;
use pt_gbuffer::GbufferParams;
use pt_scene::gpu::camera_record;
use pt_scene::{Bounds, Camera, Material, Scene};
use serde_json::{Value, json};
use std::io::Write;
use std::time::Instant;

/// Width, height and depth of the hall, metres.
const HALL: Vec3 = Vec3::new(40.0, 8.0, 40.0);
/// Power of all lights together: mean radiance times area, W / sr.
const FLUX: f32 = 400.0;

/// What a sampler costs with so many lights.
pub struct Cost {
    pub lights: u32,
    pub name: String,
    pub gpu_ms: f64,
    /// Of the passes among them that choose lights: without shadow rays, whose time also depends on the lamps as geometry.
    pub choose_gpu_ms: f64,
    pub build_ms: f64,
    pub bytes: u64,
}

/// Reads a number of lights.
pub fn count(text: &str) -> Result<u32, String> {
    let count = text.trim().parse::<u32>().ok().filter(|count| (1..=lamps::MOST).contains(count));
    count.ok_or_else(|| format!("{text} is not a number of lights from 1 to {}", lamps::MOST))
}

/// Floor, walls and ceiling, and `count` lamps of one triangle each, all of one size and turned in any direction, in the upper half.
fn hall(count: u32) -> Scene {
    let mut scene = Scene::default();
    let side = 0.3 * (256.0 / count as f32).sqrt().min(1.0);
    let area = 0.5 * side * side * count as f32;
    let mut shell = Vec::new();
    let axes = [Vec3::X, Vec3::Y, Vec3::Z];
    for axis in 0..3 {
        let (u, v) = (axes[(axis + 1) % 3] * HALL, axes[(axis + 2) % 3] * HALL);
        let far = axes[axis] * HALL;
        // Faces point inwards.
        for [a, b, c, d] in [[Vec3::ZERO, u, u + v, v], [far, far + v, far + u + v, far + u]] {
            shell.extend([[a, b, c], [a, c, d]]);
        }
    }
    let within = Bounds { min: Vec3::new(0.02, 0.5, 0.02) * HALL, max: Vec3::new(0.98, 0.95, 0.98) * HALL };
    lamps::place(&mut scene, "hall", &shell, Material::lambertian("wall", Vec3::splat(0.6)));
    let lamp = Material::lamp("lamp", Vec3::splat(FLUX / area));
    lamps::place(&mut scene, "lamps", &lamps::triangles(count, within, side), lamp);
    let eye = HALL * Vec3::new(0.5, 0.25, 0.95);
    scene.cameras.push(Camera::look_at("hall", eye, HALL * Vec3::new(0.5, 0.2, 0.3), 1.0));
    scene.name = format!("hall of {count} lamps");
    scene
}

/// Times the samplers with each number of lights, and prints what they cost.
pub fn run(args: &Args, counts: &[u32], choices: &[Choice], out: &mut impl Write) -> Result<Vec<Cost>> {
    let device = open_device(args)?;
    let size = [args.width, (args.width * 9 / 16).max(1)];
    let width = choices.iter().map(|c| c.name.len()).max().unwrap_or(0).max(14);
    let backend = match args.backend {
        // One backend for all numbers of lights.
        TraceBackend::Auto => TraceBackend::Compute,
        backend => backend,
    };
    writeln!(
        out,
        "{}, {}, {backend}, {}x{}",
        device.info().name,
        device.info().driver_line(),
        size[0],
        size[1]
    )?;
    writeln!(
        out,
        "{:>10} {:<width$} {:>9} {:>10} {:>11} {:>10}",
        "lights", "sampler", "GPU ms", "choose ms", "build ms", "KiB"
    )?;
    let mut costs: Vec<Cost> = Vec::new();
    for &lights in counts {
        let started = Instant::now();
        let scene = hall(lights);
        let Some(camera) = scene.cameras.first() else { bail!("the hall has no camera") };
        let camera = GbufferParams::default().with_lens(camera_record(camera, size));
        let stages: Vec<_> = choices.iter().map(|c| c.params.clone()).collect();
        let mut view = View::of_scene(device.clone(), scene, camera, size, backend, &stages)?;
        eprintln!("{lights} lights: scene after {:.1} s", started.elapsed().as_secs_f64());
        for choice in choices {
            let Contestant { gpu_ms, choose_gpu_ms, build_ms, bytes, .. } =
                Contestant::new(&mut view, choice, args.seed)?;
            writeln!(
                out,
                "{lights:>10} {:<width$} {gpu_ms:>9.3} {choose_gpu_ms:>10.3} {build_ms:>11.1} {:>10}",
                choice.name,
                bytes.div_ceil(1024)
            )?;
            out.flush()?;
            let name = choice.name.clone();
            costs.push(Cost { lights, name, gpu_ms, choose_gpu_ms, build_ms, bytes });
        }
    }
    if let ([first, .., last], true) = (counts, counts.len() > 1) {
        writeln!(
            out,
            "\nGPU ms with {last} lights over that with {first}, and of the choice of lights alone"
        )?;
        for choice in choices {
            let of = |lights| costs.iter().find(|c| c.lights == lights && c.name == choice.name);
            if let (Some(few), Some(many)) = (of(*first), of(*last)) {
                let [all, choice_alone] =
                    [many.gpu_ms / few.gpu_ms, many.choose_gpu_ms / few.choose_gpu_ms.max(1e-6)];
                writeln!(out, "{:<width$} {all:>6.3} {choice_alone:>6.3}", choice.name)?;
            }
        }
    }
    Ok(costs)
}

/// Time of the choice alone for each number of lights, milliseconds, and that of the last over that of the first, as a table in Markdown.
pub fn markdown(costs: &[Cost], counts: &[u32], choices: &[Choice]) -> String {
    let columns: Vec<String> = counts.iter().map(u32::to_string).collect();
    let mut text =
        format!("| sampler | {} | ratio |\n|{}\n", columns.join(" | "), " --- |".repeat(counts.len() + 2));
    for choice in choices {
        let time = |lights: &u32| {
            let cost = costs.iter().find(|c| c.lights == *lights && c.name == choice.name);
            cost.map_or(0.0, |cost| cost.choose_gpu_ms)
        };
        let times: Vec<f64> = counts.iter().map(time).collect();
        let ratio = match &times[..] {
            [first, .., last] if *first > 0.0 => format!("{:.2}", last / first),
            _ => "-".into(),
        };
        let times: Vec<String> = times.iter().map(|ms| format!("{ms:.3}")).collect();
        text += &format!("| `{}` | {} | {ratio} |\n", choice.name, times.join(" | "));
    }
    text
}

/// The rows for a JSON file.
pub fn rows(costs: &[Cost]) -> Vec<Value> {
    let row = |c: &Cost| {
        json!({
            "sampler": c.name,
            "lights": c.lights,
            "gpu_ms": c.gpu_ms,
            "choose_gpu_ms": c.choose_gpu_ms,
            "build_ms": c.build_ms,
            "bytes": c.bytes,
        })
    };
    costs.iter().map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use pt_light_sampling::LightLists;

    #[test]
    fn the_hall_has_as_many_lights_of_the_same_power() {
        let power = |count| {
            let lists = LightLists::new(&hall(count));
            assert_eq!(lists.emissives.len(), count as usize);
            lists.emissives.iter().map(|t| t.weight).sum::<f64>()
        };
        let (few, many) = (power(64), power(4096));
        assert!(
            (few / many - 1.0).abs() < 1e-3 && (few / f64::from(FLUX) - 1.0).abs() < 1e-3,
            "{few} {many}"
        );
    }

    #[test]
    fn walls_face_inwards() {
        let shell = &hall(1).meshes[0];
        for triangle in 0..shell.triangle_count() {
            let [a, b, c] = shell.triangle(triangle);
            assert!((b - a).cross(c - a).dot(0.5 * HALL - a) > 0.0, "{triangle}");
        }
    }
}
