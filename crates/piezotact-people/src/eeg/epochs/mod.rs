//! Epochs: pieces of EEG around events, all of one length.

mod cut;
mod joined;
mod reject;

use crate::eeg::pulses::Device;
use piezotact::quantity::SampleRate;

pub use cut::{Continuous, Cut, CutConfig, Event, LeftOut, NotCut, cut};
pub use joined::JoinError;
pub use reject::{Criterion, Kept, Rejected, Rejection, reject};

/// EEG around events: channels × epochs × samples in one buffer, in V.
#[derive(Clone, Debug, PartialEq)]
pub struct Epochs {
    channels: Vec<String>,
    conditions: Vec<String>,
    rate: SampleRate,
    first_s: f64,
    samples: usize,
    volts: Vec<f64>,
}

impl Epochs {
    /// Epochs of `volts`, channels × epochs × samples in this order, in V. The first sample of each is at `first_s` from its event.
    /// There are as many epochs as `conditions`.
    ///
    /// # Errors
    /// [`EpochsError`] without a channel, epoch or sample, with a name twice, or when `volts` has another length or a value that is
    /// no finite number.
    pub fn new(
        channels: Vec<String>,
        conditions: Vec<String>,
        rate: SampleRate,
        first_s: f64,
        volts: Vec<f64>,
    ) -> Result<Self, EpochsError> {
        let signals = channels.len() * conditions.len();
        if signals == 0 || volts.is_empty() || !volts.len().is_multiple_of(signals) {
            return Err(EpochsError::Shape {
                expected: format!(
                    "equally many samples in each of {} epochs of {} channels",
                    conditions.len(),
                    channels.len()
                ),
                found: format!("{} values", volts.len()),
            });
        }
        if let Some(name) = twice(&channels) {
            return Err(EpochsError::Twice { name });
        }
        let samples = volts.len() / signals;
        if let Some(at) = volts.iter().position(|v| !v.is_finite()) {
            let signal = at / samples;
            return Err(EpochsError::NotFinite {
                channel: channels[signal / conditions.len()].clone(),
                epoch: signal % conditions.len(),
                sample: at % samples,
            });
        }
        Ok(Self {
            channels,
            conditions,
            rate,
            first_s,
            samples,
            volts,
        })
    }

    /// The names of the channels.
    #[must_use]
    pub fn channels(&self) -> &[String] {
        &self.channels
    }

    /// The condition of each epoch.
    #[must_use]
    pub fn conditions(&self) -> &[String] {
        &self.conditions
    }

    /// How many epochs there are.
    #[must_use]
    pub fn count(&self) -> usize {
        self.conditions.len()
    }

    /// How many samples each epoch has.
    #[must_use]
    pub fn samples(&self) -> usize {
        self.samples
    }

    /// The rate.
    #[must_use]
    pub fn rate(&self) -> SampleRate {
        self.rate
    }

    /// The time of the first sample from the event, s.
    #[must_use]
    pub fn first_s(&self) -> f64 {
        self.first_s
    }

    /// The time of a sample from the event, s.
    #[must_use]
    pub fn time_s(&self, sample: usize) -> f64 {
        self.first_s + sample as f64 / self.rate.hz()
    }

    /// The time of the last sample from the event, s.
    #[must_use]
    pub fn last_s(&self) -> f64 {
        self.time_s(self.samples - 1)
    }

    /// All values, channels × epochs × samples, V.
    #[must_use]
    pub fn volts(&self) -> &[f64] {
        &self.volts
    }

    /// The epochs of a channel one after the other, epochs × samples, V.
    #[must_use]
    pub fn channel(&self, channel: usize) -> &[f64] {
        let length = self.count() * self.samples;
        &self.volts[channel * length..(channel + 1) * length]
    }

    /// One epoch of one channel, V.
    #[must_use]
    pub fn signal(&self, channel: usize, epoch: usize) -> &[f64] {
        let start = (channel * self.count() + epoch) * self.samples;
        &self.volts[start..start + self.samples]
    }

