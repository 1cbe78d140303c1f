//! Limits on how bright a scene is.

use crate::{MAX_RADIANCE, Scene};
use glam::Vec3;

impl Scene {
    /// Limits emission and lights to [`MAX_RADIANCE`], so that all renderers show the same, with a notice for each that was brighter.
    pub fn limit_radiance(&mut self) {
        let is_bright = |v: Vec3| v.max_element() > MAX_RADIANCE;
        let bound = |v: Vec3| v.min(Vec3::splat(MAX_RADIANCE));
        for material in self.materials.iter_mut().filter(|m| is_bright(m.emissive)) {
            let what = format!("material {:?}: emission limited to {MAX_RADIANCE:e}", material.name);
            self.notices.push(what);
            material.emissive = bound(material.emissive);
        }
        for light in self.lights.iter_mut().filter(|l| is_bright(l.intensity)) {
            self.notices.push(format!("light {:?}: intensity limited to {MAX_RADIANCE:e}", light.name));
            light.intensity = bound(light.intensity);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Light, Material};

    #[test]
    fn only_what_is_too_bright_is_limited() {
        let mut scene = Scene::default();
        let colors = [Vec3::new(1e30, 1e14, f32::INFINITY), Vec3::splat(1e14)];
        scene.materials = colors.map(|c| Material::lamp("lamp", c)).into();
        scene.lights = colors.map(|c| Light::point("bulb", Vec3::ZERO, c)).into();
        scene.limit_radiance();
        assert_eq!(scene.materials[0].emissive, Vec3::new(1e15, 1e14, 1e15));
        assert_eq!(scene.lights[0].intensity, Vec3::new(1e15, 1e14, 1e15));
        assert_eq!((scene.materials[1].emissive, scene.lights[1].intensity), (colors[1], colors[1]));
        assert_eq!(scene.notices.len(), 2, "{:?}", scene.notices);
    }
}
