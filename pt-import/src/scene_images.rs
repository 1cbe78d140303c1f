//! The images of a scene file, and image files by themselves.

use std::path::Path;

use crate::document::Document;
use crate::notices::Notices;
use crate::options::LoadOptions;
use crate::{images, materials, textures};
use pt_scene::{SceneError, Texture, TextureUsage};

/// The images of a scene file as its materials use them, for [`crate::bake::bake()`].
pub(crate) struct Images<'a>(textures::Uses<'a>);

/// Reads a scene's materials and hands over their images.
pub(crate) fn with_images<R>(
    path: &Path,
    options: &LoadOptions,
    work: impl FnOnce(&Images<'_>) -> Result<R, SceneError>,
) -> Result<R, SceneError> {
    let document = Document::read(path, options, &mut Notices::default())?;
    let (_, mut uses, _) = materials::collect(&document)?;
    // What is computed from an image is computed at load.
    uses.in_order.retain(|u| u.glossiness.is_none());
    work(&Images(uses))
}

impl Images<'_> {
    /// How many there are.
    pub fn len(&self) -> usize {
        self.0.in_order.len()
    }

    /// Label and content of the image file.
    pub fn file(&self, index: usize) -> Result<(String, Vec<u8>), SceneError> {
        self.0.file(self.0.in_order[index])
    }

    /// What an image is used for.
    pub fn usage(&self, index: usize) -> TextureUsage {
        self.0.in_order[index].usage
    }

    /// An error in an image.
    pub fn invalid(&self, index: usize, label: &str, what: String) -> SceneError {
        self.0.invalid(self.0.in_order[index], label, what)
    }
}

/// The size of an image file, from its header.
///
/// # Errors
/// No image file, or more texels than `max_texels`.
pub(crate) fn image_size(bytes: &[u8], max_texels: u64) -> Result<[u32; 2], String> {
    let header = images::Header::read(bytes)?;
    header.check(max_texels)?;
    Ok([header.width, header.height])
}

/// A texture from the content of an image file: PNG, JPEG, WebP, DDS or KTX2, told apart by the first bytes.
///
/// # Errors
/// What is wrong, in one line without the file's name. An image of more than `max_texels` texels is refused before
/// it is decoded.
pub fn decode_texture(
    name: &str,
    bytes: &[u8],
    usage: TextureUsage,
    max_texels: u64,
) -> Result<Texture, String> {
    let header = images::Header::read(bytes)?;
    header.check(max_texels)?;
    let size = [header.width, header.height];
    Ok(Texture { texels: header.decode(usage)?, ..Texture::rgba8(name, size, usage, Vec::new()) })
}