    /// The index of each of `names`.
    ///
    /// # Errors
    /// [`EpochsError::NoChannel`] for a name that no channel has.
    pub fn indices(&self, names: &[&str]) -> Result<Vec<usize>, EpochsError> {
        let index = |name: &&str| {
            let found = self.channels.iter().position(|channel| channel == name);
            found.ok_or_else(|| EpochsError::NoChannel {
                name: (*name).to_owned(),
                channels: self.channels.join(", "),
            })
        };
        names.iter().map(index).collect()
    }

    /// The epochs of one condition.
    ///
    /// # Errors
    /// [`EpochsError::NoCondition`] where no epoch has it.
    pub fn of_condition(&self, condition: &str) -> Result<Self, EpochsError> {
        let kept: Vec<usize> = (0..self.count())
            .filter(|i| self.conditions[*i] == condition)
            .collect();
        if kept.is_empty() {
            let mut found = self.conditions.clone();
            found.sort();
            found.dedup();
            return Err(EpochsError::NoCondition {
                condition: condition.to_owned(),
                found: found.join(", "),
            });
        }
        Ok(self.kept(&kept))
    }

    /// The epochs of the channels `names`, in this order.
    ///
    /// # Errors
    /// [`EpochsError`] without a name, or for one that no channel has or that stands twice.
    pub fn picked(&self, names: &[&str]) -> Result<Self, EpochsError> {
        let indices = self.indices(names)?;
        let length = self.count() * self.samples;
        let mut volts = Vec::with_capacity(indices.len() * length);
        for channel in &indices {
            volts.extend_from_slice(self.channel(*channel));
        }
        let names = names.iter().map(|name| (*name).to_owned()).collect();
        Self::new(
            names,
            self.conditions.clone(),
            self.rate,
            self.first_s,
            volts,
        )
    }

    /// The epochs of the indices `kept`, which exist and are not none.
    fn kept(&self, kept: &[usize]) -> Self {
        let mut volts = Vec::with_capacity(self.channels.len() * kept.len() * self.samples);
        for channel in 0..self.channels.len() {
            for &epoch in kept {
                volts.extend_from_slice(self.signal(channel, epoch));
            }
        }
        Self {
            channels: self.channels.clone(),
            conditions: kept.iter().map(|i| self.conditions[*i].clone()).collect(),
            volts,
            ..*self
        }
    }

    /// The same epochs with each signal changed by `change`, which gets one epoch of one channel.
    pub(super) fn mapped(&self, mut change: impl FnMut(&[f64], &mut [f64])) -> Self {
        let mut volts = vec![0.0; self.volts.len()];
        let signals = self.volts.chunks_exact(self.samples);
        for (signal, changed) in signals.zip(volts.chunks_exact_mut(self.samples)) {
            change(signal, changed);
        }
        Self {
            volts,
            channels: self.channels.clone(),
            conditions: self.conditions.clone(),
            ..*self
        }
    }

    /// The same less the least-squares line through each signal: offsets of electrodes and drifts, whose step at the ends of an epoch wavelets would see.
    pub(super) fn without_lines(&self) -> Self {
        let n = self.samples as f64;
        let middle = (n - 1.0) / 2.0;
        let squares = n * (n * n - 1.0) / 12.0;
        self.mapped(|signal, out| {
            let mean = signal.iter().sum::<f64>() / n;
            let about = signal.iter().enumerate();
            let moment: f64 = about.map(|(i, v)| (i as f64 - middle) * (v - mean)).sum();
            let slope = if squares > 0.0 { moment / squares } else { 0.0 };
            for (i, (out, value)) in out.iter_mut().zip(signal).enumerate() {
                *out = value - mean - slope * (i as f64 - middle);
            }
        })
    }

    /// As [`Self::mapped`], for the channels of the indices `channels` alone.
    pub(super) fn mapped_channels(
        &self,
        channels: &[usize],
        mut change: impl FnMut(&[f64], &mut [f64]),
    ) -> Self {
        let count = self.count();
        let mut at = 0;
        self.mapped(|signal, out| {
            if channels.contains(&(at / count)) {
                change(signal, out);
            } else {
                out.copy_from_slice(signal);
            }
            at += 1;
        })
    }

