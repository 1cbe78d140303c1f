//! All knobs: one tree for the frame, one for the reference. `--set` and profiles address them by key.

use anyhow::{Context, Result, anyhow, bail, ensure};
use pt_core::knobs;
use pt_core::settings::{Knob, Knobs, SettingsError, apply_profile, apply_sets, apply_toml, close_to};
use pt_denoise::Denoiser;
use pt_post::{BloomMode, Upscale};
use pt_shaders::channels::OtherFormats;
use pt_shaders::records::Background;
use serde_json::Value;
use std::path::Path;

knobs! {
    /// Parameters of all stages of the frame; a key is `stage.name`, the stage named after its crate.
    pub struct FrameParams {
        /// Primary rays, mirrors and glass.
        pub gbuffer: pt_gbuffer::GbufferParams;
        /// Direct lighting.
        pub lights: pt_lights::DirectParams;
        /// Indirect lighting.
        pub indirect: pt_indirect::IndirectParams;
        /// Denoiser and composite.
        pub denoise: pt_denoise::DenoiseParams;
        /// Interleave.
        pub checkerboard: pt_checkerboard::CheckerboardParams;
        /// Exposure, tone mapping and what an EXR holds.
        pub post: pt_post::PostParams;
    }
}

impl FrameParams {
    /// Whether the frame has gradient pixels.
    pub fn has_gradient_pixels(&self) -> bool {
        self.denoise.variant == Denoiser::Asvgf
    }

    /// The formats of images that are not those of their tables.
    pub(crate) fn formats(&self) -> impl Iterator<Item = &'static OtherFormats> + use<> {
        self.gbuffer.format.others().into_iter().chain(self.denoise.histories.others())
    }

    /// The value of each knob, in their order, as `--set` takes it.
    pub fn knob_values(&self) -> Vec<String> {
        let tree = serde_json::to_value(self).unwrap_or_default();
        let leaf = |key: &str| key.split('.').try_fold(&tree, |node, name| node.get(name)).cloned();
        let text = |value: Value| match value {
            Value::Null => "none".to_owned(),
            Value::String(text) => text,
            // Of an f32, which JSON widens.
            Value::Number(number) if number.is_f64() => {
                (number.as_f64().unwrap_or_default() as f32).to_string()
            }
            other => other.to_string(),
        };
        Self::knobs().iter().map(|knob| text(leaf(&knob.key).unwrap_or_default())).collect()
    }

    /// The medium of the frame as the reference has it.
    pub fn medium(&self) -> pt_reference::MediumParams {
        let pt_gbuffer::GodraysParams { density, albedo, anisotropy, max_distance, .. } =
            self.gbuffer.godrays;
        pt_reference::MediumParams { density, albedo, anisotropy, max_distance }
    }

    /// The knobs of direct lighting; gradient pixels take their light samples again.
    pub fn direct(&self) -> pt_lights::DirectParams {
        let replay = self.lights.replay || self.has_gradient_pixels();
        pt_lights::DirectParams { replay, ..self.lights.clone() }
    }
}

knobs! {
    /// Parameters of `pt reference`, as a tree of one stage.
    pub struct ReferenceSettings {
        /// The reference path tracer.
        pub reference: pt_reference::ReferenceParams;
    }
}

/// All knobs: those of the frame in the order of its stages, then those of the reference.
pub fn all_knobs() -> Vec<Knob> {
    [FrameParams::knobs(), ReferenceSettings::knobs()].concat()
}

