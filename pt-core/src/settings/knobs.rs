//! The declaration of knobs.

use super::error::InvalidValue;
use super::tree::literal;
use pt_shaders::{KnobKind, KnobType, NamedValue};
use serde::de::DeserializeOwned;
use serde::ser::{Serialize, SerializeStruct, Serializer};
use serde_json::{Value, json};
use std::ops::RangeInclusive;

/// A struct of knobs, declared with [`knobs!`](crate::knobs!).
pub trait Knobs: Clone + Default + PartialEq + Serialize + DeserializeOwned {
    /// All knobs in the order of their declaration.
    fn knobs() -> Vec<Knob>;

    /// Checks every value against its range, then what several of them say together.
    ///
    /// # Errors
    /// The first knob that is out of its range.
    fn validate(&self) -> Result<(), InvalidValue>;

    /// The first structural knob that differs, if any: then the stages must be created anew.
    fn structural_difference(&self, other: &Self) -> Option<String>;
}

/// The declaration of a knob.
#[derive(Clone, Debug, PartialEq)]
pub struct Knob {
    /// Dotted name, as `--set` takes it.
    pub key: String,
    /// The kind of its value.
    pub kind: KnobKind,
    /// Whether it takes `none` too.
    pub optional: bool,
    /// Default value; null: none.
    pub default: Value,
    /// Least and greatest value.
    pub range: Option<[Value; 2]>,
    /// The values of an enum.
    pub values: &'static [NamedValue],
    /// Unit; may be empty.
    pub unit: &'static str,
    /// What it does.
    pub doc: String,
    /// Paper or section that it comes from; may be empty.
    pub source: &'static str,
    /// Whether another value needs other kernels, images or passes; all other knobs are read in every frame.
    pub structural: bool,
}

impl Knob {
    /// A knob of type `T`.
    pub fn new<T: KnobType + Serialize>(key: &str, default: &T, doc: &str) -> Self {
        Self {
            key: key.into(),
            kind: T::KIND,
            optional: T::OPTIONAL,
            default: value(default),
            range: None,
            values: T::NAMED,
            unit: "",
            doc: doc.trim().into(),
            source: "",
            structural: false,
        }
    }

    /// With a range.
    #[must_use]
    pub fn range<N: Serialize>(self, range: &RangeInclusive<N>) -> Self {
        Self { range: Some([value(range.start()), value(range.end())]), ..self }
    }

    /// With a unit.
    #[must_use]
    pub fn unit(self, unit: &'static str) -> Self {
        Self { unit, ..self }
    }

    /// With a source.
    #[must_use]
    pub fn source(self, source: &'static str) -> Self {
        Self { source, ..self }
    }

    /// Structural.
    #[must_use]
    pub fn structural(self) -> Self {
        Self { structural: true, ..self }
    }

    /// The same knob, seen from one table further out.
    #[must_use]
    pub fn within(self, table: &str) -> Self {
        Self { key: format!("{table}.{}", self.key), ..self }
    }

    /// The values that it accepts, as text: its range with the unit, or the names of its values.
    pub fn takes(&self) -> String {
        let unit = if self.unit.is_empty() { String::new() } else { format!(" {}", self.unit) };
        let text = match &self.range {
            Some([least, greatest]) if is_unlimited(greatest) => format!("at least {}{unit}", plain(least)),
            Some([least, greatest]) => format!("{} to {}{unit}", plain(least), plain(greatest)),
            None if self.kind == KnobKind::Boolean => "true, false".into(),
            None => self.values.iter().map(|value| value.name).collect::<Vec<_>>().join(", "),
        };
        if self.optional { format!("{text}, or none") } else { text }
    }

    /// Whether `text` can be a value, before anything else is known.
    ///
    /// # Errors
    /// What is expected instead.
    pub fn check(&self, text: &str) -> Result<(), String> {
        let in_range = |number: f64| {
            let ends =
                self.range.as_ref().map(|ends| ends.each_ref().map(|end| end.as_f64().unwrap_or(f64::NAN)));
            number.is_finite() && ends.is_none_or(|[least, greatest]| (least..=greatest).contains(&number))
        };
        let fits = match self.kind {
            KnobKind::Boolean => text.parse::<bool>().is_ok(),
            KnobKind::Integer => text.parse::<u32>().is_ok_and(|number| in_range(number.into())),
            KnobKind::Number => text.parse().is_ok_and(in_range),
            KnobKind::Enum => self.values.iter().any(|value| value.name == text),
        };
        let absent = self.optional && text == super::tree::NONE;
        let whole = if self.kind == KnobKind::Integer { "a whole number, " } else { "" };
        if fits || absent { Ok(()) } else { Err(format!("expected {whole}{}", self.takes())) }
    }

