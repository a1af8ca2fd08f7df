//! Recordings: channels acquired together, with their condition, provenance and warnings.

mod about;
mod annotations;
mod clock;
mod losses;
mod lost;
mod rehearsal;
mod velocity;
mod warning;

use std::collections::BTreeSet;
use std::fmt;
pub use warning::{
    ChannelRole, Clocks, MissingChannel, NotUsed, OtherOrigin, Reached, RecordingWarning,
    ReversedSign, Simulated, Stated, Steps,
};

use serde::{Deserialize, Serialize};

use crate::checksum::Checksum;
use crate::lineage::Lineage;
use crate::number::rounded;
use crate::quantity::{Band, Degrees, Newtons, Quantity, SampleRate, Seconds, Uncalibrated, Unit};
use crate::series::{Series, SeriesError};
use crate::warning::Warning;

pub use about::About;
#[cfg(feature = "schemas")]
pub(crate) use about::MergedAbout;
pub use annotations::{Annotations, Event, EventValue, NoStartTime, StartTime};
pub use clock::Clock;
pub use losses::{BrokenPlayback, Losses};
pub use lost::LostBy;
pub use rehearsal::{RehearsalWarning, played_through_its_own, rehearsed_on};

/// How the finger meets the surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Touch {
    /// The person moves the finger.
    Active,
    /// The surface moves under a finger at rest.
    Passive,
    /// The finger rests on the actuator.
    Resting,
}

/// The direction of sliding relative to the finger.
///
/// L. Felicetti's thesis (2024), figure 3; ulnar and radial are both transversal here.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum SlidingDirection {
    /// Along the finger, towards the body.
    Proximal,
    /// Along the finger, away from the body.
    Distal,
    /// Across the finger.
    Transversal,
    /// In circles.
    Circular,
}

impl SlidingDirection {
    /// All of them, the usual one first.
    pub const ALL: [Self; 4] = [
        Self::Proximal,
        Self::Distal,
        Self::Transversal,
        Self::Circular,
    ];

    /// As documents have it: `proximal`.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Proximal => "proximal",
            Self::Distal => "distal",
            Self::Transversal => "transversal",
            Self::Circular => "circular",
        }
    }

    /// The direction that `text` names, in whatever case; `None` for another word.
    #[must_use]
    pub fn named(text: &str) -> Option<Self> {
        let text = text.to_lowercase();
        Self::ALL.into_iter().find(|one| one.word() == text)
    }
}

impl fmt::Display for SlidingDirection {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.word())
    }
}

/// The experimental condition of a recording: sample, participant, load, angle, speed, touch, direction. Unknown entries are absent.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct Condition {
    /// The surface sample.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sample: Option<String>,
    /// The participant's pseudonym.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub participant: Option<String>,
    /// The seed of the digital twin that the participant belongs to: P02 of two seeds are two people. Absent for real people.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub twin_seed: Option<u64>,
    /// The requested normal force.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub load_n: Option<Newtons>,
    /// The angle between finger and surface.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub angle_deg: Option<Degrees>,
    /// The sliding speed, m/s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub speed_m_s: Option<f64>,
    /// How the finger meets the surface.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub touch: Option<Touch>,
    /// The direction in which the finger slides.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub direction: Option<SlidingDirection>,
}

impl fmt::Display for Condition {
    /// The known entries as text; empty when nothing is known.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let known = [
            self.sample
                .as_ref()
                .map(|sample| format!("sample {sample}")),
            self.participant
                .as_ref()
                .map(|participant| format!("participant {participant}")),
            self.load_n.map(|load| format!("load {load}")),
            self.angle_deg.map(|angle| format!("angle {}°", angle.0)),
            self.speed_m_s.map(|speed| format!("speed {speed} m/s")),
            self.direction
                .map(|direction| format!("direction {direction}")),
        ];
        let known: Vec<String> = known.into_iter().flatten().collect();
        f.write_str(&known.join(", "))
    }
}

impl Condition {
    /// The participant as text: the pseudonym, with the seed for a participant of a twin; `None` if nobody is named.
    #[must_use]
    pub fn person(&self) -> Option<String> {
        let name = self.participant.as_ref()?;
        Some(match self.twin_seed {
            Some(seed) => format!("{name} (twin of seed {seed})"),
            None => name.clone(),
        })
    }

