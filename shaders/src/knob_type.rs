//! Types that a knob can have.

use crate::named_enum::{NamedEnum, NamedValue};

/// What kind of value a knob takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum KnobKind {
    /// `true` or `false`.
    Boolean,
    /// A whole number.
    Integer,
    /// A finite number.
    Number,
    /// One of the names of a [`NamedEnum`].
    Enum,
}

impl KnobKind {
    /// Name in listings.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Boolean => "boolean",
            Self::Integer => "integer",
            Self::Number => "number",
            Self::Enum => "enum",
        }
    }
}

/// A type that a knob can have: `f32`, `u32`, `bool`, a [`NamedEnum`], or an `Option` of these.
pub trait KnobType: PartialEq {
    /// What a range has at its ends.
    type Scalar;
    /// What it takes.
    const KIND: KnobKind;
    /// Whether it can be absent.
    const OPTIONAL: bool = false;
    /// The values of an enum.
    const NAMED: &'static [NamedValue] = &[];
    /// The number that must lie in the range.
    fn scalar(&self) -> Option<Self::Scalar>;
}

macro_rules! scalars {
    ($($ty:ty => $kind:ident),*) => { $(impl KnobType for $ty {
        type Scalar = Self;
        const KIND: KnobKind = KnobKind::$kind;
        fn scalar(&self) -> Option<Self> {
            Some(*self)
        }
    })* };
}

scalars!(f32 => Number, u32 => Integer, bool => Boolean);

impl<T: NamedEnum> KnobType for T {
    type Scalar = Self;
    const KIND: KnobKind = KnobKind::Enum;
    const NAMED: &'static [NamedValue] = T::NAMED;
    fn scalar(&self) -> Option<Self> {
        Some(*self)
    }
}

impl<T: KnobType> KnobType for Option<T> {
    type Scalar = T::Scalar;
    const KIND: KnobKind = T::KIND;
    const OPTIONAL: bool = true;
    const NAMED: &'static [NamedValue] = T::NAMED;
    fn scalar(&self) -> Option<T::Scalar> {
        self.as_ref().and_then(T::scalar)
    }
}
