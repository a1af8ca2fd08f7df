//! Warnings about recordings: what their files state, what they lack, and what made them.

use super::lost::LostBy;
use crate::checksum::Checksum;
use crate::number::{digits, rounded};
use crate::quantity::Band;
use crate::warning::Example;
use crate::warning::words::{first_of, percent};
use serde::{Deserialize, Serialize};
use std::fmt;

/// Warnings about the reading of a file, and about the condition of a recording.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "code", rename_all = "snake_case")]
pub enum RecordingWarning {
    /// A property that a file does not state was inferred from its content.
    #[error("{what}: check this assumption; state it in the file")]
    Guessed { what: String },
    /// A recording of touch is used as a texture as a whole.
    #[error(
        "all of {file} is used as the texture, including gesture and pauses, although it is a recording of touch: use a single stroke"
    )]
    TakenWhole { file: String },
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
    /// Cuts that do not say for which recording they were made.
    #[error(
        "{file} does not say for which recording its cuts were made: they are applied; where they are of this one, the line `# recording \
            {checksum}` says so; check the times of the cuts; state it in the file"
    )]
    CutsUnconfirmed { file: String, checksum: Checksum },
    /// A recording that has no end document: it was interrupted, or is still running.
    #[error(
        "the recording is not complete: it was interrupted or is still running; {read_s:.3} s could be read"
    )]
    Interrupted { read_s: f64 },
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
    /// A file format cannot carry part of what is written to it.
    #[error("{format} cannot store {what}: keep the original file as well")]
    FormatLoses { format: String, what: String },
    /// What is used together may not belong together.
    #[error("{what}: {}", what.advice())]
    OtherOrigin {
        #[serde(flatten)]
        what: OtherOrigin,
    },
    /// What is beside a recording, or in a file beside it, and is not used.
    #[error("{what}; {}", what.advice())]
    NotUsed {
        #[serde(flatten)]
        what: NotUsed,
    },
    /// A channel was chosen for a role among several, or none has a name known as that of the role.
    #[error("{}; name the channel of the {role}", chosen(*role, channel.as_deref(), of))]
    ChannelChosen {
        role: ChannelRole,
        channel: Option<String>,
        of: Vec<String>,
    },
    /// A condition is not the one that was asked for.
    #[error("{what}: {}", what.advice())]
    ConditionDiffers {
        #[serde(flatten)]
        what: Reached,
    },
    /// No person felt it or answered: it was simulated.
    #[error("{by}; {}", by.advice())]
    Simulated {
        #[serde(flatten)]
        by: Simulated,
    },
    /// Two clocks differ, or a delay moves.
    #[error("{of}; {}", of.advice())]
    ClocksDiffer {
        #[serde(flatten)]
        of: Clocks,
    },
    /// A signal has the wrong sign, or had it and was reversed.
    #[error("{of}; {}", of.advice())]
    #[serde(rename = "sign_reversed")]
    Sign {
        #[serde(flatten)]
        of: ReversedSign,
    },
    /// Samples were lost, or may have been.
    #[error("{by}; {}", by.advice())]
    SamplesLost {
        #[serde(flatten)]
        by: LostBy,
    },
    /// Samples or points that are not evenly spaced were read as if they were.
    #[error(
        "the steps of {of} differ from their mean by up to {}, and {} are uncertain by as much; resample the file, or export it with even steps",
        percent(*worst),
        match of { Steps::Time => "frequencies", Steps::Place => "slopes and spacings" }
    )]
    UnevenSteps { worst: f64, of: Steps },
    /// What was stated contradicts the file.
    #[error("{what}; {}", what.advice())]
    StatedDiffers {
        #[serde(flatten)]
        what: Stated,
    },
    /// A channel that is missing, and what is assumed without it.
    #[error("{what}; {}", what.advice())]
    ChannelMissing {
        #[serde(flatten)]
        what: MissingChannel,
    },
}

