//! The content of a scene as text.

use super::stats::{ExtensionStats, SceneStats};
use anyhow::Result;
use pt_light_sampling::LightPower;
use pt_shaders::glam::Vec3;
use std::io::Write;

impl SceneStats {
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
