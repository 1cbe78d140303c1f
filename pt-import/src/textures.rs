//! The uses that materials make of images, and their texels.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, Ordering};

use glam::{Affine2, Mat2, Vec2};
use gltf::json::material::NormalTexture;
use gltf::json::texture::{self, MagFilter, MinFilter, WrappingMode};
use gltf::json::validation::Checked;
use gltf::json::{Image, Index, extensions};
use rayon::prelude::*;

use crate::baked_folder::BakedFolder;
use crate::document::Document;
use crate::images::Header;
use pt_scene::one_line;
use pt_scene::{Filter, MipFilter, Sampler, SceneError, Texels, Texture, TextureRef, TextureUsage, Wrap};

/// Extensions of a texture that name another image, those that need the least work first.
#[cfg(feature = "codecs")]
const SOURCES: &[&str] = &["MSFT_texture_dds", "KHR_texture_basisu", "EXT_texture_webp"];
#[cfg(not(feature = "codecs"))]
const SOURCES: &[&str] = &["MSFT_texture_dds", "EXT_texture_webp"];

/// An image as used: what for, and with which sampler. Uses that agree share a [`Texture`].
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Use {
    pub image: usize,
    sampler: Option<usize>,
    pub usage: TextureUsage,
    /// The bits of the factor of a glossiness in alpha that becomes a roughness.
    pub glossiness: Option<u32>,
}

pub(crate) struct Uses<'a> {
    pub document: &'a Document,
    known: BTreeMap<Use, u32>,
    pub in_order: Vec<Use>,
    pub notices: Vec<String>,
    pub occlusion: bool,
}

impl<'a> Uses<'a> {
    pub fn new(document: &'a Document) -> Self {
        let (known, in_order, notices) = Default::default();
        Self { document, known, in_order, notices, occlusion: false }
    }

    /// A texture of a material.
    pub fn info(
        &mut self,
        info: &Option<texture::Info>,
        usage: TextureUsage,
        at: &str,
    ) -> Result<Option<TextureRef>, SceneError> {
        let Some(info) = info else { return Ok(None) };
        let transform = info.extensions.as_ref().and_then(|e| e.texture_transform.as_ref());
        self.reference(info.index, info.tex_coord, transform, usage, None, at)
    }

    /// A texture of roughness in G, 1 - `factor` x alpha of a texture that has glossiness in alpha.
    pub fn roughness(
        &mut self,
        info: &Option<texture::Info>,
        factor: f32,
        at: &str,
    ) -> Result<Option<TextureRef>, SceneError> {
        let Some(info) = info else { return Ok(None) };
        let transform = info.extensions.as_ref().and_then(|e| e.texture_transform.as_ref());
        self.reference(info.index, info.tex_coord, transform, TextureUsage::Data, Some(factor.to_bits()), at)
    }

    /// A normal map with its scale.
    pub fn normal(
        &mut self,
        normal: &Option<NormalTexture>,
        at: &str,
    ) -> Result<(Option<TextureRef>, f32), SceneError> {
        let Some(normal) = normal else { return Ok((None, 1.0)) };
        let others = normal.extensions.as_ref().map(|e| &e.others);
        let transform = others.and_then(|others| others.get("KHR_texture_transform"));
        let transform = transform
            .map(|value| serde_json::from_value(value.clone()))
            .transpose()
            .map_err(|e| self.document.invalid(format!("{at}.normalTexture.extensions"), e))?;
        let usage = TextureUsage::Normal;
        let texture = self.reference(normal.index, normal.tex_coord, transform.as_ref(), usage, None, at)?;
        Ok((texture, normal.scale))
    }

