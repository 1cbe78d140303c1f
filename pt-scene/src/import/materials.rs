use std::collections::{BTreeMap, BTreeSet};
use std::io::Cursor;

use glam::{Affine2, Mat2, Vec2, Vec3, Vec4};
use gltf::json::material::{self, AlphaMode as JsonAlpha};
use gltf::json::texture::{self, MagFilter, MinFilter, WrappingMode};
use gltf::json::validation::Checked;
use gltf::json::{Image, Index, extensions};
use rayon::prelude::*;

use super::document::Document;
use super::material_extensions;
use crate::error::one_line;
use crate::{AlphaMode, Filter, Material, Sampler, Scene, SceneError, Texture, TextureRef, Wrap};

/// Longest side of a texture that is accepted.
pub const MAX_TEXTURE_SIDE: u32 = 16384;

/// An image as used: colour (sRGB) or data, with a sampler. Uses that agree share a [`Texture`].
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Use {
    image: usize,
    sampler: Option<usize>,
    srgb: bool,
}

pub(super) struct Uses<'a> {
    pub document: &'a Document,
    known: BTreeMap<Use, u32>,
    in_order: Vec<Use>,
    notices: Vec<String>,
    occlusion: bool,
}

/// Fills materials (one per glTF material, then the default material) and the textures that they use.
pub(super) fn read(document: &Document, scene: &mut Scene) -> Result<(), SceneError> {
    let mut uses = Uses {
        document,
        known: BTreeMap::new(),
        in_order: Vec::new(),
        notices: Vec::new(),
        occlusion: false,
    };
    for (i, material) in document.root.materials.iter().enumerate() {
        scene.materials.push(uses.material(material, &format!("materials[{i}]"))?);
    }
    scene.materials.push(Material { name: "default".into(), ..Material::default() });
    let textures: Result<Vec<_>, _> = uses.in_order.par_iter().map(|&u| decode(document, u)).collect();
    scene.textures = textures?;
    scene.notices.append(&mut uses.notices);
    if uses.occlusion {
        scene
            .notices
            .push("occlusion textures are ignored: traced light is occluded by the geometry itself".into());
    }
    let lobes: BTreeSet<_> =
        scene.materials.iter().filter_map(|m| m.lobes.as_ref()).flat_map(|lobes| lobes.present()).collect();
    if !lobes.is_empty() {
        let lobes: Vec<_> = lobes.into_iter().collect();
        scene
            .notices
            .push(format!("lobes that the real-time frame does not shade yet: {}", lobes.join(", ")));
    }
    Ok(())
}

impl Uses<'_> {
    fn material(&mut self, m: &material::Material, at: &str) -> Result<Material, SceneError> {
        let pbr = &m.pbr_metallic_roughness;
        let default = Material::default();
        let mut out = Material {
            name: m.name.clone().unwrap_or_else(|| at.to_string()),
            base_color: Vec4::from_array(pbr.base_color_factor.0),
            base_color_texture: self.info(&pbr.base_color_texture, true, at)?,
            metallic: pbr.metallic_factor.0,
            roughness: pbr.roughness_factor.0,
            metallic_roughness_texture: self.info(&pbr.metallic_roughness_texture, false, at)?,
            emissive: Vec3::from_array(m.emissive_factor.0),
            emissive_texture: self.info(&m.emissive_texture, true, at)?,
            alpha_mode: match m.alpha_mode {
                Checked::Valid(JsonAlpha::Opaque) => AlphaMode::Opaque,
                Checked::Valid(JsonAlpha::Mask) => {
                    AlphaMode::Mask { cutoff: m.alpha_cutoff.map_or(0.5, |c| c.0) }
                }
                Checked::Valid(JsonAlpha::Blend) => AlphaMode::Blend,
                Checked::Invalid => {
                    return Err(self.document.invalid(format!("{at}.alphaMode"), "unknown mode"));
                }
            },
            double_sided: m.double_sided,
            ..default
        };
        (out.normal_texture, out.normal_scale) = self.normal(&m.normal_texture, at)?;
        self.occlusion |= m.occlusion_texture.is_some();
        if let Some(extensions) = &m.extensions {
            material_extensions::apply(self, &mut out, extensions, at)?;
        }
        Ok(out)
    }

    /// A normal map with its scale.
    pub(super) fn normal(
        &mut self,
        normal: &Option<material::NormalTexture>,
        at: &str,
    ) -> Result<(Option<TextureRef>, f32), SceneError> {
        let Some(normal) = normal else { return Ok((None, 1.0)) };
        let others = normal.extensions.as_ref().map(|e| &e.others);
        let transform = others.and_then(|others| others.get("KHR_texture_transform"));
        let transform = transform
            .map(|value| serde_json::from_value(value.clone()))
            .transpose()
            .map_err(|e| self.document.invalid(format!("{at}.normalTexture.extensions"), e))?;
        let texture = self.reference(normal.index, normal.tex_coord, transform.as_ref(), false, at)?;
        Ok((texture, normal.scale))
    }

    /// A texture for colour (`srgb`) or data.
    pub(super) fn info(
        &mut self,
        info: &Option<texture::Info>,
        srgb: bool,
        at: &str,
    ) -> Result<Option<TextureRef>, SceneError> {
        let Some(info) = info else { return Ok(None) };
        let transform = info.extensions.as_ref().and_then(|e| e.texture_transform.as_ref());
        self.reference(info.index, info.tex_coord, transform, srgb, at)
    }

    fn reference(
        &mut self,
        index: Index<texture::Texture>,
        tex_coord: u32,
        transform: Option<&extensions::texture::TextureTransform>,
        srgb: bool,
        at: &str,
    ) -> Result<Option<TextureRef>, SceneError> {
        let texture = self.document.get(index, at)?;
        let at = format!("textures[{}]", index.value());
        if self.document.root.get(texture.source).is_none() && texture.extensions.is_some() {
            self.notices
                .push(format!("{at}: its image needs an extension that is not supported; texture left out"));
            return Ok(None);
        }
        self.document.get(texture.source, &format!("{at}.source"))?;
        if let Some(sampler) = texture.sampler {
            self.document.get(sampler, &format!("{at}.sampler"))?;
        }
        let uv_set = transform.and_then(|t| t.tex_coord).unwrap_or(tex_coord);
        if uv_set > 1 {
            self.notices
                .push(format!("{at}: texture coordinate set {uv_set} is not supported; texture left out"));
            return Ok(None);
        }
        let key = Use { image: texture.source.value(), sampler: texture.sampler.map(|s| s.value()), srgb };
        let texture = *self.known.entry(key).or_insert_with(|| {
            self.in_order.push(key);
            self.in_order.len() as u32 - 1
        });
        Ok(Some(TextureRef { texture, uv_set, transform: transform.map_or(Affine2::IDENTITY, affine) }))
    }
}

