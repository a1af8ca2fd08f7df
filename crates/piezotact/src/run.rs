//! The documents that an acquisition emits while it runs: a start, chunks of samples, judgements of them, and an end.
//!
//! Everything that acquires (a stroke, a characterisation, one step of a closed loop, a run of a panel) emits these
//! documents, and any number of [`Sink`]s take them: the journal on disk, a gate, a progress bar.

mod acquired;
mod warning;

pub use acquired::{Acquired, Played, Recorded, TwinRecorded};
pub use warning::RunWarning;

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::criterion::{Criterion, Outcome};
use crate::device::DriveSetup;
use crate::quantity::{SampleRate, Seconds, Unit};
use crate::recording::{
    About, Annotations, Channel, Clock, Event, Provenance, Recording, RecordingError,
};
use crate::warning::Warning;

/// What is known of a run before its first sample.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct RunStart {
    /// What the run is for; no two runs of a procedure share it.
    pub label: String,
    /// The rate of the channels.
    pub rate_hz: SampleRate,
    /// The channels' names and SI units, in the order of [`RunChunk::channels`].
    pub channels: Vec<(String, Unit)>,
    /// Condition and provenance: who touches what and how, which bench, which seed. Warnings are reported with [`RunEnd`].
    #[serde(flatten, serialize_with = "About::without_empty_warnings")]
    pub about: About,
    /// The start time, if the bench knows the time of day; labels; planned events.
    #[serde(flatten)]
    pub annotations: Annotations,
    /// The clock of each channel; none where all run at [`Self::rate_hz`] from the first sample on.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub clocks: Vec<Clock>,
    /// The device that plays; absent where nothing plays or nothing describes it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub setup: Option<DriveSetup>,
    /// The checksum of the drive that is played; absent if nothing is played or the drive is generated during the run.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub drive: Option<crate::checksum::Checksum>,
    /// How long it is expected to take, s; absent where it ends when it is stopped.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub expected_s: Option<Seconds>,
}

/// Consecutive samples of the channels that share one clock: one list per channel, all of the same length.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct RunChunk {
    /// The index of its first sample in the run, lost samples counted.
    pub first: u64,
    /// The device's own time of its first sample, s, since the device started; absent where it has none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub device_s: Option<f64>,
    /// Samples that the device lost just before the first one.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub lost: u64,
    /// The index of the clock that its channels share, in order of first appearance in [`RunStart::clocks`]; 0 if there is only
    /// one.
    #[serde(default, skip_serializing_if = "is_zero_clock")]
    pub clock: u32,
    /// One list of samples for each channel of that clock, in its SI unit.
    pub channels: Vec<Vec<f64>>,
}

fn is_zero_clock(clock: &u32) -> bool {
    *clock == 0
}

fn is_zero(count: &u64) -> bool {
    *count == 0
}

impl RunChunk {
    /// The number of samples of each channel.
    #[must_use]
    pub fn len(&self) -> usize {
        self.channels.first().map_or(0, Vec::len)
    }

    /// Whether it holds no samples.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// The quantities judged during a run or directly after it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum RunCriterion {
    /// How far the mean force departs from its target, as a share of the target.
    Force,
    /// The median coherence of the excited lines.
    Coherence,
    /// The correlation of a repeat with the first, −1 to 1: a negative value means the opposite sign.
    Polarity,
}

impl fmt::Display for RunCriterion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Force => "relative deviation of the mean force from its target",
            Self::Coherence => "median coherence of the excited lines",
            Self::Polarity => "correlation with the first repeat",
        })
    }
}

/// The judgement of one window of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Judged {
    /// From when to when, s since the first sample.
    pub window_s: [f64; 2],
    /// The target force, N, if there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub target_n: Option<f64>,
    /// The criteria, each with the value found.
    pub criteria: Vec<Criterion<RunCriterion>>,
}

impl Judged {
    /// Whether all criteria are met.
    #[must_use]
    pub fn outcome(&self) -> Outcome {
        Outcome::of_all(self.criteria.iter().map(|criterion| criterion.outcome))
    }
}

/// One attempt at a measurement, and its judgement as a whole.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Attempt {
    /// Which repeat, from 1.
    pub repeat: usize,
    /// Which attempt at it, from 1.
    pub attempt: usize,
    /// For an accepted attempt the worst of its windows; for a repeated attempt the window that ended it.
    #[serde(flatten)]
    pub judged: Judged,
}

/// How a run ended.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(tag = "how", rename_all = "snake_case")]
pub enum Ended {
    /// It ran to its planned end.
    Completed,
    /// A criterion was not met.
    Refused,
    /// Somebody stopped it.
    Stopped,
    /// A device or a procedure failed.
    Failed {
        /// What it said.
        said: String,
    },
}

