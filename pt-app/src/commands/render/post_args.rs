//! Options of `pt render` for what happens to the frame after it is traced. Each is short for knobs of `--set`, which come
//! after them.

use clap::Args;
use pt_post::PRESETS;

/// Short names of post-processing knobs.
#[derive(Clone, Debug, Default, Args)]
pub struct PostArgs {
    /// How a smaller frame becomes the picture; taau also asks for one sub-pixel offset a frame (gbuffer.jitter=halton).
    #[arg(long, value_name = "HOW", value_parser = ["none", "taau", "fsr1"], help_heading = "Picture")]
    pub upscale: Option<String>,
    /// Sides of the frame over those of the picture, 0.25 to 1, or a preset: ultra-quality, quality, balanced, performance.
    #[arg(long, value_name = "X|PRESET", value_parser = render_scale, help_heading = "Picture")]
    pub render_scale: Option<f32>,
    /// Tone curve.
    #[arg(
        long,
        value_name = "CURVE",
        value_parser = ["aces", "aces-hill", "agx", "neutral", "noise-aware", "reinhard", "none"],
        help_heading = "Picture"
    )]
    pub tonemap: Option<String>,
    /// Exposure value at ISO 100; manual exposure, unless --exposure says otherwise.
    #[arg(long, value_name = "EV100", allow_hyphen_values = true, help_heading = "Picture")]
    pub ev: Option<f32>,
    /// How the exposure is found.
    #[arg(long, value_name = "HOW", value_parser = ["auto", "manual", "camera"], help_heading = "Picture")]
    pub exposure: Option<String>,
    /// Bloom; gaussian when no kind is given.
    #[arg(
        long,
        value_name = "KIND",
        value_parser = ["off", "gaussian", "chain"],
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = "gaussian",
        help_heading = "Picture"
    )]
    pub bloom: Option<String>,
}

impl PostArgs {
    /// The same as assignments.
    pub fn sets(&self) -> Vec<String> {
        let mut sets = Vec::new();
        if let Some(upscale) = &self.upscale {
            sets.push(format!("post.upscale={upscale}"));
            if upscale == "taau" {
                sets.push("gbuffer.jitter=halton".into());
            }
        }
        if let Some(scale) = self.render_scale {
            sets.push(format!("post.render_scale={scale}"));
        }
        if let Some(curve) = &self.tonemap {
            sets.push(format!("post.tonemap={curve}"));
        }
        if let Some(ev100) = self.ev {
            sets.push(format!("post.ev100={ev100}"));
        }
        match (&self.exposure, self.ev) {
            (Some(mode), _) => sets.push(format!("post.exposure={mode}")),
            (None, Some(_)) => sets.push("post.exposure=manual".into()),
            (None, None) => {}
        }
        if let Some(kind) = &self.bloom {
            sets.push(format!("post.bloom.mode={kind}"));
        }
        sets
    }
}

fn render_scale(text: &str) -> Result<f32, String> {
    if let Some((_, factor)) = PRESETS.iter().find(|(name, _)| *name == text) {
        return Ok(1.0 / factor);
    }
    text.parse().ok().filter(|scale| (0.25..=1.0).contains(scale)).ok_or_else(|| {
        let names: Vec<_> = PRESETS.iter().map(|(name, _)| *name).collect();
        format!("expected 0.25 to 1 or one of {}", names.join(", "))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::params::resolve;
    use pt_post::{ExposureMode, Upscale};

    #[test]
    fn options_are_knobs() {
        let args = PostArgs {
            upscale: Some("taau".into()),
            render_scale: Some(render_scale("performance").unwrap()),
            ev: Some(-2.5),
            bloom: Some("chain".into()),
            ..PostArgs::default()
        };
        let params = resolve(None, &args.sets()).unwrap();
        assert_eq!((params.post.upscale, params.post.render_scale), (Upscale::Taau, 0.5));
        assert_eq!((params.post.exposure, params.post.ev100), (ExposureMode::Manual, -2.5));
        assert_eq!(params.gbuffer.jitter, pt_gbuffer::Jitter::Halton);
        assert!(PostArgs::default().sets().is_empty());
        for text in ["0.1", "2", "NaN", "best"] {
            assert!(render_scale(text).is_err(), "{text}");
        }
        // A scale alone is refused where the knobs are checked.
        assert!(resolve(None, &["post.render_scale=0.5".into()]).is_err());
    }
}