/// What a channel is missing for.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "what", rename_all = "snake_case")]
pub enum MissingChannel {
    /// No channel says where strokes are: the whole recording is taken as one.
    #[error(
        "no channel of force or speed was recorded: the whole recording is analysed as one stroke"
    )]
    Cutting,
    /// Neither vibration nor friction says whether the finger slides.
    #[error(
        "every contact is analysed as a stroke: hesitations and stick-slip are not detected (because vibration and tangential force are missing, or \
            as requested)"
    )]
    Sliding,
    /// No force says whether the finger touches.
    #[error(
        "no normal force was recorded: the finger is assumed to touch whenever the surface moves"
    )]
    Contact,
    /// No channel records what is played: timing and level are not checked.
    #[error(
        "no input records what is played: delay, level, lost samples and silent parts of the playback are not checked"
    )]
    Loopback,
    /// A sound input does not pass 0 Hz: a steady force is not recorded.
    #[error(
        "`{channel}` is recorded by a sound input, which does not pass 0 Hz: a steady force is not in it"
    )]
    SteadyForce { channel: String },
    /// Channels that are called as forces, in another unit.
    #[error(
        "{}: named as a force, but not used as a force: the unit is not N",
        first_of(channels, ", ")
    )]
    ForceUnit { channels: Vec<String> },
}

impl MissingChannel {
    /// What a person can do.
    fn advice(&self) -> &'static str {
        match self {
            Self::Cutting => "cut the strokes by hand",
            Self::Sliding => "record the vibration or the tangential force too",
            Self::Contact | Self::SteadyForce { .. } => {
                "measure the force together with the acceleration"
            }
            Self::Loopback => "connect the output to an input",
            Self::ForceUnit { .. } => "state its scale, in N per unit",
        }
    }
}

/// What was stated, and contradicts the file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "what", rename_all = "snake_case")]
pub enum Stated {
    /// A rate was stated for a file whose own time stamps give another.
    #[error("the stated rate of {stated_hz} Hz was used, but the time stamps give {} Hz", rounded(*found_hz))]
    Rate { stated_hz: f64, found_hz: f64 },
    /// A rate was stated for a file that states its own and keeps it.
    #[error(
        "the stated rate of {stated_hz} Hz was not used: the header of the file gives {found_hz} Hz"
    )]
    RateKept { stated_hz: f64, found_hz: f64 },
    /// Two scales are given for one file.
    #[error("the stated scale {used} was used, not {ignored} from the sidecar")]
    Scale { used: String, ignored: String },
}

impl Stated {
    /// What a person can do.
    fn advice(&self) -> &'static str {
        match self {
            Self::Rate { .. } | Self::Scale { .. } => "check which value is correct",
            Self::RateKept { .. } => "do not state a rate, or correct the file",
        }
    }
}

/// Along what steps are not even.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Steps {
    /// Time.
    Time,
    /// A profile or a map.
    Place,
}

impl fmt::Display for Steps {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Time => "time",
            Self::Place => "place",
        })
    }
}

/// Whose sign is reversed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "of", rename_all = "snake_case")]
pub enum ReversedSign {
    /// A force that is negative in contact was taken with its sign reversed.
    #[error("{channel} is negative in contact and its sign was reversed")]
    Contact { channel: String },
    /// The pulses of the force are negative.
    #[error(
        "the force is negative in the hits (peak {}), although a hammer pushes: either it hit against the direction of the sensor, or the sign of \
            the force is reversed and the phase is off by 180°",
        digits(*peak)
    )]
    Hits { peak: f64 },
    /// A part of the normal force is clearly negative.
    #[error(
        "{} % of the samples of the normal force are negative by more than a tenth of {target} N (mean over all: {mean_n:.3} N): the sign of the \
            force cell is turned, or its zero has moved",
        rounded(100.0 * share),
        target = rounded(*target_n)
    )]
    Force {
        share: f64,
        mean_n: f64,
        target_n: f64,
    },
    /// The force takes power out of the finger: one of two channels has the wrong sign.
    #[error(
        "the force seems to extract power from the finger: force or acceleration has the wrong sign"
    )]
    Power,
    /// A measurement whose sign is opposite to most others' of the same load and angle.
    #[error(
        "{measurement} has the opposite sign to {count} of the {of_others} others at this load and angle, such as {such_as}: one of its channels \
            may be inverted"
    )]
    Member {
        measurement: String,
        count: usize,
        of_others: usize,
        such_as: Example,
    },
    /// The measurement follows its target with the sign reversed.
    #[error(
        "the measurement follows its target with the sign reversed (correlation {correlation:.3})"
    )]
    Measurement { correlation: f64 },
}

