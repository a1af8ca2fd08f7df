//! The signals that are analysed: chosen, checked, parts joined.

use std::collections::BTreeMap;
use std::ops::Range;

use piezotact::Warning;
use piezotact::clipping::{ClippedAt, ClippingWarning, flat_top_fraction};
use piezotact::integrity::never_changes;
use piezotact::quantity::SampleRate;
use piezotact::recording::Channel;
use serde::{Deserialize, Serialize};

use super::off::off;
use super::{PrepareConfig, PrepareError, Reference};
use crate::eeg::held::held;
use crate::eeg::source::{Segment, SignalKind};
use crate::eeg::{EegWarning, ElectrodesFault, LeftOutElectrodes, quality};

/// A larger share of samples at a limit of the amplifier is refused, a smaller one reported.
const SATURATED_SHARE: f64 = 0.01;
/// An error names so many channels.
const LISTED: usize = 80;

/// Which channels are analysed.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum ChannelChoice {
    /// All electrodes but these, and those that a table beside the file calls bad.
    AllBut(Vec<String>),
    /// These.
    Named(Vec<String>),
}

/// Signals of one rate, channels × samples, parts joined.
pub(super) struct Signals {
    /// The electrodes, then the EOG channels.
    pub(super) names: Vec<String>,
    pub(super) electrodes: Vec<String>,
    /// All channels of the file, in its order.
    pub(super) order: Vec<String>,
    pub(super) rate: SampleRate,
    pub(super) length: usize,
    /// The sample that each part begins with.
    pub(super) starts: Vec<usize>,
    pub(super) volts: Vec<f64>,
    /// Where a channel has no numbers; there it holds the last one.
    pub(super) missing: Vec<HeldPart>,
    pub(super) warnings: Vec<Warning>,
}

