//! Warnings: what a result leaves open. A value that had to be clamped, gated, guessed or estimated from few data comes back with a
//! [`Warning`]: what was found, what it is about, and what a person can do.
//!
//! The kinds of warnings stand beside the rules that raise them, as enums with typed fields (`RenderWarning`,
//! `TransferWarning`, …). Each is converted to a [`Warning`] by `into`, and back by [`Warning::kind`]. A warning
//! with an unknown code, as in a file of a newer version, is kept and written again unchanged.

mod advice;
mod json;
mod list;
mod merged;
mod value;
pub mod words;

use std::borrow::Cow;
use std::collections::BTreeMap;

pub use advice::{Advice, ChannelRole, Subject};
pub use list::Warnings;
pub(crate) use merged::serialize_merged;
pub use merged::{Merged, Range, merged, merged_of};
pub use value::{About, Counts, Example, FieldValue, Value};

/// One thing that a person should know before relying on a result.
///
/// The field that names what a warning is about, and the function that makes an [`About`] of its value.
pub type SubjectField = (&'static str, fn(String) -> About);

/// Two warnings are equal when code, subject, values and count are equal. Advice is not compared: it follows from the others.
#[derive(Clone, Debug)]
pub struct Warning {
    /// What kind of warning it is: `force_not_measured`. Codes never change their meaning.
    pub code: Cow<'static, str>,
    /// What it is about, if that is a single thing.
    pub about: Option<About>,
    /// What was found, by name; names end with their unit.
    pub values: BTreeMap<String, Value>,
    /// How many warnings of this kind are merged in it.
    pub seen: usize,
    /// What a person can do.
    pub advice: Vec<Advice>,
}

/// The warnings that one rule raises, with typed fields. Its `Display` says in one sentence what was found and why it
/// matters; what to do is its advice.
pub trait WarningKind: Sized + std::fmt::Display {
    /// The warning with typed fields; `None` when it is of another kind, or lacks a field.
    fn of(warning: &Warning) -> Option<Self>;
    /// What a person can do.
    fn advice(&self) -> Vec<Advice>;
}

impl PartialEq for Warning {
    fn eq(&self, other: &Self) -> bool {
        self.is_equivalent_to(other) && self.seen == other.seen
    }
}

impl Warning {
    /// The warning as one of the kinds of `K`, with typed fields; `None` when it is of another kind.
    ///
    /// ```
    /// use piezotact::Warning;
    /// use piezotact::spectrum::SpectrumWarning;
    /// let warning = Warning::from(SpectrumWarning::ShortSignal { segments: 2 });
    /// assert!(matches!(warning.kind(), Some(SpectrumWarning::ShortSignal { segments: 2 })));
    /// ```
    #[must_use]
    pub fn kind<K: WarningKind>(&self) -> Option<K> {
        K::of(self)
    }

    /// Whether code, subject and values equal those of `other`; count and advice are not compared.
    #[must_use]
    pub fn is_equivalent_to(&self, other: &Self) -> bool {
        (&self.code, &self.about, &self.values) == (&other.code, &other.about, &other.values)
    }

    /// A warning of `fields`, of which `subject` names the one that the warning is about.
    #[doc(hidden)]
    #[must_use]
    pub fn of_fields(
        code: &'static str,
        fields: impl IntoIterator<Item = (&'static str, Option<Value>)>,
        subject: Option<SubjectField>,
        advice: Vec<Advice>,
    ) -> Self {
        let mut values: BTreeMap<String, Value> = fields
            .into_iter()
            .filter_map(|(name, value)| Some((name.to_owned(), value?)))
            .collect();
        let about = subject.and_then(|(field, about)| match values.remove(field) {
            Some(Value::Text(text)) => Some(about(text)),
            _ => None,
        });
        Self {
            code: Cow::Borrowed(code),
            about,
            values,
            seen: 1,
            advice,
        }
    }

    /// The value of a field, which may be the one that the warning is about.
    #[doc(hidden)]
    #[must_use]
    pub fn field<T: FieldValue>(&self, name: &str, subject: Option<&str>) -> Option<T> {
        match (self.values.get(name), &self.about) {
            (None, Some(about)) if subject == Some(name) => {
                T::from_value(Some(&Value::Text(about.name()?.to_owned())))
            }
            (value, _) => T::from_value(value),
        }
    }
}

/// Declares the warnings of a rule: an enum, with the code of each and the field that names what it is about.
#[doc(hidden)]
#[macro_export]
macro_rules! warnings {
    (
        $(#[$meta:meta])*
        pub enum $name:ident { $(
            $(#[$doc:meta])*
            $variant:ident($code:literal) $(of $about:ident($subject:ident))? $({ $(
                $(#[$field_doc:meta])*
                $field:ident: $type:ty
            ),* $(,)? })?
        ),* $(,)? }
    ) => {
        $(#[$meta])*
        #[derive(Clone, Debug, PartialEq)]
        pub enum $name { $(
            $(#[$doc])*
            $variant $({ $(
                $(#[$field_doc])*
                $field: $type
            ),* })?
        ),* }

        impl $name {
            fn of_warning(warning: &$crate::warning::Warning) -> Option<Self> {
                match warning.code.as_ref() {
                    $( $code => {
                        let _subject: Option<&str> = None $(.or(Some(stringify!($subject))))?;
                        Some(Self::$variant $({ $(
                            $field: warning.field(stringify!($field), _subject)?
                        ),* })?)
                    } )*
                    _ => None,
                }
            }
        }

        impl From<$name> for $crate::warning::Warning {
            fn from(kind: $name) -> Self {
                let advice = $crate::warning::WarningKind::advice(&kind);
                match kind { $(
                    $name::$variant $({ $($field),* })? => Self::of_fields(
                        $code,
                        [$( $( (
                            stringify!($field),
                            $crate::warning::FieldValue::into_value($field),
                        ) ),* )?],
                        None $(.or(Some((
                            stringify!($subject),
                            $crate::warning::About::$about as fn(String) -> $crate::warning::About,
                        ))))?,
                        advice,
                    ),
                )* }
            }
        }
    };
}
#[doc(hidden)]
pub use warnings;

/// Declares the causes that a warning can name in one of its fields: as [`warnings!`], each kept as a warning within the warning. Their
/// last is `Said`, a cause known only as a sentence.
macro_rules! causes {
    ($(#[$meta:meta])* pub enum $name:ident { $($variants:tt)* }) => {
        $crate::warning::warnings! { $(#[$meta])* pub enum $name { $($variants)* } }

        impl $crate::warning::WarningKind for $name {
            fn of(warning: &$crate::warning::Warning) -> Option<Self> {
                Self::of_warning(warning)
            }

            fn advice(&self) -> Vec<$crate::warning::Advice> {
                Vec::new()
            }
        }

        impl $crate::warning::FieldValue for $name {
            fn into_value(self) -> Option<$crate::warning::Value> {
                Some(match self {
                    Self::Said { text } => $crate::warning::Value::Text(text),
                    cause => $crate::warning::Value::Warning(Box::new(cause.into())),
                })
            }

            fn from_value(value: Option<&$crate::warning::Value>) -> Option<Self> {
                match value? {
                    $crate::warning::Value::Text(text) => Some(Self::Said { text: text.clone() }),
                    $crate::warning::Value::Warning(warning) => Self::of_warning(warning),
                    _ => None,
                }
            }
        }
    };
}
pub(crate) use causes;
