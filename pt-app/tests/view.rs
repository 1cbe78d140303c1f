//! `pt view`: without a display, and in a window on an X server without a screen, with synthetic input.

#[cfg(xvfb)]
mod display;

use std::process::Command;

#[test]
fn without_a_display_one_line_says_so() {
    let done = Command::new(env!("CARGO_BIN_EXE_pt"))
        .args(["view", "gallery"])
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .env_remove("WAYLAND_SOCKET")
        .output()
        .unwrap();
    let said = String::from_utf8(done.stderr).unwrap();
    assert_eq!((done.status.code(), said.lines().count()), (Some(2), 1), "{said}");
    assert!(said.starts_with("error: no window can be shown:") && said.contains("pt render"), "{said}");
}

#[test]
#[cfg_attr(not(xvfb), ignore = "needs Xvfb")]
fn the_copied_command_renders_what_the_window_shows() {
    #[cfg(xvfb)]
    window::the_copied_command_renders_what_the_window_shows();
}

#[test]
#[cfg_attr(not(xvfb), ignore = "needs Xvfb")]
fn a_knob_that_is_clicked_changes_the_picture_and_a_resize_does_not() {
    #[cfg(xvfb)]
    window::a_knob_that_is_clicked_changes_the_picture_and_a_resize_does_not();
}

#[cfg(xvfb)]
mod window {
    use super::display::{Display, Ended, Key, Shown};
    use pt_core::capture::folder::CaptureFolder;
    use pt_image::image_file::LayeredImage;
    use std::path::Path;
    use std::process::Command;

    const SIZE: [usize; 2] = [64, 48];

