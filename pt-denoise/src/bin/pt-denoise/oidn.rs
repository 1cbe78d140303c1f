//! Intel Open Image Denoise over the composited radiance, with base colour and normal as guides: the ceiling of what a filter of one frame can do. Only in a program
//! that was built with the feature `oidn`; its libraries are found through `OIDN_DIR`.

use anyhow::Result;
use pt_core::{ChannelImages, StageIo};
use pt_image::image_file::LinearImage;
use pt_shaders::channels::{BASE_COLOR, NORMAL};

/// The images that guide it.
pub const GUIDES: StageIo = StageIo { reads: &[BASE_COLOR, NORMAL], ..StageIo::of("oidn") };

/// Whether the program has it.
#[cfg(not(feature = "oidn"))]
pub fn check() -> Result<()> {
    anyhow::bail!(
        "--variant oidn: this program was built without Open Image Denoise; build it with OIDN_DIR=FOLDER cargo build --release -p pt-denoise --features oidn, \
         where FOLDER/lib has libOpenImageDenoise.so"
    )
}

/// Denoises the radiance; milliseconds that it took.
#[cfg(not(feature = "oidn"))]
pub fn denoise(_: &ChannelImages, _: &mut LinearImage) -> Result<f64> {
    check()?;
    Ok(0.0)
}

/// Whether the program has it, and its libraries work.
#[cfg(feature = "oidn")]
pub fn check() -> Result<()> {
    device().map(drop)
}

#[cfg(feature = "oidn")]
fn device() -> Result<oidn::Device> {
    oidn::Device::new()
        .map_err(|error| anyhow::anyhow!("--variant oidn: Open Image Denoise does not start: {error}"))
}

/// Denoises the radiance; milliseconds that the filter took, without setting it up.
#[cfg(feature = "oidn")]
pub fn denoise(images: &ChannelImages, radiance: &mut LinearImage) -> Result<f64> {
    use pt_core::pack::unpack_unit_vector;
    use pt_core::split::to_flat;
    let base = images.current(BASE_COLOR).read_f32()?;
    let base: Vec<[f32; 3]> = base.chunks_exact(4).map(|c| [c[0], c[1], c[2]]).collect();
    let normals = images.current(NORMAL).read_u32()?;
    let unpack = |word: &u32| if *word == 0 { [0.0; 3] } else { unpack_unit_vector(*word).to_array() };
    let normals: Vec<[f32; 3]> = normals.iter().map(unpack).collect();
    let [base, normals] = [base, normals].map(|texels| to_flat(&texels, images.size()));
    // What is no light would spread over the whole picture.
    let light = |v: &f32| if v.is_finite() { v.max(0.0) } else { 0.0 };
    let color: Vec<f32> = radiance.pixels.as_flattened().iter().map(light).collect();
    let mut output = vec![0.0; color.len()];
    let device = device()?;
    let problem = |error: oidn::Error| anyhow::anyhow!("--variant oidn: {error}");
    let mut filter = oidn::RayTracing::try_new(&device).map_err(problem)?;
    filter
        .albedo_normal(base.as_flattened(), normals.as_flattened())
        .hdr(true)
        .clean_aux(true)
        .image_dimensions(radiance.width as usize, radiance.height as usize);
    // The first run sets the network up.
    filter.filter(&color, &mut output).map_err(problem)?;
    let start = std::time::Instant::now();
    filter.filter(&color, &mut output).map_err(problem)?;
    let ms = start.elapsed().as_secs_f64() * 1e3;
    radiance.pixels = output.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect();
    Ok(ms)
}
