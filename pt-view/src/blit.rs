//! Parts of a picture, and where they are shown.

use ash::vk;
use pt_core::Image;

/// A part of a picture that is shown in a part of the window.
#[derive(Clone)]
pub struct Blit {
    /// The picture, 8-bit display codes.
    pub image: Image,
    /// The part: left, top, right, bottom, texels.
    pub from: [i32; 4],
    /// Where it is shown: left, top, right, bottom, pixels of the window. What lies outside is cut off.
    pub to: [i32; 4],
}

impl Blit {
    /// Records it.
    ///
    /// # Safety
    /// The command buffer is recording, `target` is in the layout TRANSFER_DST_OPTIMAL and has `size` pixels.
    pub(crate) unsafe fn record(
        &self,
        raw: &ash::Device,
        commands: vk::CommandBuffer,
        target: vk::Image,
        size: [u32; 2],
    ) {
        let [x, y] = [0, 1].map(|axis| {
            cut([self.from[axis], self.from[axis + 2]], [self.to[axis], self.to[axis + 2]], size[axis] as i32)
        });
        let (Some((fx, tx)), Some((fy, ty))) = (x, y) else { return };
        let corners = |x: [i32; 2], y: [i32; 2]| {
            [vk::Offset3D { x: x[0], y: y[0], z: 0 }, vk::Offset3D { x: x[1], y: y[1], z: 1 }]
        };
        let layers =
            vk::ImageSubresourceLayers::default().aspect_mask(vk::ImageAspectFlags::COLOR).layer_count(1);
        let region = vk::ImageBlit::default()
            .src_subresource(layers)
            .src_offsets(corners(fx, fy))
            .dst_subresource(layers)
            .dst_offsets(corners(tx, ty));
        // Pixels are looked at: each is shown as it is.
        let filter = vk::Filter::NEAREST;
        // SAFETY: as promised by the caller; pictures are in the layout GENERAL.
        unsafe {
            raw.cmd_blit_image(
                commands,
                self.image.handle(),
                vk::ImageLayout::GENERAL,
                target,
                vk::ImageLayout::TRANSFER_DST_OPTIMAL,
                &[region],
                filter,
            );
        }
    }
}

/// Cuts a span off at 0 and at `size`; the span that is shown there is cut alike. `None` if nothing is left.
fn cut(from: [i32; 2], to: [i32; 2], size: i32) -> Option<([i32; 2], [i32; 2])> {
    let scale = f64::from(from[1] - from[0]) / f64::from(to[1] - to[0]);
    let kept = to.map(|edge| edge.clamp(0, size));
    let source = [0, 1].map(|i| f64::from(from[0]) + f64::from(kept[i] - to[0]) * scale);
    let source = [source[0].floor() as i32, source[1].ceil() as i32];
    (to[0] < to[1] && kept[0] < kept[1] && source[0] < source[1]).then_some((source, kept))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_outside_is_cut_off() {
        assert_eq!(cut([0, 10], [0, 20], 100), Some(([0, 10], [0, 20])), "inside");
        assert_eq!(cut([0, 10], [-10, 10], 100), Some(([5, 10], [0, 10])));
        assert_eq!(cut([0, 10], [90, 110], 100), Some(([0, 5], [90, 100])));
        assert_eq!(cut([0, 10], [100, 120], 100), None);
        assert_eq!(cut([0, 10], [5, 5], 100), None, "no area");
    }
}
