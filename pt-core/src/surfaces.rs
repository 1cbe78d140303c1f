//! Where the surfaces of a frame were in the frame before: what temporal errors are measured along.

use crate::channels::ChannelImages;
use crate::error::Result;
use crate::plan::StageIo;
use crate::split::to_flat;
use pt_image::image_file::LayeredImage;
use pt_image::metrics::Correspondence;
use pt_shaders::channels::{ChannelId, MOTION, VIEW_DEPTH};

/// Motion and distance of the surfaces that a frame shows.
pub struct Surfaces {
    size: [u32; 2],
    /// Flat pixels: channel `motion`, channel `view_depth`.
    pixels: Vec<([f32; 4], f32)>,
}

impl Surfaces {
    /// The channels that say where surfaces were.
    pub const IO: StageIo = StageIo { reads: &[MOTION, VIEW_DEPTH], ..StageIo::of("measures") };

    /// The surfaces of the frame in `images`; waits for it.
    ///
    /// # Errors
    /// When the device fails.
    pub fn read(images: &ChannelImages) -> Result<Self> {
        let motion = images.current(MOTION).read_f32()?;
        let depth = images.current(VIEW_DEPTH).read_f32()?;
        let motion = motion.chunks_exact(4).map(|m| [m[0], m[1], m[2], m[3]]);
        let pixels: Vec<_> = motion.zip(depth).collect();
        Ok(Self { size: images.size(), pixels: to_flat(&pixels, images.size()) })
    }

    /// The surfaces of a frame whose file has the channels as layers, as captures and `pt render --aov motion,view_depth` write them; `None` if
    /// it has not.
    pub fn of_file(file: &LayeredImage) -> Option<Self> {
        let plane = |id: ChannelId, component| Some(file.channel(&id.full_name(), component)?.to_f32());
        let [x, y, z, w] =
            [plane(MOTION, "X")?, plane(MOTION, "Y")?, plane(MOTION, "Z")?, plane(MOTION, "W")?];
        let depth = plane(VIEW_DEPTH, "Z")?;
        let pixels = (0..depth.len()).map(|i| ([x[i], y[i], z[i], w[i]], depth[i])).collect();
        Some(Self { size: [file.width, file.height], pixels })
    }

    /// Where the pixels of a picture of `size` were in the picture before, whose surfaces are `before`: those that it shows, at the distance at
    /// which they were there. A picture that is larger than its frame has the surface of the nearest pixel.
    pub fn seen_in(&self, before: &Self, size: [u32; 2]) -> Correspondence {
        let nearest = |at: [u32; 2]| {
            let [x, y] = [0, 1]
                .map(|k| ((at[k] as f32 + 0.5) * self.size[k] as f32 / size[k] as f32) as u32)
                .map(|v| v as usize);
            y * self.size[0] as usize + x
        };
        let offset = |at: [u32; 2]| {
            let (motion, depth) = self.pixels[nearest(at)];
            let offset = [motion[0] * size[0] as f32, motion[1] * size[1] as f32];
            let place = [0, 1].map(|k| (at[k] as f32 + offset[k]).round());
            let inside = (0..2).all(|k| (0.0..size[k] as f32).contains(&place[k]));
            let was = inside.then(|| before.pixels[nearest(place.map(|v| v as u32))].1)?;
            let expected = depth + motion[2];
            let tolerance = 0.02 * expected.abs() + 2.0 / motion[3].max(1e-18);
            ((was - expected).abs() <= tolerance).then_some(offset)
        };
        let pixels = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| [x, y]));
        Correspondence { offsets: pixels.map(offset).collect() }
    }
}
