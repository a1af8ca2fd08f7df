//! What a run leaves open.

use std::fmt;

use super::Ended;
use crate::doubt::{Advice, DoubtKind, FieldValue, Subject, Value, doubts};
use crate::number::counted;
use crate::quantity::Band;

doubts! {
    /// What a run leaves open.
    pub enum RunDoubt {
        /// The device lost samples; straight lines stand in their place.
        SamplesLost("samples_lost") {
            /// At how many places.
            gaps: usize,
            /// How many samples of each channel.
            samples: u64,
            /// The longest gap, s.
            longest_s: f64,
            /// From when to when each of them lies, s; absent in recordings of before.
            places_s: Option<Vec<[f64; 2]>>,
        },
        /// The run ended before its end.
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
            /// The samples that were lost, from when to when, s; none where only what was judged or the end was lost.
            lost_s: Vec<[f64; 2]>,
        },
        /// The journal of the run says in its first bytes that it has another format than the one it is read as.
        JournalFormat("journal_format") {
            /// The format that it says.
            found: usize,
            /// The format that it is read as, the newest that can be read.
            read_as: usize,
        },
        /// The journal of the run has no checksums: damage would not be seen.
        JournalUnchecked("journal_unchecked"),
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
            /// The load that the condition says, N.
            load_n: f64,
        },
        /// The mean normal force was not what the condition says.
        LoadOffTarget("load_off_target") {
            /// The mean force in N.
            mean_n: f64,
            /// The target in N.
            target_n: f64,
        },
        /// A drive was played through a transfer function that was measured before.
        Rehearsed("rehearsed") {
            /// The transfer function and where it comes from.
            through: String,
            /// Where it answers.
            answers_hz: Band,
            /// How many doubts it carries of its own.
            own_doubts: usize,
        },
    }
}

impl DoubtKind for RunDoubt {
    fn of(doubt: &crate::Doubt) -> Option<Self> {
        Self::of_doubt(doubt)
    }

    fn advice(&self) -> Vec<Advice> {
        use Advice::{Check, CloseOtherPrograms, MeasureAgain};
        match self {
            Self::SamplesLost { .. } => vec![CloseOtherPrograms, MeasureAgain],
            Self::EndedEarly { .. } => Vec::new(),
            Self::JournalDamaged { .. } => vec![Advice::LeaveOut, Check(Subject::Disk)],
            Self::JournalFormat { .. } => vec![Check(Subject::Disk)],
            Self::JournalUnchecked => Vec::new(),
            Self::PlaybackIncomplete { .. } => vec![CloseOtherPrograms, Advice::PlayAgain],
            Self::ForceNotMeasured { .. } => vec![Advice::MeasureForce],
            Self::LoadOffTarget { .. } => vec![Advice::HoldForce],
            Self::Rehearsed { own_doubts: 0, .. } => vec![Advice::PlayOnDevice],
            Self::Rehearsed { .. } => vec![Advice::ShowDoubts, Advice::PlayOnDevice],
        }
    }
}

impl fmt::Display for RunDoubt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::SamplesLost {
                gaps,
                samples,
                longest_s,
                ..
            } => write!(
                f,
                "the device lost {} at {}, {:.1} ms at the longest; straight lines stand in their place",
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
                        "the samples of {} were lost, and straight lines stand in their place",
                        lost.join(", ")
                    ),
                };
                let places = counted(*places, "place");
                write!(f, "the journal is damaged at {places}: {lost}")
            }
            Self::JournalFormat { found, read_as } => write!(
                f,
                "the journal says format {found}, this version reads up to {read_as}; all of it reads as format {read_as}, so that its first bytes are damaged"
            ),
            Self::JournalUnchecked => f.write_str(
                "the journal has no checksums, as those of the first version: damage to its samples would not be seen",
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
                "{played} of {expected} samples of the drive were played and the output ran dry {}",
                counted(*underruns, "time")
            ),
            Self::ForceNotMeasured { load_n } => write!(
                f,
                "no force was measured: whether {load_n} N was held is not known"
            ),
            Self::LoadOffTarget { mean_n, target_n } => write!(
                f,
                "the mean normal force was {mean_n:.3} N, the condition says {target_n} N"
            ),
            Self::Rehearsed {
                through,
                answers_hz,
                own_doubts,
            } => {
                write!(
                    f,
                    "no finger was touched: this was played through {through}, which answers over {answers_hz} alone, at one placement and without distortion"
                )?;
                match own_doubts {
                    0 => Ok(()),
                    1 => f.write_str(", and carries a doubt of its own"),
                    many => write!(f, ", and carries {many} doubts of its own"),
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