    /// The default, as `--set` takes it.
    pub fn default_text(&self) -> String {
        plain(&self.default)
    }

    /// Its sentence, its source, and whether it is structural.
    pub fn description(&self) -> String {
        let source = if self.source.is_empty() { String::new() } else { format!(" ({})", self.source) };
        let doc = self.doc.trim_end_matches('.');
        let structural = if self.structural { " Structural." } else { "" };
        format!("{doc}{source}.{structural}")
    }
}

/// The fields are a contract: `pt knobs --json` prints them.
impl Serialize for Knob {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let kind = self.kind.name();
        let values = match self.kind {
            KnobKind::Boolean => json!([false, true]),
            KnobKind::Enum => self.values.iter().map(|value| value.name).collect(),
            KnobKind::Integer | KnobKind::Number => Value::Null,
        };
        let text = |text: &'static str| (!text.is_empty()).then_some(text);
        let mut fields = serializer.serialize_struct("Knob", 9)?;
        fields.serialize_field("key", &self.key)?;
        fields
            .serialize_field("type", &if self.optional { format!("optional {kind}") } else { kind.into() })?;
        fields.serialize_field("default", &self.default)?;
        fields.serialize_field("range", &self.range)?;
        fields.serialize_field("values", &values)?;
        fields.serialize_field("unit", &text(self.unit))?;
        fields.serialize_field("doc", &self.doc)?;
        fields.serialize_field("source", &text(self.source))?;
        fields.serialize_field("structural", &self.structural)?;
        fields.end()
    }
}

/// As JSON, a float with the digits that were written in the source.
fn value<T: Serialize>(value: &T) -> Value {
    let wide = serde_json::to_value(value).unwrap_or_default();
    serde_json::from_str(&literal(&wide)).unwrap_or(Value::Null)
}

/// As one writes it on the command line.
fn plain(value: &Value) -> String {
    match value {
        Value::Null => super::tree::NONE.into(),
        Value::String(text) => text.clone(),
        Value::Number(number) if number.is_f64() => {
            let number = number.as_f64().unwrap_or_default();
            if number != 0.0 && !(1e-4..1e7).contains(&number.abs()) {
                format!("{number:e}")
            } else {
                number.to_string()
            }
        }
        other => other.to_string(),
    }
}

/// Whether the end of a range is that of its type.
fn is_unlimited(greatest: &Value) -> bool {
    *greatest == value(&f32::MAX) || *greatest == value(&u32::MAX)
}

