//! What a run acquired, as documents have it.

use serde::Serialize;

use super::RunStart;
use crate::document::Content;
use crate::quantity::{SampleRate, Seconds, Unit};
use crate::recording::{About, Recording};
use crate::warning::Warning;

/// What a run acquired: rate, length and channels without the samples, which have a file of their own.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Acquired {
    /// The rate of the channels, Hz.
    pub rate_hz: SampleRate,
    /// How long it is, s.
    pub duration_s: Seconds,
    /// Names and units of the channels.
    pub channels: Vec<(String, Unit)>,
    /// Who touched what and how, where it comes from, and what limits it.
    #[serde(flatten, serialize_with = "About::merged")]
    #[cfg_attr(
        feature = "schemas",
        schemars(with = "crate::recording::MergedAbout<'static>")
    )]
    pub about: About,
}

impl Acquired {
    /// The run of `samples` samples that began with `start`, with its `warnings`.
    ///
    /// Source: decision 0046 of this project.
    #[must_use]
    pub fn of_run(start: &RunStart, samples: usize, warnings: Vec<Warning>) -> Self {
        Self {
            rate_hz: start.rate_hz,
            duration_s: start.rate_hz.duration_of(samples),
            channels: start.channels.clone(),
            about: About {
                warnings,
                ..start.about.clone()
            },
        }
    }

    /// The whole of `recording`.
    ///
    /// Source: decision 0046 of this project.
    #[must_use]
    pub fn of(recording: &Recording) -> Self {
        let channels = recording.channels().iter();
        Self {
            rate_hz: recording.rate(),
            duration_s: recording.duration(),
            channels: channels
                .map(|channel| (channel.name.clone(), channel.unit.clone()))
                .collect(),
            about: recording.about.clone(),
        }
    }
}

/// What a finger answered to a drive that was played.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(transparent)]
pub struct Played(pub Acquired);

impl Content for Played {
    const SCHEMA: &'static str = "play";
    const VERSION: u32 = 2;
}

/// What sensors acquired while a person touched something.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(transparent)]
pub struct Recorded(pub Acquired);

impl Content for Recorded {
    const SCHEMA: &'static str = "record";
    const VERSION: u32 = 2;
}

/// What a finger did on a bench of the twin, or the EEG of its person.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(transparent)]
pub struct TwinRecorded(pub Acquired);

impl Content for TwinRecorded {
    const SCHEMA: &'static str = "twin_record";
    const VERSION: u32 = 2;
}
