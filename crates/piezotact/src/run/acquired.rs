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
    /// Source: docs/decisions/documents.md.
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
    /// Source: docs/decisions/documents.md.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::document::{Document, Kept};
    use crate::run::RunWarning;

    /// Two warnings of one kind are one, and those of the start are not written beside those of the end.
    #[test]
    fn a_recording_is_written_without_its_samples_and_with_its_warnings_once() {
        let mut start = RunStart {
            label: "touch".into(),
            rate_hz: SampleRate::new(5000.0).unwrap(),
            channels: vec![("force".into(), Unit::Newton)],
            about: About::default(),
            annotations: Default::default(),
            clocks: Vec::new(),
            setup: None,
            drive: None,
            expected_s: None,
        };
        let warning = |load_n| Warning::from(RunWarning::ForceNotMeasured { load_n });
        start.about.warnings = vec![warning(0.1)];
        let warnings = vec![warning(0.2), warning(0.3)];
        let recorded = Recorded(Acquired::of_run(&start, 7500, warnings));
        let kept = Kept {
            out: std::path::Path::new("r.parquet"),
            value: &recorded,
        };
        let text = serde_json::to_string(&Document::of(&kept)).unwrap();
        assert_eq!(text.matches("\"warnings\":").count(), 1, "{text}");
        let document: serde_json::Value = serde_json::from_str(&text).unwrap();
        assert_eq!(document["schema"], "record");
        assert_eq!(document["duration_s"], 1.5);
        assert_eq!(document["channels"], serde_json::json!([["force", "N"]]));
        assert_eq!(document["warnings"].as_array().unwrap().len(), 1);
        assert_eq!(document["warnings"][0]["seen"], 2);
    }
}
