//! Small scenes that strangers' files are made of, rendered by the program: what the pictures must show.

use clap::Parser;
use pt_app::cli::Cli;
use pt_image::image_file::LinearImage;
use pt_test_data::shared;

/// Runs a command line whose `CASE` stands for the folder of a case, and reads the picture that it writes.
fn picture(case: &str, command: &str) -> LinearImage {
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("x.exr");
    let case = shared("cases").join(case);
    let line = format!("pt {command} -o {}", output.display()).replace("CASE", case.to_str().unwrap());
    let cli = Cli::try_parse_from(line.split_whitespace()).unwrap_or_else(|e| panic!("{line}: {e}"));
    cli.run(&mut Vec::new()).unwrap_or_else(|e| panic!("{line}: {e:#}"));
    LinearImage::read(&output).unwrap()
}

/// Mean of the pixels of a part of the picture: x and y from 0 to 1.
fn mean_of(image: &LinearImage, x: [f32; 2], y: [f32; 2]) -> [f32; 3] {
    let range = |[from, to]: [f32; 2], side: u32| {
        (from * side as f32).round() as u32
            ..((to * side as f32).round() as u32).max((from * side as f32) as u32 + 1)
    };
    let (mut sum, mut count) = ([0.0; 3], 0.0);
    for row in range(y, image.height) {
        for column in range(x, image.width) {
            let pixel = image.pixels[(row * image.width + column) as usize];
            (0..3).for_each(|c| sum[c] += pixel[c]);
            count += 1.0;
        }
    }
    sum.map(|s| s / count)
}

fn mean(image: &LinearImage) -> [f32; 3] {
    mean_of(image, [0.0, 1.0], [0.0, 1.0])
}

#[track_caller]
fn assert_near(what: &str, actual: [f32; 3], expected: [f32; 3], tolerance: f32) {
    println!("{what}: {actual:.4?}, expected {expected:.4?}");
    for (a, e) in actual.into_iter().zip(expected) {
        assert!((a - e).abs() <= tolerance, "{what}: {actual:?} instead of {expected:?}");
    }
}

const ONE: &str = "--env CASE/one.hdr --backend compute";

/// A partial metal is a mixture of two BRDFs; mixed parameters, as in Quake II RTX, are a knob.
#[test]
#[cfg_attr(not(shared), ignore = "needs ../shared")]
fn partial_metals() {
    let render = format!("render CASE/metal_half.gltf {ONE} --size 16x16 --frames 256 --accumulate");
    assert_near("two BRDFs", mean(&picture("partial-metal", &render)), [0.640; 3], 0.01);
    let mixed = format!("{render} --set lights.partial_metal=mixed-parameters");
    assert_near("mixed parameters", mean(&picture("partial-metal", &mixed)), [0.399; 3], 0.01);
    let reference = format!("reference CASE/metal_half.gltf {ONE} --size 16x16 --spp 64 --no-aov");
    assert_near("reference", mean(&picture("partial-metal", &reference)), [0.640; 3], 0.01);
}

/// A smooth dielectric reflects its share of the environment.
#[test]
#[cfg_attr(not(shared), ignore = "needs ../shared")]
fn smooth_dielectrics_reflect() {
    let render = format!("render CASE/varnish.gltf {ONE} --size 16x16 --frames 64 --accumulate");
    assert_near("black varnish", mean(&picture("render-smooth-dielectric", &render)), [0.04; 3], 0.002);
}

/// KHR_materials_specular and _ior count in the real-time frame.
#[test]
#[cfg_attr(not(shared), ignore = "needs ../shared")]
fn specular_colours() {
    let render = format!("render CASE/red_specular.gltf {ONE} --size 16x16 --frames 512 --accumulate");
    assert_near("red reflection", mean(&picture("render-specular-ior", &render)), [0.04, 0.0, 0.0], 0.002);
}

