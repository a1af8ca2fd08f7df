//! What is in a file or a folder.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use piezotact::device::{DeviceDescription, DriveSetup};
use piezotact::document::Content;
use piezotact::quantity::{Acceleration, Band, Drive, Quantity, SampleRate, Seconds, Unit};
use piezotact::recording::{Annotations, Clock, Condition, Provenance, Recording};
use piezotact::render::Rendering;
use piezotact::roles::Roles;
use piezotact::statistics::{mean, peak, standard_deviation};
use piezotact::transfer::{
    CoherenceSummary, Distortion, Limits, StoredIdentities, TransferFunction,
};
use piezotact::warning::{Merged, merged};
use serde::Serialize;

use crate::{Contents, ReadError, ReadOptions, TransferDocument, read_recording};

/// What is in a file or a folder: one form for each kind.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(untagged)]
pub enum InfoDocument<'a> {
    /// A recording.
    Recording(Box<RecordingInfo<'a>>),
    /// A transfer function.
    Transfer(Box<TransferInfo<'a>>),
    /// The index of a panel.
    Panel(PanelIndexInfo),
    /// A folder of runs.
    Runs(RunsInfo),
    /// The description of a device.
    Device(DeviceInfo<'a>),
}

impl Content for InfoDocument<'_> {
    const SCHEMA: &'static str = "info";
}

/// A channel of a recording in numbers.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct ChannelSummary {
    /// Its name.
    pub name: String,
    /// Its unit.
    pub unit: Unit,
    /// Its mean, in `unit`.
    pub mean: f64,
    /// Its standard deviation, in `unit`.
    pub standard_deviation: f64,
    /// The largest absolute value, in `unit`.
    pub peak: f64,
}

/// The channels of one clock.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct ClockSummary {
    /// Their rate, Hz.
    pub rate_hz: SampleRate,
    /// The time of their first sample, s.
    pub start_s: Seconds,
    /// How many samples each has.
    pub samples: usize,
    /// Their names.
    pub channels: Vec<String>,
}

impl ClockSummary {
    /// The clock.
    #[must_use]
    pub fn clock(&self) -> Clock {
        Clock {
            rate_hz: self.rate_hz,
            start_s: self.start_s,
        }
    }
}

/// A recording in numbers: its channels by mean, spread and peak, without their samples.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct RecordingInfo<'a> {
    /// The file.
    pub file: &'a Path,
    /// What kind of file it is.
    pub kind: String,
    /// The rate of its first channel, Hz.
    pub rate_hz: SampleRate,
    /// How many samples its first channel has.
    pub samples: usize,
    /// How long it is, s.
    pub duration_s: Seconds,
    /// Its channels.
    pub channels: Vec<ChannelSummary>,
    /// The channels from which nothing is computed unless they are named; absent where there are none.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub without_role: Vec<&'a str>,
    /// The channels of each clock; absent where there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub clocks: Option<Vec<ClockSummary>>,
    /// Time, labels and events; absent where there are none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub annotations: Option<&'a Annotations>,
    /// Who touched what, and how.
    pub condition: &'a Condition,
    /// Where it comes from.
    pub provenance: &'a Provenance,
    /// The device that played, or that a drive is for.
    pub drive_setup: Option<&'a DriveSetup>,
    /// How the drive was made.
    pub rendering: Option<&'a Rendering>,
    /// The transfer function that an analyser stored beside the signals; absent where there is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stored_transfer: Option<TransferInfo<'a>>,
    /// What limits it.
    pub warnings: Vec<Merged>,
}

/// How many events of each kind and value `recording` has, in the order in which they first appear.
#[must_use]
pub fn event_counts(recording: &Recording) -> Vec<(String, usize)> {
    let mut places = BTreeMap::new();
    let mut counts: Vec<(String, usize)> = Vec::new();
    for event in &recording.annotations.events {
        let name = match &event.value {
            Some(value) => format!("{} {value}", event.kind),
            None => event.kind.clone(),
        };
        let place = *places.entry(name.clone()).or_insert(counts.len());
        match counts.get_mut(place) {
            Some((_, count)) => *count += 1,
            None => counts.push((name, 1)),
        }
    }
    counts
}