/// KHR_texture_transform: scale, then rotation (counter-clockwise as seen with v down), then offset.
fn affine(t: &extensions::texture::TextureTransform) -> Affine2 {
    let matrix2 = Mat2::from_angle(-t.rotation.0) * Mat2::from_diagonal(Vec2::from_array(t.scale.0));
    Affine2 { matrix2, translation: Vec2::from_array(t.offset.0) }
}

fn decode(document: &Document, u: Use) -> Result<Texture, SceneError> {
    let at = format!("images[{}]", u.image);
    let image = &document.root.images[u.image];
    let bytes = match (&image.uri, image.buffer_view) {
        (Some(uri), _) => document.fetch(uri, &at)?,
        (None, Some(view)) => document.view(view, &at)?.0.to_vec(),
        (None, None) => return Err(document.invalid(at, "has neither a uri nor a bufferView")),
    };
    let label = label(image, &at);
    let pixels = pixels(&bytes).map_err(|what| document.invalid(&at, format!("{label}: {what}")))?;
    Ok(Texture {
        name: label,
        width: pixels.width(),
        height: pixels.height(),
        texels: pixels.into_raw(),
        srgb: u.srgb,
        sampler: sampler(u.sampler.and_then(|s| document.root.samplers.get(s))),
    })
}

fn label(image: &Image, at: &str) -> String {
    let uri = image.uri.as_ref().filter(|uri| !uri.starts_with("data:"));
    one_line(image.name.as_ref().or(uri).map_or(at, |name| name))
}

fn pixels(bytes: &[u8]) -> Result<image::RgbaImage, String> {
    let mut reader =
        image::ImageReader::new(Cursor::new(bytes)).with_guessed_format().map_err(|e| e.to_string())?;
    match reader.format() {
        Some(image::ImageFormat::Png | image::ImageFormat::Jpeg) => {}
        Some(other) => return Err(format!("{other:?} images are not supported, only PNG and JPEG")),
        None => return Err("is neither a PNG nor a JPEG image".into()),
    }
    let mut limits = image::Limits::default();
    limits.max_image_width = Some(MAX_TEXTURE_SIDE);
    limits.max_image_height = Some(MAX_TEXTURE_SIDE);
    limits.max_alloc = Some(2 << 30);
    reader.limits(limits);
    Ok(reader.decode().map_err(|e| e.to_string())?.into_rgba8())
}

fn sampler(sampler: Option<&texture::Sampler>) -> Sampler {
    let wrap = |mode| match mode {
        Checked::Valid(WrappingMode::ClampToEdge) => Wrap::ClampToEdge,
        Checked::Valid(WrappingMode::MirroredRepeat) => Wrap::MirroredRepeat,
        Checked::Valid(WrappingMode::Repeat) | Checked::Invalid => Wrap::Repeat,
    };
    let Some(s) = sampler else { return Sampler::default() };
    Sampler {
        wrap_u: wrap(s.wrap_s),
        wrap_v: wrap(s.wrap_t),
        mag: match s.mag_filter {
            Some(Checked::Valid(MagFilter::Nearest)) => Filter::Nearest,
            _ => Filter::Linear,
        },
        min: match s.min_filter {
            Some(Checked::Valid(
                MinFilter::Nearest | MinFilter::NearestMipmapNearest | MinFilter::NearestMipmapLinear,
            )) => Filter::Nearest,
            _ => Filter::Linear,
        },
    }
}
