//! `pt scenes --stats`: what is in a scene, as text or as JSON. The names of the JSON fields are stable.
//!
//! Powers are radiant fluxes in watts, with spectra weighted to one number by Rec. 709 luminance and KHR_lights_punctual
//! intensities taken one to one with radiance:
//!
//! | light | power |
//! |---|---|
//! | emissive triangles | pi x area x mean radiance, for each side that emits |
//! | point, intensity I | 4 pi I |
//! | spot, intensity I | 2 pi I ((1 - cos inner) + (cos inner - cos outer) / 3): the integral of the squared linear falloff |
//! | directional, illuminance E | pi r^2 E, what falls on the scene's bounding sphere of radius r |
//! | environment, mean radiance L | 4 pi^2 r^2 L, what falls on that sphere from all sides |

use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::io::Write;

use anyhow::Result;
use pt_lights::{LightLists, luminance};
use pt_import::support;
use pt_scene::{AlphaMode, Clusters, Environment, Light, LightKind, Material, Projection, Scene, Support, Texels, Texture};
use pt_shaders::glam::Vec3;
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
    /// What the loader left out or changed.
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
    /// How many of each format: RGBA8 or a block format, with " sRGB" where colours are sRGB-encoded.
    pub formats: BTreeMap<String, usize>,
    /// Texels as they are held on the host, bytes.
    pub host_bytes: u64,
    /// On the device with all mip levels, bytes.
    pub gpu_bytes: u64,
}

/// A light and its power.
#[derive(Clone, Debug, Serialize)]
pub struct LightPower {
    /// point, spot, directional, emissive or environment.
    pub kind: &'static str,
    /// Name from the file.
    pub name: String,
    /// Luminance of the intensity (candela), illuminance (lux), or mean radiance.
    pub strength: f64,
    /// Emitting triangles; 0 for lights that are none.
    pub triangles: usize,
    /// Watts.
    pub power_w: f64,
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
            lights: lights(scene),
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
            notices: scene.notices.clone(),
        }
    }

    /// Writes it for people.
    ///
    /// # Errors
    /// A stream that cannot be written.
    pub fn print(&self, out: &mut impl Write) -> Result<()> {
        let mut line = |what: &str, text: String| writeln!(out, "{what:12} {text}");
        line("scene", self.scene.clone())?;
        match self.bounds {
            Some([min, max]) => {
                let size = Vec3::from(max) - Vec3::from(min);
                line(
                    "bounds",
                    format!("{min:?} .. {max:?}, {:.4} x {:.4} x {:.4} m", size.x, size.y, size.z),
                )?;
            }
            None => line("bounds", "none: no triangle".into())?,
        }
        let t = &self.triangles;
        line(
            "triangles",
            format!("{} stored in {} meshes, {} with instances", t.stored, self.meshes, t.instanced),
        )?;
        line("", format!("{} emissive, {} masked or blended", t.emissive, t.masked))?;
        line("instances", format!("{}, {} moving", self.instances, self.moving_instances))?;
        let kinds: Vec<_> = self.material_kinds.iter().map(|(kind, n)| format!("{n} {kind}")).collect();
        line("materials", format!("{}: {}", self.materials, kinds.join(", ")))?;
        let x = &self.textures;
        let mib = |bytes: u64| bytes as f64 / f64::from(1 << 20);
        let formats: Vec<_> = x.formats.iter().map(|(format, n)| format!("{n} {format}")).collect();
        let bytes =
            format!("{:.1} MiB on the host, {:.1} MiB on the device", mib(x.host_bytes), mib(x.gpu_bytes));
        line("textures", format!("{}: {}; {bytes}", x.count, formats.join(", ")))?;
        const SHOWN: usize = 16;
        for light in self.lights.iter().take(SHOWN) {
            let unit = match light.kind {
                "point" | "spot" => "cd",
                "directional" => "lux",
                _ => "W/(sr m^2)",
            };
            let many =
                if light.triangles > 0 { format!(", {} triangles", light.triangles) } else { String::new() };
            let name = if light.name.is_empty() { String::new() } else { format!(" {}", light.name) };
            let LightPower { kind, strength, power_w, .. } = light;
            line("light", format!("{kind}{name}: {strength:.4} {unit}, {power_w:.4} W{many}"))?;
        }
        if self.lights.len() > SHOWN {
            let rest: f64 = self.lights[SHOWN..].iter().map(|l| l.power_w).sum();
            line("", format!("and {} weaker ones, together {rest:.4} W", self.lights.len() - SHOWN))?;
        }
        for c in &self.cameras {
            let [p, f] = [c.position, c.forward].map(|v| format!("({:.3}, {:.3}, {:.3})", v[0], v[1], v[2]));
            let path = if c.path_s > 0.0 { format!(", path of {} s", c.path_s) } else { String::new() };
            line("camera", format!("{}: {} at {p}, looks along {f}{path}", c.name, c.projection))?;
        }
        for a in &self.animations {
            let rests = if a.plays { "" } else { ", does not play" };
            line("animation", format!("{}: {:.3} s, {} channels{rests}", a.name, a.duration_s, a.channels))?;
        }
        for (what, names) in [("scenes", &self.file_scenes), ("variants", &self.variants)] {
            if names.len() > usize::from(what == "scenes") {
                line(what, names.join(", "))?;
            }
        }
        for e in &self.extensions {
            line("extension", extension_line(e))?;
        }
        let c = &self.clusters;
        line("clusters", format!("{}, {} with surfaces", c.count, c.occupied))?;
        let [least, median, most] = c.triangles;
        line("", format!("triangles in one: {least} to {most}, median {median}"))?;
        let [least, median, most] = c.cell_size_m;
        line("", format!("longest edge: {least:.3} to {most:.3} m, median {median:.3} m"))?;
        let bars: Vec<_> = c.histogram.iter().map(|(n, count)| format!("<={n}: {count}")).collect();
        line("", format!("by triangles: {}", bars.join("  ")))?;
        for notice in &self.notices {
            line("notice", notice.clone())?;
        }
        Ok(())
    }
}

