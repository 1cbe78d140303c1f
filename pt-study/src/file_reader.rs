//! Reads the parts of a study file, with the place of what is wrong.

use crate::error::StudyError;
use crate::file::{Against, Axis, AxisValue, Ledger, PROFILE, Setting, Study, VARIANT_AXIS};
use crate::keys;
use crate::metric::{MeasureAt, STUDY_METRICS};
use crate::toml_reader::{Source, Table, Value};
use pt_core::settings::{Knob, close_to};
use pt_core::trace::TraceBackend;
use pt_image::image_file::ImageSize;
use pt_image::metrics::{Metric, SequenceMetric};
use pt_shaders::NamedEnum;
use std::collections::HashSet;
use std::ops::Range;
use std::path::Path;
use toml::de::{DeTable, DeValue};

/// The stage of a ledger that a picture as shown has, and radiance has not.
const TONE_MAP: &str = "tonemap";

/// Reads what depends on the knobs.
pub(crate) struct Reader<'a> {
    /// The file.
    pub source: Source<'a>,
    /// All knobs.
    pub knobs: &'a [Knob],
}

impl<'a> Reader<'a> {
    fn knob(&self, key: &str) -> Option<&'a Knob> {
        self.knobs.iter().find(|knob| knob.key == key)
    }

    /// The assignments of a table, nested tables and dotted keys alike, in the order of the file.
    pub fn settings(&self, value: &Value<'_>, of_reference: bool) -> Result<Vec<Setting>, StudyError> {
        let Some(table) = value.get_ref().as_table() else {
            return Err(self.source.error(
                value.span(),
                "expected a table of knobs, for example { \"denoise.variant\" = \"off\" }",
            ));
        };
        let mut found = Vec::new();
        self.flatten("", table, of_reference, &mut found)?;
        found.sort_by_key(|(place, _)| *place);
        Ok(found.into_iter().map(|(_, setting)| setting).collect())
    }

    fn flatten(
        &self,
        prefix: &str,
        table: &DeTable<'_>,
        of_reference: bool,
        found: &mut Vec<(usize, Setting)>,
    ) -> Result<(), StudyError> {
        for (name, value) in table {
            let key = if prefix.is_empty() {
                name.get_ref().to_string()
            } else {
                format!("{prefix}.{}", name.get_ref())
            };
            if let DeValue::Table(inner) = value.get_ref() {
                self.flatten(&key, inner, of_reference, found)?;
                continue;
            }
            self.check_key(&key, name.span(), of_reference)?;
            found.push((name.span().start, self.setting(&key, value)?));
        }
        Ok(())
    }

    fn check_key(&self, key: &str, span: Range<usize>, of_reference: bool) -> Result<(), StudyError> {
        if key != PROFILE && self.knob(key).is_none() {
            let closest = close_to(key, self.knobs.iter().map(|knob| knob.key.as_str()));
            return Err(self
                .source
                .error(span, format!("unknown knob {key:?}{closest} (pt knobs lists them)")));
        }
        if key.starts_with("reference.") && !of_reference {
            return Err(self.source.error(
                span,
                format!("{key} is a knob of the reference, which all variants share; put it into the set of the whole study"),
            ));
        }
        Ok(())
    }

    /// A value of a knob, checked as far as one value can be.
    fn setting(&self, key: &str, value: &Value<'_>) -> Result<Setting, StudyError> {
        let text = self.source.knob_text(value)?;
        if let Some(Err(expected)) = self.knob(key).map(|knob| knob.check(&text)) {
            return Err(self.source.error(value.span(), format!("{key} = {text}: {expected}")));
        }
        Ok(Setting { key: key.into(), value: text })
    }

    pub fn axes(&self, table: &Table<'_, '_>, common: &[Setting]) -> Result<Vec<Axis>, StudyError> {
        let named = table.read_list("variant", |_, value| self.variant(value))?;
        let mut axes: Vec<Axis> = Vec::new();
        axes.extend(named.map(|values| Axis { name: VARIANT_AXIS.into(), values }));
        let mut keys: Vec<String> = axes
            .iter()
            .flat_map(|axis| &axis.values)
            .flat_map(|value| &value.set)
            .map(|s| s.key.clone())
            .collect();
        for value in table.get("axis").map(|value| self.source.list(value)).unwrap_or_default() {
            let (key, axis) = self.axis(value)?;
            if let Some(key) = key {
                if common.iter().any(|setting| setting.key == key) {
                    return Err(self
                        .source
                        .error(value.span(), format!("{key} is an axis and in set; remove one of them")));
                }
                if keys.contains(&key) {
                    return Err(self
                        .source
                        .error(value.span(), format!("{key} is set by two axes; remove one of them")));
                }
                keys.push(key);
            }
            if axes.iter().any(|other| other.name == axis.name) {
                return Err(self.source.error(value.span(), format!("two axes are called {:?}", axis.name)));
            }
            axes.push(axis);
        }
        Ok(axes)
    }

    fn variant(&self, value: &Value<'a>) -> Result<AxisValue, StudyError> {
        let Some(table) = value.get_ref().as_table() else {
            return Err(self.source.error(value.span(), "expected a table [[variant]] with name and set"));
        };
        let table = self.source.table(table, "a variant", keys::VARIANT)?;
        let name = table.read("name", Source::string)?.filter(|name| !name.trim().is_empty());
        let name = name
            .ok_or_else(|| self.source.error(value.span(), "the variant has no name; add name = \"...\""))?;
        let set = table.read("set", |_, value| self.settings(value, false))?.unwrap_or_default();
        Ok(AxisValue { name, set })
    }

    /// An axis and the knob that it sets, if it sets one.
    fn axis(&self, value: &Value<'a>) -> Result<(Option<String>, Axis), StudyError> {
        let Some(table) = value.get_ref().as_table() else {
            return Err(self.source.error(value.span(), "expected a table [[axis]] with key and values"));
        };
        let table = self.source.table(table, "an axis", keys::AXIS)?;
        let key = table.read("key", |source, place| {
            let key = source.string(place)?;
            self.check_key(&key, place.span(), false)?;
            Ok(key)
        })?;
        let Some(name) = table.read("name", Source::string)?.or_else(|| key.clone()) else {
            return Err(self.source.error(
                value.span(),
                "the axis has neither key nor name; a knob is its key, an axis that sets nothing has a name",
            ));
        };
        let Some(values) = table.get("values") else {
            return Err(self
                .source
                .error(value.span(), format!("the axis {name} has no values; add values = [...]")));
        };
        let all = values.get_ref().as_str() == Some("all");
        if let (Some(except), false) = (table.get("except"), all) {
            return Err(self.source.error(except.span(), "except needs values = \"all\""));
        }
        let values = match (&key, all) {
            (Some(key), true) => {
                let except = table.read_list("except", Source::string)?.unwrap_or_default();
                let names = self.knob(key).map(|knob| knob.values).unwrap_or_default().iter();
                let names: Vec<String> =
                    names.map(|value| value.name.into()).filter(|name| !except.contains(name)).collect();
                if names.is_empty() {
                    return Err(self
                        .source
                        .error(values.span(), format!("{key} has no list of names; give its values")));
                }
                names.into_iter().map(|value| Setting { key: key.clone(), value }).map(value_of).collect()
            }
            (Some(key), false) => {
                let read = |_: Source<'_>, value: &Value<'_>| Ok(value_of(self.setting(key, value)?));
                table.read_list("values", read)?.unwrap_or_default()
            }
            (None, _) => {
                let read = |source: Source<'_>, value: &Value<'_>| {
                    Ok(AxisValue { name: source.knob_text(value)?, set: Vec::new() })
                };
                table.read_list("values", read)?.unwrap_or_default()
            }
        };
        Ok((key, Axis { name, values }))
    }

    pub fn against(&self, table: &Table<'_, '_>) -> Result<Against, StudyError> {
        let spp = table.read("spp", positive)?;
        let against = table.read("against", Source::string)?.unwrap_or_else(|| "reference".into());
        match (against.as_str(), table.get("spp")) {
            ("reference", _) => Ok(Against::Reference { spp: spp.unwrap_or(256) }),
            (_, Some(place)) => Err(self
                .source
                .error(place.span(), "spp is of a reference that is path traced; a capture has its own")),
            (folder, None) => {
                let base = self.source.path.parent().unwrap_or(Path::new(""));
                Ok(Against::Capture(base.join(folder)))
            }
        }
    }

    pub fn ledger(
        &self,
        table: &Table<'a, '_>,
        stages: &[&str],
        measure_at: MeasureAt,
    ) -> Result<Option<Ledger>, StudyError> {
        let Some(value) = table.get("ledger") else { return Ok(None) };
        let Some(inner) = value.get_ref().as_table() else {
            return Err(self.source.error(value.span(), "expected a table [ledger] with metric and stages"));
        };
        let inner = self.source.table(inner, "a ledger", keys::LEDGER)?;
        let stage = |source: Source<'_>, value: &Value<'_>| {
            let name = source.string(value)?;
            if name == TONE_MAP && measure_at == MeasureAt::Radiance {
                return Err(source.error(
                    value.span(),
                    "radiance is measured before the tone map; add measure_at = \"display\", or do not list tonemap",
                ));
            }
            if stages.contains(&name.as_str()) {
                return Ok(name);
            }
            Err(source.error(value.span(), format!("stage {name:?}: expected one of {}", stages.join(", "))))
        };
        let metric = inner.read("metric", |source, value| match metric(source, value, measure_at)? {
            metric if metric.is_temporal() || metric.perfect() != 0.0 => Err(source.error(
                value.span(),
                format!(
                    "{} cannot be split; take an error of single frames, for example relmse",
                    metric.name()
                ),
            )),
            metric => Ok(metric),
        })?;
        let listed = inner.read_list("stages", stage)?;
        let in_order = stages.iter().filter(|&&s| match &listed {
            Some(listed) => listed.iter().any(|l| l == s),
            None => s != TONE_MAP || measure_at == MeasureAt::Display,
        });
        Ok(Some(Ledger {
            metric: metric.unwrap_or(SequenceMetric::Image(Metric::RelMse)),
            stages: in_order.map(|&stage| stage.into()).collect(),
        }))
    }

    /// Nothing may be listed twice: cells would be the same.
    pub fn check_unique(&self, table: &Table<'_, '_>, study: &Study) -> Result<(), StudyError> {
        let at = |key: &str| table.get(key).map_or(0..0, |value| value.span());
        let check = |key: &str, names: Vec<String>| match twice(&names) {
            Some(name) => Err(self.source.error(at(key), format!("{name} is twice in {key}"))),
            None => Ok(()),
        };
        let texts = |values: &[u64]| values.iter().map(u64::to_string).collect();
        check("scenes", study.scenes.clone())?;
        check("cameras", study.cameras.clone())?;
        check("sizes", study.sizes.iter().map(|[w, h]| format!("{w}x{h}")).collect())?;
        check("backends", study.backends.clone())?;
        check("seeds", texts(&study.seeds))?;
        check("metrics", study.metrics.iter().map(|metric| metric.name().into()).collect())?;
        for axis in &study.axes {
            let names: Vec<_> = axis.values.iter().map(|value| value.name.clone()).collect();
            if let Some(name) = twice(&names) {
                let key = if axis.name == VARIANT_AXIS { "variant" } else { "axis" };
                return Err(self.source.error(at(key), format!("{name} is twice on the axis {}", axis.name)));
            }
        }
        Ok(())
    }
}