impl fmt::Display for Ended {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Completed => f.write_str("completed"),
            Self::Refused => f.write_str("refused by the gate"),
            Self::Stopped => f.write_str("stopped by hand"),
            Self::Failed { said } => write!(f, "failed: {said}"),
        }
    }
}

/// What is known of a run after its last sample.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct RunEnd {
    /// The number of samples of each channel, with those that were filled in for lost ones.
    pub samples: u64,
    /// How it ended.
    pub ended: Ended,
    /// The provenance of the start, completed with what became known during the run, such as the sensors' noise at rest.
    pub provenance: Provenance,
    /// What a person should know before relying on it, beside how it ended ([`Self::all_warnings`]).
    #[serde(alias = "doubts")]
    pub warnings: Vec<Warning>,
}

impl RunEnd {
    /// What to know of a run at `rate`: its warnings, and that it ended before its planned end where it did.
    #[must_use]
    pub fn all_warnings(&self, rate: SampleRate) -> Vec<Warning> {
        let mut warnings = self.warnings.clone();
        if self.ended != Ended::Completed {
            let early = RunWarning::EndedEarly {
                ended: self.ended.clone(),
                after_s: self.samples as f64 / rate.hz(),
            };
            warnings.push(early.into());
        }
        warnings
    }
}

/// One document of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(tag = "document", rename_all = "snake_case")]
pub enum RunDocument {
    /// The first.
    Start(Box<RunStart>),
    /// Samples.
    Chunk(RunChunk),
    /// What was judged.
    Judged(Judged),
    /// Something that happened.
    Event(Event),
    /// The last.
    End(Box<RunEnd>),
}

/// Why a sink could not take a document.
pub type SinkError = Box<dyn std::error::Error + Send + Sync>;

/// A consumer of run documents as they are emitted: a journal, a gate, a progress bar.
pub trait Sink {
    /// Takes the next document. A judgement that it returns is emitted to all sinks; if a criterion is not met, the run ends.
    ///
    /// # Errors
    /// Whatever keeps it from taking the document; the run then ends.
    fn take(&mut self, document: &RunDocument) -> Result<Option<Judged>, SinkError>;
}

/// A sink that discards all documents.
#[derive(Clone, Copy, Debug, Default)]
pub struct Discard;

impl Sink for Discard {
    fn take(&mut self, _document: &RunDocument) -> Result<Option<Judged>, SinkError> {
        Ok(None)
    }
}

/// Collects the documents of one run into a recording.
#[derive(Clone, Debug, Default)]
pub struct RunCollector {
    start: Option<RunStart>,
    samples: Vec<Vec<f64>>,
    events: Vec<Event>,
    end: Option<RunEnd>,
}

impl RunCollector {
    /// The recording, with the warnings of its end.
    ///
    /// # Errors
    /// [`RecordingError::NoChannel`] when nothing was started, else those of [`Recording::new`].
    pub fn recording(self) -> Result<Recording, RecordingError> {
        let start = self.start.ok_or(RecordingError::NoChannel)?;
        let channels = start
            .channels
            .into_iter()
            .zip(self.samples)
            .map(|((name, unit), samples)| Channel {
                name,
                unit,
                samples,
            })
            .collect();
        let mut about = start.about;
        if let Some(end) = self.end {
            about.warnings = end.all_warnings(start.rate_hz);
            about.provenance = end.provenance;
        }
        let mut recording = Recording::on_clocks(channels, start.rate_hz, &start.clocks, about)?;
        recording.annotations = start.annotations;
        recording.annotations.events.extend(self.events);
        Ok(recording)
    }
}

impl Sink for RunCollector {
    fn take(&mut self, document: &RunDocument) -> Result<Option<Judged>, SinkError> {
        match document {
            RunDocument::Start(start) => {
                self.samples = vec![Vec::new(); start.channels.len()];
                self.end = None;
                self.events = Vec::new();
                self.start = Some((**start).clone());
            }
            RunDocument::Chunk(chunk) => {
                let clocks = self.start.as_ref().map_or(&[][..], |start| &start.clocks);
                let numbers = Clock::numbered(clocks).1;
                let of_clock =
                    self.samples.iter_mut().enumerate().filter(|(k, _)| {
                        numbers.get(*k).copied().unwrap_or(0) == chunk.clock as usize
                    });
                for ((_, channel), new) in of_clock.zip(&chunk.channels) {
                    channel.extend(new);
                }
            }
            RunDocument::Judged(_) => {}
            RunDocument::Event(event) => self.events.push(event.clone()),
            RunDocument::End(end) => self.end = Some(RunEnd::clone(end)),
        }
        Ok(None)
    }
}
