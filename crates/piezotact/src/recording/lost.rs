//! Samples that were lost, whatever lost them.

use serde::{Deserialize, Serialize};

use crate::number::{counted, digits, digits_signed, rounded};

/// What lost samples.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "by", rename_all = "snake_case")]
pub enum LostBy {
    /// The device lost samples; straight lines stand in their place.
    #[error(
        "the device lost {} at {}, {:.1} ms at the longest; they were replaced by linear interpolation",
        counted(*samples as usize, "sample"),
        counted(*gaps, "place"),
        1e3 * longest_s
    )]
    Device {
        gaps: usize,
        samples: u64,
        longest_s: f64,
        places_s: Vec<[f64; 2]>,
    },
    /// Time stamps of a file lack samples; straight lines stand in their place.
    #[error(
        "{} missing between the time stamps at {}, {:.1} ms at the longest; they were replaced by linear interpolation",
        counted_are(*samples as usize),
        counted(*gaps, "place"),
        1e3 * longest_s
    )]
    Stamps {
        gaps: usize,
        samples: u64,
        longest_s: f64,
        places_s: Vec<[f64; 2]>,
    },
    /// The journal of the run is damaged; straight lines stand in the place of what was lost.
    #[error("the journal is damaged at {}: {}", counted(*places, "place"), lost(lost_s))]
    Journal {
        places: usize,
        lost_s: Vec<[f64; 2]>,
    },
    /// The first bytes of the run's journal name another format than the one as which it is read.
    #[error(
        "the journal states format {found}, but this version reads up to {read_as}; the rest of it can be read as format {read_as}, so its first \
            bytes are damaged"
    )]
    JournalHeader { found: usize, read_as: usize },
    /// Readings are missing over some time; straight lines stand in their place.
    #[error(
        "the force has no readings in {} longer than {} s, {} s together and {} s at the longest; it was interpolated linearly",
        counted(*gaps, "gap"),
        rounded(*longer_than_s),
        digits(*total_s),
        digits(*longest_s)
    )]
    Force {
        gaps: usize,
        longest_s: f64,
        total_s: f64,
        longer_than_s: f64,
    },
    /// Many of its lines could not be read.
    #[error(
        "{unreadable} of {lines} lines of {signal} could not be read, such as `{example}`, and their readings are missing"
    )]
    ForceLines {
        signal: String,
        unreadable: usize,
        lines: usize,
        example: String,
    },
    /// Samples of the response are missing without having been reported; the following samples were shifted back into place.
    #[error(
        "{:.0} samples of the {} are missing at about {at_s:.2} s and were not reported as lost: the later samples were shifted to their correct times",
        count.abs(),
        if *count < 0.0 { "drive" } else { "response" }
    )]
    Unreported { count: f64, at_s: f64 },
    /// The recording lost samples, and was compared after correcting for it.
    #[error(
        "the recording lost {samples:.0} samples at {places} place(s): compared after correcting for it"
    )]
    Recording { samples: f64, places: usize },
    /// The delay of the loopback stepped, and no loss was reported.
    #[error(
        "at {at_s:.2} s the delay from output to input stepped by {} ms: samples were lost or repeated, and the sound system did not report it",
        digits_signed(1e3 * by_s)
    )]
    DelayStep { at_s: f64, by_s: f64 },
    /// The engine left parts of the signal silent.
    #[error(
        "the loopback holds {} of silence, {samples} samples in all, where the drive has none",
        counted(*parts, "part")
    )]
    Silence { parts: usize, samples: usize },
    /// Callbacks of the sound system came late.
    #[error(
        "the sound system paused {}, at the longest for {} ms",
        counted(*times, "time"),
        digits(1e3 * longest_s)
    )]
    Pause { times: usize, longest_s: f64 },
    /// Not all of a drive was played, or the output ran dry.
    #[error(
        "{played} of {expected} samples of the drive were played, and the output buffer was empty {}",
        counted(*underruns, "time")
    )]
    Playback {
        played: usize,
        expected: usize,
        underruns: usize,
    },
    /// Segments that touch samples which were lost are left out of the estimate.
    #[error("{left_out} of {of} segments contain lost samples, and were left out")]
    Segments { left_out: usize, of: usize },
    /// Restarts without a latency, or with samples lost.
    #[error("of {}, {silent} had no signal in the loopback and {dropped} lost samples", counted(*restarts, "restart"))]
    Restarts {
        silent: usize,
        dropped: usize,
        restarts: usize,
    },
}

impl LostBy {
    /// What a person can do.
    pub(super) fn advice(&self) -> &'static str {
        match self {
            Self::Journal { .. } => "leave these parts out, and check the disk",
            Self::JournalHeader { .. } => "check the disk",
            Self::Stamps { .. } => "leave these parts out where they matter",
            Self::ForceLines { .. } => "check its cable and its range",
            Self::Device { .. }
            | Self::Force { .. }
            | Self::Unreported { .. }
            | Self::Recording { .. }
            | Self::DelayStep { .. }
            | Self::Silence { .. }
            | Self::Pause { .. }
            | Self::Playback { .. }
            | Self::Segments { .. }
            | Self::Restarts { .. } => "close other programs, and measure again",
        }
    }
}

/// `1 sample is`, `3 samples are`.
fn counted_are(samples: usize) -> String {
    let verb = if samples == 1 { "is" } else { "are" };
    format!("{} {verb}", counted(samples, "sample"))
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