fn twice(names: &[String]) -> Option<&String> {
    let mut seen = HashSet::new();
    names.iter().find(|name| !seen.insert(*name))
}

fn value_of(setting: Setting) -> AxisValue {
    AxisValue { name: setting.value.clone(), set: vec![setting] }
}

pub(crate) fn positive(source: Source<'_>, value: &Value<'_>) -> Result<u32, StudyError> {
    let number = source.number(value)?;
    u32::try_from(number)
        .ok()
        .filter(|&number| number > 0)
        .ok_or_else(|| source.error(value.span(), "expected a whole number of 1 or more, below 2^32"))
}

pub(crate) fn above_zero(source: Source<'_>, value: &Value<'_>) -> Result<f64, StudyError> {
    let number = source.float(value)?;
    if number > 0.0 { Ok(number) } else { Err(source.error(value.span(), "expected a number above 0")) }
}

pub(crate) fn camera(source: Source<'_>, value: &Value<'_>) -> Result<String, StudyError> {
    if value.get_ref().is_integer() { Ok(source.number(value)?.to_string()) } else { source.string(value) }
}

pub(crate) fn size(source: Source<'_>, value: &Value<'_>) -> Result<[u32; 2], StudyError> {
    let text = source.string(value)?;
    text.parse::<ImageSize>()
        .map(Into::into)
        .map_err(|error| source.error(value.span(), format!("size {text:?}: {error}")))
}

