//! Warnings about comparisons.

use super::conclusion::listed_hz;
use crate::number::{digits, rounded};
use serde::{Deserialize, Serialize};

/// Warnings about summaries of groups and comparisons between them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "code", rename_all = "snake_case")]
pub enum CompareWarning {
    /// No spatial period stands out at all speeds.
    #[error(
        "no spatial period is clear at every speed (the strongest candidate is {prominence_db:.1} dB above the background): the surface may have \
            none, or the stated speeds were not reached; check that the stated speeds were reached"
    )]
    NoCommonPeriod { prominence_db: f64 },
    /// A spatial period that may be a harmonic: the frequency of a multiple of it is analysed at no speed.
    #[error(
        "a spatial period of {} mm cannot be excluded, of which {} mm would be a harmonic: its frequency, {} Hz at the fastest speed, is not \
            analysed, or stands out at one speed only; record at a higher speed too; state a high-pass filter at {} Hz",
        digits(multiple_m * 1e3),
        digits(period_m * 1e3),
        digits(*needed_hz),
        rounded(one_digit(needed_hz / 2.0))
    )]
    OpenMultiple {
        period_m: f64,
        multiple_m: f64,
        needed_hz: f64,
    },
    /// Recordings that are averaged or compared differ in more than the compared factor, as far as is known.
    #[error("{how}; {}", how.advice())]
    #[serde(rename = "conditions_mixed")]
    Mixed {
        #[serde(flatten)]
        how: Mixed,
    },
}

/// How conditions are mixed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "how", rename_all = "snake_case")]
pub enum Mixed {
    /// A group contains recordings made under different conditions.
    #[error(
        "{group}: recordings of different {what} are averaged together{}",
        if what == "participants" { ", although the strokes of one participant are not independent" } else { "" }
    )]
    Pooled { group: String, what: String },
    /// Groups differ in something beside what is compared.
    #[error(
        "the groups differ in {what} too ({} to {} {unit}): a difference between them may come from the {what} and not from the {by}",
        digits(*low),
        digits(*high)
    )]
    Confounded {
        what: String,
        by: String,
        low: f64,
        high: f64,
        unit: String,
    },
    /// Groups of which it is not known whether they differ in something beside what is compared.
    #[error(
        "the {what} of some recordings is not known: a difference between groups may come from it and not from the {by}"
    )]
    Unknown { what: String, by: String },
    /// Lines that may not be the textures' hold a part of the power that counts.
    #[error(
        "lines at {} Hz, which may be of the machine or the mains, hold up to {:.0} % of the power: differences and slopes are said only as \
            far as they hold with and without them",
        listed_hz(lines_hz),
        100.0 * share
    )]
    LinesInDoubt { lines_hz: Vec<f64>, share: f64 },
    /// Recordings without a counterpart for comparison.
    #[error(
        "{recordings} cannot be compared, as they differ from the others in more than the compared factor"
    )]
    LeftOut { recordings: String },
    /// Samples or participants whose names differ in capital letters, blanks or leading zeros alone.
    #[error(
        "the {of}s `{one}` and `{other}` count as two, although their names differ in capital letters, blanks or leading zeros alone"
    )]
    NamesAlike {
        #[serde(default)]
        of: Named,
        one: String,
        other: String,
    },
    /// Strokes of one texture were recorded under different conditions.
    #[error(
        "strokes of different {what} ({values}) count as one texture: the one that is rendered is typical of none of them"
    )]
    OneTexture {
        texture: String,
        what: String,
        values: String,
    },
}

impl Mixed {
    /// What a person can do.
    fn advice(&self) -> String {
        match self {
            Self::Pooled { what, .. } => {
                format!("group by {}, or compare the groups", factor_of(what))
            }
            Self::LinesInDoubt { .. } => {
                "record the machine without contact, and one sample that differs from the others"
                    .into()
            }
            Self::NamesAlike { of, .. } => format!("give one {of} one name"),
            Self::Confounded { .. }
            | Self::Unknown { .. }
            | Self::LeftOut { .. }
            | Self::OneTexture { .. } => {
                "give recordings that differ only in the compared factor".into()
            }
        }
    }
}

/// What has a name.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Named {
    /// A sample.
    #[default]
    Sample,
    /// A participant.
    Participant,
}

impl std::fmt::Display for Named {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Sample => "sample",
            Self::Participant => "participant",
        })
    }
}

/// A name in small letters, without blanks and without zeros before a number: two names that are the same so may be meant as one.
///
/// Source: docs/decisions/answers.md.
///
/// ```
/// use piezotact::compare::plain_name;
/// assert_eq!(plain_name("P 01"), plain_name("p1"));
/// assert_ne!(plain_name("P10"), plain_name("P1"));
/// ```
#[must_use]
pub fn plain_name(name: &str) -> String {
    let mut plain = String::new();
    let mut digits = false;
    let mut letters = name.chars().flat_map(char::to_lowercase).peekable();
    while let Some(letter) = letters.next() {
        let next_is_digit = letters.peek().is_some_and(char::is_ascii_digit);
        let leads = letter == '0' && !digits && next_is_digit;
        if !letter.is_whitespace() && !leads {
            digits = letter.is_ascii_digit();
            plain.push(letter);
        }
    }
    plain
}

/// A number above zero with one digit, rounded down.
fn one_digit(value: f64) -> f64 {
    let power = 10f64.powf(value.log10().floor());
    (value / power).floor() * power
}

/// The factor by which `what` is grouped.
fn factor_of(what: &str) -> &str {
    match what {
        "participants" => "participant",
        "samples" => "sample",
        "touch (active and passive)" => "touch",
        other => other,
    }
}
