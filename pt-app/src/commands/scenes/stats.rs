//! `pt scenes --stats` prints the content of a scene, as text or as JSON. The names of the JSON fields are stable.

use std::collections::BTreeMap;

use pt_gbuffer::{GbufferParams, hidden_lobes};
use pt_import::support;
use pt_light_sampling::{LightPower, light_powers};
use pt_scene::{AlphaMode, Clusters, Material, Projection, Scene, Shows, Support, Texels, Texture};
use serde::Serialize;

/// Everything that `pt scenes --stats` says about a scene.
#[derive(Clone, Debug, Serialize)]
pub struct SceneStats {
    /// File name or name of the built-in scene.
    pub scene: String,
    /// Of all lengths.
    pub unit: &'static str,
    /// Smallest and largest corner of everything, where it is at time 0; absent without a triangle.
    pub bounds: Option<[[f32; 3]; 2]>,
    /// Shapes in memory.
    pub meshes: usize,
    /// Placed shapes.
    pub instances: usize,
    /// Of these, moving ones.
    pub moving_instances: usize,
    /// Counts of triangles.
    pub triangles: Triangles,
    /// Number of materials.
    pub materials: usize,
    /// Number of materials by kind; one can be of several.
    pub material_kinds: BTreeMap<&'static str, usize>,
    /// Textures.
    pub textures: Textures,
    /// Lights, strongest first: punctual ones, one entry for each instance with emissive triangles, the environment.
    pub lights: Vec<LightPower>,
    /// Cameras.
    pub cameras: Vec<CameraStats>,
    /// Animations.
    pub animations: Vec<AnimationStats>,
    /// Names of the scenes in the file.
    pub file_scenes: Vec<String>,
    /// Names of the material variants in the file.
    pub variants: Vec<String>,
    /// Extensions that the file names.
    pub extensions: Vec<ExtensionStats>,
    /// The division into clusters.
    pub clusters: ClusterStats,
    /// What the importer left out or changed, and what the real-time frame leaves out.
    pub notices: Vec<String>,
}

/// Counts of triangles.
#[derive(Clone, Debug, Serialize)]
pub struct Triangles {
    /// In memory.
    pub stored: usize,
    /// Once per instance.
    pub instanced: usize,
    /// Of `instanced`, emitting ones.
    pub emissive: usize,
    /// Of `instanced`, masked or blended ones.
    pub masked: usize,
}

/// Textures of a scene.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Textures {
    /// How many.
    pub count: usize,
    /// How many of each format: RGBA8, RGBA16 (16 bits per channel) or a block format, with " sRGB" where colours are sRGB-encoded.
    pub formats: BTreeMap<String, usize>,
    /// Texels as they are held on the host, bytes.
    pub host_bytes: u64,
    /// On the device with all mip levels, bytes.
    pub gpu_bytes: u64,
}

/// A camera.
#[derive(Clone, Debug, Serialize)]
pub struct CameraStats {
    /// Name.
    pub name: String,
    /// perspective or orthographic.
    pub projection: &'static str,
    /// At time 0.
    pub position: [f32; 3],
    /// Unit direction of view at time 0.
    pub forward: [f32; 3],
    /// Seconds of its path; 0 without one.
    pub path_s: f64,
}

/// An animation of the file.
#[derive(Clone, Debug, Serialize)]
pub struct AnimationStats {
    /// Name; may be empty.
    pub name: String,
    /// Seconds.
    pub duration_s: f64,
    /// Properties of nodes that it moves.
    pub channels: usize,
    /// Whether it plays unless another is asked for.
    pub plays: bool,
}

/// An extension that a file names.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct ExtensionStats {
    /// As in `extensionsUsed`.
    pub name: String,
    /// Also in `extensionsRequired`.
    pub required: bool,
    /// supported, ignored (the scene is shown without it) or refused (so is the file).
    pub status: &'static str,
}

impl ExtensionStats {
    /// What becomes of an extension.
    pub fn of(name: &str, required: bool) -> Self {
        let status = match (support(name), required) {
            (Support::Supported, _) => "supported",
            (Support::Refused, true) => "refused",
            (Support::Ignored, _) | (Support::Refused, false) => "ignored",
        };
        Self { name: name.into(), required, status }
    }
}

/// The division into clusters.
#[derive(Clone, Debug, Serialize)]
pub struct ClusterStats {
    /// How many.
    pub count: usize,
    /// Of these, with a surface in them.
    pub occupied: usize,
    /// Triangles per occupied cluster: smallest, median, largest.
    pub triangles: [usize; 3],
    /// Longest edge of the bounds of the surfaces in an occupied cluster, metres: smallest, median, largest.
    pub cell_size_m: [f32; 3],
    /// Numbers of clusters with up to so many triangles: (triangles, clusters).
    pub histogram: Vec<(usize, usize)>,
}

