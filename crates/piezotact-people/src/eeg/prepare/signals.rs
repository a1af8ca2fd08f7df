//! The signals that are analysed: chosen, checked, parts joined.

use std::ops::Range;

use piezotact::Doubt;
use piezotact::clipping::flat_top_fraction;
use piezotact::integrity::never_changes;
use piezotact::quantity::SampleRate;
use serde::{Deserialize, Serialize};

use super::PrepareError;
use crate::eeg::EegDoubt;
use crate::eeg::source::{Segment, SignalKind};

/// A larger share of samples at a limit of the amplifier is refused, a smaller one doubted.
const SATURATED_SHARE: f64 = 0.01;

/// Which channels are analysed.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum ChannelChoice {
    /// All electrodes but these.
    AllBut(Vec<String>),
    /// These.
    Named(Vec<String>),
}

/// Signals of one rate, channels × samples, parts joined.
pub(super) struct Signals {
    /// The electrodes, then the EOG channels.
    pub(super) names: Vec<String>,
    pub(super) electrodes: Vec<String>,
    pub(super) rate: SampleRate,
    pub(super) length: usize,
    /// The sample that each part begins with.
    pub(super) starts: Vec<usize>,
    pub(super) volts: Vec<f64>,
    pub(super) doubts: Vec<Doubt>,
}

impl Signals {
    /// The chosen channels of `segments`, and `eog`.
    pub(super) fn of(
        segments: &[Segment<'_>],
        choice: &ChannelChoice,
        eog: &[String],
    ) -> Result<Self, PrepareError> {
        let first = segments.first().ok_or(PrepareError::Empty)?.recording;
        let all = || -> Vec<String> { first.channels().iter().map(|c| c.name.clone()).collect() };
        let known = |name: &String| match all().contains(name) {
            true => Ok(name.clone()),
            false => Err(PrepareError::NoChannel {
                name: name.clone(),
                channels: all().join(", "),
            }),
        };
        let eog = eog.iter().map(known).collect::<Result<Vec<_>, _>>()?;
        let electrodes = match choice {
            ChannelChoice::Named(names) => names.iter().map(known).collect::<Result<_, _>>()?,
            ChannelChoice::AllBut(out) => {
                let out = out.iter().map(known).collect::<Result<Vec<_>, _>>()?;
                let channels = first.channels().iter();
                let own = channels.filter(|c| SignalKind::of(&c.name, &c.unit) == SignalKind::Eeg);
                let names = own.map(|c| c.name.clone());
                names
                    .filter(|name| !out.contains(name) && !eog.contains(name))
                    .collect::<Vec<_>>()
            }
        };
        if electrodes.is_empty() {
            return Err(PrepareError::NoElectrode {
                channels: all().join(", "),
            });
        }
        let names = [electrodes.clone(), eog].concat();
        one_rate(segments, &names)?;
        let joined = Self::joined(segments, names, electrodes)?;
        joined.checked()
    }

    fn joined(
        segments: &[Segment<'_>],
        names: Vec<String>,
        electrodes: Vec<String>,
    ) -> Result<Self, PrepareError> {
        let rate = segments[0].recording.clock_of(&names[0]).rate_hz;
        let mut volts = Vec::new();
        let mut starts = Vec::new();
        for name in &names {
            starts.clear();
            let begins = volts.len();
            for segment in segments {
                let channels = segment.recording.channels();
                let own = channels.iter().find(|channel| channel.name == *name);
                let own = own.ok_or_else(|| PrepareError::NoChannel {
                    name: name.clone(),
                    channels: channels
                        .iter()
                        .map(|c| c.name.clone())
                        .collect::<Vec<_>>()
                        .join(", "),
                })?;
                starts.push(volts.len() - begins);
                volts.extend_from_slice(&own.samples);
            }
        }
        if volts.is_empty() || !volts.len().is_multiple_of(names.len()) {
            return Err(PrepareError::Empty);
        }
        Ok(Self {
            length: volts.len() / names.len(),
            names,
            electrodes,
            rate,
            starts,
            volts,
            doubts: Vec::new(),
        })
    }

    /// Refuses flat and saturated channels.
    fn checked(mut self) -> Result<Self, PrepareError> {
        let signals = || self.names.iter().zip(self.volts.chunks_exact(self.length));
        let flat: Vec<&str> = signals()
            .filter(|(_, signal)| never_changes(signal))
            .map(|(name, _)| name.as_str())
            .collect();
        if !flat.is_empty() {
            return Err(PrepareError::Flat {
                channels: flat.join(", "),
            });
        }
        let mut doubts = Vec::new();
        for (name, signal) in signals() {
            let share = flat_top_fraction(signal);
            if share > SATURATED_SHARE {
                return Err(PrepareError::Saturated {
                    channel: name.clone(),
                    percent: 100.0 * share,
                });
            }
            if share > 0.0 {
                doubts.push(
                    EegDoubt::SomeSaturated {
                        channel: name.clone(),
                        share,
                    }
                    .into(),
                );
            }
        }
        self.doubts = doubts;
        Ok(self)
    }

    /// The samples of each part.
    pub(super) fn parts(&self) -> impl Iterator<Item = Range<usize>> {
        let ends = self.starts.iter().skip(1).copied().chain([self.length]);
        self.starts.iter().zip(ends).map(|(from, to)| *from..to)
    }
}

fn one_rate(segments: &[Segment<'_>], names: &[String]) -> Result<(), PrepareError> {
    let recording = segments[0].recording;
    let rate = |name: &String| recording.clock_of(name).rate_hz.hz();
    let first_hz = rate(&names[0]);
    let other = names.iter().find(|name| rate(name) != first_hz);
    match other {
        None => Ok(()),
        Some(other) => Err(PrepareError::Rates {
            first: names[0].clone(),
            first_hz,
            other: other.clone(),
            other_hz: rate(other),
        }),
    }
}
