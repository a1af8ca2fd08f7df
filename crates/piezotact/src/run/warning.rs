//! Warnings about a run.

use super::Ended;
use crate::number::{counted, rounded};
use crate::quantity::Band;
use serde::{Deserialize, Serialize};

/// Warnings about a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "code", rename_all = "snake_case")]
pub enum RunWarning {
    /// The device lost samples; straight lines stand in their place.
    #[error(
        "the device lost {} at {}, {:.1} ms at the longest; they were replaced by linear interpolation: close other programs; measure again",
        counted(*samples as usize, "sample"),
        counted(*gaps, "place"),
        1e3 * longest_s
    )]
    SamplesLost {
        gaps: usize,
        samples: u64,
        longest_s: f64,
        places_s: Vec<[f64; 2]>,
    },
    /// The run ended before its planned end.
    #[error("the run ended early, after {after_s:.2} s: {ended}")]
    EndedEarly { ended: Ended, after_s: f64 },
    /// The journal of the run is damaged; straight lines stand in the place of what was lost.
    #[error("the journal is damaged at {}: {}; leave these parts out; check the disk", counted(*places, "place"), lost(lost_s))]
    JournalDamaged {
        places: usize,
        lost_s: Vec<[f64; 2]>,
    },
    /// The first bytes of the run's journal name another format than the one as which it is read.
    #[error(
        "the journal states format {found}, but this version reads up to {read_as}; the rest of it can be read as format {read_as}, so its first \
            bytes are damaged: check the disk"
    )]
    JournalFormat { found: usize, read_as: usize },
    /// Not all of a drive was played, or the output ran dry.
    #[error(
        "{played} of {expected} samples of the drive were played, and the output buffer was empty {}: close other programs; play again",
        counted(*underruns, "time")
    )]
    PlaybackIncomplete {
        played: usize,
        expected: usize,
        underruns: usize,
    },
    /// No channel says whether the load was held.
    #[error(
        "no force was measured: it is not known whether {load_n} N was held; measure the force together with the acceleration",
        load_n = rounded(*load_n)
    )]
    ForceNotMeasured { load_n: f64 },
    /// The mean normal force differs from the load stated by the condition.
    #[error(
        "the mean normal force was {mean_n:.3} N, but the condition states {target_n} N: repeat while holding the stated force",
        target_n = rounded(*target_n)
    )]
    LoadOffTarget { mean_n: f64, target_n: f64 },
    /// A part of the normal force is clearly negative.
    #[error(
        "{} % of the samples of the normal force are negative by more than a tenth of {target} N (mean over all: {mean_n:.3} N): the sign of the \
            force cell is turned, or its zero has moved; check its unit and scale",
        rounded(100.0 * share),
        target = rounded(*target_n)
    )]
    ForceNegative {
        share: f64,
        mean_n: f64,
        target_n: f64,
    },
    /// The drive was played through an already measured transfer function instead of a device.
    #[error(
        "no finger was involved: this was played through {through}, which responds only over {answers_hz}, at one placement and without \
            distortion{}; play it on the device before relying on it",
        match own_warnings {
        0 => String::new(),
        1 => ", and has a warning of its own".into(),
        many => format!(", and has {many} warnings of its own"),
        }
    )]
    Rehearsed {
        through: String,
        answers_hz: Band,
        own_warnings: usize,
    },
}

/// The stretches of lost samples.
fn lost(lost_s: &[[f64; 2]]) -> String {
    if lost_s.is_empty() {
        return "no samples were lost".into();
    }
    let stretches: Vec<String> = lost_s
        .iter()
        .map(|[from, to]| format!("{from:.2}–{to:.2} s"))
        .collect();
    format!(
        "the samples of {} were lost, and were replaced by linear interpolation",
        stretches.join(", ")
    )
}
