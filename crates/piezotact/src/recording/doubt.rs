//! What the reading of a recording leaves open.

use std::fmt;

use crate::doubt::words::percent;
use crate::doubt::{Advice, ChannelRole, DoubtKind, Subject, doubts};

doubts! {
    /// What the reading of a file, and the condition of a recording, leave open.
    pub enum RecordingDoubt {
        /// Something that a file does not say was concluded from its content.
        Guessed("guessed") {
            /// What was guessed, and from what.
            what: String,
        },
        /// Several normal forces, of which one is used.
        SeveralForces("several_forces") {
            /// The channels.
            channels: Vec<String>,
        },
        /// Forces, none of which is known by its name as the normal force.
        NoNormalForce("no_normal_force") {
            /// The channels.
            channels: Vec<String>,
        },
        /// Several motions, of which one is used.
        SeveralMotions("several_motions") of Channel(taken) {
            /// The channel that is taken.
            taken: String,
            /// The unit in which it is.
            unit: String,
            /// How many there are.
            count: usize,
        },
        /// No acceleration: other channels are taken as the vibration.
        VibrationAssumed("vibration_assumed") {
            /// The first channel that is taken.
            first: String,
            /// The last.
            last: String,
            /// How many are taken.
            count: usize,
        },
        /// Several accelerations, of which one is used.
        SeveralAccelerations("several_accelerations") of Channel(taken) {
            /// The channel that is taken.
            taken: String,
            /// How many there are.
            count: usize,
        },
        /// A recording of touch is taken whole as a texture.
        TakenWhole("taken_whole") of File(file) {
            /// The file.
            file: String,
        },
        /// A rate was stated for a file whose own time stamps say another.
        RateStated("rate_stated") {
            /// The rate stated, Hz.
            stated_hz: f64,
            /// The rate of the time stamps, Hz.
            found_hz: f64,
        },
        /// A rate was stated for a file that states its own and keeps it.
        RateNotUsed("rate_not_used") {
            /// The rate stated, Hz.
            stated_hz: f64,
            /// The rate of the file, Hz.
            found_hz: f64,
        },
        /// Two scales are given for one file.
        ScaleOverridden("scale_overridden") {
            /// The scale that was used.
            used: String,
            /// The scale in the sidecar that was not.
            ignored: String,
        },
        /// No physical scale is known for a signal.
        Uncalibrated("uncalibrated") of Channel(channel) {
            /// The channel.
            channel: String,
        },
        /// Integers without a scale.
        Counts("counts") of Channel(channel) {
            /// The channel.
            channel: String,
        },
        /// A sidecar has entries that no part of the program reads.
        UnknownEntries("unknown_entries") of File(file) {
            /// The sidecar.
            file: String,
            /// The entries, such as `condition.smaple`.
            entries: Vec<String>,
        },
        /// A sidecar beside a file of a format that takes none.
        SidecarNotRead("sidecar_not_read") of File(file) {
            /// The sidecar.
            file: String,
            /// The format of the file beside it.
            format: String,
        },
        /// Events that the recording does not hold.
        EventsOutside("events_outside") {
            /// How many.
            count: usize,
            /// When the first of them begins, s.
            onset_s: f64,
            /// How long that one lasts, s.
            lasts_s: f64,
            /// The length of the recording, s.
            length_s: f64,
        },
        /// The time stamps are not evenly spaced.
        UnevenSampling("uneven_sampling") {
            /// The largest departure from the mean step, as a share of it.
            worst: f64,
        },
        /// A recording that has no end document: it was interrupted, or is still running.
        Interrupted("interrupted") {
            /// How much could be read, in s.
            read_s: f64,
        },
        /// A later recording of the same name was interrupted.
        InterruptedLater("interrupted_later") of File(journal) {
            /// Where its journal is.
            journal: String,
        },
        /// A file format cannot carry part of what is written to it.
        FormatLoses("format_loses") {
            /// The format.
            format: String,
            /// What it does not carry.
            what: String,
        },
        /// A measurement was made under another condition than the one its drive was rendered for.
        OtherCondition("other_condition") {
            /// What differs.
            what: String,
            /// As rendered for.
            rendered_for: String,
            /// As measured.
            measured: String,
        },
    }
}

impl DoubtKind for RecordingDoubt {
    fn of(doubt: &crate::Doubt) -> Option<Self> {
        Self::of_doubt(doubt)
    }