/// Name, purpose and TOML text of a built-in profile.
type Profile = (&'static str, &'static str, &'static str);

/// Built-in profiles of the frame.
pub const PROFILES: &[Profile] = &[
    ("default", "what every knob says by itself", ""),
    (
        "still",
        "pictures averaged over frames: the fields swap, so that no pixel of glass borrows from its neighbours",
        "[gbuffer]\nalternate_fields = true\n[denoise]\nvariant = \"off\"\n[checkerboard]\nblend_split = false\n",
    ),
    (
        "realtime",
        "temporal anti-aliasing after the denoiser: one Halton offset a frame, no lens; bright tiles of indirect diffuse light are limited",
        r#"
[gbuffer]
jitter = "halton"
depth_of_field = false
replaced_motion = "search"
[denoise.lf]
iterations = 4
deflicker = 4.0
[post.taa]
enabled = true
"#,
    ),
    (
        "q2rtx",
        "in the manner of Quake II RTX: shading of partial metals, bounce rays, temporal anti-aliasing, bloom, noise-aware tone curve",
        r#"
[gbuffer]
jitter = "halton"
depth_of_field = false
thin_refraction = "double"
[lights]
partial_metal = "mixed-parameters"
[indirect]
bounces = 1.0
hemisphere = "uniform"
lobe_choice = "half"
emission_share = "crossover"
ndf_trim = 0.9
specular_fade = 0.2
anti_flicker = 0.8
sun_range = 50.0
[post]
tonemap = "noise-aware"
centre_weight = 1.0
[post.taa]
enabled = true
blend_linear = false
blend_still = 0.1
temporal = 0.0
anti_sparkle = 0.25
pq_scale = 128.0
[post.bloom]
mode = "gaussian"
[post.fsr]
sharpness = 0.2
"#,
    ),
    (
        "unbiased",
        "for comparison with the reference, averaged over frames: ten mirrors or panes in a row, textures at their finest level, no light straight through glass that bends it, no trims and no clamps",
        "[gbuffer]\nalternate_fields = true\nreflect_refract = 10\ntexture_lod_bias = -8.0\n[lights]\nglass_shadows = \"straight\"\n[denoise]\nvariant = \"off\"\n[checkerboard]\nblend_split = false\n[indirect]\ntexture_spread = 0.0\n",
    ),
    ("half-res-gi", "indirect diffuse light at every other row alone", "[indirect]\nbounces = 0.5\n"),
];

/// Parameters of the frame from a profile (name or file), then single assignments. `accumulate`: frames are averaged. The mean of noise has no
/// need of a denoiser, whose blur would stay, so that none is the default then; a profile or an assignment may still ask for one.
///
/// # Errors
/// An unknown profile, key or value, with the closest known one.
pub fn resolve(profile: Option<&str>, sets: &[String], accumulate: bool) -> Result<FrameParams> {
    let mut params = FrameParams::default();
    if accumulate {
        params.denoise.variant = Denoiser::Off;
    }
    layer(params, PROFILES, profile, sets)
}

/// Checks that the stages of a whole frame can do together what the parameters say. `accumulate`: frames are averaged.
///
/// # Errors
/// What to change.
pub fn check_frame(params: &FrameParams, accumulate: bool) -> Result<()> {
    ensure!(
        !(accumulate && params.post.upscale == Upscale::Taau),
        "averaged frames have the picture's own size; post.upscale is taau, choose none or fsr1"
    );
    check_background(params, accumulate)?;
    check_denoiser(params)
}

/// The knobs that differ from their defaults, as `--set` takes them.
pub fn assignments(params: &FrameParams) -> Vec<String> {
    differences(&FrameParams::default(), params)
}

/// The knobs of `params` that differ from those of `base`, as `--set` takes them.
pub fn differences(base: &FrameParams, params: &FrameParams) -> Vec<String> {
    let values = base.knob_values().into_iter().zip(params.knob_values());
    let knobs = FrameParams::knobs().into_iter().zip(values);
    knobs.filter(|(_, (was, is))| was != is).map(|(knob, (_, is))| format!("{}={is}", knob.key)).collect()
}

/// Checks that nothing after the interleave would lose the alpha of a transparent background.
///
/// # Errors
/// What to switch off.
pub fn check_background(params: &FrameParams, accumulate: bool) -> Result<()> {
    let post = &params.post;
    if params.denoise.background != Background::Transparent {
        return Ok(());
    }
    let problem = if post.uses_taa() && !accumulate {
        "temporal anti-aliasing keeps no alpha; use --accumulate, or --set post.taa.enabled=false"
    } else if post.uses_fsr() {
        "upscaling and sharpening keep no alpha; use --upscale none and --set post.fsr.sharpen=false"
    } else if post.bloom.mode != BloomMode::Off {
        "bloom spreads light over the background; use --bloom=off"
    } else if post.encoding.is_hdr() {
        "HDR pictures have no alpha; use --set post.encoding=srgb"
    } else {
        return Ok(());
    };
    bail!("background transparent: {problem}")
}

/// Parameters of the reference from a profile (a file), then single assignments, over `base`.
///
/// # Errors
/// As [`resolve`].
pub fn resolve_reference(
    base: ReferenceSettings,
    profile: Option<&str>,
    sets: &[String],
) -> Result<ReferenceSettings> {
    layer(base, &PROFILES[..1], profile, sets)
}

/// Names the command that has a knob, where this one does not.
fn of_other_command(error: SettingsError) -> anyhow::Error {
    let unknown: &SettingsError = match &error {
        SettingsError::Profile { error, .. } => error.as_ref(),
        error => error,
    };
    let SettingsError::UnknownKey { key, .. } = unknown else { return error.into() };
    if !all_knobs().iter().any(|knob| knob.key == *key) {
        return error.into();
    }
    let [has, takes] = match key.starts_with("reference.") {
        true => ["pt reference", "those of the frame's stages"],
        false => ["pt render and pt capture", "those of reference"],
    };
    anyhow!("{key} is a knob of {has}; this command takes {takes} (pt knobs lists them)")
}

/// Checks that all passes can be made, before a scene is loaded.
///
/// # Errors
/// A denoiser that is no pass of a frame.
pub fn check_denoiser(params: &FrameParams) -> Result<()> {
    ensure!(
        params.denoise.variant != Denoiser::Oidn,
        "denoise.variant=oidn is no pass of a frame; record frames with pt capture and run pt-denoise DIR --variant oidn"
    );
    Ok(())
}

/// Checks that a frame has one plane, for what reads the images of one.
///
/// # Errors
/// Several planes, with the knob to set. `what` reads them.
pub fn check_one_plane(params: &FrameParams, scene: &pt_scene::Scene, what: &str) -> Result<()> {
    let planes = pt_gbuffer::plane_count(scene, &params.gbuffer);
    ensure!(
        planes == 1,
        "{what}: this frame has {planes} planes, each with images of its own, and {what} knows one; use --set gbuffer.decomposition=replacement"
    );
    Ok(())
}

fn layer<T: Knobs>(mut params: T, built_in: &[Profile], profile: Option<&str>, sets: &[String]) -> Result<T> {
    if let Some(profile) = profile {
        if let Some((.., text)) = built_in.iter().find(|(name, ..)| *name == profile) {
            apply_toml(&mut params, text).with_context(|| format!("profile {profile}"))?;
        } else if Path::new(profile).exists() {
            apply_profile(&mut params, Path::new(profile)).map_err(of_other_command)?;
        } else {
            let names: Vec<_> = built_in.iter().map(|(name, ..)| *name).collect();
            let hint = close_to(profile, names.iter().copied());
            bail!("profile {profile}: no such file{hint} (the built-in profiles are {})", names.join(", "));
        }
    }
    apply_sets(&mut params, sets).map_err(of_other_command)?;
    Ok(params)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn assignments_say_all_that_a_profile_sets() {
        for (name, ..) in PROFILES {
            let sets = [
                "denoise.temporal.firefly=none".to_owned(),
                "lights.sun=false".into(),
                "denoise.lf.deflicker=2.7".into(),
            ];
            let params = resolve(Some(name), &sets, false).unwrap();
            assert_eq!(resolve(None, &assignments(&params), false).unwrap(), params, "{name}");
        }
        assert!(assignments(&FrameParams::default()).is_empty());
    }

    #[test]
    fn profiles_are_valid_and_sets_come_last() {
        for (name, ..) in PROFILES {
            resolve(Some(name), &[], false).unwrap();
        }
        let sets = ["gbuffer.jitter=none".to_owned()];
        assert_eq!(resolve(Some("realtime"), &sets, false).unwrap().gbuffer.jitter, pt_gbuffer::Jitter::None);
        let error = resolve(None, &["gbufer.jitter=none".into()], false).unwrap_err().to_string();
        assert!(error.contains("gbuffer"), "{error}");
        assert!(resolve(Some("no-such-profile"), &[], false).is_err());
    }
}