/// The channels of each clock of `recording`, with the number of their samples.
#[must_use]
pub fn clock_summaries(recording: &Recording) -> Vec<ClockSummary> {
    let of = |clock: &Clock| {
        let channels = recording.channels_with_clocks();
        let channels: Vec<_> = channels
            .filter_map(|(channel, own)| (own == *clock).then_some(channel))
            .collect();
        ClockSummary {
            rate_hz: clock.rate_hz,
            start_s: clock.start_s,
            samples: channels.first().map_or(0, |channel| channel.samples.len()),
            channels: (channels.iter())
                .map(|channel| channel.name.clone())
                .collect(),
        }
    };
    recording.clocks().iter().map(of).collect()
}

impl<'a> RecordingInfo<'a> {
    /// What was read from `file`, with the transfer function stored in it.
    #[must_use]
    pub fn of(
        file: &'a Path,
        contents: &'a Contents,
        stored_transfer: Option<TransferInfo<'a>>,
    ) -> Self {
        let recording = &contents.recording;
        let annotated = recording.annotations != Annotations::default();
        Self {
            file,
            kind: contents.kind.to_string(),
            rate_hz: recording.rate(),
            samples: recording.len(),
            duration_s: recording.duration(),
            channels: (recording.channels().iter())
                .map(|channel| ChannelSummary {
                    name: channel.name.clone(),
                    unit: channel.unit.clone(),
                    mean: mean(&channel.samples),
                    standard_deviation: standard_deviation(&channel.samples),
                    peak: peak(&channel.samples),
                })
                .collect(),
            without_role: Roles::guess(recording).0.without_part(recording),
            clocks: (recording.clocks().len() > 1).then(|| clock_summaries(recording)),
            annotations: annotated.then_some(&recording.annotations),
            condition: &recording.about.condition,
            provenance: &recording.about.provenance,
            drive_setup: contents.setup.as_ref(),
            rendering: contents.rendering.as_ref(),
            stored_transfer,
            warnings: merged(&recording.about.warnings),
        }
    }
}

/// A transfer function in numbers: what its file states beside it, and what a person asks first.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct TransferInfo<'a> {
    /// The file.
    pub file: &'a Path,
    /// What it is: "transfer function".
    pub kind: &'static str,
    /// The unit of the drive.
    pub drive_unit: Unit,
    /// The unit of the response.
    pub response_unit: Unit,
    /// How many lines it has.
    pub lines: usize,
    /// The frequency of the highest line, Hz.
    pub highest_hz: f64,
    /// What its limits hold; absent where the averages are not known or of one hit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub limits: Option<Limits>,
    /// How it agrees with the spectra stored beside it; absent where none were.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub identities: Option<StoredIdentities>,
    /// Noise and distortion; absent where nothing told them apart.
    pub distortion: Option<Distortion>,
    /// Coherence over the band that is usually rendered; absent where no line lies in it, and of an impact test of one hit.
    pub coherence: Option<CoherenceSummary>,
    /// What it was estimated from and what limits it.
    #[serde(flatten)]
    pub function: TransferFunction<Drive, Acceleration>,
}

impl<'a> TransferInfo<'a> {
    /// What `document`, read from `file`, holds, with its coherence over `band`.
    ///
    /// # Errors
    /// [`ReadError`] where its columns are no transfer function.
    pub fn of(file: &'a Path, document: &TransferDocument, band: Band) -> Result<Self, ReadError> {
        // Read as what it says it is, so that what is wrong with it is found here.
        let mut read = document.clone();
        (read.drive_unit, read.response_unit) = (Drive::UNIT, Acceleration::UNIT);
        let function = read.function::<Drive, Acceleration>(file)?;
        Ok(Self {
            file,
            kind: "transfer function",
            drive_unit: document.drive_unit.clone(),
            response_unit: document.response_unit.clone(),
            lines: function.response().len(),
            highest_hz: function.highest_hz(),
            limits: function.confidence().map(|_| function.limits()),
            identities: document.identities.clone(),
            distortion: document.distortion.clone(),
            coherence: function.coherence_in(band),
            function,
        })
    }
}