impl Signals {
    /// The chosen channels of `segments`, and the EOG channels.
    pub(super) fn of(
        segments: &[Segment<'_>],
        config: &PrepareConfig,
    ) -> Result<Self, PrepareError> {
        let first = segments.first().ok_or(PrepareError::Empty)?;
        let channels = first.recording.channels();
        let kinds: BTreeMap<&str, SignalKind> = channels
            .iter()
            .map(|c| (c.name.as_str(), first.kind_of(&c.name, &c.unit)))
            .collect();
        let known = |name: &String| match kinds.contains_key(name.as_str()) {
            true => Ok(name.clone()),
            false => Err(PrepareError::NoChannel {
                name: name.clone(),
                channels: listed(channels),
            }),
        };
        let eog = config
            .eog
            .iter()
            .map(known)
            .collect::<Result<Vec<_>, _>>()?;
        let replaced = config
            .interpolated
            .iter()
            .map(known)
            .collect::<Result<Vec<_>, _>>()?;
        for name in &replaced {
            let kind = kinds[name.as_str()];
            if kind != SignalKind::Eeg {
                return Err(PrepareError::NotAnElectrode {
                    name: name.clone(),
                    kind: kind.word(),
                });
            }
        }
        let mut bad: Vec<&str> = Vec::new();
        let electrodes: Vec<String> = match &config.channels {
            ChannelChoice::Named(names) => {
                let named = names.iter().map(known).collect::<Result<Vec<_>, _>>()?;
                for name in &named {
                    let kind = kinds[name.as_str()];
                    only_electrodes(name, kind, &config.reference)?;
                }
                let is_kept = |name: &String| !replaced.contains(name);
                named.into_iter().filter(is_kept).collect()
            }
            ChannelChoice::AllBut(out) => {
                let out = out.iter().map(known).collect::<Result<Vec<_>, _>>()?;
                if let Some(name) = out.iter().find(|name| replaced.contains(name)) {
                    let name = name.clone();
                    return Err(PrepareError::OutAndInterpolated { name });
                }
                let out = [out, replaced].concat();
                let own = channels.iter().filter(|c| {
                    kinds[c.name.as_str()] == SignalKind::Eeg
                        && !out.contains(&c.name)
                        && !eog.contains(&c.name)
                });
                let (called_bad, own): (Vec<_>, Vec<_>) =
                    own.partition(|channel| first.is_bad(&channel.name));
                bad = called_bad.iter().map(|c| c.name.as_str()).collect();
                own.into_iter().map(|c| c.name.clone()).collect()
            }
        };
        let odd = first.electrodes_in_other_units();
        if electrodes.is_empty() {
            let units: Vec<String> = (odd.iter())
                .map(|(unit, names)| format!("; {} are in `{unit}`", names.join(", ")))
                .collect();
            return Err(PrepareError::NoElectrode {
                channels: format!("{}{}", listed(channels), units.concat()),
            });
        }
        let names = [electrodes.clone(), eog].concat();
        one_rate(segments, &names)?;
        let mut found = Self::joined(segments, names, electrodes)?.checked()?;
        if matches!(config.channels, ChannelChoice::AllBut(_)) {
            let left_out = odd
                .into_iter()
                .map(|(unit, names)| EegWarning::ElectrodesLeftOut {
                    names: names.join(", "),
                    why: LeftOutElectrodes::NotInVolts { unit },
                });
            found.warnings.extend(left_out.map(Warning::from));
        }
        if !bad.is_empty() {
            let names = bad.join(", ");
            found.warnings.push(
                EegWarning::ElectrodesLeftOut {
                    names,
                    why: LeftOutElectrodes::CalledBad,
                }
                .into(),
            );
        }
        let used = found.electrodes.iter().filter(|name| first.is_bad(name));
        let used: Vec<&str> = used.map(String::as_str).collect();
        if !used.is_empty() {
            let names = used.join(", ");
            found.warnings.push(
                EegWarning::Electrodes {
                    names,
                    fault: ElectrodesFault::CalledBad,
                }
                .into(),
            );
        }
        Ok(found)
    }

    fn joined(
        segments: &[Segment<'_>],
        names: Vec<String>,
        electrodes: Vec<String>,
    ) -> Result<Self, PrepareError> {
        let parts: Vec<BTreeMap<&str, &Channel>> = segments
            .iter()
            .map(|segment| {
                let channels = segment.recording.channels().iter();
                channels.map(|c| (c.name.as_str(), c)).collect()
            })
            .collect();
        let rate = segments[0].recording.clock_of(&names[0]).rate_hz;
        let mut volts = Vec::new();
        let mut starts = Vec::new();
        for name in &names {
            starts.clear();
            let begins = volts.len();
            for (segment, part) in segments.iter().zip(&parts) {
                let own = part
                    .get(name.as_str())
                    .ok_or_else(|| PrepareError::NoChannel {
                        name: name.clone(),
                        channels: listed(segment.recording.channels()),
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
            order: (segments[0].recording.channels().iter())
                .map(|channel| channel.name.clone())
                .collect(),
            names,
            electrodes,
            rate,
            starts,
            volts,
            missing: Vec::new(),
            warnings: Vec::new(),
        }
        .with_numbers())
    }

    /// The last number in the place of what is none, and where that was: a filter would carry it through the whole recording.
    fn with_numbers(mut self) -> Self {
        for (name, signal) in self
            .names
            .iter()
            .zip(self.volts.chunks_exact_mut(self.length))
        {
            let mut last = 0.0;
            let mut at = 0;
            while at < signal.len() {
                let run = signal[at..]
                    .iter()
                    .take_while(|value| !value.is_finite())
                    .count();
                if run == 0 {
                    last = signal[at];
                    at += 1;
                    continue;
                }
                signal[at..at + run].fill(last);
                self.missing.push(HeldPart {
                    channel: name.clone(),
                    samples: at..at + run,
                });
                at += run;
            }
        }
        self
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
        let mut warnings = Vec::new();
        for (name, signal) in signals() {
            let share = flat_top_fraction(signal);
            if share > SATURATED_SHARE {
                return Err(PrepareError::Saturated {
                    channel: name.clone(),
                    percent: 100.0 * share,
                });
            }
            if share > 0.0 {
                warnings.push(
                    ClippingWarning::Clipped {
                        signal: name.clone(),
                        at: ClippedAt::Amplifier { fraction: share },
                    }
                    .into(),
                );
            }
        }
        self.warnings = warnings;
        Ok(self)
    }

    /// The signals of the electrodes.
    fn of_electrodes(&self) -> Vec<&[f64]> {
        let all = self.volts.chunks_exact(self.length);
        all.take(self.electrodes.len()).collect()
    }

    /// The warnings about electrodes that stand apart from the others.
    pub(super) fn apart(&self) -> Vec<Warning> {
        quality::warnings(&self.electrodes, &self.of_electrodes(), self.rate)
    }

    /// The parts in which each electrode is off.
    pub(super) fn off(&self) -> Vec<Vec<Range<usize>>> {
        off(&self.of_electrodes(), self.rate)
    }

    /// The samples of each part.
    pub(super) fn parts(&self) -> impl Iterator<Item = Range<usize>> {
        let ends = self.starts.iter().skip(1).copied().chain([self.length]);
        self.starts.iter().zip(ends).map(|(from, to)| *from..to)
    }
}

/// Where a channel holds one value, on the samples of all parts joined: its name, and from which sample to which.
pub(super) struct HeldPart {
    pub(super) channel: String,
    pub(super) samples: Range<usize>,
}

impl Signals {
    /// The parts in which a channel holds one value.
    pub(super) fn held(&self) -> Vec<HeldPart> {
        let mut found = Vec::new();
        for (name, signal) in self.names.iter().zip(self.volts.chunks_exact(self.length)) {
            for part in self.parts() {
                let own = held(&signal[part.clone()], self.rate);
                found.extend(own.into_iter().map(|own| HeldPart {
                    channel: name.clone(),
                    samples: part.start + own.start..part.start + own.end,
                }));
            }
        }
        found
    }
}

/// The names of channels, the first of many.
fn listed(channels: &[Channel]) -> String {
    let names: Vec<&str> = channels
        .iter()
        .take(LISTED)
        .map(|c| c.name.as_str())
        .collect();
    let further = channels.len().saturating_sub(LISTED);
    match further {
        0 => names.join(", "),
        further => format!("{} and {further} more", names.join(", ")),
    }
}

/// Refuses a channel that is no electrode where the reference is made of all of them.
fn only_electrodes(
    name: &str,
    kind: SignalKind,
    reference: &Reference,
) -> Result<(), PrepareError> {
    if *reference == Reference::Average && kind != SignalKind::Eeg {
        return Err(PrepareError::NotAnElectrode {
            name: name.to_owned(),
            kind: kind.word(),
        });
    }
    Ok(())
}

fn one_rate(segments: &[Segment<'_>], names: &[String]) -> Result<(), PrepareError> {
    let clocks: BTreeMap<&str, f64> = segments[0]
        .recording
        .channels_with_clocks()
        .map(|(channel, clock)| (channel.name.as_str(), clock.rate_hz.hz()))
        .collect();
    let rate = |name: &String| clocks[name.as_str()];
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
