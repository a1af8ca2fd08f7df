//! Warnings about a run.

use std::fmt;

use super::Ended;
use crate::number::{counted, rounded};
use crate::quantity::Band;
use crate::warning::{Advice, FieldValue, Subject, Value, WarningKind, warnings};

warnings! {
    /// Warnings about a run.
    pub enum RunWarning {
        /// The device lost samples; straight lines stand in their place.
        SamplesLost("samples_lost") {
            /// At how many places.
            gaps: usize,
            /// How many samples of each channel.
            samples: u64,
            /// The longest gap, s.
            longest_s: f64,
            /// Start and end of each gap, s.
            places_s: Vec<[f64; 2]>,
        },
        /// The run ended before its planned end.
        EndedEarly("ended_early") {
            /// How.
            ended: Ended,
            /// After how long, s.
            after_s: f64,
        },
        /// The journal of the run is damaged; straight lines stand in the place of what was lost.
        JournalDamaged("journal_damaged") {
            /// At how many places.
            places: usize,
            /// Start and end of each stretch of lost samples, s; empty if only judgements or the end document were lost.
            lost_s: Vec<[f64; 2]>,
        },
        /// The first bytes of the run's journal name another format than the one as which it is read.
        JournalFormat("journal_format") {
            /// The format that it names.
            found: usize,
            /// The format that it is read as, the newest that can be read.
            read_as: usize,
        },
        /// Not all of a drive was played, or the output ran dry.
        PlaybackIncomplete("playback_incomplete") {
            /// Samples played.
            played: usize,
            /// Samples of the drive.
            expected: usize,
            /// Times the output ran dry.
            underruns: usize,
        },
        /// No channel says whether the load was held.
        ForceNotMeasured("force_not_measured") {
            /// The load stated by the condition, N.
            load_n: f64,
        },
        /// The mean normal force differs from the load stated by the condition.
        LoadOffTarget("load_off_target") {
            /// The mean force in N.
            mean_n: f64,
            /// The target in N.
            target_n: f64,
        },
        /// A part of the normal force is clearly negative.
        ForceNegative("force_negative") {
            /// The share of its samples below minus a tenth of the target, 0–1.
            share: f64,
            /// Its mean over all samples, N.
            mean_n: f64,
            /// The target in N.
            target_n: f64,
        },
        /// The drive was played through an already measured transfer function instead of a device.
        Rehearsed("rehearsed") {
            /// The transfer function and where it comes from.
            through: String,
            /// The band in which it responds.
            answers_hz: Band,
            /// How many warnings it carries of its own.
            own_warnings: usize,
        },
    }
}

impl WarningKind for RunWarning {
    fn of(warning: &crate::Warning) -> Option<Self> {
        Self::of_warning(warning)
    }

    fn advice(&self) -> Vec<Advice> {
        use Advice::{Check, CloseOtherPrograms, MeasureAgain};
        match self {
            Self::SamplesLost { .. } => vec![CloseOtherPrograms, MeasureAgain],
            Self::EndedEarly { .. } => Vec::new(),
            Self::JournalDamaged { .. } => vec![Advice::LeaveOut, Check(Subject::Disk)],
            Self::JournalFormat { .. } => vec![Check(Subject::Disk)],
            Self::PlaybackIncomplete { .. } => vec![CloseOtherPrograms, Advice::PlayAgain],
            Self::ForceNotMeasured { .. } => vec![Advice::MeasureForce],
            Self::LoadOffTarget { .. } => vec![Advice::HoldForce],
            Self::ForceNegative { .. } => vec![Check(Subject::UnitAndScale)],
            Self::Rehearsed {
                own_warnings: 0, ..
            } => vec![Advice::PlayOnDevice],
            Self::Rehearsed { .. } => vec![Advice::ShowWarnings, Advice::PlayOnDevice],
        }
    }
}

impl fmt::Display for RunWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::SamplesLost {
                gaps,
                samples,
                longest_s,
                ..
            } => write!(
                f,
                "the device lost {} at {}, {:.1} ms at the longest; they were replaced by linear interpolation",
                counted(*samples as usize, "sample"),
                counted(*gaps, "place"),
                1e3 * longest_s
            ),
            Self::JournalDamaged { places, lost_s } => {
                let lost: Vec<String> = lost_s
                    .iter()
                    .map(|[from, to]| format!("{from:.2}–{to:.2} s"))
                    .collect();
                let lost = match lost.is_empty() {
                    true => "no samples were lost".to_owned(),
                    false => format!(
                        "the samples of {} were lost, and were replaced by linear interpolation",
                        lost.join(", ")
                    ),
                };
                let places = counted(*places, "place");
                write!(f, "the journal is damaged at {places}: {lost}")
            }
            Self::JournalFormat { found, read_as } => write!(
                f,
                "the journal states format {found}, but this version reads up to {read_as}; the rest of it can be read as \
                    format {read_as}, so its first bytes are damaged"
            ),
            Self::EndedEarly { ended, after_s } => {
                write!(f, "the run ended early, after {after_s:.2} s: {ended}")
            }
            Self::PlaybackIncomplete {
                played,
                expected,
                underruns,
            } => write!(
                f,
                "{played} of {expected} samples of the drive were played, and the output buffer was empty {}",
                counted(*underruns, "time")
            ),
            Self::ForceNotMeasured { load_n } => write!(
                f,
                "no force was measured: it is not known whether {load_n} N was held",
                load_n = rounded(*load_n)
            ),
            Self::LoadOffTarget { mean_n, target_n } => write!(
                f,
                "the mean normal force was {mean_n:.3} N, but the condition states {target_n} N",
                target_n = rounded(*target_n)
            ),
            Self::ForceNegative {
                share,
                mean_n,
                target_n,
            } => write!(
                f,
                "{} % of the samples of the normal force are negative by more than a tenth of {target} N (mean over all: {mean_n:.3} N): the sign of the \
                 force cell is turned, or its zero has moved",
                rounded(100.0 * share),
                target = rounded(*target_n)
            ),
            Self::Rehearsed {
                through,
                answers_hz,
                own_warnings,
            } => {
                write!(
                    f,
                    "no finger was involved: this was played through {through}, which responds only over {answers_hz}, at one \
                        placement and without distortion"
                )?;
                match own_warnings {
                    0 => Ok(()),
                    1 => f.write_str(", and has a warning of its own"),
                    many => write!(f, ", and has {many} warnings of its own"),
                }
            }
        }
    }
}

impl FieldValue for Ended {
    fn into_value(self) -> Option<Value> {
        serde_json::to_value(self).ok().map(Value::from)
    }

    fn from_value(value: Option<&Value>) -> Option<Self> {
        serde_json::from_value(value?.clone().into()).ok()
    }
}
