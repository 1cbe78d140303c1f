use crate::{Shows, Waves};
use glam::{Affine2, Vec3, Vec4};
use std::collections::BTreeMap;

/// Largest radiance and intensity, per channel. Squares of it, which variances are made of, are finite in fp32.
pub const MAX_RADIANCE: f32 = 1e15;

/// How alpha (base colour factor x texture x vertex colour) acts on visibility.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum AlphaMode {
    /// Alpha is ignored.
    #[default]
    Opaque,
    /// Present where alpha >= `cutoff`, absent elsewhere.
    Mask {
        /// Threshold, 0..1.
        cutoff: f32,
    },
    /// Alpha is coverage, 0..1.
    Blend,
}

/// Use of a texture by a material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextureRef {
    /// Index into [`crate::Scene::textures`].
    pub texture: u32,
    /// 0 for [`crate::Mesh::uv0`], 1 for [`crate::Mesh::uv1`].
    pub uv_set: u32,
    /// KHR_texture_transform: texture coordinate = `transform` x mesh coordinate.
    pub transform: Affine2,
}

impl TextureRef {
    /// The texture with coordinates `uv0`, not transformed.
    pub fn new(texture: u32) -> Self {
        Self { texture, uv_set: 0, transform: Affine2::IDENTITY }
    }
}

/// Lobes of KHR extensions over and in the base layer. Every texture multiplies the factor beside it; a factor of 0
/// means that the lobe is absent.
#[derive(Clone, Debug, PartialEq)]
pub struct Lobes {
    /// KHR_materials_clearcoat: strength of the coat, 0..1; texture channel R.
    pub clearcoat: f32,
    /// Linear.
    pub clearcoat_texture: Option<TextureRef>,
    /// Perceptual roughness of the coat, 0..1; texture channel G.
    pub clearcoat_roughness: f32,
    /// Linear.
    pub clearcoat_roughness_texture: Option<TextureRef>,
    /// Tangent-space normal map of the coat, linear; without it the coat follows the geometry.
    pub clearcoat_normal_texture: Option<TextureRef>,
    /// Scale of the coat's normal map in x and y.
    pub clearcoat_normal_scale: f32,
    /// KHR_materials_sheen: colour, linear, 0..1.
    pub sheen_color: Vec3,
    /// sRGB.
    pub sheen_color_texture: Option<TextureRef>,
    /// Perceptual roughness of the sheen, 0..1; texture channel A.
    pub sheen_roughness: f32,
    /// Linear alpha.
    pub sheen_roughness_texture: Option<TextureRef>,
    /// KHR_materials_anisotropy: strength, 0..1; texture channel B.
    pub anisotropy_strength: f32,
    /// Radians from the tangent towards the bitangent; adds to the texture's direction in R and G.
    pub anisotropy_rotation: f32,
    /// Linear.
    pub anisotropy_texture: Option<TextureRef>,
    /// KHR_materials_iridescence: strength, 0..1; texture channel R.
    pub iridescence: f32,
    /// Linear.
    pub iridescence_texture: Option<TextureRef>,
    /// Index of refraction of the thin film, >= 1.
    pub iridescence_ior: f32,
    /// Thickness of the film where the texture is 0, nanometres.
    pub iridescence_thickness_min: f32,
    /// Thickness of the film where the texture is 1 or absent, nanometres.
    pub iridescence_thickness_max: f32,
    /// Linear, channel G.
    pub iridescence_thickness_texture: Option<TextureRef>,
    /// KHR_materials_dispersion: 20 / Abbe number, >= 0.
    pub dispersion: f32,
}

impl Default for Lobes {
    /// All lobes absent, other values as the extensions set them by default.
    fn default() -> Self {
        Self {
            clearcoat: 0.0,
            clearcoat_texture: None,
            clearcoat_roughness: 0.0,
            clearcoat_roughness_texture: None,
            clearcoat_normal_texture: None,
            clearcoat_normal_scale: 1.0,
            sheen_color: Vec3::ZERO,
            sheen_color_texture: None,
            sheen_roughness: 0.0,
            sheen_roughness_texture: None,
            anisotropy_strength: 0.0,
            anisotropy_rotation: 0.0,
            anisotropy_texture: None,
            iridescence: 0.0,
            iridescence_texture: None,
            iridescence_ior: 1.3,
            iridescence_thickness_min: 100.0,
            iridescence_thickness_max: 400.0,
            iridescence_thickness_texture: None,
            dispersion: 0.0,
        }
    }
}

