//! Flags for the post-processing of the frame.

use super::flags::{Flag, FlagSet, Flags};
use crate::params::FrameParams;
use pt_core::settings::{Knob, Knobs};
use pt_post::PRESETS;

/// Short names of post-processing knobs.
pub type PostArgs = Flags<Picture>;

/// The flags.
pub struct Picture;

impl FlagSet for Picture {
    const HEADING: &'static str = "Picture";
    const FLAGS: &'static [Flag] = &[
        Flag {
            implies: &[("taau", "gbuffer.jitter=halton")],
            note: "; taau also asks for one sub-pixel offset a frame (gbuffer.jitter=halton)",
            ..Flag::new("upscale", "post.upscale", "HOW")
        },
        Flag {
            aliases: preset,
            note: ", or a preset: ultra-quality, quality, balanced, performance",
            ..Flag::new("render-scale", "post.render_scale", "X|PRESET")
        },
        Flag {
            note: "; transparent writes alpha to png (straight) and exr (premultiplied)",
            ..Flag::new("background", "denoise.background", "WHAT")
        },
        Flag::new("tonemap", "post.tonemap", "CURVE"),
        Flag {
            implies: &[("", "post.exposure=manual")],
            note: "; manual exposure, unless --exposure says otherwise",
            ..Flag::new("ev", "post.ev100", "EV100")
        },
        Flag::new("exposure", "post.exposure", "HOW"),
        Flag {
            without_value: Some("gaussian"),
            note: "; gaussian when no kind is given",
            ..Flag::new("bloom", "post.bloom.mode", "KIND")
        },
    ];

    fn knobs() -> Vec<Knob> {
        FrameParams::knobs()
    }
}

fn preset(name: &str) -> Option<String> {
    PRESETS.iter().find(|(preset, _)| *preset == name).map(|(_, factor)| (1.0 / factor).to_string())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::params::resolve;
    use clap::Parser;
    use pt_post::{ExposureMode, Upscale};

    #[derive(Debug, Parser)]
    struct Program {
        #[command(flatten)]
        post: PostArgs,
    }

    fn sets(line: &str) -> Result<Vec<String>, String> {
        let words = ["pt"].into_iter().chain(line.split_whitespace());
        Program::try_parse_from(words).map(|program| program.post.sets).map_err(|error| error.to_string())
    }

    #[test]
    fn options_are_knobs() {
        let line = "--upscale taau --render-scale performance --ev -2.5 --bloom=chain";
        let params = resolve(None, &sets(line).unwrap(), false).unwrap();
        assert_eq!((params.post.upscale, params.post.render_scale), (Upscale::Taau, 0.5));
        assert_eq!((params.post.exposure, params.post.ev100), (ExposureMode::Manual, -2.5));
        assert_eq!(params.gbuffer.jitter, pt_gbuffer::Jitter::Halton);
        assert!(sets("").unwrap().is_empty());
        assert_eq!(sets("--bloom").unwrap(), ["post.bloom.mode=gaussian"]);
        let params = resolve(None, &sets("--exposure auto --ev 3").unwrap(), false).unwrap();
        assert_eq!((params.post.exposure, params.post.ev100), (ExposureMode::Auto, 3.0));
        // A scale alone is refused where the knobs are checked.
        assert!(resolve(None, &["post.render_scale=0.5".into()], false).is_err());
    }

    #[test]
    fn what_a_knob_does_not_take_is_refused() {
        for (line, says) in [
            ("--render-scale 0.1", "0.25 to 1"),
            ("--render-scale 2", "0.25 to 1"),
            ("--render-scale NaN", "0.25 to 1"),
            ("--render-scale best", "0.25 to 1"),
            ("--tonemap filmic", "noise-aware"),
            ("--ev 33", "-32 to 32 EV"),
            ("--bloom=wide", "gaussian"),
        ] {
            let message = sets(line).unwrap_err();
            assert!(message.contains(says), "{line}: {message}");
        }
    }
}
