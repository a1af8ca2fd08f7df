//! Warnings that arise from reading a recording.

use crate::checksum::Checksum;
use crate::number::rounded;
use crate::warning::words::percent;
use serde::{Deserialize, Serialize};

/// Warnings about the reading of a file, and about the condition of a recording.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "code", rename_all = "snake_case")]
pub enum RecordingWarning {
    /// A property that a file does not state was inferred from its content.
    #[error("{what}: check this assumption; state it in the file")]
    Guessed { what: String },
    /// Several normal forces, of which one is used.
    #[error(
        "there are {} normal forces ({}) and one is used; the signals of the cells of one platform must be summed first: name the channel of the \
            normal force",
        channels.len(),
        channels.join(", ")
    )]
    SeveralForces { channels: Vec<String> },
    /// Several forces, none of which has a name known as that of the normal force.
    #[error("{} in N: none of the names is that of a normal force; name the channel of the normal force", channels.join(", "))]
    NoNormalForce { channels: Vec<String> },
    /// Several motions, of which one is used.
    #[error(
        "`{channel}` is used, one of {count} motions in {unit}: name the channel of the motion"
    )]
    SeveralMotions {
        channel: String,
        unit: String,
        count: usize,
    },
    /// No acceleration: other channels are taken as the vibration.
    #[error(
        "no channel is in m/s²: {count} channels from `{first}` to `{last}` are used as the vibration; name the channel of the vibration"
    )]
    VibrationAssumed {
        first: String,
        last: String,
        count: usize,
    },
    /// Several accelerations, of which one is used.
    #[error(
        "`{channel}` is used as the vibration, one of {count} accelerations: name the channel of the vibration"
    )]
    SeveralAccelerations { channel: String, count: usize },
    /// A recording of touch is used as a texture as a whole.
    #[error(
        "all of {file} is used as the texture, including gesture and pauses, although it is a recording of touch: use a single stroke"
    )]
    TakenWhole { file: String },
    /// A rate was stated for a file whose own time stamps give another.
    #[error("the stated rate of {stated_hz} Hz was used, but the time stamps give {} Hz: check which value is correct", rounded(*found_hz))]
    RateStated { stated_hz: f64, found_hz: f64 },
    /// A rate was stated for a file that states its own and keeps it.
    #[error(
        "the stated rate of {stated_hz} Hz was not used: the header of the file gives {found_hz} Hz; do not state a rate; correct the file"
    )]
    RateNotUsed { stated_hz: f64, found_hz: f64 },
    /// Two scales are given for one file.
    #[error(
        "the stated scale {used} was used, not {ignored} from the sidecar: check which value is correct"
    )]
    ScaleOverridden { used: String, ignored: String },
    /// No physical scale is known for a signal.
    #[error(
        "{channel} has no physical scale (full scale = 1), and is not in m/s²: state the scale, or add a sidecar file"
    )]
    Uncalibrated { channel: String },
    /// Codes that lie outside the range that the file states for them.
    #[error(
        "`{channel}`: {samples} of {of} samples lie outside the range that the file states for its codes: its scale may be wrong; correct the file"
    )]
    #[serde(rename = "outside_stated_range")]
    OutsideRange {
        channel: String,
        samples: usize,
        of: usize,
    },
    /// Integers without a scale.
    #[error(
        "{channel} contains integers without a scale: its samples are counts of a converter, not m/s²; state the scale, or add a sidecar file"
    )]
    Counts { channel: String },
    /// A sidecar has entries that no part of the program reads.
    #[error("{} of {file} is not read: a sidecar has no entry of this name; correct the file", entries.join(", "))]
    UnknownEntries { file: String, entries: Vec<String> },
    /// A sidecar beside a file of a format that takes none.
    #[error(
        "{file} is not read: sidecars are read only for WAV and NumPy files, and this recording is {format}; state it in the file"
    )]
    SidecarNotRead { file: String, format: String },
    /// Cuts that do not say for which recording they were made.
    #[error(
        "{file} does not say for which recording its cuts were made: they are applied; where they are of this one, the line `# recording \
            {checksum}` says so; check the times of the cuts; state it in the file"
    )]
    CutsUnconfirmed { file: String, checksum: Checksum },
    /// Events that the recording does not hold.
    #[error(
        "{count} event(s) are outside the recording of {length_s:.3} s, the first at {onset_s} s for {lasts_s} s: correct the file",
        onset_s = rounded(*onset_s),
        lasts_s = rounded(*lasts_s)
    )]
    EventsOutside {
        count: usize,
        onset_s: f64,
        lasts_s: f64,
        length_s: f64,
    },
    /// The time stamps are not evenly spaced.
    #[error("the time steps differ from their mean by up to {}: frequencies have the same uncertainty", percent(*worst))]
    UnevenSampling { worst: f64 },
    /// A recording that has no end document: it was interrupted, or is still running.
    #[error(
        "the recording is not complete: it was interrupted or is still running; {read_s:.3} s could be read"
    )]
    Interrupted { read_s: f64 },
    /// A later recording of the same name was interrupted.
    #[error(
        "a later recording of this name was interrupted and is stored in {file}: check whether this is the intended recording"
    )]
    InterruptedLater { file: String },
    /// A file with gaps, of which only the part before the first gap is used.
    #[error(
        "the recording was paused: the file holds {count} parts with gaps between them, and only the first is used, {lasts_s:.3} s of {all_s:.3} s; \
            keep the original file as well"
    )]
    OneSegment {
        count: usize,
        lasts_s: f64,
        all_s: f64,
    },
    /// Channels of one name, which were numbered.
    #[error("several channels are called {}: a number was added to their names; correct the file", names.join(", "))]
    ChannelsRenamed { names: Vec<String> },
    /// Samples that were added at the end to fill the last record of a file.
    #[error(
        "{samples} sample(s) were added at the end, with the last value of each channel: the format stores whole records; keep the original file as \
            well"
    )]
    Padded { samples: usize },
    /// A file format cannot carry part of what is written to it.
    #[error("{format} cannot store {what}: keep the original file as well")]
    FormatLoses { format: String, what: String },
    /// A measurement was made under another condition than the one its drive was rendered for.
    #[error(
        "the drive was rendered for {what} {rendered_for}, but measured with {measured}: characterise and render for {measured}"
    )]
    OtherCondition {
        what: String,
        rendered_for: String,
        measured: String,
    },
}
