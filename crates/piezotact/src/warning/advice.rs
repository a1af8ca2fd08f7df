//! What a person can do about a warning.

use crate::number::rounded;
use std::fmt;

use serde::{Deserialize, Serialize};

/// What a person can do about a warning. Its `Display` is a general text; each front end adds its own means: the
/// command line an option, a page a button, Python a keyword.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Advice {
    /// Check something.
    Check(Subject),
    /// Measure the transfer function again.
    MeasureAgain,
    /// Measure longer.
    MeasureLonger,
    /// Record again.
    RecordAgain,
    /// Record longer.
    RecordLonger,
    /// Record strokes or recordings until there are so many.
    RecordMore {
        /// How many.
        count: usize,
    },
    /// Record each sample in several recordings.
    RecordEachSampleAgain,
    /// Record at a higher speed too.
    RecordFaster,
    /// Record before the finger lands and after it lifts.
    RecordLift,
    /// Record from before the playback until it has ended.
    RecordWholePlayback,
    /// Record with another gain, so that more steps of the converter are used.
    RaiseGain,
    /// Measure the normal force too.
    MeasureForce,
    /// Hold the normal force that the condition says.
    HoldForce,
    /// Let the force cell warm up, or zero it between trials.
    ZeroForceCell,
    /// Raise the level of drive or rendering.
    RaiseLevel,
    /// Lower the level.
    LowerLevel {
        /// To this level relative to the one asked for, dB, where it is known.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        to_db: Option<f64>,
    },
    /// Narrow the band.
    NarrowBand,
    /// Widen the band.
    WidenBand,
    /// Drive the whole band.
    DriveWholeBand,
    /// Keep the band below a share of the rate.
    KeepBandBelow {
        /// The highest frequency, Hz.
        to_hz: f64,
    },
    /// Take longer segments.
    LongerSegments,
    /// State a segment of this length or shorter.
    ShorterSegments {
        /// The longest that fits, s, where it is known.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        to_s: Option<f64>,
    },
    /// Align drive and response.
    AlignChannels,
    /// Exchange drive and response.
    ExchangeDriveAndResponse,
    /// Characterise the device and finger again.
    CharacteriseAgain,
    /// Characterise at the level that will be played.
    CharacteriseAtLevel,
    /// Characterise and render for this condition.
    CharacteriseFor {
        /// The condition.
        condition: String,
    },
    /// Characterise the person, instead of using an average.
    CharacterisePerson,
    /// State amplifier gain and volts at full scale when a transfer function is made.
    DescribeDevice,
    /// Play again.
    PlayAgain,
    /// Play on the device.
    PlayOnDevice,
    /// Play through another placement, drawn from a panel's repeats.
    PlayThroughOtherPlacement,
    /// Close other programs.
    CloseOtherPrograms,
    /// Leave out the parts or lines with warnings.
    LeaveOut,
    /// Name the channel that has a role.
    NameChannel {
        /// The role.
        role: ChannelRole,
    },
    /// State the scale of a file.
    StateScale,
    /// Do not state a rate.
    OmitRate,
    /// State the load.
    StateLoad,
    /// Cut strokes by hand.
    CutByHand,
    /// Use a single stroke.
    TakeStroke,
    /// State a high-pass filter.
    StateHighPass {
        /// Its frequency, Hz.
        at_hz: f64,
    },
    /// State the cut-off of a profile.
    StateCutoff,
    /// Evaluate a profile as it is, without a filter.
    LeaveUnfiltered,
    /// State the distance of two points.
    StateStep,
    /// Keep the file with the instrument's settings beside the profile.
    KeepSettingsFile,
    /// State what was guessed in the file.
    StateInFile,
    /// Correct the file.
    CorrectFile,
    /// Show the warnings of the transfer function itself.
    ShowWarnings,
    /// Group by this, or compare.
    GroupBy {
        /// By what.
        by: String,
    },
    /// Compare recordings that share all other conditions.
    CompareLike,
    /// Compare by hand.
    CompareByHand,
    /// Exchange reference and test.
    ExchangeReferenceAndTest,
    /// Use the score instead of an index.
    UseScore,
    /// Give what was recorded while the drive was played.
    GiveRecording,
    /// Drive playback and recording from one clock.
    OneClock,
    /// Evaluate the drive as the hits of a hammer.
    EvaluateAsImpacts,
    /// State what the drive is.
    StateExcitation,
    /// Hit so many times.
    HitMore {
        /// How many.
        count: usize,
    },
    /// Hit again only after the response has come to rest.
    HitLater,
    /// Begin to record before the hit.
    RecordBeforeHit,
    /// Subtract the damping that a window added.
    SubtractDamping,
    /// Use an exponential window.
    ExponentialWindow,
    /// Use a quieter sensor.
    QuieterSensor,
    /// Give a map from the nail to the skin, where one was measured.
    GiveContactMap,
    /// Measure a longer line or a larger area.
    MeasureLargerSurface,
    /// Remove more form or waviness.
    RemoveMoreForm,
    /// Fill or measure again the missing points.
    FillPoints,
    /// Measure these participants too.
    MeasureOthers,
    /// Measure so many participants.
    MeasureParticipants {
        /// How many.
        count: usize,
    },
    /// Exchange the sign of the inverted channel and add the measurement again.
    InvertChannel,
    /// File the measurement under the participant named in it.
    FileUnder {
        /// The participant.
        participant: String,
    },
    /// Keep the twins in panels of their own.
    SeparatePanels,
    /// Measure the control longer or louder.
    MeasureControl,
    /// Run the campaign again; it continues where it stopped.
    ContinueCampaign,
    /// Use a smaller change, or record at another rate.
    SmallerChange,
    /// Take a longer stroke, with the gesture filtered out.
    LongerStroke,
    /// Take a stroke whose level is constant.
    SteadyStroke,
    /// Keep the original beside the file.
    KeepOriginal,
    /// State a lower rate.
    LowerRate,
    /// Join a texture with itself, so that it lasts longer.
    JoinWithItself,
    /// Ask the author of the program that wrote the file.
    AskExporter,
    /// An advice of a newer version, kept unchanged.
    #[serde(untagged)]
    Other(serde_json::Value),
}

