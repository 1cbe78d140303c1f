//! Intel Open Image Denoise over the composited radiance, with base colour and normal as guides: the ceiling of what a filter of one frame can do. Only in a program
//! that was built with the feature `oidn`; its libraries are found through `OIDN_DIR`.

use anyhow::Result;
use pt_core::{ChannelImages, StageIo};
use pt_denoise::OidnQuality;
use pt_image::image_file::LinearImage;
use pt_shaders::channels::{BASE_COLOR, NORMAL};

/// The images that guide it.
pub const GUIDES: StageIo = StageIo { reads: &[BASE_COLOR, NORMAL], ..StageIo::of("oidn") };

/// The library on the fastest device that it finds.
pub struct Oidn {
    #[cfg(feature = "oidn")]
    device: oidn::Device,
}

#[cfg(not(feature = "oidn"))]
impl Oidn {
    pub fn new() -> Result<Self> {
        anyhow::bail!(
            "--variant oidn: this program was built without Open Image Denoise; build it with OIDN_DIR=FOLDER cargo build --release -p pt-denoise --features oidn, \
             where FOLDER/lib has libOpenImageDenoise.so"
        )
    }

    pub fn denoise(&self, _: &ChannelImages, _: &mut LinearImage, _: OidnQuality) -> Result<f64> {
        Ok(0.0)
    }
}

#[cfg(feature = "oidn")]
impl Oidn {
    /// # Errors
    /// The library or a device is missing.
    pub fn new() -> Result<Self> {
        let device = oidn::Device::new()
            .map_err(|error| anyhow::anyhow!("--variant oidn: Open Image Denoise does not start: {error}"))?;
        Ok(Self { device })
    }

    /// Denoises the radiance. Milliseconds that the filter took, from buffers of its device to such a buffer, without setting it up.
    ///
    /// # Errors
    /// The library's.
    pub fn denoise(
        &self,
        images: &ChannelImages,
        radiance: &mut LinearImage,
        quality: OidnQuality,
    ) -> Result<f64> {
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
        let (milliseconds, pixels) = self
            .filter(
                [&color, base.as_flattened(), normals.as_flattened()],
                [radiance.width, radiance.height],
                quality,
            )
            .map_err(|error| anyhow::anyhow!("--variant oidn: {error}"))?;
        radiance.pixels = pixels.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect();
        Ok(milliseconds)
    }

    fn filter(
        &self,
        images: [&[f32]; 3],
        [width, height]: [u32; 2],
        quality: OidnQuality,
    ) -> Result<(f64, Vec<f32>), oidn::Error> {
        let buffer = || self.device.create_buffer_with_storage(images[0].len(), oidn::Storage::Device);
        let filled = |values| {
            let buffer = buffer()?;
            buffer.write(values)?;
            Ok::<_, oidn::Error>(buffer)
        };
        let (color, output) = (filled(images[0])?, buffer()?);
        let mut filter = oidn::RayTracing::try_new(&self.device)?;
        filter.image_dimensions(width as usize, height as usize).hdr(true).clean_aux(true);
        filter.filter_quality(match quality {
            OidnQuality::High => oidn::Quality::High,
            OidnQuality::Balanced => oidn::Quality::Balanced,
            OidnQuality::Fast => oidn::Quality::Fast,
        });
        filter.albedo_normal_buffer(filled(images[1])?, filled(images[2])?)?;
        // The first run sets the network up.
        filter.filter_buffer(&color, &output)?;
        self.device.sync();
        let start = std::time::Instant::now();
        filter.filter_buffer(&color, &output)?;
        self.device.sync();
        let milliseconds = start.elapsed().as_secs_f64() * 1e3;
        Ok((milliseconds, output.read()?))
    }
}