pub(crate) fn backend(source: Source<'_>, value: &Value<'_>) -> Result<String, StudyError> {
    let name = source.string(value)?;
    match TraceBackend::from_name(&name) {
        Ok(_) => Ok(name),
        Err(error) => Err(source.error(value.span(), error.to_string())),
    }
}

pub(crate) fn metric(
    source: Source<'_>,
    value: &Value<'_>,
    measure_at: MeasureAt,
) -> Result<SequenceMetric, StudyError> {
    let name = source.string(value)?;
    let found = STUDY_METRICS.into_iter().find(|metric| metric.name() == name);
    if found == Some(SequenceMetric::Image(Metric::HdrFlip)) && measure_at == MeasureAt::Display {
        return Err(source.error(
            value.span(),
            "hdr-flip exposes radiance itself, and the picture as shown is measured; take flip",
        ));
    }
    found.ok_or_else(|| {
        let known = STUDY_METRICS.map(SequenceMetric::name);
        let closest = close_to(&name, known);
        source
            .error(value.span(), format!("unknown metric {name:?}{closest} (there are {})", known.join(", ")))
    })
}

/// The last frames by their number, or a range `A..B`.
pub(crate) fn measured(source: Source<'_>, value: &Value<'_>, frames: u32) -> Result<Range<u32>, StudyError> {
    let expected = || {
        source.error(value.span(), format!("measure: expected how many of the last frames, 1 to {frames}, or a range \"A..B\" within 0..{frames}"))
    };
    let range = match value.get_ref() {
        DeValue::String(text) => {
            let (start, end) = text.split_once("..").ok_or_else(expected)?;
            let parse = |text: &str| text.trim().parse::<u32>().map_err(|_| expected());
            parse(start)?..parse(end)?
        }
        _ => frames.checked_sub(positive(source, value)?).ok_or_else(expected)?..frames,
    };
    if range.is_empty() || range.end > frames { Err(expected()) } else { Ok(range) }
}