    /// The warnings about a measurement under the condition `measured` with a drive rendered for this condition: one for each of
    /// participant, load and angle that both state and that differ.
    #[must_use]
    pub fn warnings_when_measured(&self, measured: &Self) -> Vec<Warning> {
        self.differences(measured, |of, rendered_for, measured| {
            Reached::RenderedFor {
                of,
                rendered_for,
                measured,
            }
        })
    }

    /// The warnings about a measurement under the condition `measured` beside a transfer function of this condition, likewise.
    #[must_use]
    pub fn warnings_beside(&self, measured: &Self) -> Vec<Warning> {
        self.differences(measured, |of, function_of, measured| Reached::FunctionOf {
            of,
            function_of,
            measured,
        })
    }

    /// A warning for each of participant, load and angle that both state and that differ: its name, this one and the `other`.
    fn differences(
        &self,
        other: &Self,
        what: impl Fn(String, String, String) -> Reached,
    ) -> Vec<Warning> {
        let text = |value: Option<f64>, unit: &str| value.map(|value| format!("{value} {unit}"));
        let load = |of: &Self| text(of.load_n.map(|n| n.0), "N");
        let angle = |of: &Self| text(of.angle_deg.map(|a| a.0), "°");
        let pairs = [
            ("participant", self.person(), other.person()),
            ("load", load(self), load(other)),
            ("angle", angle(self), angle(other)),
        ];
        let differ = pairs.into_iter().filter_map(|(of, one, other)| {
            let (one, other) = one.zip(other).filter(|(one, other)| one != other)?;
            let what = what(of.into(), one, other);
            Some(RecordingWarning::ConditionDiffers { what }.into())
        });
        differ.collect()
    }
}

/// The provenance of a value: its bench or file, the processing steps, and the seed.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct Provenance {
    /// The bench or file it comes from, as a person would name it.
    pub source: String,
    /// The kind of bench: digital twin, hardware, or a measured transfer function; absent if a file does not state it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bench: Option<BenchKind>,
    /// The seed of a twin or of a random drive.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
    /// The band that the drive excites; absent if unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[serde(alias = "driven_hz")]
    pub excited_hz: Option<Band>,
    /// When the measurement behind a transfer function, and behind what is rendered with it, began; absent if unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub measured_at: Option<StartTime>,
    /// The processing steps, oldest first, each with its parameters.
    pub steps: Vec<String>,
    /// The transfer functions that a drive was rendered with or corrected on.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub made_with: Vec<Checksum>,
    /// The checksum of the transfer function that was used in place of a device and a finger.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub answered_with: Option<Checksum>,
    /// The source of a texture and the manipulations applied to it; absent if there were none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lineage: Option<Lineage>,
    /// How many participants a transfer function is the average of; absent for that of one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub averaged_people: Option<usize>,
    /// What the recording lacks of its run. A transfer function has none: what was lost is left out of it.
    #[serde(skip_serializing_if = "Losses::are_none")]
    pub losses: Losses,
}

impl Provenance {
    /// The same provenance with one more step at its end.
    #[must_use]
    pub fn then(mut self, step: impl Into<String>) -> Self {
        self.steps.push(step.into());
        self
    }
}

/// The kind of bench a value comes from; stated in reports.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum BenchKind {
    /// The digital twin.
    Twin,
    /// Real devices.
    Hardware,
    /// A measured transfer function that replaces device and finger: nobody is touched.
    Measured,
    /// A scripted fake for tests of procedures: no device and no finger.
    Scripted,
}

impl BenchKind {
    /// Whether real devices took part.
    #[must_use]
    pub fn is_real(self) -> bool {
        self == Self::Hardware
    }

    /// What is simulated of recordings that come from `benches`, in a sentence; nothing of those that state no bench.
    #[must_use]
    pub fn simulated(benches: impl IntoIterator<Item = Option<Self>>) -> Option<String> {
        let benches: Vec<Option<Self>> = benches.into_iter().collect();
        let simulated = benches.iter().flatten();
        let simulated: Vec<Self> = simulated.copied().filter(|kind| !kind.is_real()).collect();
        let sentence = simulated.first()?.sentence();
        let (some, all) = (simulated.len(), benches.len());
        Some(if some == all {
            sentence.to_owned()
        } else {
            format!("{some} of {all} recordings are simulated. {sentence}")
        })
    }

