//! What a recording lacks of its run.

use serde::{Deserialize, Serialize};

use crate::quantity::Seconds;

/// What a recording lacks of its run; nothing as a rule.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct Losses {
    /// How many samples of each channel the device lost.
    #[serde(skip_serializing_if = "is_zero")]
    pub samples: u64,
    /// From when to when straight lines stand for samples that the device or the journal lost, s.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub stretches_s: Vec<[f64; 2]>,
    /// Incomplete or interrupted playback of the drive; absent where it was complete.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub playback: Option<BrokenPlayback>,
    /// Whether the recording has no end: it was interrupted, or is still running.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub is_interrupted: bool,
}

fn is_zero(count: &u64) -> bool {
    *count == 0
}

/// A drive that was not played whole, or not in time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct BrokenPlayback {
    /// How many samples of the drive were played.
    pub played: usize,
    /// How many it has.
    pub expected: usize,
    /// How often the output buffer was empty.
    pub underruns: usize,
}

impl Losses {
    /// Whether nothing is lacking.
    #[must_use]
    pub fn are_none(&self) -> bool {
        *self == Self::default()
    }

    /// The longest stretch of lost samples, s; 0 where none was lost.
    #[must_use]
    pub fn longest(&self) -> Seconds {
        let lengths = self.stretches_s.iter().map(|[from, to]| to - from);
        Seconds(lengths.fold(0.0, f64::max))
    }

    /// The same for a part that begins `start` after the beginning of the recording and lasts `duration`: stretches outside are left
    /// out, and times count from its beginning.
    #[must_use]
    pub fn cut(mut self, start: Seconds, duration: Seconds) -> Self {
        let within = |at_s: f64| (at_s - start.0).clamp(0.0, duration.0);
        self.stretches_s = (self.stretches_s.iter())
            .map(|stretch| stretch.map(within))
            .filter(|[from, to]| from < to)
            .collect();
        self
    }
}
