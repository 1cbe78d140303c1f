//! Kinds of surfaces: names for sets of material values. What draws a surface reads the values alone.

use crate::{AlphaMode, Material, Shows};
use glam::{Vec3, Vec4Swizzles};
use pt_shaders::named_enum;

named_enum! {
    /// Kind of a surface, which [`Material::with_kind`] gives to a material.
    pub enum MaterialKind {
        /// The material as it is.
        Regular = "regular",
        /// A smooth metal: a mirror of its base colour.
        Chrome = "chrome",
        /// The same on a body that moves: what it mirrors has the motion of the body.
        ChromeModel = "chrome-model",
        /// Smooth glass of its base colour: a thin sheet, or a solid if it has a thickness.
        Glass = "glass",
        /// The surface of water, with waves: a solid with an index of refraction of 1.33.
        Water = "water",
        /// The surface of a murky liquid, with waves: a solid with an index of refraction of 1.34.
        Slime = "slime",
        /// A rough surface that emits light of its base colour.
        Lava = "lava",
        /// A hole through which the environment is seen.
        Sky = "sky",
        /// Not there for any ray.
        Invisible = "invisible",
        /// Emits light of its base colour on both sides; alpha is coverage.
        Explosion = "explosion",
        /// Alpha is coverage; both sides are seen.
        TransparentWall = "transparent-wall",
        /// Alpha is coverage.
        TransparentModel = "transparent-model",
        /// Emits light of its base colour behind a smooth clear coat.
        Screen = "screen",
        /// Shows what a camera of the scene sees.
        Camera = "camera",
    }
}

/// Extinction per metre of water and of slime: 20 times what Quake II RTX has per unit of length, 1/40 m, at its density of 0.5.
const WATER_EXTINCTION: Vec3 = Vec3::new(0.7, 0.26, 0.24);
const SLIME_EXTINCTION: Vec3 = Vec3::new(4.0, 0.2, 1.0);

/// Radiance of lava and of explosions of white base colour.
const LAVA_RADIANCE: f32 = 5.0;
const EXPLOSION_RADIANCE: f32 = 10.0;

impl Material {
    /// The material as a surface of the kind. Values that the kind says nothing about stay. A material that emits light already keeps its
    /// emission where the kind would give it one, and a liquid its attenuation. [`MaterialKind::Camera`] shows the first camera of the
    /// scene; set [`Material::shows`] for another.
    pub fn with_kind(self, kind: MaterialKind) -> Self {
        match kind {
            MaterialKind::Regular => self,
            MaterialKind::Chrome => self.mirror(),
            MaterialKind::ChromeModel => Self { own_motion: true, ..self.mirror() },
            MaterialKind::Glass => self.clear(),
            MaterialKind::Water => self.liquid(1.33, WATER_EXTINCTION),
            MaterialKind::Slime => self.liquid(1.34, SLIME_EXTINCTION),
            MaterialKind::Lava => Self { roughness: 1.0, ..self.glowing(LAVA_RADIANCE).smooth() },
            MaterialKind::Sky => Self { shows: Shows::Environment, emissive: Vec3::ZERO, ..self.black() },
            MaterialKind::Invisible => self.absent(),
            MaterialKind::Explosion => Self {
                alpha_mode: AlphaMode::Blend,
                double_sided: true,
                ..self.glowing(EXPLOSION_RADIANCE).black()
            },
            MaterialKind::TransparentWall => {
                Self { alpha_mode: AlphaMode::Blend, double_sided: true, ..self }
            }
            MaterialKind::TransparentModel => Self { alpha_mode: AlphaMode::Blend, ..self },
            MaterialKind::Screen => {
                Self { roughness: 0.0, specular: 1.0, specular_color: Vec3::ONE, ..self.glowing(1.0).black() }
            }
            MaterialKind::Camera => Self { shows: Shows::Camera(0), emissive: Vec3::ZERO, ..self.black() },
        }
    }

    /// An opaque dielectric that is perfectly smooth, without the lobes of extensions.
    fn smooth(self) -> Self {
        Self {
            metallic: 0.0,
            roughness: 0.0,
            metallic_roughness_texture: None,
            alpha_mode: AlphaMode::Opaque,
            unlit: false,
            transmission: 0.0,
            transmission_texture: None,
            lobes: None,
            ..self
        }
    }

    fn mirror(self) -> Self {
        Self { metallic: 1.0, ..self.smooth() }
    }

    fn clear(self) -> Self {
        Self { transmission: 1.0, ..self.smooth() }
    }

    fn liquid(self, ior: f32, extinction: Vec3) -> Self {
        let (attenuation_color, attenuation_distance) = match self.attenuation_distance.is_finite() {
            true => (self.attenuation_color, self.attenuation_distance),
            false => ((-extinction).exp(), 1.0),
        };
        Self {
            base_color: Vec3::ONE.extend(1.0),
            base_color_texture: None,
            normal_texture: None,
            thickness: 1.0,
            ior,
            attenuation_color,
            attenuation_distance,
            waves: Some(self.waves.unwrap_or_default()),
            ..self.clear()
        }
    }