    /// Red, green, blue of a PNG.
    fn png(path: &Path) -> Vec<[u8; 3]> {
        let mut reader = png::Decoder::new(std::io::BufReader::new(std::fs::File::open(path).unwrap()))
            .read_info()
            .unwrap();
        let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut bytes).unwrap();
        bytes.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect()
    }

    /// Whether a window without its panel shows a picture: the colour around it is in all corners, where the panel would be, and not alone.
    fn has_picture(shown: &Shown) -> bool {
        let ([width, _], pixels) = shown.pixels();
        let (width, last) = (width as usize, pixels.len() - 1);
        let corners = [0, width - 1, last + 1 - width, last].map(|corner| pixels[corner]);
        corners == [corners[0]; 4] && colours(&pixels) > 100
    }

    fn colours(pixels: &[[u8; 3]]) -> usize {
        pixels.iter().collect::<std::collections::BTreeSet<_>>().len()
    }

    /// The picture within a window without its panel: enlarged by a whole factor, and centred.
    fn picture_of((size, pixels): ([u32; 2], Vec<[u8; 3]>)) -> Vec<[u8; 3]> {
        let size = size.map(|side| side as usize);
        let scale = (size[0] / SIZE[0]).min(size[1] / SIZE[1]);
        let start = [0, 1].map(|axis| (size[axis] - SIZE[axis] * scale) / 2);
        let texel = |i: usize| {
            let at = [i % SIZE[0], i / SIZE[0]];
            let [x, y] = [0, 1].map(|axis| start[axis] + at[axis] * scale + scale / 2);
            pixels[y * size[0] + x]
        };
        (0..SIZE[0] * SIZE[1]).map(texel).collect()
    }

    pub fn the_copied_command_renders_what_the_window_shows() {
        let (display, folder) = (Display::start(), tempfile::tempdir().unwrap());
        let into = folder.path().to_str().unwrap();
        let words = [
            "flicker",
            "--size",
            "64x48",
            "--profile",
            "realtime",
            "--seed",
            "5",
            "--device",
            "cpu",
            "--backend",
            "compute",
        ];
        let more = ["--play", "--frames", "3", "--validation", "--folder", into];
        let mut shown = Shown::start(&display, &[&words[..], &more[..]].concat());
        shown.tap(Key::H);
        shown.wait_for("a picture", has_picture);
        // The camera flies, so that no command line can say how the picture came about.
        shown.press(Key::W);
        std::thread::sleep(std::time::Duration::from_millis(700));
        shown.release(Key::W);
        // Captured frames go on where the histories of the window are.
        shown.tap(Key::G);
        let capture = folder.path().join("capture-1");
        shown.wait_for("three captured frames", |_| {
            CaptureFolder::open(&capture).is_ok_and(|capture| capture.index.frames.len() == 3)
        });
        assert_replays(&capture);
        shown.tap(Key::C);
        let command = shown.line();
        shown.tap(Key::P);
        let saved = folder.path().join("view-1.png");
        shown.wait_for("the saved picture", |_| saved.exists() && saved.with_extension("exr").exists());

        let words = command.strip_prefix("pt ").unwrap().strip_suffix(" -o picture.png").unwrap();
        assert!(words.contains("--look=") && words.contains("--frames=3"), "{command}");
        let again = folder.path().join("again.png");
        let done = Command::new(env!("CARGO_BIN_EXE_pt"))
            .args(words.split(' '))
            .args(["-o", again.to_str().unwrap(), "-o", again.with_extension("exr").to_str().unwrap()])
            .output()
            .unwrap();
        assert!(done.status.success(), "{command}: {done:?}");
        let picture = png(&again);
        assert!(colours(&picture) > 100, "it is not all the same");
        assert!(png(&saved) == picture, "{command}: another picture than the saved one");
        let radiance = |path: &Path| pt_image::image_file::LinearImage::read(path).unwrap().pixels;
        assert!(
            radiance(&saved.with_extension("exr")) == radiance(&again.with_extension("exr")),
            "{command}"
        );
        shown.wait_for("the picture in the window", |shown| picture_of(shown.pixels()) == picture);

        // The ground truth takes the right half, and the left one stays.
        shown.tap(Key::T);
        let quarter = |picture: &[[u8; 3]], index: usize| -> Vec<[u8; 3]> {
            let part = index * SIZE[0] / 4..(index + 1) * SIZE[0] / 4;
            picture.chunks(SIZE[0]).flat_map(|row| &row[part.clone()]).copied().collect()
        };
        let is_frame = |shown: &Shown| {
            let now = picture_of(shown.pixels());
            [0, 1, 2, 3].map(|index| quarter(&now, index) == quarter(&picture, index))
        };
        shown.wait_for("the truth beside the frame", |shown| is_frame(shown) == [true, true, false, false]);
        // A drag takes the edge, not the camera, which would change the frame.
        let [left, top] = [(464 - 2 * 64) / 2, 54];
        shown.drag(1, [left + 64, top], [left + 32, top]);
        shown.wait_for("the edge is moved", |shown| is_frame(shown) == [true, false, false, false]);
        shown.press(Key::F);
        shown.wait_for("the truth while a key is held", |shown| is_frame(shown) == [false; 4]);
        shown.release(Key::F);
        shown.wait_for("the frame again", |shown| is_frame(shown) == [true, false, false, false]);
        assert_does_not_block(&shown.close());
    }

    /// Checks that the rest of the frame, from the denoiser on, gives the bits that were captured.
    fn assert_replays(capture: &Path) {
        let layers = ["flat_color", "display"];
        let again = capture.with_file_name("replayed");
        std::fs::create_dir(&again).unwrap();
        let done = Command::new(env!("CARGO_BIN_EXE_pt"))
            .args(["replay", capture.to_str().unwrap(), "--from", "denoise", "--device", "cpu"])
            .args(["--aov", &layers.join(","), "-o", again.join("#.exr").to_str().unwrap()])
            .output()
            .unwrap();
        assert!(done.status.success(), "{done:?}");
        let folder = CaptureFolder::open(capture).unwrap();
        assert!(folder.range().start > 0, "frames were before it");
        assert!(folder.sidecar(folder.range().start).unwrap().has_history);
        for frame in folder.range() {
            let captured = folder.frame(frame).unwrap().into_image();
            let replayed = LayeredImage::read_exr(&again.join(format!("{frame}.exr"))).unwrap();
            for layer in layers {
                let layer_is = |image: &LayeredImage| image.layer(layer).cloned();
                assert!(layer_is(&captured).is_some(), "{layer} was not captured");
                assert!(layer_is(&captured) == layer_is(&replayed), "frame {frame}: {layer} differs");
            }
        }
    }

    /// Input waits for a frame at most, and seldom that long. A frame is that of a device that may be busy with another test, and so may the processor be.
    fn assert_does_not_block(ended: &Ended) {
        assert!(ended.frames > 3.0, "{ended:?}");
        assert!(ended.longest_wait <= ended.longest_frame + 500.0, "{ended:?}");
        assert!(ended.median_wait < ended.median_frame, "{ended:?}");
    }

    /// Where the panel of a window for pictures of 64x48 has its widgets: 380 of its 464 points are the panel's.
    const LIGHTS: [i16; 2] = [128, 84];
    /// Knob `lights.emissive`, once its stage is open.
    const EMISSIVE: [i16; 2] = [173, 147];

    pub fn a_knob_that_is_clicked_changes_the_picture_and_a_resize_does_not() {
        let (display, folder) = (Display::start(), tempfile::tempdir().unwrap());
        let into = folder.path().to_str().unwrap();
        let words = ["cornell", "--size", "64x48", "--device", "cpu", "--backend", "compute"];
        let more = ["--frames", "2", "--validation", "--folder", into];
        let mut shown = Shown::start(&display, &[&words[..], &more[..]].concat());
        let picture = |shown: &mut Shown, number: u32| {
            let path = folder.path().join(format!("view-{number}.png"));
            shown.tap(Key::P);
            // The EXR is written after it.
            shown.wait_for("the saved picture", |_| path.with_extension("exr").exists());
            png(&path)
        };
        let mean = |picture: &[[u8; 3]]| {
            picture.iter().flatten().map(|&code| f64::from(code)).sum::<f64>() / picture.len() as f64
        };
        shown.tap(Key::C);
        assert!(!shown.line().contains("--set"));
        let lit = picture(&mut shown, 1);

        // The row of the knob: only the panel changes there.
        let row = |shown: &Shown| {
            let ([width, _], pixels) = shown.pixels();
            let row = |y: usize| pixels[y * width as usize + 108..][..100].to_vec();
            (135..160).flat_map(row).collect::<Vec<_>>()
        };
        for at in [LIGHTS, EMISSIVE] {
            shown.move_to(at);
            std::thread::sleep(std::time::Duration::from_secs(1));
            let before = row(&shown);
            shown.click(at);
            shown.wait_for("the panel follows the click", |shown| row(shown) != before);
            // Stages open with a movement.
            let mut last = Vec::new();
            shown.wait_for("the panel rests", |shown| {
                let now = row(shown);
                std::mem::replace(&mut last, now.clone()) == now
            });
        }
        shown.tap(Key::C);
        let command = shown.line();
        assert!(
            command.contains("--set lights.emissive=false") && command.contains("--frames=2"),
            "{command}"
        );
        let dark = picture(&mut shown, 2);
        assert!(mean(&dark) < 0.5 * mean(&lit), "{} and {}", mean(&dark), mean(&lit));

        shown.tap(Key::H);
        shown.wait_for("the picture in the window", |shown| picture_of(shown.pixels()) == dark);
        shown.resize([700, 500]);
        let has_size = |shown: &Shown| shown.pixels().0 == [700, 500];
        shown.wait_for("the picture in a larger window", |shown| {
            has_size(shown) && picture_of(shown.pixels()) == dark
        });
        shown.play_about(1, std::time::Duration::from_secs(4));
        let ended = shown.close_by_key();
        assert_does_not_block(&ended);
    }
}