    fn reference(
        &mut self,
        index: Index<texture::Texture>,
        tex_coord: u32,
        transform: Option<&extensions::texture::TextureTransform>,
        usage: TextureUsage,
        glossiness: Option<u32>,
        at: &str,
    ) -> Result<Option<TextureRef>, SceneError> {
        let texture = self.document.get(index, at)?;
        let at = format!("textures[{}]", index.value());
        let source = self.source(texture, &at)?;
        let Some(source) = source else {
            self.notices
                .push(format!("{at}: has no image, or one of an extension that is not supported; left out"));
            return Ok(None);
        };
        if let Some(sampler) = texture.sampler {
            self.document.get(sampler, &format!("{at}.sampler"))?;
        }
        let uv_set = transform.and_then(|t| t.tex_coord).unwrap_or(tex_coord);
        if uv_set > 1 {
            self.notices
                .push(format!("{at}: texture coordinate set {uv_set} is not supported; texture left out"));
            return Ok(None);
        }
        let sampler = texture.sampler.map(|s| s.value());
        let key = Use { image: source.value(), sampler, usage, glossiness };
        let texture = *self.known.entry(key).or_insert_with(|| {
            self.in_order.push(key);
            self.in_order.len() as u32 - 1
        });
        Ok(Some(TextureRef { texture, uv_set, transform: transform.map_or(Affine2::IDENTITY, affine) }))
    }

    /// The image of a texture: that of an extension before the one that every reader knows.
    fn source(&self, texture: &texture::Texture, at: &str) -> Result<Option<Index<Image>>, SceneError> {
        for &name in SOURCES {
            let Some(extension) = texture.extensions.as_ref().and_then(|e| e.others.get(name)) else {
                continue;
            };
            let index = extension.get("source").and_then(|source| source.as_u64());
            let index = index.and_then(|index| u32::try_from(index).ok()).map(Index::new);
            let at = format!("{at}.extensions.{name}.source");
            let index = index.ok_or_else(|| self.document.invalid(&at, "is no index"))?;
            self.document.get(index, &at)?;
            return Ok(Some(index));
        }
        // What the JSON crate writes where the property is missing, which the format allows.
        if texture.source.value() == u32::MAX as usize {
            return Ok(None);
        }
        self.document.get(texture.source, &format!("{at}.source"))?;
        Ok(Some(texture.source))
    }

    /// The file that a use names: its label and its bytes.
    pub fn file(&self, u: Use) -> Result<(String, Vec<u8>), SceneError> {
        let at = format!("images[{}]", u.image);
        let image = &self.document.root.images[u.image];
        let bytes = match (&image.uri, image.buffer_view) {
            (Some(uri), _) => self.document.fetch(uri, &at)?,
            (None, Some(view)) => self.document.view(view, &at)?.0.to_vec(),
            (None, None) => return Err(self.document.invalid(at, "has neither a uri nor a bufferView")),
        };
        Ok((label(image, &at), bytes))
    }

    /// The texture of a use, without texels as yet, from its file.
    pub fn texture(&self, u: Use, label: String, [width, height]: [u32; 2]) -> Texture {
        let sampler = sampler(u.sampler.and_then(|s| self.document.root.samplers.get(s)));
        Texture { sampler, ..Texture::rgba8(&label, [width, height], u.usage, Vec::new()) }
    }

    /// An error in the image of a use.
    pub fn invalid(&self, u: Use, label: &str, what: impl std::fmt::Display) -> SceneError {
        let at = format!("images[{}]", u.image);
        let what = if label == at { what.to_string() } else { format!("{label}: {what}") };
        self.document.invalid(at, what)
    }

    /// All textures: baked ones where `baked` has them, the others decoded, up to `max_texels` in all.
    pub fn load(&mut self, baked: Option<&BakedFolder>, max_texels: u64) -> Result<Vec<Texture>, SceneError> {
        let texels = AtomicU64::new(0);
        let loaded: Vec<_> =
            self.in_order.par_iter().map(|&u| self.load_one(u, baked, &texels, max_texels)).collect();
        let texels = texels.into_inner();
        if texels > max_texels {
            let what =
                format!("{texels} texels are more than the limit of {max_texels}; see --max-texture-pixels");
            return Err(self.document.invalid("images", what));
        }
        let mut textures = Vec::with_capacity(loaded.len());
        for result in loaded {
            let (texture, notice) = result?;
            textures.push(texture);
            self.notices.extend(notice);
        }
        Ok(textures)
    }

