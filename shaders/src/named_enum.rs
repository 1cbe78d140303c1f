//! Enums whose values have names on the command line and in files, and constants in GLSL: declared once.

use std::fmt;

/// Name and meaning of a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NamedValue {
    /// As the command line, profiles and JSON spell it.
    pub name: &'static str,
    /// What it stands for.
    pub doc: &'static str,
}

/// An enum declared with [`named_enum!`](crate::named_enum!).
pub trait NamedEnum: Copy + PartialEq + 'static {
    /// All values, in the order of their declaration.
    const VALUES: &'static [Self];
    /// Name and meaning of each.
    const NAMED: &'static [NamedValue];
    /// The names alone.
    const NAMES: &'static [&'static str];

    /// The number that stands for the value in kernels: its place in the declaration.
    fn code(self) -> u32;

    /// Name of the value.
    fn name(self) -> &'static str {
        Self::NAMES[self.code() as usize]
    }

    /// The value of that name.
    ///
    /// # Errors
    /// [`UnknownName`], which lists the names that there are.
    fn from_name(name: &str) -> Result<Self, UnknownName> {
        let place = Self::NAMES.iter().position(|known| *known == name);
        place.map(|i| Self::VALUES[i]).ok_or_else(|| UnknownName { name: name.into(), known: Self::NAMES })
    }

    /// GLSL constants `PREFIX_NAME` of all values.
    fn glsl_constants(prefix: &str) -> String {
        let constant = |&value: &Self| {
            let name = value.name().replace('-', "_").to_uppercase();
            format!("const uint {prefix}_{name} = {}u;\n", value.code())
        };
        Self::VALUES.iter().map(constant).collect()
    }
}

/// A name that no value has.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnknownName {
    /// What was asked for.
    pub name: String,
    /// The names that there are.
    pub known: &'static [&'static str],
}

impl fmt::Display for UnknownName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "unknown name {:?}, expected one of {}", self.name, self.known.join(", "))
    }
}

impl std::error::Error for UnknownName {}

/// Declares an enum with the names of its values, for the command line, serde and, where a prefix is given, GLSL:
///
/// ```
/// pt_shaders::named_enum! {
///     /// Which way to go; `WAY_*` in GLSL.
///     pub enum Way: "WAY" {
///         /// To the left.
///         Left = "left",
///         /// Straight on.
///         StraightOn = "straight-on",
///     }
/// }
/// assert_eq!(Way::glsl(), "const uint WAY_LEFT = 0u;\nconst uint WAY_STRAIGHT_ON = 1u;\n");
/// ```
#[macro_export]
macro_rules! named_enum {
    (
        $(#[$meta:meta])*
        pub enum $name:ident $(: $prefix:literal)? {
            $($(#[doc = $doc:literal])* $value:ident = $text:literal),* $(,)?
        }
    ) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum $name { $($(#[doc = $doc])* $value),* }

        impl $name {
            /// All values, in the order of their declaration.
            #[allow(dead_code, reason = "build scripts need the GLSL alone")]
            pub const ALL: [Self; [$($text),*].len()] = [$(Self::$value),*];

            /// The number that stands for the value in kernels: its place in the declaration.
            #[allow(dead_code, reason = "build scripts need the GLSL alone")]
            pub const fn code(self) -> u32 {
                self as u32
            }

            /// Name of the value.
            #[allow(dead_code, reason = "build scripts need the GLSL alone")]
            pub const fn name(self) -> &'static str {
                <Self as $crate::NamedEnum>::NAMES[self as usize]
            }

            $(
                /// GLSL constants of the values.
                #[allow(dead_code, reason = "build scripts need the GLSL alone")]
                pub fn glsl() -> String {
                    <Self as $crate::NamedEnum>::glsl_constants($prefix)
                }
            )?
        }

        impl $crate::NamedEnum for $name {
            const VALUES: &'static [Self] = &Self::ALL;
            const NAMED: &'static [$crate::NamedValue] =
                &[$($crate::NamedValue { name: $text, doc: concat!($($doc),*).trim_ascii() }),*];
            const NAMES: &'static [&'static str] = &[$($text),*];
            fn code(self) -> u32 {
                Self::code(self)
            }
        }

        impl $crate::serde_core::Serialize for $name {
            fn serialize<S: $crate::serde_core::Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
                serializer.serialize_str($crate::NamedEnum::name(*self))
            }
        }

        impl<'de> $crate::serde_core::Deserialize<'de> for $name {
            fn deserialize<D: $crate::serde_core::Deserializer<'de>>(deserializer: D) -> std::result::Result<Self, D::Error> {
                let name = <String as $crate::serde_core::Deserialize>::deserialize(deserializer)?;
                <Self as $crate::NamedEnum>::from_name(&name).map_err($crate::serde_core::de::Error::custom)
            }
        }
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    named_enum! {
        /// For the tests.
        pub enum Curve: "CURVE" {
            /// Nothing
            /// happens.
            None = "none",
            /// A fit.
            AcesHill = "aces-hill",
        }
    }

    #[test]
    fn names_codes_and_glsl_agree() {
        assert_eq!(Curve::glsl(), "const uint CURVE_NONE = 0u;\nconst uint CURVE_ACES_HILL = 1u;\n");
        for curve in Curve::ALL {
            assert_eq!(Curve::from_name(curve.name()), Ok(curve));
        }
        assert_eq!(Curve::NAMED[0], NamedValue { name: "none", doc: "Nothing happens." });
        let error = Curve::from_name("filmic").unwrap_err().to_string();
        assert_eq!(error, r#"unknown name "filmic", expected one of none, aces-hill"#);
    }
}
