//! Folders of baked textures and the names of their files.

use std::path::{Path, PathBuf};

use pt_image::atomic_file::write_atomic;

use crate::dds::DdsTexture;
use pt_scene::Texels;
use pt_scene::{SceneError, TextureUsage};
use pt_scene::{one_line, read_file};
use pt_shaders::named_enum;

/// Part of every name: another encoder, other settings or another layout of the file get another one.
const ENCODER: &str = "pt bake 1, block_compression 0.11.0";

/// The words of the DDS header that are reserved; writers put their mark there, readers skip them.
const RESERVED: std::ops::Range<usize> = 32..76;
const MARK: &[u8; 4] = b"ptbk";

named_enum! {
    /// How long the encoder searches.
    pub enum Quality {
        /// A third of the time.
        Fast = "fast",
        /// Some 2 dB better on hard images.
        Best = "best",
    }
}

/// The content of a baked file.
pub(crate) struct BakedFile {
    pub dds: DdsTexture,
    pub quality: Quality,
    /// The image has 16 bits per channel: without compression it would take twice the memory.
    pub is_16_bit: bool,
}

/// A folder of baked textures.
#[derive(Clone, Debug)]
pub struct BakedFolder {
    path: PathBuf,
}

impl BakedFolder {
    /// A folder to read from.
    ///
    /// # Errors
    /// No such folder.
    pub fn open(path: &Path) -> Result<Self, SceneError> {
        if !path.is_dir() {
            return Err(SceneError::file(path, "no such folder; `pt bake SCENE -o DIR` makes one"));
        }
        Ok(Self { path: path.to_owned() })
    }

    /// A folder to write to.
    pub(crate) fn create(path: &Path) -> Result<Self, SceneError> {
        std::fs::create_dir_all(path).map_err(|e| SceneError::file(path, e))?;
        Self::open(path)
    }

    /// Name of the file for an image file and its use.
    pub fn file_name(image: &[u8], usage: TextureUsage) -> String {
        let mut hasher = blake3::Hasher::new();
        hasher.update(ENCODER.as_bytes());
        hasher.update(format!("{usage:?}").as_bytes());
        hasher.update(image);
        format!("{}.dds", &hasher.finalize().to_hex()[..32])
    }

    /// The baked texels of an image file, `None` when there are none.
    ///
    /// # Errors
    /// A damaged file, in one line that names it.
    pub fn find(
        &self,
        image: &[u8],
        usage: TextureUsage,
        extent: [u32; 2],
    ) -> Result<Option<Texels>, String> {
        let Some(BakedFile { dds, .. }) = self.lookup(image, usage)? else { return Ok(None) };
        if [dds.width, dds.height] != extent {
            let path = self.path.join(Self::file_name(image, usage));
            return Err(format!(
                "{}: is {}x{}, not {}x{}",
                path.display(),
                dds.width,
                dds.height,
                extent[0],
                extent[1]
            ));
        }
        Ok(Some(Texels::Blocks { format: dds.format, levels: dds.levels }))
    }

    pub(crate) fn lookup(&self, image: &[u8], usage: TextureUsage) -> Result<Option<BakedFile>, String> {
        let path = self.path.join(Self::file_name(image, usage));
        if !path.exists() {
            return Ok(None);
        }
        let bytes = read_file(&path).map_err(|e| e.to_string())?;
        unseal(&bytes).map(Some).map_err(|what| format!("{}: {what}", path.display()))
    }

    pub(crate) fn store(&self, name: &str, file: &BakedFile) -> Result<(), SceneError> {
        let path = self.path.join(name);
        let bytes = seal(file).map_err(|what| SceneError::file(&path, what))?;
        write_atomic(&path, &bytes).map_err(|e| SceneError::file(&path, one_line(&e.to_string())))
    }
}

/// Checksum of the file without its reserved words.
fn checksum(bytes: &[u8]) -> [u8; 16] {
    let mut hasher = blake3::Hasher::new();
    hasher.update(&bytes[..RESERVED.start]);
    hasher.update(&bytes[RESERVED.end..]);
    let mut sum = [0; 16];
    hasher.finalize_xof().fill(&mut sum);
    sum
}

/// The file, with mark, quality, depth of the image and checksum in the reserved words of its header.
fn seal(file: &BakedFile) -> Result<Vec<u8>, String> {
    let mut bytes = file.dds.to_bytes()?;
    let sum = checksum(&bytes);
    let reserved = &mut bytes[RESERVED];
    reserved[..4].copy_from_slice(MARK);
    reserved[4] = file.quality as u8;
    reserved[5] = u8::from(file.is_16_bit);
    reserved[8..24].copy_from_slice(&sum);
    Ok(bytes)
}

fn unseal(bytes: &[u8]) -> Result<BakedFile, String> {
    let reserved = bytes.get(RESERVED).ok_or("the baked texture is cut short")?;
    if reserved[..4] != *MARK || reserved[8..24] != checksum(bytes) {
        return Err("the baked texture is damaged".into());
    }
    let quality = if reserved[4] == Quality::Fast as u8 { Quality::Fast } else { Quality::Best };
    Ok(BakedFile { dds: DdsTexture::from_bytes(bytes)?, quality, is_16_bit: reserved[5] == 1 })
}