    /// Emits `radiance` times the base colour, unless it emits light already.
    fn glowing(self, radiance: f32) -> Self {
        if self.is_emissive() {
            return self;
        }
        let emissive = radiance * self.base_color.xyz();
        Self { emissive, emissive_texture: self.base_color_texture, ..self }
    }

    /// Reflects nothing. The alpha stays.
    fn black(self) -> Self {
        let base_color = Vec3::ZERO.extend(self.base_color.w);
        Self { base_color, roughness: 1.0, specular: 0.0, specular_texture: None, ..self.smooth() }
    }

    /// Its coverage is 0 everywhere.
    fn absent(self) -> Self {
        Self {
            alpha_mode: AlphaMode::Mask { cutoff: 1.0 },
            base_color: Vec3::ONE.extend(0.0),
            emissive: Vec3::ZERO,
            ..self.smooth()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{TextureRef, Waves};

    /// A material that no kind leaves as it is.
    fn plain() -> Material {
        Material {
            metallic: 0.5,
            roughness: 0.5,
            base_color: Vec3::new(0.2, 0.4, 0.8).extend(0.6),
            base_color_texture: Some(TextureRef::new(0)),
            ..Material::default()
        }
    }

    fn of(kind: MaterialKind) -> Material {
        plain().with_kind(kind)
    }

    /// One row for each kind, with the values that make it what it is.
    #[test]
    fn every_kind_has_its_values() {
        type Holds = fn(&Material) -> bool;
        let color = Vec3::new(0.2, 0.4, 0.8);
        assert_eq!(plain().base_color.xyz(), color);
        let rows: [(MaterialKind, Holds); MaterialKind::ALL.len()] = [
            (MaterialKind::Regular, |m| *m == plain()),
            (MaterialKind::Chrome, |m| (m.metallic, m.roughness, m.own_motion) == (1.0, 0.0, false)),
            (MaterialKind::ChromeModel, |m| (m.metallic, m.roughness, m.own_motion) == (1.0, 0.0, true)),
            (MaterialKind::Glass, |m| m.transmits() && !m.is_solid() && m.roughness == 0.0 && m.ior == 1.5),
            (MaterialKind::Water, |m| m.is_solid() && m.ior == 1.33 && m.waves == Some(Waves::default())),
            (MaterialKind::Slime, |m| m.is_solid() && m.ior == 1.34 && m.waves == Some(Waves::default())),
            (MaterialKind::Lava, |m| m.emissive == 5.0 * plain().base_color.xyz() && m.roughness == 1.0),
            (MaterialKind::Sky, |m| m.shows == Shows::Environment && !m.is_emissive()),
            (MaterialKind::Invisible, |m| {
                m.base_color.w < 1.0 && matches!(m.alpha_mode, AlphaMode::Mask { cutoff } if cutoff == 1.0)
            }),
            (MaterialKind::Explosion, |m| {
                m.alpha_mode == AlphaMode::Blend
                    && m.emissive == 10.0 * plain().base_color.xyz()
                    && m.base_color.w == 0.6
            }),
            (MaterialKind::TransparentWall, |m| m.alpha_mode == AlphaMode::Blend && m.double_sided),
            (MaterialKind::TransparentModel, |m| m.alpha_mode == AlphaMode::Blend && !m.double_sided),
            (MaterialKind::Screen, |m| {
                m.emissive == plain().base_color.xyz()
                    && m.base_color.xyz() == Vec3::ZERO
                    && m.roughness == 0.0
                    && m.specular == 1.0
            }),
            (MaterialKind::Camera, |m| m.shows == Shows::Camera(0) && m.base_color.xyz() == Vec3::ZERO),
        ];
        for (kind, (row, holds)) in MaterialKind::ALL.into_iter().zip(rows) {
            assert_eq!(kind, row, "the rows stand in the order of the kinds");
            assert!(holds(&of(kind)), "{}: {:?}", kind.name(), of(kind));
        }
    }

    #[test]
    fn no_two_kinds_are_the_same() {
        for (i, a) in MaterialKind::ALL.into_iter().enumerate() {
            for b in MaterialKind::ALL.into_iter().skip(i + 1) {
                assert_ne!(of(a), of(b), "{} and {}", a.name(), b.name());
            }
        }
    }

    #[test]
    fn what_a_file_says_of_emission_and_attenuation_stays() {
        let lamp = Material { emissive: Vec3::X, ..plain() };
        assert_eq!(lamp.clone().with_kind(MaterialKind::Screen).emissive, Vec3::X);
        let tea = Material { attenuation_color: Vec3::Y, attenuation_distance: 0.1, ..plain() };
        let tea = tea.with_kind(MaterialKind::Water);
        assert_eq!((tea.attenuation_color, tea.attenuation_distance), (Vec3::Y, 0.1));
        let water = of(MaterialKind::Water);
        assert!(
            (water.attenuation_color.x - (-0.7f32).exp()).abs() < 1e-6 && water.attenuation_distance == 1.0
        );
    }
}
