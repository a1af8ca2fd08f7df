//! Warnings about comparisons.

use crate::number::{digits, rounded};
use crate::warning::words::percent;
use serde::{Deserialize, Serialize};

/// Warnings about summaries of groups and comparisons between them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "code", rename_all = "snake_case")]
pub enum CompareWarning {
    /// Recordings without a counterpart for comparison.
    #[error(
        "{recordings} cannot be compared: they differ from the others in more than the compared factor; give recordings that differ only in the \
            compared factor"
    )]
    NotCompared { recordings: String },
    /// Strokes that differ far more than strokes of one texture do.
    #[error(
        "{group}: the rms of the strokes varies by {} of its mean, far more than usual for strokes of one texture; check whether the sensor is \
            loose or the conditions differ",
        percent(*share)
    )]
    Scattered { group: String, share: f64 },
    /// Few strokes: their average scatters.
    #[error(
        "{group}: strokes kept: {kept}, so averages are uncertain; record {recommended} or more"
    )]
    FewStrokes {
        group: String,
        kept: usize,
        recommended: usize,
    },
    /// A group contains recordings made under different conditions.
    #[error(
        "{group}: recordings of different {what} are averaged together{}: group by {}, or compare the groups",
        if what == "participants" {
        ", although the strokes of one participant are not independent"
        } else {
        ""
        },
        factor_of(what)
    )]
    Pooled { group: String, what: String },
    /// Groups differ in something beside what is compared.
    #[error(
        "the groups differ in {what} too ({} to {} {unit}): a difference between them may come from the {what} and not from the {by}; give \
            recordings that differ only in the compared factor",
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
        "the {what} of some recordings is not known: a difference between groups may come from it and not from the {by}; give recordings that \
            differ only in the compared factor"
    )]
    MayDiffer { what: String, by: String },
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
    /// A value from so few groups that it has no interval.
    #[error(
        "{result} is from {groups} group(s) only, so it has no confidence interval: record 3 or more"
    )]
    NoInterval { result: String, groups: usize },
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