impl Lobes {
    /// The lobes that are there, by the names of their extensions without `KHR_materials_`.
    pub fn present(&self) -> impl Iterator<Item = &'static str> {
        [
            ("clearcoat", self.clearcoat > 0.0),
            ("sheen", self.sheen_color != Vec3::ZERO),
            ("anisotropy", self.anisotropy_strength > 0.0),
            ("iridescence", self.iridescence > 0.0),
            ("dispersion", self.dispersion > 0.0),
        ]
        .into_iter()
        .filter_map(|(name, there)| there.then_some(name))
    }

    fn textures(&self) -> [(&'static str, Option<TextureRef>); 8] {
        [
            ("clearcoat_texture", self.clearcoat_texture),
            ("clearcoat_roughness_texture", self.clearcoat_roughness_texture),
            ("clearcoat_normal_texture", self.clearcoat_normal_texture),
            ("sheen_color_texture", self.sheen_color_texture),
            ("sheen_roughness_texture", self.sheen_roughness_texture),
            ("anisotropy_texture", self.anisotropy_texture),
            ("iridescence_texture", self.iridescence_texture),
            ("iridescence_thickness_texture", self.iridescence_thickness_texture),
        ]
    }
}

/// A surface, in the terms of glTF 2.0 metallic-roughness and its KHR extensions. Every texture multiplies the
/// factor beside it.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Name from the file, for messages.
    pub name: String,
    /// Linear base colour and alpha.
    pub base_color: Vec4,
    /// sRGB colour, linear alpha.
    pub base_color_texture: Option<TextureRef>,
    /// 0 dielectric .. 1 metal; texture channel B.
    pub metallic: f32,
    /// Perceptual roughness 0..1 (GGX alpha is its square); texture channel G.
    pub roughness: f32,
    /// Roughness in G, metallic in B, linear.
    pub metallic_roughness_texture: Option<TextureRef>,
    /// Tangent-space normal map, linear.
    pub normal_texture: Option<TextureRef>,
    /// Scale of the normal map's x and y.
    pub normal_scale: f32,
    /// Emitted radiance (factor x strength), linear. Leaves the front face, and the back face when `double_sided`.
    pub emissive: Vec3,
    /// sRGB factor on `emissive`.
    pub emissive_texture: Option<TextureRef>,
    /// What alpha means.
    pub alpha_mode: AlphaMode,
    /// Shaded, and emitting, on both faces.
    pub double_sided: bool,
    /// Seen by the camera with its base colour, not lit (KHR_materials_unlit).
    pub unlit: bool,
    /// Share of the light that passes into the dielectric base instead of being diffused, 0..1.
    pub transmission: f32,
    /// Linear, channel R.
    pub transmission_texture: Option<TextureRef>,
    /// Index of refraction, >= 1.
    pub ior: f32,
    /// 0: a thin sheet that does not bend light. Above: the mesh bounds a solid (metres; only > 0 matters here).
    pub thickness: f32,
    /// Linear, channel G. What traces rays takes the thickness from the geometry.
    pub thickness_texture: Option<TextureRef>,
    /// Transmittance after `attenuation_distance` inside the solid, linear.
    pub attenuation_color: Vec3,
    /// Metres; infinite means a clear medium.
    pub attenuation_distance: f32,
    /// Strength of the dielectric specular lobe (KHR_materials_specular), 0..1.
    pub specular: f32,
    /// Linear, channel A.
    pub specular_texture: Option<TextureRef>,
    /// F0 tint of the dielectric specular lobe, linear.
    pub specular_color: Vec3,
    /// sRGB.
    pub specular_color_texture: Option<TextureRef>,
    /// Lobes of further extensions; `None` when there are none.
    pub lobes: Option<Box<Lobes>>,
    /// Which solid is there where several overlap: the one of the highest priority, 0..=[`MAX_PRIORITY`] (Schmidt and Budge
    /// 2002, "Simple Nested Dielectrics in Ray Traced Images"). Among equal
    /// priorities the higher `ior` wins, then the lower material index. glTF has no such property: files have 0 everywhere,
    /// so that a glass wall wins over the liquid that reaches into it.
    pub priority: u32,
    /// For a surface that is the interface of two solids at once: the material whose `ior` and attenuation hold on its front
    /// side; its own hold behind it, as ever. Crossing it leaves the one solid and enters the other. `None`: in front is
    /// air, or whatever solid the point is in anyhow. Not in glTF.
    pub exterior: Option<u32>,
    /// What rays find at the surface.
    pub shows: Shows,
    /// Waves that bend its normals, in place of a normal map.
    pub waves: Option<Waves>,
    /// What is seen in a flat mirror of this material has the motion vector of the mirror, not that of the mirror image.
    pub own_motion: bool,
}

