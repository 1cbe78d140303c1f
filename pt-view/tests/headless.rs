//! The presenter against a surface without a window (`VK_EXT_headless_surface`), under the validation layers.

use pt_core::{Device, DeviceOptions, Image};
use pt_shaders::channels::Format;
use pt_view::Context;
use pt_view::blit::Blit;
use pt_view::headless;
use pt_view::offscreen::Offscreen;
use pt_view::panel::{Panel, PanelContent};
use pt_view::panel_renderer::LaidOut;
use pt_view::presenter::Presenter;
use pt_view::protocol::Status;
use pt_view::swapchain_rules::Outcome;
use std::time::{Duration, Instant};

fn device() -> Device {
    let device = std::env::var("PT_TEST_DEVICE").ok();
    headless::open_device(&DeviceOptions { device, validation: true }).unwrap()
}

fn presenter(device: &Device, size: [u32; 2]) -> Presenter {
    headless::presenter(device, size).unwrap()
}

/// Shows until it is shown: an image may not be free at once.
fn show(presenter: &mut Presenter, blits: &[Blit], mut panel: Option<&mut LaidOut>) {
    let begun = Instant::now();
    while presenter.show(blits, panel.as_deref_mut()).unwrap() == Outcome::LeftOut {
        assert!(begun.elapsed() < Duration::from_secs(60), "nothing is shown");
        std::thread::sleep(Duration::from_millis(1));
    }
}

fn assert_silent(device: &Device) {
    let messages = device.validation().unwrap().messages();
    assert!(messages.is_empty(), "{}", messages.join("\n"));
}

fn picture(device: &Device) -> Blit {
    let image = Image::new(device, "picture", Format::Rgba8Unorm, [16, 8]).unwrap();
    image.write(&[200; 16 * 8 * 4]).unwrap();
    Blit { image, from: [0, 0, 16, 8], to: [-4, 2, 28, 18] }
}

#[test]
fn pictures_and_panels_are_shown_and_other_sizes_get_another_swapchain() {
    let device = device();
    let mut presenter = presenter(&device, [64, 48]);
    let (context, blit) = (Context::default(), picture(&device));
    let mut panel = Panel::new(PanelContent::default());
    let mut lay_out = |size| headless::lay_out(&context, size, &mut panel, &Status::default());
    for _ in 0..8 {
        let mut laid_out = lay_out([64, 48]);
        show(&mut presenter, std::slice::from_ref(&blit), Some(&mut laid_out));
        assert!(laid_out.textures.set.is_empty(), "they are uploaded once");
    }
    assert!(presenter.panel_ms().is_some_and(|ms| ms >= 0.0));
    let first = presenter.extent();
    assert_eq!(first, Some([64, 48]));
    for size in [[80, 40], [1, 1], [33, 17]] {
        presenter.resized(size);
        show(&mut presenter, std::slice::from_ref(&blit), Some(&mut lay_out(size)));
        assert_eq!(presenter.extent(), Some(size));
    }
    drop((blit, presenter));
    assert_silent(&device);
}

#[test]
fn a_window_without_area_shows_nothing_until_it_has_one() {
    let device = device();
    let mut presenter = presenter(&device, [0, 0]);
    let blit = picture(&device);
    for _ in 0..3 {
        assert_eq!(presenter.show(std::slice::from_ref(&blit), None).unwrap(), Outcome::LeftOut);
    }
    presenter.resized([40, 30]);
    show(&mut presenter, std::slice::from_ref(&blit), None);
    presenter.resized([0, 30]);
    assert_eq!(presenter.show(std::slice::from_ref(&blit), None).unwrap(), Outcome::LeftOut, "minimised");
    presenter.resized([40, 30]);
    show(&mut presenter, &[blit], None);
    drop(presenter);
    assert_silent(&device);
}

#[test]
fn panels_are_drawn_where_nobody_sees_them() {
    let name = std::env::var("PT_TEST_DEVICE").ok();
    let device = Device::open(&DeviceOptions { device: name, validation: true }).unwrap();
    let mut target = Offscreen::new(&device, [64, 48]).unwrap();
    let (context, blit) = (Context::default(), picture(&device));
    let mut panel = Panel::new(PanelContent::default());
    let mut drawn = 0;
    while drawn < 4 {
        let mut laid_out = headless::lay_out(&context, [64, 48], &mut panel, &Status::default());
        while !target.draw(std::slice::from_ref(&blit), Some(&mut laid_out)).unwrap() {
            std::thread::sleep(Duration::from_millis(1));
        }
        drawn += 1;
    }
    assert!(target.panel_ms().is_some_and(|ms| ms > 0.0), "the third one is done");
    drop((blit, target));
    assert_silent(&device);
}

#[test]
fn a_lost_surface_is_made_anew() {
    let device = device();
    let mut presenter = presenter(&device, [40, 30]);
    let blit = picture(&device);
    for _ in 0..3 {
        show(&mut presenter, std::slice::from_ref(&blit), None);
        presenter.surface_lost().unwrap();
    }
    show(&mut presenter, &[blit], None);
    drop(presenter);
    assert_silent(&device);
}