    /// Which bench it is, as reports state it.
    #[must_use]
    pub fn sentence(self) -> &'static str {
        match self {
            Self::Twin => "Digital twin: no hardware and no person took part.",
            Self::Hardware => "Measured on hardware.",
            Self::Measured => {
                "Played through a measured transfer function: no finger was involved."
            }
            Self::Scripted => {
                "Scripted fake of a bench, for tests only: no device and no finger was involved."
            }
        }
    }
}

/// One channel of a recording, in SI.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    pub name: String,
    /// The SI unit of the samples.
    pub unit: Unit,
    pub samples: Vec<f64>,
}

/// Channels, each with its clock, with condition, provenance and annotations. Usually all channels share one clock and have the
/// same length.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    channels: Vec<Channel>,
    clocks: Vec<Clock>,
    clock_of: Vec<usize>,
    /// Condition, provenance and warnings.
    pub about: About,
    /// When it began, its labels, and what happened while it ran.
    pub annotations: Annotations,
}

impl Recording {
    /// A recording of `channels` at `rate`.
    ///
    /// # Errors
    /// [`RecordingError::NoChannel`] without channels, [`RecordingError::Length`] when two channels differ
    /// in length, [`RecordingError::SameName`] when two share a name.
    pub fn new(
        channels: Vec<Channel>,
        rate: SampleRate,
        condition: Condition,
        provenance: Provenance,
    ) -> Result<Self, RecordingError> {
        let clock_of = vec![0; channels.len()];
        let clocks = vec![Clock::at(rate)];
        Self::of_parts(channels, clocks, clock_of, condition, provenance)
    }

    fn of_parts(
        channels: Vec<Channel>,
        clocks: Vec<Clock>,
        clock_of: Vec<usize>,
        condition: Condition,
        provenance: Provenance,
    ) -> Result<Self, RecordingError> {
        if channels.is_empty() {
            return Err(RecordingError::NoChannel);
        }
        let mut names = BTreeSet::new();
        for (i, channel) in channels.iter().enumerate() {
            let same = clock_of.iter().position(|clock| *clock == clock_of[i]);
            let first = &channels[same.unwrap_or(i)];
            if channel.samples.len() != first.samples.len() {
                return Err(RecordingError::Length {
                    first: first.name.clone(),
                    expected: first.samples.len(),
                    channel: channel.name.clone(),
                    found: channel.samples.len(),
                });
            }
            if !names.insert(channel.name.as_str()) {
                return Err(RecordingError::SameName {
                    name: channel.name.clone(),
                });
            }
        }
        Ok(Self {
            channels,
            clocks,
            clock_of,
            about: About::new(condition, provenance),
            annotations: Annotations::default(),
        })
    }

    /// Calls channels by `name` of their names.
    ///
    /// # Errors
    /// [`RecordingError::SameName`] when two would share a name; then nothing is changed.
    pub fn rename(&mut self, name: impl Fn(&str) -> String) -> Result<(), RecordingError> {
        let names: Vec<String> = self.channels.iter().map(|c| name(&c.name)).collect();
        let mut seen = BTreeSet::new();
        if let Some(name) = names.iter().find(|name| !seen.insert(name.as_str())) {
            return Err(RecordingError::SameName { name: name.clone() });
        }
        for (channel, name) in self.channels.iter_mut().zip(names) {
            channel.name = name;
        }
        Ok(())
    }

    /// States the unit of each channel as `unit` of it; the samples stay.
    pub fn restate_units(&mut self, unit: impl Fn(&Unit) -> Unit) {
        for channel in &mut self.channels {
            channel.unit = unit(&channel.unit);
        }
    }

    /// The channels.
    #[must_use]
    pub fn channels(&self) -> &[Channel] {
        &self.channels
    }

    /// The sampling rate of the first channel, and so of all where they share a clock ([`Self::clocks`]).
    #[must_use]
    pub fn rate(&self) -> SampleRate {
        self.clocks[0].rate_hz
    }