    /// The same with the signals of the channels of the indices `channels` as they are in `other`, which has the same shape.
    pub(super) fn with_channels_of(mut self, other: &Self, channels: &[usize]) -> Self {
        let length = self.count() * self.samples;
        for channel in channels {
            let range = channel * length..(channel + 1) * length;
            self.volts[range].copy_from_slice(other.channel(*channel));
        }
        self
    }

    /// Signals that are sums of those of the channels: `weights` is channels out × channels in, `names` those of the channels out.
    pub(super) fn mixed(&self, names: Vec<String>, weights: &[f64]) -> Self {
        let length = self.count() * self.samples;
        let inputs = self.channels.len();
        let mut volts = vec![0.0; names.len() * length];
        for (row, out) in volts.chunks_exact_mut(length).enumerate() {
            for channel in 0..inputs {
                let weight = weights[row * inputs + channel];
                if weight == 0.0 {
                    continue;
                }
                for (sum, value) in out.iter_mut().zip(self.channel(channel)) {
                    *sum += weight * value;
                }
            }
        }
        Self {
            channels: names,
            conditions: self.conditions.clone(),
            volts,
            ..*self
        }
    }
}

/// The first name that stands twice.
fn twice(names: &[String]) -> Option<String> {
    let mut sorted: Vec<&String> = names.iter().collect();
    sorted.sort();
    let found = sorted.windows(2).find(|pair| pair[0] == pair[1]);
    found.map(|pair| pair[0].clone())
}

