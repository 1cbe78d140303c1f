//! Every knob of the frame as one tree: what `--set`, profiles and studies address.

use anyhow::{Context, Result};
use pt_core::settings::{InvalidValue, Validate, apply_profile, apply_sets, apply_toml};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Parameters of all stages; a key is `stage.name`, the stage named after its crate.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct FrameParams {
    /// Primary rays, mirrors and glass.
    pub gbuffer: pt_gbuffer::GbufferParams,
    /// Direct lighting.
    pub lights: pt_lights::DirectParams,
    /// Composite.
    pub denoise: pt_denoise::DenoiseParams,
    /// Interleave.
    pub checkerboard: pt_checkerboard::CheckerboardParams,
    /// Exposure, tone mapping and what an EXR holds.
    pub post: pt_post::PostParams,
}

impl Validate for FrameParams {
    fn validate(&self) -> Result<(), InvalidValue> {
        self.gbuffer.validate().map_err(|e| e.within("gbuffer"))?;
        self.lights.validate().map_err(|e| e.within("lights"))?;
        self.denoise.validate().map_err(|e| e.within("denoise"))?;
        self.checkerboard.validate().map_err(|e| e.within("checkerboard"))?;
        self.post.validate().map_err(|e| e.within("post"))
    }
}

/// Built-in profiles: name, what for, TOML.
pub const PROFILES: &[(&str, &str, &str)] = &[
    ("default", "what every knob says by itself", ""),
    (
        "still",
        "pictures averaged over frames: the fields swap, so that no pixel of glass borrows from its neighbours",
        "[gbuffer]\nalternate_fields = true\n[checkerboard]\nblend_split = false\n",
    ),
    (
        "realtime",
        "temporal anti-aliasing: one Halton offset a frame, no lens",
        "[gbuffer]\njitter = \"halton\"\ndepth_of_field = false\n[post.taa]\nenabled = true\n",
    ),
    (
        "q2rtx",
        "post-processing in the manner of Quake II RTX: temporal anti-aliasing, bloom, noise-aware tone curve",
        r#"
[gbuffer]
jitter = "halton"
depth_of_field = false
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
];

/// Parameters from a profile (name or file), then single assignments.
///
/// # Errors
/// An unknown profile, key or value, with the closest known one.
pub fn resolve(profile: Option<&str>, sets: &[String]) -> Result<FrameParams> {
    let mut params = FrameParams::default();
    if let Some(profile) = profile {
        if let Some((.., text)) = PROFILES.iter().find(|(name, ..)| *name == profile) {
            apply_toml(&mut params, text).with_context(|| format!("profile {profile}"))?;
        } else if Path::new(profile).exists() {
            apply_profile(&mut params, Path::new(profile))?;
        } else {
            let names: Vec<_> = PROFILES.iter().map(|(name, ..)| *name).collect();
            anyhow::bail!(
                "profile {profile}: no such file, and the built-in profiles are {}",
                names.join(", ")
            );
        }
    }
    apply_sets(&mut params, sets)?;
    Ok(params)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn profiles_are_valid_and_sets_come_last() {
        for (name, ..) in PROFILES {
            resolve(Some(name), &[]).unwrap();
        }
        let sets = ["gbuffer.jitter=none".to_owned()];
        assert_eq!(resolve(Some("realtime"), &sets).unwrap().gbuffer.jitter, pt_gbuffer::Jitter::None);
        let error = resolve(None, &["gbufer.jitter=none".into()]).unwrap_err().to_string();
        assert!(error.contains("gbuffer"), "{error}");
        assert!(resolve(Some("no-such-profile"), &[]).is_err());
    }
}