impl ReversedSign {
    /// What a person can do.
    fn advice(&self) -> &'static str {
        match self {
            Self::Force { .. } => "check the polarity and the zero of the force cell",
            Self::Member { .. } => "invert that channel and add the measurement again",
            Self::Contact { .. } | Self::Hits { .. } | Self::Power | Self::Measurement { .. } => {
                "check the polarity of the sensors and the actuator"
            }
        }
    }
}

/// Which clocks differ.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "of", rename_all = "snake_case")]
pub enum Clocks {
    /// Drive and response were sampled with two clocks; the response was corrected to the clock of the drive.
    #[error(
        "the clock of the response runs {ppm:.1} ± {uncertainty_ppm:.1} parts per million faster than that of the drive: the response was resampled \
            to the clock of the drive"
    )]
    Response { ppm: f64, uncertainty_ppm: f64 },
    /// The clocks of playback and recording differ, and the measurement was compared after correcting for it.
    #[error(
        "the clocks of playback and recording differ by {ppm:+.1} ppm: compared after correcting for it"
    )]
    Playback { ppm: f64 },
    /// The clocks of output and input differ.
    #[error(
        "the clock of the input runs {} ppm {} than that of the output (±{} ppm, 95 %): what was recorded shares one clock, and verifications are \
            corrected for it; every other comparison with the drive that was played is off by more and more",
        digits(ppm.abs()),
        if *ppm >= 0.0 { "faster" } else { "slower" },
        digits(*uncertainty_ppm)
    )]
    Device { ppm: f64, uncertainty_ppm: f64 },
    /// The delay changes over time in a way that neither clock drift nor lost samples explain.
    #[error(
        "the delay of the measurement varies by {:.2} ms rms, which neither two clocks nor lost samples explain",
        rms_s * 1e3
    )]
    Wanders { rms_s: f64 },
    /// When the force was measured is less certain than force and acceleration need.
    #[error(
        "the time of each force reading is known to ±{} ms only, which is more than {} ms: force and acceleration may be out of step",
        digits(1e3 * uncertainty_s),
        rounded(1e3 * most_s)
    )]
    Force { uncertainty_s: f64, most_s: f64 },
    /// A motion with a clock of its own was placed on that of the vibration.
    #[error(
        "`{channel}` has a clock of its own, {} Hz, which begins {} than that of `{onto}`, {} Hz: it was placed there by time, with straight lines \
            between its samples{}",
        rounded(*rate_hz),
        match *later_s < 0.0 {
            true => format!("{:.3} s earlier", -later_s),
            false => format!("{later_s:.3} s later"),
        },
        rounded(*onto_hz),
        outside.map_or(String::new(), |[from_s, to_s]| format!(
            "; it was measured from {from_s:.3} s to {to_s:.3} s alone, and strokes outside are rejected"
        ))
    )]
    Motion {
        channel: String,
        rate_hz: f64,
        later_s: f64,
        onto: String,
        onto_hz: f64,
        /// Where it was measured, in s; absent where it always was.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        outside: Option<[f64; 2]>,
    },
}