/// What a channel is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum ChannelRole {
    /// The normal force.
    NormalForce,
    /// The motion of finger or surface.
    Motion,
    /// The vibration.
    Vibration,
    /// The signal to be processed.
    Signal,
}

/// What a person can check.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Subject {
    /// Whether channels are swapped or out of step.
    Channels,
    /// Which channel is which, and its sensor.
    ChannelsAndSensor,
    /// The polarity of the sensors.
    Polarity,
    /// The sensor's cable and range.
    CableAndRange,
    /// The wiring, and the names of the channels.
    Wiring,
    /// Shield and earth.
    ShieldAndEarth,
    /// The unit or the scale.
    UnitAndScale,
    /// Whether all hits were at one point in one direction, and the finger did not move.
    PointOfHits,
    /// The force channel.
    ForceChannel,
    /// Which channel is the normal force.
    ForceAxes,
    /// The force cell: its zero, and what pulls on it.
    ForceCell,
    /// What was assumed.
    Assumption,
    /// Which of two values is right.
    WhichIsRight,
    /// Whether two things belong together.
    Belonging,
    /// The times of cuts.
    CutTimes,
    /// The strokes in the report.
    Strokes,
    /// The lines in the report.
    Lines,
    /// Distortion, mains and other sources of vibration.
    OtherSources,
    /// The speeds that were stated.
    Speeds,
    /// The measurement: sensor, placement, person.
    Measurement,
    /// A loose sensor or other conditions.
    LooseSensor,
    /// The recorder's load.
    Recorder,
    /// The disk.
    Disk,
    /// The journal of the interrupted recording.
    Journal,
    /// The content of the texture outside the band.
    OutsideBand,
    /// The clock of the sound output.
    OutputClock,
}

