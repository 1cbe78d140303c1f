//! Resources that passes access, resources that a frame in flight keeps alive, and the rows of the pass table.

use crate::buffer::Buffer;
use crate::image::Image;
use crate::kernel::Kernel;
use crate::texture::TextureTable;

/// A row of the pass table.
#[derive(Clone, Debug, serde::Serialize)]
pub struct PassInfo {
    /// Pass name.
    pub name: String,
    /// The kernel that it runs; in parentheses a command of the driver, such as `(copy)`.
    pub kernel: String,
    /// Threads.
    pub extent: [u32; 3],
    /// Names of the resources that it reads.
    pub reads: Vec<String>,
    /// Names of the resources that it writes.
    pub writes: Vec<String>,
    /// Bytes that it moves when it touches every texel of its images and every byte of its buffers once.
    pub bytes: u64,
    /// Whether it touches fewer than that, as many as the frame needs.
    pub bytes_are_upper_bound: bool,
}

impl PassInfo {
    /// Whether it runs a kernel, so that `extent` counts threads.
    pub fn runs_kernel(&self) -> bool {
        !self.kernel.starts_with('(')
    }
}

/// A resource that a frame in flight keeps alive.
pub(crate) enum Keep {
    Buffer(#[expect(dead_code, reason = "held, not used")] Buffer),
    Image(#[expect(dead_code, reason = "held, not used")] Image),
    Kernel(#[expect(dead_code, reason = "held, not used")] Kernel),
    Textures(#[expect(dead_code, reason = "held, not used")] TextureTable),
}

/// A resource that can be bound by name.
#[derive(Clone)]
pub enum Resource {
    /// A storage image.
    Image(Image),
    /// A uniform or storage buffer.
    Buffer(Buffer),
}

impl From<&Image> for Resource {
    fn from(image: &Image) -> Self {
        Self::Image(image.clone())
    }
}

impl From<&Buffer> for Resource {
    fn from(buffer: &Buffer) -> Self {
        Self::Buffer(buffer.clone())
    }
}

impl Resource {
    pub(super) fn id(&self) -> u64 {
        match self {
            Self::Image(image) => image.id(),
            Self::Buffer(buffer) => buffer.id(),
        }
    }

    /// See [`Image::note_written`].
    pub(super) fn note_written(&self) -> Vec<u64> {
        match self {
            Self::Image(image) => image.note_written(),
            Self::Buffer(buffer) => buffer.note_written(),
        }
    }

    /// See [`Image::is_overwritten`].
    pub(super) fn is_overwritten(&self) -> bool {
        match self {
            Self::Image(image) => image.is_overwritten(),
            Self::Buffer(buffer) => buffer.is_overwritten(),
        }
    }

    /// Whether both have a byte in the same place.
    pub(super) fn shares_memory_with(&self, other: &Self) -> bool {
        let part = |resource: &Self| match resource {
            Self::Image(image) => image.part().cloned(),
            Self::Buffer(buffer) => buffer.part().cloned(),
        };
        match (part(self), part(other)) {
            (Some(a), Some(b)) => a.meets(&b),
            _ => self.id() == other.id(),
        }
    }

    pub(super) fn name(&self) -> &str {
        match self {
            Self::Image(image) => image.name(),
            Self::Buffer(buffer) => buffer.name(),
        }
    }

    pub(super) fn bytes(&self) -> u64 {
        match self {
            Self::Image(image) => image.bytes(),
            Self::Buffer(buffer) => buffer.size(),
        }
    }

    pub(super) fn keep(&self) -> Keep {
        match self {
            Self::Image(image) => Keep::Image(image.clone()),
            Self::Buffer(buffer) => Keep::Buffer(buffer.clone()),
        }
    }
}