    /// The length in time, to the end of the channel that ends last.
    #[must_use]
    pub fn duration(&self) -> Seconds {
        let ends = self.channels_with_clocks().map(|(channel, clock)| {
            clock.start_s.0 + clock.rate_hz.duration_of(channel.samples.len()).0
        });
        Seconds(ends.fold(0.0, f64::max))
    }

    /// The number of samples of the first channel, and so of all where they share a clock ([`Self::clocks`]).
    #[must_use]
    pub fn len(&self) -> usize {
        self.channels
            .first()
            .map_or(0, |channel| channel.samples.len())
    }

    /// Whether a channel holds no samples.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.channels
            .iter()
            .any(|channel| channel.samples.is_empty())
    }

    /// The channel called `name`; without a name the only channel, or the only one in `unit`.
    ///
    /// # Errors
    /// [`RecordingError::Missing`] when no channel has that name, or [`RecordingError::Ambiguous`] when no
    /// name was given and the choice is not clear. Both list the channels there are.
    pub fn pick(&self, name: Option<&str>, unit: &Unit) -> Result<&Channel, RecordingError> {
        if let Some(name) = name {
            return self
                .channels
                .iter()
                .find(|channel| channel.name == name)
                .ok_or_else(|| RecordingError::Missing {
                    wanted: name.into(),
                    found: self.names(),
                });
        }
        let mut of_unit = self.channels.iter().filter(|channel| channel.unit == *unit);
        match (of_unit.next(), of_unit.next(), self.channels.as_slice()) {
            (Some(only), None, _) | (None, _, [only]) => Ok(only),
            _ => Err(RecordingError::Ambiguous {
                unit: unit.clone(),
                found: self.names(),
            }),
        }
    }

    /// The series of `Q` in the channel called `name` (or picked as in [`Self::pick`]).
    ///
    /// # Errors
    /// Those of [`Self::pick`]; [`RecordingError::Unit`] when the channel holds another quantity;
    /// [`RecordingError::Series`] when its samples make no series.
    pub fn series<Q: Quantity>(&self, name: Option<&str>) -> Result<Series<Q>, RecordingError> {
        let channel = self.pick(name, &Q::UNIT)?;
        if channel.unit != Q::UNIT {
            return Err(RecordingError::Unit {
                channel: channel.name.clone(),
                quantity: Q::NAME,
                expected: Q::UNIT,
                found: channel.unit.clone(),
            });
        }
        series_of(channel, self.clock_of(&channel.name).rate_hz)
    }

    /// The samples of a channel whatever their unit, as a series that can be looked at but not rendered.
    ///
    /// # Errors
    /// Those of [`Self::pick`]; [`RecordingError::Series`] when its samples make no series.
    pub fn raw(
        &self,
        name: Option<&str>,
    ) -> Result<(&Channel, Series<Uncalibrated>), RecordingError> {
        let channel = self.pick(name, &Unit::MetrePerSecondSquared)?;
        let rate = self.clock_of(&channel.name).rate_hz;
        Ok((channel, series_of(channel, rate)?))
    }

    fn names(&self) -> String {
        let names: Vec<String> = self
            .channels
            .iter()
            .map(|channel| format!("{} [{}]", channel.name, channel.unit))
            .collect();
        names.join(", ")
    }
}

fn series_of<Q: Quantity>(
    channel: &Channel,
    rate: SampleRate,
) -> Result<Series<Q>, RecordingError> {
    Series::new(channel.samples.clone(), rate).map_err(|source| RecordingError::Series {
        channel: channel.name.clone(),
        source,
    })
}