impl fmt::Display for Subject {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Channels => {
                "whether drive and response are swapped, or their channels out of step"
            }
            Self::ChannelsAndSensor => "the channels and the sensor",
            Self::Polarity => "the polarity of the sensors and the actuator",
            Self::CableAndRange => "its cable and its range",
            Self::Wiring => "the wiring and the names of the channels",
            Self::ShieldAndEarth => "shield and earth",
            Self::UnitAndScale => "its unit and scale",
            Self::PointOfHits => "that all hits were at one point in one direction, and that nothing moved between them",
            Self::ForceChannel => "the force channel",
            Self::ForceAxes => "which channel is the normal force",
            Self::ForceCell => "the zero of the force cell, and any weight on it",
            Self::Assumption => "this assumption",
            Self::WhichIsRight => "which value is correct",
            Self::Belonging => "that they belong together",
            Self::CutTimes => "the times of the cuts",
            Self::Strokes => "the rejected parts in the report",
            Self::Lines => "the lines in the report",
            Self::OtherSources => "distortion, mains and other sources of vibration",
            Self::Speeds => "that the stated speeds were reached",
            Self::Measurement => "that measurement (sensor, placement, person)",
            Self::LooseSensor => "whether the sensor is loose or the conditions differ",
            Self::Recorder => "whether the recorder is overloaded",
            Self::Disk => "the disk",
            Self::Journal => "whether this is the intended recording",
            Self::OutsideBand => "whether the power outside the band belongs to the texture",
            Self::OutputClock => {
                "whether the rate of the sound output changes, or the sensor moves"
            }
        })
    }
}