/// Quads of one lobe each under a sun: the real-time frame and the reference shade them alike.
#[test]
#[cfg_attr(not(shared), ignore = "needs ../shared")]
fn lobes_are_shaded_in_real_time() {
    for file in ["s0", "s3"] {
        let scene = format!("CASE/{file}.gltf --size 640x240 --backend compute");
        let render = picture(
            "lobes-closed-forms",
            &format!("render {scene} --frames 4 --accumulate --set indirect.bounces=0"),
        );
        let truth =
            picture("lobes-closed-forms", &format!("reference {scene} --spp 4 --max-bounces 0 --no-aov"));
        let mut largest = 0.0f32;
        // Pixels that lie within a quad: their neighbours show it too.
        let inside = |image: &LinearImage, i: usize| {
            let (w, center) = (image.width as usize, image.pixels[i]);
            let like = |i: usize| {
                let differs = |(a, b): (&f32, &f32)| (a - b).abs() > 0.02 * b;
                image.pixels.get(i).is_some_and(|p| !p.iter().zip(&center).any(differs))
            };
            center.iter().sum::<f32>() > 1e-4
                && [i + 1, i.wrapping_sub(1), i + w, i.wrapping_sub(w)].into_iter().all(like)
        };
        let mut count = 0;
        for i in (0..truth.pixels.len()).filter(|&i| inside(&truth, i)) {
            count += 1;
            for (a, b) in render.pixels[i].into_iter().zip(truth.pixels[i]) {
                largest = largest.max((a - b).abs() / b.max(0.02));
            }
        }
        assert!(count > 100 && largest < 0.03, "{file}: {largest} of {count} pixels");
        println!("{file}: largest relative difference {largest:.4}");
    }
}

/// Scenes may be larger than 10 km.
#[test]
#[cfg_attr(not(shared), ignore = "needs ../shared")]
fn large_scenes_are_seen() {
    let render = format!("render CASE/mm1e4.gltf {ONE} --size 48x48 --frames 64 --accumulate");
    let image = picture("render-10km", &render);
    assert_near("box of 20 km", mean_of(&image, [0.48, 0.52], [0.48, 0.52]), [0.5; 3], 0.05);
}

/// The back of a single-sided material is not seen, unless culling is off.
#[test]
#[cfg_attr(not(shared), ignore = "needs ../shared")]
fn single_sided_materials_are_culled() {
    for (command, culling, length) in [
        ("render", "gbuffer.culling", "--frames 4 --accumulate"),
        ("reference", "reference.culling", "--spp 4 --no-aov"),
    ] {
        for backend in ["compute", "ray-query", "rt-pipeline"] {
            let line = format!("{command} CASE/cull.gltf --size 32x32 --backend {backend} {length}");
            let [red, green, _] = mean(&picture("single-sided-culling", &line));
            assert!(green > 0.01 && red < 0.02 * green, "{line}: {red} {green}");
        }
        let all =
            format!("{command} CASE/cull.gltf --size 32x32 --backend compute {length} --set {culling}=none");
        let [red, green, _] = mean(&picture("single-sided-culling", &all));
        assert!(red > 0.3 * green, "{all}: {red} {green}");
    }
}

/// Normals that point into the surface, or nowhere, do no harm: both renderers show what the triangles are.
#[test]
#[cfg_attr(not(shared), ignore = "needs ../shared")]
fn bad_normals_do_no_harm() {
    for (case, file, size) in [("inward-normals", "flip.gltf", "48x48"), ("zero-normals", "zn.gltf", "9x9")] {
        let env = if case == "inward-normals" {
            "--env CASE/one.hdr"
        } else {
            "--env CASE/../inward-normals/one.hdr"
        };
        let scene = format!("CASE/{file} {env} --size {size} --backend compute");
        let half = if case == "inward-normals" { 0.1 } else { 0.5 };
        let middle = |image: &LinearImage| mean_of(image, [0.5 - half, 0.5 + half], [0.5 - half, 0.5 + half]);
        let render = middle(&picture(case, &format!("render {scene} --frames 256 --accumulate")));
        assert_near(case, render, [0.5; 3], 0.01);
        let truth = middle(&picture(case, &format!("reference {scene} --spp 64 --no-aov")));
        assert_near(case, truth, [0.5; 3], 0.01);
    }
}

/// Vertex colours keep the precision of the file.
#[test]
#[cfg_attr(not(shared), ignore = "needs ../shared")]
fn dark_vertex_colours_are_kept() {
    let line = "reference CASE/vcd.gltf --env CASE/one.hdr --size 9x9 --spp 64 --no-aov";
    assert_near("dark", mean(&picture("vertex-colour-8bit", line)), [0.002; 3], 2e-5);
}

/// alphaMode MASK: an alpha that equals the cutoff is opaque.
#[test]
#[cfg_attr(not(shared), ignore = "needs ../shared")]
fn alpha_that_equals_the_cutoff_is_opaque() {
    for backend in ["compute", "ray-query", "rt-pipeline"] {
        let line = format!(
            "reference CASE/a1c1.gltf --spp 16 --size 64x64 --max-bounces 0 --no-aov --backend {backend}"
        );
        assert_near(backend, mean(&picture("mask-alpha-equals-cutoff", &line)), [1.0; 3], 1e-4);
    }
}