/// Channels that do not form a recording, or a recording without the requested channel.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RecordingError {
    /// There is no channel.
    #[error("the recording has no channel; check the export settings")]
    NoChannel,
    /// Channels of different length.
    #[error(
        "expected {expected} samples in every channel as in `{first}`, found {found} in `{channel}`; export them together"
    )]
    Length {
        first: String,
        expected: usize,
        /// The channel that differs.
        channel: String,
        found: usize,
    },
    /// Channels of two clocks where samples of one index have to belong together.
    #[error(
        "`{first}` is sampled at {of_first}, `{channel}` at {found}: {}",
        match of_first.rate_hz == found.rate_hz {
            true => "they have one rate and begin at different times: start them together, or resample one to the times of the other",
            false => "use channels of one clock, or resample them to one rate",
        }
    )]
    Clocks {
        first: String,
        of_first: Clock,
        /// A channel with another.
        channel: String,
        found: Clock,
    },
    /// As many clocks as channels, or none.
    #[error(
        "expected a clock for each of {channels} channels, found {found}; write the file again"
    )]
    ClocksOf { channels: usize, found: usize },
    /// A clock with a start that is not a number.
    #[error(
        "expected a start in s, found {found_s} for channel `{channel}`; correct it",
        found_s = rounded(*found_s)
    )]
    Start { channel: String, found_s: f64 },
    /// Two channels of one name.
    #[error("expected channels of different names, found `{name}` twice; rename one")]
    SameName { name: String },
    /// No channel of that name.
    #[error("expected a channel `{wanted}`, found only {found}; use one of these")]
    Missing {
        /// The name asked for.
        wanted: String,
        /// The channels there are.
        found: String,
    },
    /// No name was given and the choice is not clear.
    #[error("expected one channel in {unit}, found {found}; name the one to use")]
    Ambiguous {
        /// The unit looked for.
        unit: Unit,
        /// The channels there are.
        found: String,
    },
    /// The channel holds another quantity.
    #[error(
        "expected {quantity} in {expected}, found channel `{channel}` in {found}; use another channel or state its unit"
    )]
    Unit {
        channel: String,
        quantity: &'static str,
        expected: Unit,
        found: Unit,
    },
    /// The samples make no series.
    #[error("channel `{channel}`: {source}")]
    Series {
        channel: String,
        source: SeriesError,
    },
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantity::{Acceleration, Force};

    fn two() -> Recording {
        let channel = |name: &str, unit| Channel {
            name: name.into(),
            unit,
            samples: vec![1.0, 2.0],
        };
        Recording::new(
            vec![
                channel("acc", Unit::MetrePerSecondSquared),
                channel("fz", Unit::Newton),
            ],
            SampleRate::new(5000.0).unwrap(),
            Condition::default(),
            Provenance::default(),
        )
        .unwrap()
    }

    #[test]
    fn what_is_simulated_is_said_of_all_or_of_some() {
        let said = |benches: &[Option<BenchKind>]| BenchKind::simulated(benches.iter().copied());
        let (twin, real) = (Some(BenchKind::Twin), Some(BenchKind::Hardware));
        assert_eq!(said(&[real, None]), None);
        assert_eq!(
            said(&[twin, twin]).as_deref(),
            Some(BenchKind::Twin.sentence())
        );
        let some = said(&[real, twin, None]).unwrap();
        assert!(
            some.starts_with("1 of 3 recordings are simulated. Digital twin"),
            "{some}"
        );
    }

    #[test]
    fn the_only_channel_of_a_unit_needs_no_name() {
        assert_eq!(two().series::<Force>(None).unwrap().samples(), [1.0, 2.0]);
    }

    #[test]
    fn a_wrong_channel_is_named_with_what_there_is() {
        let missing = two()
            .series::<Acceleration>(Some("nail"))
            .unwrap_err()
            .to_string();
        assert!(
            missing.contains("`nail`") && missing.contains("acc [m/s²], fz [N]"),
            "{missing}"
        );
        let unit = two()
            .series::<Acceleration>(Some("fz"))
            .unwrap_err()
            .to_string();
        assert!(unit.contains("m/s²") && unit.contains("in N"), "{unit}");
    }

    /// P02 of the twin of seed 7 and P02 of the twin of seed 8 are two people.
    #[test]
    fn a_twin_s_participant_is_one_of_its_seed() {
        let of = |seed: Option<u64>| Condition {
            participant: Some("P02".into()),
            twin_seed: seed,
            ..Condition::default()
        };
        assert_eq!(of(Some(7)).warnings_when_measured(&of(Some(7))), []);
        for other in [Some(8), None] {
            let said = of(Some(7)).warnings_when_measured(&of(other));
            assert_eq!(said.len(), 1, "{said:?}");
            assert!(said[0].to_string().contains("P02 (twin of seed 7)"));
        }
    }
}