/// Declares a struct of knobs: with it come its defaults, serde, the check of ranges and [`Knobs`].
///
/// ```
/// use pt_core::settings::Knobs;
///
/// pt_core::knobs! {
///     /// Knobs of a blur.
///     pub struct BlurParams {
///         /// Standard deviation of the blur.
///         pub sigma: f32 = 1.5, in 0.0..=10.0, unit "pixels", source "Bjorge 2015";
///         /// Number of levels.
///         pub levels: u32 = 6, in 1..=10 => structural;
///         /// Another struct of knobs: a table.
///         pub other: OtherParams;
///         check Self::is_wide_enough;
///     }
/// }
///
/// pt_core::knobs! {
///     /// Knobs of something else.
///     pub struct OtherParams {
///         /// Whether it is on.
///         pub enabled: bool = true;
///     }
/// }
///
/// impl BlurParams {
///     /// What a range cannot say.
///     fn is_wide_enough(&self) -> Result<(), pt_core::settings::InvalidValue> {
///         pt_core::settings::check_range("sigma", self.sigma, 0.1 * self.levels as f32..=10.0, "pixels")
///     }
/// }
///
/// assert_eq!(BlurParams::knobs()[2].key, "other.enabled");
/// let other = BlurParams { levels: 7, ..BlurParams::default() };
/// assert_eq!(BlurParams::default().structural_difference(&other).as_deref(), Some("levels"));
/// ```
///
/// After the default follow, each optional: the range (`in`), the `unit`, the `source` (paper or section), and `=> structural` if
/// another value needs other kernels, images or passes. A field without a default is a struct of knobs itself. The
/// crate that uses it needs `serde` (with `derive`) and `pt-shaders`.
#[macro_export]
macro_rules! knobs {
    (@default) => { Default::default() };
    (@default $default:expr) => { $default };

    (@list $list:ident $field:ident: $ty:ty { $($doc:literal)* }) => {
        $list.extend(<$ty as $crate::settings::Knobs>::knobs().into_iter().map(|knob| knob.within(stringify!($field))));
    };
    (@list $list:ident $field:ident: $ty:ty { $($doc:literal)* } = $default:expr $(, in $range:expr)? $(, unit $unit:literal)? $(, source $source:literal)? $(=> $structural:ident)?) => {
        $list.push(
            $crate::settings::Knob::new::<$ty>(stringify!($field), &$default, concat!($($doc),*))
                $(.range::<<$ty as $crate::KnobType>::Scalar>(&($range)))?
                $(.unit($unit))?
                $(.source($source))?
                $(.$structural())?
        );
    };

    (@check $params:ident $field:ident: $ty:ty) => {
        $crate::settings::Knobs::validate(&$params.$field).map_err(|error| error.within(stringify!($field)))?;
    };
    (@check $params:ident $field:ident: $ty:ty = $default:expr) => {};
    (@check $params:ident $field:ident: $ty:ty = $default:expr, in $range:expr $(, unit $unit:literal)?) => {
        if let Some(value) = <$ty as $crate::KnobType>::scalar(&$params.$field) {
            $crate::settings::check_range(stringify!($field), value, $range, concat!($($unit)?))?;
        }
    };

    (@difference $params:ident $other:ident $field:ident) => {
        if let Some(key) = $crate::settings::Knobs::structural_difference(&$params.$field, &$other.$field) {
            return Some(format!("{}.{key}", stringify!($field)));
        }
    };
    (@difference $params:ident $other:ident $field:ident = $default:expr) => {};
    (@difference $params:ident $other:ident $field:ident = $default:expr => structural) => {
        if $params.$field != $other.$field {
            return Some(stringify!($field).into());
        }
    };

    (
        $(#[$meta:meta])*
        pub struct $name:ident {
            $(
                $(#[doc = $doc:literal])*
                pub $field:ident: $ty:ty
                    $(= $default:expr $(, in $range:expr)? $(, unit $unit:literal)? $(, source $source:literal)? $(=> $structural:ident)?)?;
            )*
            $(check $check:path;)?
        }
    ) => {
        $(#[$meta])*
        #[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
        #[serde(default, deny_unknown_fields)]
        pub struct $name {
            $(
                $(#[doc = $doc])*
                $(
                    #[doc = ""]
                    #[doc = concat!("Default `", stringify!($default), "`" $(, ", range `", stringify!($range), "`")? $(, " ", $unit)?, ".")]
                )?
                pub $field: $ty,
            )*
        }

        impl Default for $name {
            fn default() -> Self {
                Self { $($field: $crate::knobs!(@default $($default)?)),* }
            }
        }

        impl $crate::settings::Knobs for $name {
            fn knobs() -> Vec<$crate::settings::Knob> {
                let mut list = Vec::new();
                $($crate::knobs!(@list list $field: $ty { $($doc)* } $(= $default $(, in $range)? $(, unit $unit)? $(, source $source)? $(=> $structural)?)?);)*
                list
            }

            fn validate(&self) -> std::result::Result<(), $crate::settings::InvalidValue> {
                $($crate::knobs!(@check self $field: $ty $(= $default $(, in $range)? $(, unit $unit)?)?);)*
                $($check(self)?;)?
                Ok(())
            }

            fn structural_difference(&self, other: &Self) -> Option<String> {
                let _ = other;
                $($crate::knobs!(@difference self other $field $(= $default $(=> $structural)?)?);)*
                None
            }
        }
    };
}