impl Clocks {
    /// What a person can do.
    fn advice(&self) -> &'static str {
        match self {
            Self::Response { .. } | Self::Playback { .. } => {
                "drive playback and recording from one clock, or use short textures"
            }
            Self::Device { .. } => "align the channels",
            Self::Wanders { .. } => {
                "check whether the rate of the sound output changes, or the sensor moves"
            }
            Self::Force { .. } => "close other programs; measure again",
            Self::Motion { .. } => {
                "check that both devices state their start by one clock: speeds and places are off by what it is wrong"
            }
        }
    }
}

/// By what something was simulated.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "by", rename_all = "snake_case")]
pub enum Simulated {
    /// A drive was played through an already measured transfer function instead of a device.
    #[error(
        "no finger was involved: this was played through {through}, which responds only over {answers_hz}, at one placement and without \
            distortion{}",
        match own_warnings {
            0 => String::new(),
            1 => ", and has a warning of its own".into(),
            many => format!(", and has {many} warnings of its own"),
        }
    )]
    Transfer {
        through: String,
        answers_hz: Band,
        own_warnings: usize,
    },
    /// The digital twin made a recording.
    #[error(
        "the digital twin made this recording: no person took part, and nothing follows from it about people"
    )]
    Twin,
    /// Virtual volunteers answered, who judge as a model does.
    #[error(
        "virtual volunteers answered in {sessions} sessions, judging as the model `{judge}`: no person answered, and the answers are those of this \
            model"
    )]
    Volunteers { sessions: usize, judge: String },
    /// Stimuli were played to a finger that a bench simulates.
    #[error(
        "{session}: {playings} playings were on a simulated bench: no person felt them, and the answers say nothing about people"
    )]
    Bench { session: String, playings: usize },
}

impl Simulated {
    /// What a person can do.
    fn advice(&self) -> &'static str {
        match self {
            Self::Transfer { .. } => "play it on the device before relying on it",
            Self::Twin => "record people before relying on it",
            Self::Volunteers { .. } => "ask people before relying on it",
            Self::Bench { .. } => "play them on the device before relying on the answers",
        }
    }
}

/// Which condition was not reached.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "what", rename_all = "snake_case")]
pub enum Reached {
    /// The mean normal force differs from the load stated by the condition.
    #[error(
        "the mean normal force was {mean_n:.3} N, but the condition states {target_n} N",
        target_n = rounded(*target_n)
    )]
    Load { mean_n: f64, target_n: f64 },
    /// The speed differs from the requested one.
    #[error(
        "the speed was {:.2} mm/s, but {:.2} mm/s was requested, and frequencies and rms are those of the speed that was reached",
        mean_m_s * 1e3,
        target_m_s * 1e3
    )]
    Speed { mean_m_s: f64, target_m_s: f64 },
    /// The strokes were made at another load than the transfer function.
    #[error(
        "the strokes were made at {} N, the transfer function was measured at {} N",
        rounded(*strokes_n),
        rounded(*transfer_n)
    )]
    StrokesLoad {
        texture: String,
        strokes_n: f64,
        transfer_n: f64,
    },
    /// A measurement was made under another condition than the one its drive was rendered for.
    #[error("the drive was rendered for {of} {rendered_for}, but measured with {measured}")]
    RenderedFor {
        of: String,
        rendered_for: String,
        measured: String,
    },
    /// A measurement was made under another condition than the transfer function beside it.
    #[error(
        "the transfer function is that of {of} {function_of}, but the measurement that of {measured}"
    )]
    FunctionOf {
        of: String,
        function_of: String,
        measured: String,
    },
}

impl Reached {
    /// What a person can do.
    fn advice(&self) -> String {
        match self {
            Self::Load { .. } | Self::StrokesLoad { .. } => {
                "repeat while holding the stated force".into()
            }
            Self::Speed { .. } => "repeat at the requested speed, or state the speed".into(),
            Self::RenderedFor { measured, .. } => {
                format!("characterise and render for {measured}")
            }
            Self::FunctionOf { measured, .. } => {
                format!("give the transfer function of {measured}")
            }
        }
    }
}

