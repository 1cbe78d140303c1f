use glam::{Affine3A, Vec3};

use crate::LightMotion;

/// Shape of a punctual light (KHR_lights_punctual).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightKind {
    /// Shines equally into all directions; intensity in candela.
    Point,
    /// A cone; intensity in candela on the axis. Half angles in radians, 0 <= inner < outer <= pi/2.
    Spot {
        /// Where the angular attenuation starts.
        inner: f32,
        /// Where it reaches zero.
        outer: f32,
    },
    /// Parallel light; intensity in lux on a surface facing it.
    Directional,
}

/// A light that is not a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    /// Name from the file, for messages.
    pub name: String,
    /// Tells which light it is when lights appear and vanish from frame to frame. Lights with the same id (0 unless set otherwise) are
    /// told apart by their order: enough as long as their number stays.
    pub id: u32,
    /// Shape.
    pub kind: LightKind,
    /// Colour x intensity, linear, in candela (point, spot) or lux (directional), used one to one with radiance:
    /// 1 cd at distance d over a Lambertian plane gives radiance albedo/pi x cos/d^2.
    pub intensity: Vec3,
    /// World position; unused by directional lights.
    pub position: Vec3,
    /// Unit direction in which the light shines; unused by point lights.
    pub direction: Vec3,
    /// Radius of the sphere that stands for a point or spot light, metres; 0: a true point.
    pub radius: f32,
    /// Half the angle under which a directional light is seen, radians; 0: exactly parallel light.
    pub angular_radius: f32,
    /// How it moves and blinks; [`Light::at`] evaluates it.
    pub motion: Option<LightMotion>,
    /// Node of [`crate::Scene::rig`] that carries it, if it moves.
    pub node: Option<u32>,
}

/// Direction in which a light shines that a node carries (KHR_lights_punctual).
pub fn shines(world_from_node: &Affine3A) -> Vec3 {
    world_from_node.transform_vector3(Vec3::NEG_Z).normalize_or(Vec3::NEG_Z)
}

impl Light {
    /// A point light of `intensity` candela.
    pub fn point(name: &str, position: Vec3, intensity: Vec3) -> Self {
        Self {
            name: name.into(),
            id: 0,
            kind: LightKind::Point,
            intensity,
            position,
            direction: Vec3::NEG_Y,
            radius: 0.0,
            angular_radius: 0.0,
            motion: None,
            node: None,
        }
    }

    /// The light at `time` seconds; itself when it neither moves nor blinks.
    pub fn at(&self, time: f64) -> Self {
        let mut light = self.clone();
        if let Some(motion) = &self.motion {
            let world_from_light = motion.path.at(time);
            light.position = world_from_light.translation.into();
            light.direction = shines(&world_from_light);
            light.intensity = motion.peak * motion.blink.at(time);
        }
        light
    }

    /// Whether it is seen in the sky as a disc.
    pub fn is_disc(&self) -> bool {
        self.kind == LightKind::Directional && self.angular_radius > 0.0
    }

    /// The same light with a motion, as it is at time 0.
    pub fn moving(self, motion: LightMotion) -> Self {
        Self { motion: Some(motion), ..self }.at(0.0)
    }

    /// Parallel light of `intensity` lux that shines along `direction`.
    pub fn directional(name: &str, direction: Vec3, intensity: Vec3) -> Self {
        Self {
            kind: LightKind::Directional,
            direction: direction.normalize_or(Vec3::NEG_Y),
            ..Self::point(name, Vec3::ZERO, intensity)
        }
    }

    /// A cone of light of `intensity` candela on its axis.
    pub fn spot(
        name: &str,
        position: Vec3,
        direction: Vec3,
        inner: f32,
        outer: f32,
        intensity: Vec3,
    ) -> Self {
        Self {
            kind: LightKind::Spot { inner, outer },
            direction: direction.normalize_or(Vec3::NEG_Y),
            ..Self::point(name, position, intensity)
        }
    }
}