    fn advice(&self) -> Vec<Advice> {
        use Advice::{Check, NameChannel};
        match self {
            Self::Guessed { .. } => vec![Check(Subject::Assumption), Advice::StateInFile],
            Self::SeveralForces { .. } | Self::NoNormalForce { .. } => vec![NameChannel {
                role: ChannelRole::NormalForce,
            }],
            Self::SeveralMotions { .. } => vec![NameChannel {
                role: ChannelRole::Motion,
            }],
            Self::VibrationAssumed { .. } | Self::SeveralAccelerations { .. } => {
                vec![NameChannel {
                    role: ChannelRole::Vibration,
                }]
            }
            Self::TakenWhole { .. } => vec![Advice::TakeStroke],
            Self::RateStated { .. } | Self::ScaleOverridden { .. } => {
                vec![Check(Subject::WhichIsRight)]
            }
            Self::RateNotUsed { .. } => vec![Advice::OmitRate, Advice::CorrectFile],
            Self::Uncalibrated { .. } | Self::Counts { .. } => vec![Advice::StateScale],
            Self::UnknownEntries { .. } | Self::EventsOutside { .. } => {
                vec![Advice::CorrectFile]
            }
            Self::SidecarNotRead { .. } => vec![Advice::StateInFile],
            Self::UnevenSampling { .. } | Self::Interrupted { .. } => Vec::new(),
            Self::InterruptedLater { .. } => vec![Check(Subject::Journal)],
            Self::FormatLoses { .. } => vec![Advice::KeepOriginal],
            Self::OtherCondition { measured, .. } => vec![Advice::CharacteriseFor {
                condition: measured.clone(),
            }],
        }
    }
}

impl fmt::Display for RecordingDoubt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Guessed { what } => f.write_str(what),
            Self::SeveralForces { channels } => write!(
                f,
                "there are {} normal forces ({}) and one is used; cells of one platform have to be added together first",
                channels.len(),
                channels.join(", ")
            ),
            Self::NoNormalForce { channels } => write!(
                f,
                "{} in N, and none is known by its name as the normal force",
                channels.join(", ")
            ),
            Self::SeveralMotions { taken, unit, count } => {
                write!(f, "of {count} motions in {unit} `{taken}` is taken")
            }
            Self::VibrationAssumed { first, last, count } => write!(
                f,
                "no channel is in m/s²: {count} channels from `{first}` to `{last}` are taken as the vibration"
            ),
            Self::SeveralAccelerations { taken, count } => {
                write!(
                    f,
                    "of {count} accelerations `{taken}` is taken as the vibration"
                )
            }
            Self::TakenWhole { file } => write!(
                f,
                "all of {file} is taken as the texture, with gesture and pauses, though it is a recording of touch"
            ),
            Self::RateStated {
                stated_hz,
                found_hz,
            } => write!(
                f,
                "the stated rate of {stated_hz} Hz was used, and the time stamps say {found_hz:.4} Hz"
            ),
            Self::RateNotUsed {
                stated_hz,
                found_hz,
            } => write!(
                f,
                "the stated rate of {stated_hz} Hz was not used: by its own header the file has {found_hz} Hz"
            ),
            Self::ScaleOverridden { used, ignored } => write!(
                f,
                "the stated scale {used} was used, not {ignored} from the sidecar"
            ),
            Self::Uncalibrated { channel } => {
                write!(
                    f,
                    "{channel} has no physical scale (full scale = 1), and is not in m/s²"
                )
            }
            Self::Counts { channel } => write!(
                f,
                "{channel} holds integers without a scale: its samples are counts of a converter, not m/s²"
            ),
            Self::UnknownEntries { file, entries } => write!(
                f,
                "{} of {file} is not read, as no entry of a sidecar is called so",
                entries.join(", ")
            ),
            Self::SidecarNotRead { file, format } => write!(
                f,
                "{file} is not read: a sidecar is read beside WAV and NumPy files, and this file is {format}"
            ),
            Self::EventsOutside {
                count,
                onset_s,
                lasts_s,
                length_s,
            } => write!(
                f,
                "{count} event(s) do not lie in the recording of {length_s:.3} s, the first at {onset_s} s for {lasts_s} s"
            ),
            Self::UnevenSampling { worst } => write!(
                f,
                "the time steps differ from their mean by up to {}: frequencies are only that exact",
                percent(*worst)
            ),
            Self::Interrupted { read_s } => write!(
                f,
                "the recording has no end: it was interrupted or is still running; {read_s:.3} s could be read"
            ),
            Self::InterruptedLater { journal } => write!(
                f,
                "a later recording of this name was interrupted and stands in {journal}"
            ),
            Self::FormatLoses { format, what } => write!(f, "{format} does not carry {what}"),
            Self::OtherCondition {
                what,
                rendered_for,
                measured,
            } => write!(
                f,
                "the drive was rendered for {what} {rendered_for} and measured with {measured}"
            ),
        }
    }
}