    /// Beyond the limit the header's size is counted, and nothing decoded.
    fn load_one(
        &self,
        u: Use,
        baked: Option<&BakedFolder>,
        texels: &AtomicU64,
        max_texels: u64,
    ) -> Result<(Texture, Option<String>), SceneError> {
        let (label, bytes) = self.file(u)?;
        let header = Header::read(&bytes).map_err(|what| self.invalid(u, &label, what))?;
        let count = header.texel_count();
        let mut texture = self.texture(u, label, [header.width, header.height]);
        if texels.fetch_add(count, Ordering::Relaxed).saturating_add(count) > max_texels {
            return Ok((texture, None));
        }
        let mut notice = None;
        // What is baked is the image as it is.
        if let Some(folder) = baked.filter(|_| u.glossiness.is_none()) {
            match folder.find(&bytes, u.usage, [texture.width, texture.height]) {
                Ok(Some(texels)) => {
                    texture.texels = texels;
                    return Ok((texture, None));
                }
                Ok(None) => {}
                Err(what) => notice = Some(format!("{what}; {} is decoded instead", texture.name)),
            }
        }
        texture.texels = header.decode(u.usage).map_err(|what| self.invalid(u, &texture.name, what))?;
        if let Some(factor) = u.glossiness.map(f32::from_bits) {
            texture = roughness_of(texture, factor);
        }
        Ok((texture, notice))
    }
}

/// A texture with glossiness in alpha as one with roughness in G, with as many bits as the image has.
fn roughness_of(texture: Texture, factor: f32) -> Texture {
    let mut texture = texture.decoded().into_owned();
    match &mut texture.texels {
        Texels::Rgba8(texels) => {
            for texel in texels.as_chunks_mut().0 {
                let [_, _, _, glossiness] = *texel;
                *texel = [0, (255.0 - factor * f32::from(glossiness)).round() as u8, 0, 255];
            }
        }
        Texels::Rgba16(texels) => {
            for texel in texels.as_chunks_mut().0 {
                let [_, _, _, glossiness] = *texel;
                *texel = [0, (65535.0 - factor * f32::from(glossiness)).round() as u16, 0, 65535];
            }
        }
        Texels::Blocks { .. } => {}
    }
    texture
}

/// KHR_texture_transform: scale, then rotation (counter-clockwise as seen with v down), then offset.
fn affine(t: &extensions::texture::TextureTransform) -> Affine2 {
    let matrix2 = Mat2::from_angle(-t.rotation.0) * Mat2::from_diagonal(Vec2::from_array(t.scale.0));
    Affine2 { matrix2, translation: Vec2::from_array(t.offset.0) }
}

fn label(image: &Image, at: &str) -> String {
    let uri = image.uri.as_ref().filter(|uri| !uri.starts_with("data:"));
    one_line(image.name.as_ref().or(uri).map_or(at, |name| name))
}

fn sampler(sampler: Option<&texture::Sampler>) -> Sampler {
    let wrap = |mode| match mode {
        Checked::Valid(WrappingMode::ClampToEdge) => Wrap::ClampToEdge,
        Checked::Valid(WrappingMode::MirroredRepeat) => Wrap::MirroredRepeat,
        Checked::Valid(WrappingMode::Repeat) | Checked::Invalid => Wrap::Repeat,
    };
    let Some(s) = sampler else { return Sampler::default() };
    let (min, mip) = match s.min_filter {
        Some(Checked::Valid(MinFilter::Nearest)) => (Filter::Nearest, MipFilter::Off),
        Some(Checked::Valid(MinFilter::Linear)) => (Filter::Linear, MipFilter::Off),
        Some(Checked::Valid(MinFilter::NearestMipmapNearest)) => (Filter::Nearest, MipFilter::Nearest),
        Some(Checked::Valid(MinFilter::LinearMipmapNearest)) => (Filter::Linear, MipFilter::Nearest),
        Some(Checked::Valid(MinFilter::NearestMipmapLinear)) => (Filter::Nearest, MipFilter::Linear),
        Some(Checked::Valid(MinFilter::LinearMipmapLinear) | Checked::Invalid) | None => Default::default(),
    };
    let mag = match s.mag_filter {
        Some(Checked::Valid(MagFilter::Nearest)) => Filter::Nearest,
        _ => Filter::Linear,
    };
    Sampler { wrap_u: wrap(s.wrap_s), wrap_v: wrap(s.wrap_t), mag, min, mip }
}
