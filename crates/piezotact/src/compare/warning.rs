//! Warnings about comparisons.

use std::fmt;

use crate::number::digits;
use crate::warning::words::percent;
use crate::warning::{Advice, Subject, WarningKind, warnings};

warnings! {
    /// Warnings about summaries of groups and comparisons between them.
    pub enum CompareWarning {
        /// Recordings without a counterpart for comparison.
        NotCompared("not_compared") {
            /// Their names.
            recordings: String,
        },
        /// Strokes that differ far more than strokes of one texture do.
        Scattered("scattered") of Group(group) {
            /// The group.
            group: String,
            /// The standard deviation of the rms as a share of its mean.
            share: f64,
        },
        /// Few strokes: their average scatters.
        FewStrokes("few_strokes") of Group(what) {
            /// What was recorded.
            what: String,
            /// Strokes kept.
            kept: usize,
            /// The number recommended.
            recommended: usize,
        },
        /// A group contains recordings made under different conditions.
        Pooled("pooled") of Group(group) {
            /// The group.
            group: String,
            /// In what they differ.
            what: String,
        },
        /// Groups differ in something beside what is compared.
        Confounded("confounded") {
            /// In what they differ.
            what: String,
            /// What is compared.
            by: String,
            /// The least of them.
            low: f64,
            /// The largest.
            high: f64,
            /// Their unit.
            unit: String,
        },
        /// Groups of which it is not known whether they differ in something beside what is compared.
        MayDiffer("may_differ") {
            /// In what they may differ.
            what: String,
            /// What is compared.
            by: String,
        },
        /// No spatial period stands out at all speeds.
        NoCommonPeriod("no_common_period") {
            /// How far the strongest candidate stands above the background, dB.
            prominence_db: f64,
        },
        /// A spatial period that may be a harmonic: the frequency of a multiple of it is analysed at no speed.
        OpenMultiple("open_multiple") {
            /// The period, m.
            period_m: f64,
            /// The multiple that may be the period, m.
            multiple_m: f64,
            /// Its frequency at the fastest speed, Hz.
            needed_hz: f64,
        },
        /// A value from so few groups that it has no interval.
        NoInterval("no_interval") of Result(what) {
            /// What.
            what: String,
            /// Groups that it comes from.
            groups: usize,
        },
    }
}

impl WarningKind for CompareWarning {
    fn of(warning: &crate::Warning) -> Option<Self> {
        Self::of_warning(warning)
    }

    fn advice(&self) -> Vec<Advice> {
        match self {
            Self::NotCompared { .. } | Self::Confounded { .. } | Self::MayDiffer { .. } => {
                vec![Advice::CompareLike]
            }
            Self::Scattered { .. } => vec![Advice::Check(Subject::LooseSensor)],
            Self::FewStrokes { recommended, .. } => vec![Advice::RecordMore {
                count: *recommended,
            }],
            Self::Pooled { what, .. } => {
                let by = match what.as_str() {
                    "participants" => "participant",
                    "samples" => "sample",
                    "touch (active and passive)" => "touch",
                    other => other,
                };
                vec![Advice::GroupBy { by: by.into() }]
            }
            Self::NoCommonPeriod { .. } => vec![Advice::Check(Subject::Speeds)],
            // The band begins half an octave above the cut-off.
            Self::OpenMultiple { needed_hz, .. } => vec![
                Advice::RecordFaster,
                Advice::StateHighPass {
                    at_hz: one_digit(needed_hz / 2.0),
                },
            ],
            Self::NoInterval { .. } => vec![Advice::RecordMore { count: 3 }],
        }
    }
}

/// A number above zero with one digit, rounded down.
fn one_digit(value: f64) -> f64 {
    let power = 10f64.powf(value.log10().floor());
    (value / power).floor() * power
}

impl fmt::Display for CompareWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotCompared { recordings } => write!(
                f,
                "{recordings} cannot be compared: they differ from the others in more than the compared factor"
            ),
            Self::Scattered { group, share } => write!(
                f,
                "{group}: the rms of the strokes varies by {} of its mean, far more than usual for strokes of one texture",
                percent(*share)
            ),
            Self::FewStrokes { what, kept, .. } => {
                write!(f, "{what}: strokes kept: {kept}, so averages are uncertain")
            }
            Self::Pooled { group, what } => write!(
                f,
                "{group}: recordings of different {what} are averaged together{}",
                if what == "participants" {
                    ", although the strokes of one participant are not independent"
                } else {
                    ""
                }
            ),
            Self::Confounded {
                what,
                by,
                low,
                high,
                unit,
            } => write!(
                f,
                "the groups differ in {what} too ({} to {} {unit}): a difference between them may come from the {what} and not \
                    from the {by}",
                digits(*low),
                digits(*high)
            ),
            Self::MayDiffer { what, by } => write!(
                f,
                "the {what} of some recordings is not known: a difference between groups may come from it and not from the {by}"
            ),
            Self::NoCommonPeriod { prominence_db } => write!(
                f,
                "no spatial period is clear at every speed (the strongest candidate is {prominence_db:.1} dB above the \
                    background): the surface may have none, or the stated speeds were not reached"
            ),
            Self::OpenMultiple {
                period_m,
                multiple_m,
                needed_hz,
            } => write!(
                f,
                "a spatial period of {} mm cannot be excluded, of which {} mm would be a harmonic: its frequency, {} Hz at the \
                    fastest speed, is not analysed, or stands out at one speed only",
                digits(multiple_m * 1e3),
                digits(period_m * 1e3),
                digits(*needed_hz)
            ),
            Self::NoInterval { what, groups } => {
                write!(
                    f,
                    "{what} is from {groups} group(s) only, so it has no confidence interval"
                )
            }
        }
    }
}