/// Emissive triangles in the same place are one light, whichever strategy finds it.
#[test]
#[cfg_attr(not(shared), ignore = "needs ../shared")]
fn coincident_emitters_are_one() {
    for strategy in ["lights", "bsdf", "both"] {
        let line = format!(
            "reference CASE/dd.gltf --size 9x9 --spp 1024 --max-bounces 1 --no-aov --strategy {strategy}"
        );
        assert_near(strategy, mean(&picture("duplicate-emitter", &line)), [0.0367; 3], 0.0015);
    }
}

/// Emission beyond what squares of it can hold is limited on load, for both renderers alike.
#[test]
#[cfg_attr(not(shared), ignore = "needs ../shared")]
fn emission_is_limited() {
    let render = picture("emissive-1e30", "render CASE/e.gltf --size 8x8 --frames 2 --accumulate");
    let truth = picture("emissive-1e30", "reference CASE/e.gltf --size 8x8 --spp 2 --no-aov");
    let brightest = |image: &LinearImage| image.pixels.iter().flatten().copied().fold(0.0, f32::max);
    assert_eq!((brightest(&render), brightest(&truth)), (1e15, 1e15));
}

/// A sun shines through a smooth thin pane, tinted by it. The floor below has the albedo 0.8 and gets the irradiance pi times what the
/// pane lets through: 0.96 of it at normal incidence, times the base colour.
#[test]
#[cfg_attr(not(shared), ignore = "needs ../shared")]
fn thin_glass_lets_light_through() {
    let floor = [0.3, 0.8, 0.3].map(|color| 0.8 * 0.96 * color);
    // To pass the pane counts as a bounce. The pane itself brings no light to the floor: it is a delta lobe above a floor that is flat.
    for command in [
        "reference CASE/thin-sun.gltf --spp 4 --max-bounces 1 --no-aov",
        "render CASE/thin-sun.gltf --accumulate",
    ] {
        // From the side, below the pane. All light is from one direction: no noise.
        let view = "--look 1.5,0.9,0,-1.5,0,0 --size 16x9 --backend compute";
        let image = picture("thin-glass-delta-lights", &format!("{command} {view}"));
        assert_near(command, mean_of(&image, [0.45, 0.55], [0.45, 0.55]), floor, 1e-4);
    }
}

/// Scenes of any size are framed: the picture is that of the same scene at the scale of a metre.
#[test]
#[cfg_attr(not(shared), ignore = "needs ../shared")]
fn tiny_scenes_are_framed() {
    let folder = tempfile::tempdir().unwrap();
    for scale in ["1e-05", "0.0001"] {
        let file = shared("cases").join(format!("auto-camera-tiny/auto_{scale}.gltf"));
        let tiny = std::fs::read_to_string(&file).unwrap();
        let metre = tiny.replace(&format!("[{scale}, {scale}, {scale}]"), "[1, 1, 1]");
        assert_ne!(metre, tiny, "{}: other scales", file.display());
        let large = folder.path().join("large.gltf");
        std::fs::write(&large, metre).unwrap();
        let [tiny, large] = [&file, &large].map(|file| {
            let options = "--size 48x32 --spp 16 --max-bounces 2 --backend compute --no-aov";
            picture("auto-camera-tiny", &format!("reference {} {options}", file.display()))
        });
        let range = |image: &LinearImage| {
            let green = image.pixels.iter().map(|pixel| pixel[1]);
            green.fold([f32::MAX, 0.0f32], |[least, most], v| [least.min(v), most.max(v)])
        };
        let [least, most] = range(&large);
        assert!(most > 2.0 * least, "the picture shows nothing: {least} to {most}");
        // The same random numbers: only what rounding does is left.
        let off = |(a, b): (&[f32; 3], &[f32; 3])| (0..3).map(|c| (a[c] - b[c]).abs()).fold(0.0f32, f32::max);
        let differences: Vec<f32> = tiny.pixels.iter().zip(&large.pixels).map(off).collect();
        let mean = differences.iter().sum::<f32>() / differences.len() as f32;
        println!("{scale}: mean difference {mean:.2e} of {least:.3} to {most:.3}");
        assert!(mean < 1e-5 * most, "{scale}: {mean}");
    }
}