impl SceneStats {
    /// Looks through a scene and divides it into `clusters`.
    pub fn of(scene: &Scene, clusters: usize) -> Self {
        let s = scene.statistics();
        let clusters = Clusters::new(scene, clusters).statistics(scene);
        Self {
            scene: scene.name.clone(),
            unit: "metre",
            bounds: scene.bounds().map(|b| [b.min.to_array(), b.max.to_array()]),
            meshes: scene.meshes.len(),
            instances: scene.instances.len(),
            moving_instances: scene
                .instances
                .iter()
                .filter(|i| !i.is_static(&scene.meshes[i.mesh as usize]))
                .count(),
            triangles: Triangles {
                stored: s.triangles,
                instanced: s.instanced_triangles,
                emissive: s.emissive_triangles,
                masked: s.masked_triangles,
            },
            materials: scene.materials.len(),
            material_kinds: material_kinds(&scene.materials),
            textures: textures(&scene.textures),
            lights: light_powers(scene),
            cameras: scene
                .cameras
                .iter()
                .map(|c| CameraStats {
                    name: c.name.clone(),
                    projection: match c.projection {
                        Projection::Perspective { .. } => "perspective",
                        Projection::Orthographic { .. } => "orthographic",
                    },
                    position: c.position().to_array(),
                    forward: c.forward().to_array(),
                    path_s: c.path.as_ref().map_or(0.0, pt_scene::CameraPath::duration),
                })
                .collect(),
            animations: scene
                .animations
                .iter()
                .map(|a| AnimationStats {
                    name: a.name.clone(),
                    duration_s: a.duration,
                    channels: a.channels,
                    plays: a.plays,
                })
                .collect(),
            file_scenes: scene.scenes.clone(),
            variants: scene.variants.clone(),
            extensions: scene.extensions.iter().map(|e| ExtensionStats::of(&e.name, e.required)).collect(),
            clusters: ClusterStats {
                count: clusters.count,
                occupied: clusters.occupied,
                triangles: clusters.triangles,
                cell_size_m: clusters.cell_size,
                histogram: clusters.histogram,
            },
            notices: scene
                .notices
                .iter()
                .cloned()
                .chain(hidden_lobes(scene, &GbufferParams::default()))
                .collect(),
        }
    }
}

fn material_kinds(materials: &[Material]) -> BTreeMap<&'static str, usize> {
    let mut kinds = BTreeMap::new();
    for m in materials {
        let transmits = m.transmission > 0.0;
        let own = [
            ("metallic", m.metallic > 0.5),
            ("emissive", m.is_emissive()),
            ("mask", matches!(m.alpha_mode, AlphaMode::Mask { .. })),
            ("blend", m.alpha_mode == AlphaMode::Blend),
            ("double-sided", m.double_sided),
            ("unlit", m.unlit),
            ("thin transmission", transmits && m.thickness == 0.0),
            ("solid transmission", transmits && m.thickness > 0.0),
            ("absorbing", transmits && m.attenuation_distance.is_finite()),
            ("normal-mapped", m.normal_texture.is_some()),
            ("waves", m.waves.is_some()),
            ("sky", m.shows == Shows::Environment),
            ("camera view", matches!(m.shows, Shows::Camera(_))),
        ];
        let lobes = m.lobes.iter().flat_map(|lobes| lobes.present());
        for kind in own.into_iter().filter_map(|(kind, is)| is.then_some(kind)).chain(lobes) {
            *kinds.entry(kind).or_insert(0) += 1;
        }
    }
    kinds
}

fn textures(textures: &[Texture]) -> Textures {
    let mut sum = Textures { count: textures.len(), ..Textures::default() };
    for t in textures {
        let (format, gpu_bytes) = match &t.texels {
            Texels::Rgba8(_) => ("RGBA8".into(), t.uncompressed_bytes()),
            Texels::Rgba16(_) => ("RGBA16".into(), t.uncompressed_bytes()),
            Texels::Blocks { format, .. } => (format!("{format:?}").to_uppercase(), t.bytes() as u64),
        };
        let encoding = if t.usage.is_srgb() { " sRGB" } else { "" };
        *sum.formats.entry(format + encoding).or_insert(0) += 1;
        sum.host_bytes += t.bytes() as u64;
        sum.gpu_bytes += gpu_bytes;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use pt_scene::builtin;

    fn stats(name: &str) -> SceneStats {
        SceneStats::of(&builtin(name).unwrap(), 64)
    }

    #[test]
    fn counts_are_those_of_the_scene() {
        let s = stats("kinds");
        for kind in
            ["unlit", "clearcoat", "sheen", "anisotropy", "iridescence", "dispersion", "sky", "camera view"]
        {
            assert_eq!(s.material_kinds.get(kind), Some(&1), "{kind}");
        }
        let several = ["solid transmission", "absorbing", "waves", "mask", "blend"];
        assert_eq!(several.map(|kind| s.material_kinds[kind]), [7, 3, 2, 2, 4]);
        assert_eq!((s.textures.count, s.textures.formats.get("RGBA8 sRGB")), (2, Some(&2)));
        assert_eq!(s.textures.host_bytes, 4 * (128 * 128 + 256 * 256));
        let chain = |n: u64| -> u64 { (0..=n.ilog2()).map(|l| 4 * (n >> l) * (n >> l)).sum() };
        assert_eq!(s.textures.gpu_bytes, chain(128) + chain(256));
        assert_eq!(s.clusters.count, 64);
        let mut text = Vec::new();
        s.print(&mut text).unwrap();
        let text = String::from_utf8(text).unwrap();
        for word in ["kinds", "clearcoat", "sun", "camera", "clusters", "64"] {
            assert!(text.contains(word), "no {word} in\n{text}");
        }
    }

    #[test]
    fn textures_of_16_bits_count_twice() {
        use pt_scene::TextureUsage::{Color, Normal};
        let texture = |usage| Texture::rgba16("wide", [2, 2], usage, vec![7; 16]);
        let sum = textures(&[texture(Color), texture(Normal)]);
        assert_eq!((sum.formats["RGBA16 sRGB"], sum.formats["RGBA16"]), (1, 1));
        // 2x2 and 1x1 texels of four and of two channels.
        assert_eq!((sum.host_bytes, sum.gpu_bytes), (2 * 32, 5 * 8 + 5 * 4));
    }
}