/// The index of a panel.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct PanelIndexInfo {
    /// The file.
    pub file: PathBuf,
    /// What it is: "index of a panel".
    pub kind: &'static str,
    /// How many measurements it lists.
    pub measurements: usize,
    /// The command that reads it.
    pub read_with: String,
}

impl PanelIndexInfo {
    /// The index in `file`, which the command `read_with` reads. An index that is no JSON lists nothing.
    ///
    /// # Errors
    /// [`ReadError`] where the file cannot be read.
    pub fn of(file: &Path, read_with: String) -> Result<Self, ReadError> {
        let text = crate::input::read_input_text(file)?;
        let index: serde_json::Value = serde_json::from_str(&text).unwrap_or_default();
        Ok(Self {
            file: file.to_owned(),
            kind: "index of a panel",
            measurements: index["entries"].as_array().map_or(0, Vec::len),
            read_with,
        })
    }
}

/// A folder of runs that a command kept.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct RunsInfo {
    /// The folder.
    pub file: PathBuf,
    /// What it is: "kept runs".
    pub kind: &'static str,
    /// The runs.
    pub runs: Vec<RunInfo>,
}

impl RunsInfo {
    /// The runs in `folder`, by name.
    ///
    /// # Errors
    /// [`ReadError`] where the folder cannot be read; a run that cannot is listed with the reason.
    pub fn of(folder: &Path) -> Result<Self, ReadError> {
        let failed = |error| ReadError::io(folder, &error);
        let mut files: Vec<PathBuf> = Vec::new();
        for entry in std::fs::read_dir(folder).map_err(failed)? {
            let path = entry.map_err(failed)?.path();
            let ending = path.extension().and_then(|ending| ending.to_str());
            if matches!(ending, Some("parquet" | "part")) {
                files.push(path);
            }
        }
        files.sort();
        let run = |file: &PathBuf| {
            let contents = read_recording(file, &ReadOptions::default());
            RunInfo::of(file, &contents)
        };
        Ok(Self {
            file: folder.to_owned(),
            kind: "kept runs",
            runs: files.iter().map(run).collect(),
        })
    }
}

/// A run in such a folder.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(untagged)]
pub enum RunInfo {
    /// One that cannot be read.
    Unreadable {
        /// Its file.
        file: PathBuf,
        /// How it ended: "unreadable".
        ended: &'static str,
        /// Why it cannot be read.
        why: String,
    },
    /// One that can be read.
    Read {
        /// Its file.
        file: PathBuf,
        /// What kind of file it is.
        kind: String,
        /// How long it is, s.
        duration_s: Seconds,
        /// How it ended: "ended" or "interrupted".
        ended: &'static str,
        /// Who touched what, and how.
        condition: Box<Condition>,
        /// What was done.
        steps: Vec<String>,
        /// What limits it.
        warnings: Vec<Merged>,
    },
}

impl RunInfo {
    /// What was read from `file`, or why it could not be.
    #[must_use]
    pub fn of(file: &Path, contents: &Result<Contents, ReadError>) -> Self {
        let file = file.to_owned();
        let contents = match contents {
            Ok(contents) => contents,
            Err(error) => {
                return Self::Unreadable {
                    file,
                    ended: "unreadable",
                    why: error.to_string(),
                };
            }
        };
        let about = &contents.recording.about;
        Self::Read {
            file,
            kind: contents.kind.to_string(),
            duration_s: contents.recording.duration(),
            ended: match about.provenance.losses.is_interrupted {
                true => "interrupted",
                false => "ended",
            },
            condition: Box::new(about.condition.clone()),
            steps: about.provenance.steps.clone(),
            warnings: merged(&about.warnings),
        }
    }
}

/// The description of a device.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct DeviceInfo<'a> {
    /// The file.
    pub file: &'a Path,
    /// What it is: "description of a device".
    pub kind: &'static str,
    /// The device.
    pub device: DeviceDescription,
}
