//! The content of the panel, from the table of knobs and the scene.

use crate::params::{FrameParams, PROFILES, resolve};
use anyhow::Result;
use pt_core::settings::{Knob as Declared, Knobs};
use pt_scene::Camera;
use pt_shaders::KnobKind as Kind;
use pt_view::knob_sheet::{Knob, KnobKind, Profile};
use pt_view::panel::PanelContent;

/// Seconds that the slider of scene time covers.
const DURATION: f64 = 20.0;

/// The content for the cameras of a scene and the first values of the knobs.
///
/// # Errors
/// A built-in profile that is wrong.
pub(crate) fn of(params: &FrameParams, cameras: &[Camera], accumulate: bool) -> Result<PanelContent> {
    let profile = |(name, doc, _): &(&str, &str, &str)| {
        let values = resolve(Some(name), &[], accumulate)?.knob_values();
        Ok(Profile { name: (*name).into(), doc: (*doc).into(), values })
    };
    Ok(PanelContent {
        knobs: knobs(),
        values: params.knob_values(),
        profiles: PROFILES.iter().map(profile).collect::<Result<_>>()?,
        cameras: cameras.iter().map(|camera| camera.name.clone()).collect(),
        duration: DURATION,
    })
}

fn knobs() -> Vec<Knob> {
    FrameParams::knobs().iter().zip(FrameParams::default().knob_values()).map(knob).collect()
}

/// `default`: as [`FrameParams::knob_values`] writes it.
fn knob((declared, default): (&Declared, String)) -> Knob {
    let ends = || {
        let ends =
            declared.range.as_ref().map(|ends| ends.each_ref().map(|end| end.as_f64().unwrap_or_default()));
        ends.unwrap_or([f64::MIN, f64::MAX])
    };
    Knob {
        key: declared.key.clone(),
        kind: match declared.kind {
            Kind::Boolean => KnobKind::Boolean,
            Kind::Integer => KnobKind::Integer(ends()),
            Kind::Number => KnobKind::Number(ends()),
            Kind::Enum => KnobKind::Choice(
                declared.values.iter().map(|value| (value.name.to_owned(), value.doc.to_owned())).collect(),
            ),
        },
        optional: declared.optional,
        default,
        takes: declared.takes(),
        doc: declared.description(),
        structural: declared.structural,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pt_view::knob_sheet::KnobSheet;

    #[test]
    fn no_knob_is_marked_as_changed_at_its_default() {
        let sheet = KnobSheet::new(knobs(), FrameParams::default().knob_values());
        for (i, knob) in sheet.knobs().iter().enumerate() {
            assert!(!sheet.is_changed(i), "{}: {} and {}", knob.key, knob.default, sheet.value(i));
        }
    }
}