/// One line about an extension.
pub fn extension_line(e: &ExtensionStats) -> String {
    format!("{}: {}{}", e.name, e.status, if e.required { ", required" } else { "" })
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
            Texels::Blocks { format, .. } => (format!("{format:?}").to_uppercase(), t.bytes() as u64),
        };
        let encoding = if t.usage.is_srgb() { " sRGB" } else { "" };
        *sum.formats.entry(format + encoding).or_insert(0) += 1;
        sum.host_bytes += t.bytes() as u64;
        sum.gpu_bytes += gpu_bytes;
    }
    sum
}

fn lights(scene: &Scene) -> Vec<LightPower> {
    let radius = scene.bounds().map_or(0.0, |b| 0.5 * f64::from(b.size().length()));
    let mut lights: Vec<LightPower> = scene.lights.iter().map(|light| punctual(light, radius)).collect();
    let mut by_instance: BTreeMap<u32, LightPower> = BTreeMap::new();
    for t in LightLists::new(scene).emissives {
        let instance = &scene.instances[t.instance as usize];
        let mesh = &scene.meshes[instance.mesh as usize];
        let material = &scene.materials[mesh.triangle_materials[t.triangle as usize] as usize];
        let entry = by_instance.entry(t.instance).or_insert_with(|| LightPower {
            kind: "emissive",
            name: instance.name.clone(),
            strength: 0.0,
            triangles: 0,
            power_w: 0.0,
        });
        entry.triangles += 1;
        let sides = if material.double_sided { 2.0 } else { 1.0 };
        entry.power_w += PI * t.weight * sides;
        // The emitting area for now.
        let corners = mesh.triangle(t.triangle as usize);
        let [a, b, c] = corners.map(|p| instance.world_from_object.transform_point3(p).as_dvec3());
        entry.strength += sides * 0.5 * (b - a).cross(c - a).length();
    }
    lights.extend(by_instance.into_values().map(|mut light| {
        light.strength = light.power_w / (PI * light.strength);
        light
    }));
    if !scene.environment.is_black() {
        let mean = mean_radiance(&scene.environment);
        lights.push(LightPower {
            kind: "environment",
            name: String::new(),
            strength: mean,
            triangles: 0,
            power_w: 4.0 * (PI * radius).powi(2) * mean,
        });
    }
    lights.sort_by(|a, b| b.power_w.total_cmp(&a.power_w));
    lights
}