/// Invalid epochs, or a method that cannot be applied to them.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum EpochsError {
    /// Values or settings that do not fit: of another number, or out of range.
    #[error("expected {expected}, found {found}; correct the call")]
    Shape { expected: String, found: String },
    /// A channel name that stands twice.
    #[error("two channels are named `{name}`: rename one")]
    Twice { name: String },
    /// A value that is no number.
    #[error("channel {channel}, epoch {epoch}, sample {sample} is not finite: leave the epoch out")]
    NotFinite {
        channel: String,
        /// Its epoch, from 0.
        epoch: usize,
        /// Its sample, from 0.
        sample: usize,
    },
    /// A channel that does not exist.
    #[error(
        "expected one of the channels {channels}; found `{name}`; name a channel that was recorded"
    )]
    NoChannel {
        /// What was asked for.
        name: String,
        channels: String,
    },
    /// A condition that no epoch has.
    #[error(
        "expected one of the conditions {found}; found `{condition}`; name a condition that has epochs"
    )]
    NoCondition {
        /// What was asked for.
        condition: String,
        found: String,
    },
    /// An extent that is not ascending.
    #[error(
        "expected an epoch from an earlier to a later time, found {start_s} s to {end_s} s; exchange or correct them"
    )]
    Extent {
        /// The first time, s.
        start_s: f64,
        /// The last time, s.
        end_s: f64,
    },
    /// No epoch is left.
    #[error(
        "none of {events} events has a whole epoch: {why}; take a shorter extent or correct the events"
    )]
    NoneCut {
        /// How many events there are.
        events: usize,
        /// Why the first has none.
        why: String,
    },
    /// No criterion.
    #[error("no criterion is stated: state a limit, or use the epochs as they are")]
    NoCriterion,
    /// A limit that is no amplitude.
    #[error("expected a limit above 0 V, found {found_v} V; state it in V (100 µV is 1e-4 V)")]
    Limit {
        /// What was found, V.
        found_v: f64,
    },
    /// Every epoch is rejected.
    #[error(
        "all {epochs} epochs are rejected (the first: {why}); check the unit of the signals and the limits"
    )]
    AllRejected {
        /// How many there were.
        epochs: usize,
        /// By what the first was rejected.
        why: String,
    },
    /// No channel of one kind.
    #[error("at least one EOG channel and one other are needed: name them")]
    NoEog,
    /// A channel of both kinds.
    #[error("channel `{name}` is named both as EOG and as another: leave it out of one")]
    Both { name: String },
    /// EOG channels that say the same.
    #[error("the {eog} EOG channels are constant or multiples of each other: leave one out")]
    Dependent {
        /// How many there are.
        eog: usize,
    },
    /// No reference.
    #[error(
        "no channel is named as the reference: name the mastoids (M1, M2), or take the average reference"
    )]
    NoReference,
    /// A channel that has no built-in position.
    #[error(
        "`{name}` is no electrode of the 10-10 system: rename it, leave it out, or state measured positions"
    )]
    NoPosition { name: String },
    /// Positions that are none.
    #[error(
        "{found} positions for {channels} channels are not usable: each channel needs one of its own, finite and off the centre"
    )]
    Positions { channels: usize, found: usize },
    /// Positions that lie on no sphere.
    #[error("{found} positions fit no sphere: give at least 8 positions on a head, not in a plane")]
    Sphere {
        /// How many there are.
        found: usize,
    },
    /// Electrodes that do not determine a spline.
    #[error(
        "the positions of {channels} electrodes do not determine a spline: add electrodes or a regularisation"
    )]
    Singular {
        /// How many there are.
        channels: usize,
    },
    /// Times that do not ascend.
    #[error(
        "the pulse times of the {device} device are not finite and ascending: sort them and leave repetitions out"
    )]
    PulseOrder { device: Device },
    /// Too few pulses that both have.
    #[error(
        "only {found} pulses were recorded by both devices ({first} by the first, {second} by the second), and 3 are needed: check that both lists are of the same pulses"
    )]
    FewShared {
        found: usize,
        /// Pulses of the first device.
        first: usize,
        /// Pulses of the second.
        second: usize,
    },
    /// An edge outside the band of the signal.
    #[error(
        "expected an edge above 0 Hz and below half the rate ({nyquist_hz} Hz), found {found_hz} Hz; state another"
    )]
    Edge {
        /// What was found, Hz.
        found_hz: f64,
        /// Half the rate, Hz.
        nyquist_hz: f64,
    },
    /// Edges that do not ascend.
    #[error(
        "the edge {low_hz} Hz is not below the next, {high_hz} Hz: exchange them, or leave one notch out"
    )]
    EdgeOrder { low_hz: f64, high_hz: f64 },
    /// A transition so narrow that the filter is too long.
    #[error(
        "the filter would be {length_s} s long, above 10 million samples: move the edge further from 0 Hz or half the rate"
    )]
    TooLong { length_s: f64 },
    /// No notch.
    #[error("no frequency to leave out is stated: state 50 Hz or 60 Hz")]
    NoNotch,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn epochs_are_where_they_were_put() {
        let names = |n: &[&str]| n.iter().map(|s| (*s).to_owned()).collect::<Vec<_>>();
        let rate = SampleRate::new(100.0).unwrap();
        let of = |volts: Vec<f64>| {
            Epochs::new(
                names(&["C3", "C4"]),
                names(&["a", "b", "a"]),
                rate,
                -0.02,
                volts,
            )
        };
        let epochs = of((0..30).map(f64::from).collect()).unwrap();
        assert_eq!((epochs.samples(), epochs.count()), (5, 3));
        assert_eq!(epochs.signal(1, 2), [25.0, 26.0, 27.0, 28.0, 29.0]);
        assert!((epochs.last_s() - 0.02).abs() < 1e-12);
        let a = epochs.of_condition("a").unwrap();
        assert_eq!(a.signal(0, 1), epochs.signal(0, 2));
        assert!(
            epochs
                .of_condition("c")
                .unwrap_err()
                .to_string()
                .contains("a, b")
        );
        assert_eq!(epochs.indices(&["C4"]).unwrap(), [1]);
        assert!(epochs.indices(&["Cz"]).is_err());
        assert!(
            of(vec![0.0; 31]).is_err() && of(vec![f64::NAN; 30]).is_err() && of(vec![]).is_err()
        );
        let twice = Epochs::new(names(&["C3", "C3"]), names(&["a"]), rate, 0.0, vec![0.0; 2]);
        assert!(matches!(twice, Err(EpochsError::Twice { .. })));
    }
}
