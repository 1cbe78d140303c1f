//! The sizes of a frame: as traced, after temporal upscaling, and of the picture.

use crate::split::split_size;
use pt_shaders::channels::ExtentClass;

/// Sizes of one frame in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrameSizes {
    /// The full frame as it is traced.
    pub frame: [u32; 2],
    /// The frame after temporal upscaling.
    pub resolved: [u32; 2],
    /// The picture.
    pub output: [u32; 2],
}

impl FrameSizes {
    /// A frame whose picture is as large as itself.
    pub const fn same(size: [u32; 2]) -> Self {
        Self { frame: size, resolved: size, output: size }
    }

    /// Extent of an image in texels.
    pub fn extent(&self, class: ExtentClass) -> [u32; 2] {
        let part = |size: [u32; 2], divisor: u32| size.map(|side| side.div_ceil(divisor));
        match class {
            ExtentClass::Split => split_size(self.frame),
            ExtentClass::Flat => self.frame,
            ExtentClass::Resolved => self.resolved,
            ExtentClass::Output => self.output,
            ExtentClass::SplitPart(divisor) => part(split_size(self.frame), divisor),
            ExtentClass::ResolvedPart(divisor) => part(self.resolved, divisor),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_rounded_up() {
        let sizes = FrameSizes { frame: [5, 3], resolved: [10, 6], output: [20, 12] };
        assert_eq!(sizes.extent(ExtentClass::Split), [6, 3]);
        assert_eq!(sizes.extent(ExtentClass::SplitPart(3)), [2, 1]);
        assert_eq!(sizes.extent(ExtentClass::ResolvedPart(4)), [3, 2]);
        assert_eq!(sizes.extent(ExtentClass::Output), [20, 12]);
    }
}