fn punctual(light: &Light, radius: f64) -> LightPower {
    let strength = luminance(light.intensity);
    let (kind, power) = match light.kind {
        LightKind::Point => ("point", 4.0 * PI),
        LightKind::Spot { inner, outer } => {
            let (inner, outer) = (f64::from(inner).cos(), f64::from(outer).cos());
            ("spot", 2.0 * PI * ((1.0 - inner) + (inner - outer) / 3.0))
        }
        LightKind::Directional => ("directional", PI * radius * radius),
    };
    LightPower { kind, name: light.name.clone(), strength, triangles: 0, power_w: power * strength }
}

/// Mean over the sphere.
fn mean_radiance(environment: &Environment) -> f64 {
    let (width, height) = (environment.image.width as usize, environment.image.height as usize);
    let (mut sum, mut weights) = (0.0, 0.0);
    for (y, row) in environment.image.texels.chunks_exact(width).enumerate() {
        let weight = (PI * y as f64 / height as f64).cos() - (PI * (y + 1) as f64 / height as f64).cos();
        sum += weight * row.iter().map(|&t| luminance(t)).sum::<f64>() / width as f64;
        weights += weight;
    }
    sum / weights * f64::from(environment.intensity)
}

#[cfg(test)]
mod tests {
    use super::*;
    use pt_scene::builtin;
    use std::f32::consts::FRAC_PI_2;

    fn stats(name: &str) -> SceneStats {
        SceneStats::of(&builtin(name).unwrap(), 64)
    }

    fn light<'a>(stats: &'a SceneStats, kind: &str) -> &'a LightPower {
        stats.lights.iter().find(|l| l.kind == kind).unwrap()
    }

    #[test]
    fn powers_by_their_formulas() {
        let close = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 1e-3, "{a} for {b}");
        close(light(&stats("plane"), "point").power_w, 400.0 * PI);
        // The lamp of the Cornell box: 0.13 m x 0.105 m.
        let cornell = stats("cornell");
        let lamp = light(&cornell, "emissive");
        let radiance = luminance(Vec3::new(17.0, 12.0, 4.0));
        close(lamp.strength, radiance);
        close(lamp.power_w, PI * 0.13 * 0.105 * radiance);
        // All four lamps have 40 W in each channel.
        let veach = stats("veach");
        assert_eq!(veach.lights.len(), 4);
        veach.lights.iter().for_each(|l| close(l.power_w, 40.0));
        // Radiance 1 from everywhere: pi of irradiance on the whole sphere.
        let furnace = stats("furnace");
        let [min, max] = furnace.bounds.unwrap().map(Vec3::from);
        let radius = 0.5 * f64::from((max - min).length());
        close(light(&furnace, "environment").strength, 1.0);
        close(light(&furnace, "environment").power_w, PI * 4.0 * PI * radius * radius);
        // A hemisphere of even light is half a point light.
        let cone = Light::spot("s", Vec3::ZERO, Vec3::Y, FRAC_PI_2 - 1e-6, FRAC_PI_2, Vec3::ONE);
        close(punctual(&cone, 1.0).power_w, 2.0 * PI);
    }

    #[test]
    fn double_sided_lamps_count_twice() {
        let mut scene = builtin("cornell").unwrap();
        let once = SceneStats::of(&scene, 8);
        scene.materials.iter_mut().filter(|m| m.is_emissive()).for_each(|m| m.double_sided = true);
        let twice = SceneStats::of(&scene, 8);
        let [once, twice] = [&once, &twice].map(|s| light(s, "emissive"));
        assert!(
            (twice.power_w / once.power_w - 2.0).abs() < 1e-9
                && (twice.strength / once.strength - 1.0).abs() < 1e-9
        );
    }

    #[test]
    fn counts_are_those_of_the_scene() {
        let s = stats("kinds");
        for kind in
            ["mask", "blend", "unlit", "clearcoat", "sheen", "anisotropy", "iridescence", "dispersion"]
        {
            assert_eq!(s.material_kinds.get(kind), Some(&1), "{kind}");
        }
        assert!(s.material_kinds["solid transmission"] == 4 && s.material_kinds["absorbing"] == 1);
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
}