/// What a channel is used as.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ChannelRole {
    /// The normal force.
    NormalForce,
    /// The tangential force.
    TangentialForce,
    /// The motion of the finger or the surface.
    Motion,
    /// The vibration.
    Vibration,
}

impl fmt::Display for ChannelRole {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NormalForce => "normal force",
            Self::TangentialForce => "tangential force",
            Self::Motion => "motion",
            Self::Vibration => "vibration",
        })
    }
}

/// Which channel of `of` was chosen for `role`.
fn chosen(role: ChannelRole, channel: Option<&str>, of: &[String]) -> String {
    let of = first_of(of, ", ");
    match (role, channel) {
        (ChannelRole::NormalForce, Some(channel)) => format!(
            "`{channel}` of {of} is used as the {role}, although the signals of the cells of one platform must be summed first"
        ),
        (ChannelRole::Vibration, None) => {
            format!("no channel is in m/s², and {of} are used as the {role}")
        }
        (_, Some(channel)) => format!("`{channel}` of {of} is used as the {role}"),
        (_, None) => format!("none of {of} has a name known as that of a {role}"),
    }
}

/// What is not used.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "what", rename_all = "snake_case")]
pub enum NotUsed {
    /// A sidecar has entries that no part of the program reads.
    #[error("{} in {file} is not used: a sidecar has no entry of this name", entries.join(", "))]
    Entries { file: String, entries: Vec<String> },
    /// A sidecar beside a file of a format that takes none.
    #[error("{file} is not read: a file of this kind ({format}) takes no sidecar")]
    Sidecar { file: String, format: String },
    /// Events that the recording does not hold.
    #[error(
        "{count} event(s) are outside the recording of {length_s:.3} s, the first at {onset_s} s for {lasts_s} s",
        onset_s = rounded(*onset_s),
        lasts_s = rounded(*lasts_s)
    )]
    Events {
        count: usize,
        onset_s: f64,
        lasts_s: f64,
        length_s: f64,
    },
    /// A person's cuts that lie outside the recording.
    #[error("{count} cuts of {file} are outside the recording and were not applied")]
    Cuts { file: String, count: usize },
    /// Transfer functions in the folder of a panel that its index does not list.
    #[error(
        "the folder contains transfer functions that panel.json does not list; they are left out: {}",
        first_of(files, ", ")
    )]
    TransferFunctions { files: Vec<String> },
}

impl NotUsed {
    /// What a person can do.
    fn advice(&self) -> &'static str {
        match self {
            Self::Entries { .. } | Self::Events { .. } => "correct the file",
            Self::Sidecar { .. } => "state in the recording what the sidecar states",
            Self::Cuts { .. } => "check the times of the cuts",
            Self::TransferFunctions { .. } => {
                "run the same command `panel run` again: it continues the panel"
            }
        }
    }
}

/// What may not belong together.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "what", rename_all = "snake_case")]
pub enum OtherOrigin {
    /// A measurement is compared with another texture than the one its drive was rendered from.
    #[error("the drive was rendered from {rendered} and is compared with {compared}")]
    Target { rendered: String, compared: String },
    /// Measurements of digital twins of different seeds.
    #[error(
        "the measurements are of digital twins of different seeds: {one} is of seed {one_seed}, {other} is of seed {other_seed}"
    )]
    Twins {
        one: String,
        one_seed: String,
        other: String,
        other_seed: String,
    },
    /// A later recording of the same name was interrupted.
    #[error("a later recording of this name was interrupted and is stored in {file}")]
    LaterRecording { file: String },
}

impl OtherOrigin {
    /// What a person can do.
    fn advice(&self) -> &'static str {
        match self {
            Self::Target { .. } => "check that they belong together",
            Self::Twins { .. } => "keep them in separate panels",
            Self::LaterRecording { .. } => "check whether this is the intended recording",
        }
    }
}
