//! How many planes a frame has.

use crate::{Decomposition, GbufferParams};
use pt_scene::{Material, Scene};

/// Planes of a frame of the scene: 1 without glass, 3 where some of the glass has a diffuse base, else 2. With
/// [`Decomposition::Replacement`] there is 1.
///
/// Plane 0 follows reflection at the first glass of a path, plane 1 transmission, plane 2 the diffuse base. Textures can only lower transmission.
pub fn plane_count(scene: &Scene, params: &GbufferParams) -> u32 {
    if params.decomposition == Decomposition::Replacement || params.reflect_refract == 0 {
        return 1;
    }
    let mut glass = scene.materials.iter().filter(|m| m.transmission > 0.0 && !m.unlit).peekable();
    let has_base = |m: &Material| m.transmission < 1.0 || m.transmission_texture.is_some();
    match (glass.peek().is_some(), glass.any(has_base)) {
        (false, _) => 1,
        (true, false) => 2,
        (true, true) => 3,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planes_are_those_of_the_lobes_that_the_scene_has() {
        let planes = GbufferParams { decomposition: Decomposition::Planes, ..Default::default() };
        let count = |materials: Vec<Material>, params: &GbufferParams| {
            plane_count(&Scene { materials, ..Scene::default() }, params)
        };
        let glass = Material::solid("glass", 1.5);
        let milk = Material { transmission: 0.5, ..glass.clone() };
        let wall = Material::diffuse("wall", glam::Vec3::ONE);
        assert_eq!(count(vec![wall.clone()], &planes), 1);
        assert_eq!(count(vec![wall.clone(), glass.clone()], &planes), 2);
        assert_eq!(count(vec![milk.clone(), glass.clone()], &planes), 3);
        assert_eq!(count(vec![Material { unlit: true, ..glass.clone() }], &planes), 1);
        assert_eq!(count(vec![milk.clone()], &GbufferParams::default()), 1);
        assert_eq!(count(vec![milk], &GbufferParams { reflect_refract: 0, ..planes }), 1);
    }
}