impl fmt::Display for Advice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Check(subject) => return write!(f, "check {subject}"),
            Self::RecordMore { count } => return write!(f, "record {count} or more"),
            Self::HitMore { count } => return write!(f, "hit {count} times or more"),
            Self::LowerLevel { to_db: Some(to_db) } => {
                return write!(f, "lower the level by {:.1} dB", -to_db);
            }
            Self::KeepBandBelow { to_hz } => {
                return write!(f, "keep the band below {to_hz:.0} Hz");
            }
            Self::ShorterSegments { to_s: Some(to_s) } => {
                return write!(f, "state a segment of {to_s:.3} s or shorter");
            }
            Self::CharacteriseFor { condition } => {
                return write!(f, "characterise and render for {condition}");
            }
            Self::StateHighPass { at_hz } => {
                return write!(f, "state a high-pass filter at {at_hz} Hz", at_hz = rounded(*at_hz));
            }
            Self::GroupBy { by } => return write!(f, "group by {by}, or compare the groups"),
            Self::MeasureParticipants { count } => {
                return write!(f, "measure {count} participants or more");
            }
            Self::FileUnder { participant } => {
                return write!(f, "check whose it is, and file it under {participant}");
            }
            Self::NameChannel { role } => match role {
                ChannelRole::NormalForce => "name the channel of the normal force",
                ChannelRole::Motion => "name the channel of the motion",
                ChannelRole::Vibration => "name the channel of the vibration",
                ChannelRole::Signal => "name the channel to use",
            },
            Self::Other(other) => return write!(f, "advice of a newer version: {other}"),
            Self::MeasureAgain => "measure again",
            Self::MeasureLonger => "measure longer",
            Self::RecordAgain => "record again",
            Self::RecordLonger => "record longer",
            Self::RecordEachSampleAgain => "record each sample several times",
            Self::RecordFaster => "record at a higher speed too",
            Self::RecordLift => "record a part with the finger lifted",
            Self::RecordWholePlayback => "start recording before the playback and stop after its end",
            Self::RaiseGain => "record with more gain",
            Self::MeasureForce => "measure the force together with the acceleration",
            Self::HoldForce => "repeat while holding the stated force",
            Self::ZeroForceCell => "let the cell warm up, or zero it between trials",
            Self::RaiseLevel => "raise the level",
            Self::LowerLevel { to_db: None } => "lower the level",
            Self::NarrowBand => "narrow the band",
            Self::WidenBand => "widen the band where the device responds",
            Self::DriveWholeBand => "drive the whole band",
            Self::LongerSegments => "use longer segments",
            Self::ShorterSegments { to_s: None } => "use shorter segments",
            Self::AlignChannels => "align the channels",
            Self::ExchangeDriveAndResponse => "exchange drive and response",
            Self::CharacteriseAgain => "characterise again",
            Self::CharacteriseAtLevel => "characterise at the level that will be played",
            Self::CharacterisePerson => "characterise the participant if this error is too large",
            Self::DescribeDevice => "state amplifier gain and volts at full scale when the transfer function is estimated",
            Self::PlayAgain => "play again",
            Self::PlayOnDevice => "play it on the device before relying on it",
            Self::PlayThroughOtherPlacement => {
                "play it through another placement (drawn from the repeats of a panel), through the transfer function of \
                    another participant, or on the device"
            }
            Self::CloseOtherPrograms => "close other programs",
            Self::LeaveOut => "leave these parts out",
            Self::StateScale => "state the scale, or add a sidecar file",
            Self::OmitRate => "do not state a rate",
            Self::StateLoad => "state the load",
            Self::CutByHand => "cut the strokes by hand",
            Self::TakeStroke => "use a single stroke",
            Self::StateCutoff => "state the cut-off",
            Self::LeaveUnfiltered => "evaluate it without a filter",
            Self::StateStep => "state the step between points",
            Self::KeepSettingsFile => {
                "keep the instrument's file with settings (.tx3) beside the profile"
            }
            Self::StateInFile => "state it in the file",
            Self::CorrectFile => "correct the file",
            Self::ShowWarnings => "look at the warnings of the transfer function",
            Self::CompareLike => "give recordings that differ only in the compared factor",
            Self::CompareByHand => "compare them by hand",
            Self::ExchangeReferenceAndTest => "exchange reference and test",
            Self::UseScore => "use the score instead",
            Self::GiveRecording => "give the recording made while the drive was played",
            Self::OneClock => "drive playback and recording from one clock, or use short textures",
            Self::EvaluateAsImpacts => "evaluate it as an impact test",
            Self::StateExcitation => "state what the drive is",
            Self::HitLater => "hit again only after the response has come to rest",
            Self::RecordBeforeHit => "begin to record before the hit",
            Self::SubtractDamping => "subtract it from the damping of every resonance",
            Self::ExponentialWindow => "use an exponential window",
            Self::QuieterSensor => "use a sensor with less noise",
            Self::GiveContactMap => "give a nail-to-skin map if one was measured",
            Self::MeasureLargerSurface => "measure a longer line or a larger area",
            Self::RemoveMoreForm => "remove more form or waviness",
            Self::FillPoints => "fill or measure again the areas where many are missing",
            Self::MeasureOthers => "complete the missing measurements",
            Self::InvertChannel => "invert that channel and add the measurement again",
            Self::SeparatePanels => "keep them in separate panels",
            Self::MeasureControl => "measure the control longer or at a higher level",
            Self::ContinueCampaign => "run the campaign again to continue it",
            Self::SmallerChange => "use a smaller change, or record at another rate",
            Self::LongerStroke => "use a longer stroke, or one with the gesture filtered out",
            Self::SteadyStroke => "use a stroke of constant level",
            Self::KeepOriginal => "keep the original file as well",
            Self::LowerRate => "state a lower rate",
            Self::JoinWithItself => "loop it",
            Self::AskExporter => "ask the author of the program that exported it",
        })
    }
}
