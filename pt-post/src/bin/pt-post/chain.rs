//! Parser of `--chain`.

use pt_post::{BloomMode, PRESETS, PostParams, Tonemap, Upscale};
use pt_shaders::NamedEnum;
use std::str::FromStr;

/// Which stages run. They have one order; the list names them in it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Chain {
    pub accumulate: bool,
    pub taa: Option<f32>,
    pub bloom: Option<BloomMode>,
    pub tonemap: Option<Option<Tonemap>>,
    pub fsr: Option<f32>,
    pub sharpen: bool,
}

/// The stages in the order of the frame.
const ORDER: [&str; 6] = ["accumulate", "taa", "bloom", "tonemap", "fsr", "sharpen"];

impl FromStr for Chain {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let mut chain = Self::default();
        let mut last: Option<usize> = None;
        for element in text.split(',').map(str::trim) {
            let (name, value) = match element.split_once('=') {
                Some((name, value)) => (name, Some(value)),
                None => (element, None),
            };
            let place = ORDER.iter().position(|known| *known == name).ok_or_else(|| {
                format!("{name:?} is no stage; there are, in this order: {}", ORDER.join(", "))
            })?;
            if last.is_some_and(|last| place <= last) {
                return Err(format!("{name}: the stages run in the order {}, each once", ORDER.join(", ")));
            }
            last = Some(place);
            match name {
                "accumulate" => no_value(name, value).map(|()| chain.accumulate = true)?,
                "taa" => chain.taa = Some(value.map_or(Ok(1.0), factor)?),
                "bloom" => chain.bloom = Some(value.map_or(Ok(BloomMode::Gaussian), named)?),
                "tonemap" => chain.tonemap = Some(value.map(named).transpose()?),
                "fsr" => chain.fsr = Some(factor(value.ok_or("fsr needs a factor, for example fsr=1.5")?)?),
                _ => no_value(name, value).map(|()| chain.sharpen = true)?,
            }
        }
        if chain.taa.is_some_and(|factor| factor > 1.0) && chain.fsr.is_some() {
            return Err("taa with a factor and fsr both upscale: choose one".into());
        }
        if chain.accumulate && chain.taa.is_some() {
            return Err("accumulate and taa both average frames: choose one".into());
        }
        if (chain.fsr.is_some() || chain.sharpen) && chain.tonemap.is_none() {
            return Err("fsr and sharpen work on display codes: put tonemap before them".into());
        }
        Ok(chain)
    }
}

impl Chain {
    /// The knobs with what the chain itself says.
    pub fn apply(&self, mut params: PostParams) -> PostParams {
        params.taa.enabled = self.taa.is_some();
        params.bloom.mode = self.bloom.unwrap_or(BloomMode::Off);
        params.tonemap = self.tonemap.flatten().unwrap_or(params.tonemap);
        params.fsr.sharpen = self.sharpen;
        (params.upscale, params.render_scale) = match (self.taa, self.fsr) {
            (Some(factor), _) if factor > 1.0 => (Upscale::Taau, 1.0 / factor),
            (_, Some(factor)) => (Upscale::Fsr1, 1.0 / factor),
            _ => (Upscale::None, 1.0),
        };
        params
    }

    /// Side of the picture over side of the frame.
    pub fn factor(&self) -> f32 {
        self.fsr.or(self.taa).unwrap_or(1.0)
    }
}

fn no_value(name: &str, value: Option<&str>) -> Result<(), String> {
    value.map_or(Ok(()), |_| Err(format!("{name} takes no value")))
}

/// A knob's value by its name.
pub fn named<T: NamedEnum>(name: &str) -> Result<T, String> {
    T::from_name(name).map_err(|error| error.to_string())
}

/// A factor of 1 to 4, or the name of a preset.
fn factor(text: &str) -> Result<f32, String> {
    if let Some((_, factor)) = PRESETS.iter().find(|(name, _)| *name == text) {
        return Ok(*factor);
    }
    let names: Vec<_> = PRESETS.iter().map(|(name, _)| *name).collect();
    text.parse().ok().filter(|factor| (1.0..=4.0).contains(factor)).ok_or_else(|| {
        format!("{text:?} is no upscaling factor; expected 1 to 4 or one of {}", names.join(", "))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chains_are_parsed() {
        let chain: Chain = "taa,bloom,tonemap=agx,fsr=1.5".parse().unwrap();
        assert_eq!(chain.taa, Some(1.0));
        assert_eq!(chain.bloom, Some(BloomMode::Gaussian));
        assert_eq!(chain.tonemap, Some(Some(Tonemap::Agx)));
        assert_eq!(chain.factor(), 1.5);
        assert_eq!("tonemap, fsr=quality".parse::<Chain>().unwrap().fsr, Some(1.5));
        let params = "taa=2,bloom=chain".parse::<Chain>().unwrap().apply(PostParams::default());
        assert_eq!((params.upscale, params.render_scale), (Upscale::Taau, 0.5));
        assert_eq!(params.bloom.mode, BloomMode::Chain);
    }

    #[test]
    fn what_makes_no_sense_is_refused() {
        for (text, says) in [
            ("bloom,taa", "order"),
            ("taa,taa", "once"),
            ("blur", "no stage"),
            ("", "no stage"),
            ("tonemap=filmic", "unknown name"),
            ("tonemap,fsr", "factor"),
            ("tonemap,fsr=5", "1 to 4"),
            ("tonemap,fsr=NaN", "1 to 4"),
            ("fsr=2", "tonemap"),
            ("taa=2,tonemap,fsr=2", "both"),
            ("accumulate=3", "no value"),
        ] {
            let error = text.parse::<Chain>().unwrap_err();
            assert!(error.contains(says), "{text}: {error}");
        }
    }
}
