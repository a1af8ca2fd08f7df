//! Warnings that arise from reading a recording.

use std::fmt;

use crate::checksum::Checksum;
use crate::number::rounded;
use crate::warning::words::percent;
use crate::warning::{Advice, ChannelRole, Subject, WarningKind, warnings};

warnings! {
    /// Warnings about the reading of a file, and about the condition of a recording.
    pub enum RecordingWarning {
        /// A property that a file does not state was inferred from its content.
        Guessed("guessed") {
            /// What was guessed, and from what.
            what: String,
        },
        /// Several normal forces, of which one is used.
        SeveralForces("several_forces") {
            /// The channels.
            channels: Vec<String>,
        },
        /// Several forces, none of which has a name known as that of the normal force.
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
        /// A recording of touch is used as a texture as a whole.
        TakenWhole("taken_whole") of File(file) {
            /// The file.
            file: String,
        },
        /// A rate was stated for a file whose own time stamps give another.
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
        /// Codes that lie outside the range that the file states for them.
        OutsideRange("outside_stated_range") of Channel(channel) {
            /// The channel.
            channel: String,
            /// How many samples.
            samples: usize,
            /// Of how many.
            of: usize,
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
        /// Cuts that do not say for which recording they were made.
        CutsUnconfirmed("cuts_unconfirmed") of File(file) {
            /// The file with the cuts.
            file: String,
            /// The checksum of the recording.
            checksum: Checksum,
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
        /// A file with gaps, of which only the part before the first gap is used.
        OneSegment("one_segment") {
            /// How many parts there are.
            count: usize,
            /// The length of the part that is used, s.
            lasts_s: f64,
            /// The length of all parts together, s.
            all_s: f64,
        },
        /// Channels of one name, which were numbered.
        ChannelsRenamed("channels_renamed") {
            /// The names as in the file.
            names: Vec<String>,
        },
        /// Samples that were added at the end to fill the last record of a file.
        Padded("padded") {
            /// How many, in the channels of the highest rate.
            samples: usize,
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

impl WarningKind for RecordingWarning {
    fn of(warning: &crate::Warning) -> Option<Self> {
        Self::of_warning(warning)
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
            Self::UnknownEntries { .. }
            | Self::EventsOutside { .. }
            | Self::OutsideRange { .. } => {
                vec![Advice::CorrectFile]
            }
            Self::SidecarNotRead { .. } => vec![Advice::StateInFile],
            Self::CutsUnconfirmed { .. } => {
                vec![Check(Subject::CutTimes), Advice::StateInFile]
            }
            Self::UnevenSampling { .. } | Self::Interrupted { .. } => Vec::new(),
            Self::OneSegment { .. } => vec![Advice::KeepOriginal],
            Self::ChannelsRenamed { .. } => vec![Advice::CorrectFile],
            Self::Padded { .. } => vec![Advice::KeepOriginal],
            Self::InterruptedLater { .. } => vec![Check(Subject::Journal)],
            Self::FormatLoses { .. } => vec![Advice::KeepOriginal],
            Self::OtherCondition { measured, .. } => vec![Advice::CharacteriseFor {
                condition: measured.clone(),
            }],
        }
    }
}

impl fmt::Display for RecordingWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Guessed { what } => f.write_str(what),
            Self::SeveralForces { channels } => write!(
                f,
                "there are {} normal forces ({}) and one is used; the signals of the cells of one platform must be summed first",
                channels.len(),
                channels.join(", ")
            ),
            Self::NoNormalForce { channels } => write!(
                f,
                "{} in N: none of the names is that of a normal force",
                channels.join(", ")
            ),
            Self::SeveralMotions { taken, unit, count } => {
                write!(f, "`{taken}` is used, one of {count} motions in {unit}")
            }
            Self::VibrationAssumed { first, last, count } => write!(
                f,
                "no channel is in m/s²: {count} channels from `{first}` to `{last}` are used as the vibration"
            ),
            Self::SeveralAccelerations { taken, count } => {
                write!(
                    f,
                    "`{taken}` is used as the vibration, one of {count} accelerations"
                )
            }
            Self::TakenWhole { file } => write!(
                f,
                "all of {file} is used as the texture, including gesture and pauses, although it is a recording of touch"
            ),
            Self::RateStated {
                stated_hz,
                found_hz,
            } => write!(
                f,
                "the stated rate of {stated_hz} Hz was used, but the time stamps give {} Hz",
                rounded(*found_hz)
            ),
            Self::RateNotUsed {
                stated_hz,
                found_hz,
            } => write!(
                f,
                "the stated rate of {stated_hz} Hz was not used: the header of the file gives {found_hz} Hz"
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
                "{channel} contains integers without a scale: its samples are counts of a converter, not m/s²"
            ),
            Self::UnknownEntries { file, entries } => write!(
                f,
                "{} of {file} is not read: a sidecar has no entry of this name",
                entries.join(", ")
            ),
            Self::SidecarNotRead { file, format } => write!(
                f,
                "{file} is not read: sidecars are read only for WAV and NumPy files, and this recording is {format}"
            ),
            Self::CutsUnconfirmed { file, checksum } => write!(
                f,
                "{file} does not say for which recording its cuts were made: they are applied; where they are of this one, the line \
                    `# recording {checksum}` says so"
            ),
            Self::OutsideRange {
                channel,
                samples,
                of,
            } => write!(
                f,
                "`{channel}`: {samples} of {of} samples lie outside the range that the file states for its codes: its scale may be wrong"
            ),
            Self::EventsOutside {
                count,
                onset_s,
                lasts_s,
                length_s,
            } => write!(
                f,
                "{count} event(s) are outside the recording of {length_s:.3} s, the first at {onset_s} s for {lasts_s} s",
                onset_s = rounded(*onset_s),
                lasts_s = rounded(*lasts_s)
            ),
            Self::UnevenSampling { worst } => write!(
                f,
                "the time steps differ from their mean by up to {}: frequencies have the same uncertainty",
                percent(*worst)
            ),
            Self::Interrupted { read_s } => write!(
                f,
                "the recording is not complete: it was interrupted or is still running; {read_s:.3} s could be read"
            ),
            Self::InterruptedLater { journal } => write!(
                f,
                "a later recording of this name was interrupted and is stored in {journal}"
            ),
            Self::OneSegment {
                count,
                lasts_s,
                all_s,
            } => write!(
                f,
                "the recording was paused: the file holds {count} parts with gaps between them, and only the first is used, {lasts_s:.3} s of \
                    {all_s:.3} s"
            ),
            Self::ChannelsRenamed { names } => write!(
                f,
                "several channels are called {}: a number was added to their names",
                names.join(", ")
            ),
            Self::Padded { samples } => write!(
                f,
                "{samples} sample(s) were added at the end, with the last value of each channel: the format stores whole records"
            ),
            Self::FormatLoses { format, what } => write!(f, "{format} cannot store {what}"),
            Self::OtherCondition {
                what,
                rendered_for,
                measured,
            } => write!(
                f,
                "the drive was rendered for {what} {rendered_for}, but measured with {measured}"
            ),
        }
    }
}