/// Largest [`Material::priority`]; the GPU record has 8 bits for it.
pub const MAX_PRIORITY: u32 = 255;

impl Default for Material {
    /// The glTF default material: white, metallic 1, roughness 1.
    fn default() -> Self {
        Self {
            name: String::new(),
            base_color: Vec4::ONE,
            base_color_texture: None,
            metallic: 1.0,
            roughness: 1.0,
            metallic_roughness_texture: None,
            normal_texture: None,
            normal_scale: 1.0,
            emissive: Vec3::ZERO,
            emissive_texture: None,
            alpha_mode: AlphaMode::Opaque,
            double_sided: false,
            unlit: false,
            transmission: 0.0,
            transmission_texture: None,
            ior: 1.5,
            thickness: 0.0,
            thickness_texture: None,
            attenuation_color: Vec3::ONE,
            attenuation_distance: f32::INFINITY,
            specular: 1.0,
            specular_texture: None,
            specular_color: Vec3::ONE,
            specular_color_texture: None,
            lobes: None,
            priority: 0,
            exterior: None,
            shows: Shows::Itself,
            waves: None,
            own_motion: false,
        }
    }
}

impl Material {
    /// A rough dielectric of the given linear colour.
    pub fn diffuse(name: &str, color: Vec3) -> Self {
        Self { name: name.into(), base_color: color.extend(1.0), metallic: 0.0, ..Self::default() }
    }

    /// A pure Lambertian surface: no specular lobe at all.
    pub fn lambertian(name: &str, albedo: Vec3) -> Self {
        Self { specular: 0.0, ..Self::diffuse(name, albedo) }
    }

    /// A metal with the given normal-incidence reflectance.
    pub fn metal(name: &str, f0: Vec3, roughness: f32) -> Self {
        Self { name: name.into(), base_color: f0.extend(1.0), roughness, ..Self::default() }
    }

    /// A single-sided lamp: emits `radiance`, reflects nothing.
    pub fn lamp(name: &str, radiance: Vec3) -> Self {
        Self { emissive: radiance, ..Self::lambertian(name, Vec3::ZERO) }
    }

    /// A smooth, clear solid that bends and lets through all light.
    pub fn solid(name: &str, ior: f32) -> Self {
        Self { roughness: 0.0, transmission: 1.0, thickness: 1.0, ior, ..Self::diffuse(name, Vec3::ONE) }
    }

    /// Whether triangles of this material emit light.
    pub fn is_emissive(&self) -> bool {
        self.emissive.max_element() > 0.0
    }

    /// Whether light passes through (KHR_materials_transmission).
    pub fn transmits(&self) -> bool {
        self.transmission > 0.0 && self.metallic < 1.0
    }

    /// Whether its surfaces bound a solid (KHR_materials_volume).
    pub fn is_solid(&self) -> bool {
        self.transmission > 0.0 && self.thickness > 0.0
    }

    /// Whether visibility has to look at alpha: MASK and BLEND.
    pub fn is_masked(&self) -> bool {
        self.alpha_mode != AlphaMode::Opaque
    }

    /// The textures in use, with the names of their slots.
    pub fn textures(&self) -> impl Iterator<Item = (&'static str, TextureRef)> {
        [
            ("base_color_texture", self.base_color_texture),
            ("metallic_roughness_texture", self.metallic_roughness_texture),
            ("normal_texture", self.normal_texture),
            ("emissive_texture", self.emissive_texture),
            ("transmission_texture", self.transmission_texture),
            ("thickness_texture", self.thickness_texture),
            ("specular_texture", self.specular_texture),
            ("specular_color_texture", self.specular_color_texture),
        ]
        .into_iter()
        .chain(self.lobes.iter().flat_map(|lobes| lobes.textures()))
        .filter_map(|(slot, texture)| texture.map(|t| (slot, t)))
    }
}

/// For each material the first one with the same medium behind its surfaces: one solid may be bounded by several materials
/// (walls that are wet in part, say).
pub fn media(materials: &[Material]) -> Vec<u32> {
    let mut first = BTreeMap::new();
    let number = |(i, m): (usize, &Material)| {
        let color = m.attenuation_color.to_array().map(f32::to_bits);
        let medium = (m.priority, m.ior.to_bits(), color, m.attenuation_distance.to_bits());
        *first.entry(medium).or_insert(i as u32)
    };
    materials.iter().enumerate().map(number).collect()
}
