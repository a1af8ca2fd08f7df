//! Signal integrity between sensor and file: clipping, frozen and dead channels, drop-outs, copies, mains
//! hum, drives that could not be played. Uses samples, rate and unit only, independent of the file format.

mod copied;
mod hum;
mod in_parts;
mod level;
mod pair;
mod warning;

pub use copied::{Copy, copied};
pub use hum::{Hum, RestLine, lines_at_rest, mains_hum};
pub use in_parts::InParts;
pub(crate) use pair::{Broken, BrokenInParts, warnings_beside};
pub use pair::{Pair, transfer_warnings};
pub use warning::{ChannelFault, SignalWarning};

use serde::{Deserialize, Serialize};

use crate::clipping::{ClippedAt, ClippingWarning, limited};
use crate::quantity::{Quantity, SampleRate, Seconds, Unit};
use crate::recording::{Channel, Clock, Recording};
use crate::series::Series;
use crate::statistics::{mean, standard_deviation};
use crate::warning::{Warning, Warnings};

/// A part of a signal, from the sample `from` up to and without the sample `to`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Span {
    /// The first sample.
    pub from: usize,
    /// The sample after the last.
    pub to: usize,
}

impl Span {
    /// The number of samples.
    #[must_use]
    pub fn len(self) -> usize {
        self.to - self.from
    }

    /// Whether it holds no sample.
    #[must_use]
    pub fn is_empty(self) -> bool {
        self.to <= self.from
    }
}

/// The defects found in one signal.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Defects {
    /// Whether it never changes, but for rounding.
    pub dead: bool,
    /// Parts in which it holds one value although the surrounding signal varies.
    pub frozen: Vec<Span>,
    /// Parts in which it falls abruptly to its floor and returns abruptly, excluding those in `frozen`.
    pub gaps: Vec<Span>,
    /// Lines of the mains; absent where there are none.
    pub hum: Option<Hum>,
    /// The share of samples at a limit, 0–1.
    pub clipped_fraction: f64,
    /// The number of samples.
    pub samples: usize,
    /// The rate.
    pub rate: SampleRate,
}

impl Defects {
    /// Whether nothing is broken.
    #[must_use]
    pub fn none(&self) -> bool {
        !self.dead
            && self.frozen.is_empty()
            && self.gaps.is_empty()
            && self.hum.is_none()
            && self.clipped_fraction <= 0.0
    }

    /// The warnings about the signal, which is called `channel`.
    #[must_use]
    pub fn warnings(&self, channel: &str) -> Vec<Warning> {
        let channel = || channel.to_owned();
        if self.dead {
            return vec![Warning::from(SignalWarning::Channel {
                channel: channel(),
                fault: ChannelFault::Dead,
            })];
        }
        let mut warnings = Vec::new();
        let share = |spans: &[Span]| {
            spans.iter().map(|s| s.len()).sum::<usize>() as f64 / self.samples.max(1) as f64
        };
        let seconds = |samples: usize| self.rate.duration_of(samples).0;
        let longest = |spans: &[Span]| spans.iter().copied().max_by_key(|s| s.len());
        if let Some(most) = longest(&self.frozen) {
            warnings.push(Warning::from(SignalWarning::Channel {
                channel: channel(),
                fault: ChannelFault::Frozen {
                    count: self.frozen.len(),
                    at_s: seconds(most.from),
                    longest_s: seconds(most.len()),
                    share: share(&self.frozen),
                },
            }));
        }
        if let Some(most) = longest(&self.gaps) {
            warnings.push(Warning::from(SignalWarning::Channel {
                channel: channel(),
                fault: ChannelFault::DropOuts {
                    count: self.gaps.len(),
                    at_s: seconds(most.from),
                    longest_s: seconds(most.len()),
                    share: share(&self.gaps),
                },
            }));
        }
        if self.clipped_fraction > 0.0 {
            warnings.push(Warning::from(ClippingWarning::Clipped {
                signal: channel(),
                at: ClippedAt::Recorded {
                    fraction: self.clipped_fraction,
                },
            }));
        }
        warnings.extend(
            self.hum
                .as_ref()
                .map(|hum| Warning::from(hum.warning(channel()))),
        );
        warnings
    }
}

/// The defects of `series`; intervals in samples, shares 0–1.
///
/// Source: [`limited`], [`mains_hum`]; drop-outs and frozen parts by abrupt edges of the short-time level, as stated in
/// docs/decisions/signals.md.
#[must_use]
pub fn inspect<Q: Quantity>(series: &Series<Q>) -> Defects {
    inspect_samples(series.samples(), series.rate(), &Q::UNIT)
}

/// A channel whose standard deviation is less than this part of its mean holds rounding alone.
const ROUNDING: f64 = 1e-12;

/// Whether `samples` never change, but for rounding.
///
/// Source: house rule; 1e-12 of the mean is a thousand times the rounding of a double.
#[must_use]
pub fn never_changes(samples: &[f64]) -> bool {
    let first = samples.first().copied().unwrap_or(0.0);
    samples.iter().all(|v| *v == first)
        || standard_deviation(samples) <= ROUNDING * mean(samples).abs()
}

/// A force that holds one value for less is none that froze: force cells give 10 to 80 readings a second, and two may be the same.
const HELD_FORCE: Seconds = Seconds(0.1);

/// The defects of `samples` at `rate`, in the SI unit `unit`; intervals in samples, shares 0–1. Positions, speeds and times rest
/// and repeat by command: for these only constant channels are detected.
///
/// Source: as [`inspect`].
#[must_use]
pub fn inspect_samples(samples: &[f64], rate: SampleRate, unit: &Unit) -> Defects {
    let mut defects = Defects {
        dead: never_changes(samples),
        frozen: Vec::new(),
        gaps: Vec::new(),
        hum: None,
        clipped_fraction: 0.0,
        samples: samples.len(),
        rate,
    };
    if defects.dead || commanded(unit) {
        return defects;
    }
    let lost = match unit {
        Unit::Newton => level::lost_of_force(samples, rate),
        _ => level::lost(samples, rate),
    };
    let shortest = match unit {
        Unit::Newton => rate.samples_in(HELD_FORCE),
        _ => 0,
    };
    let long = |spans: Vec<Span>| {
        let all = spans.into_iter();
        all.filter(|span| span.len() >= shortest).collect()
    };
    defects.frozen = long(lost.frozen);
    defects.gaps = long(lost.gaps);
    defects.clipped_fraction = limited(samples).share();
    if measured(unit) {
        defects.hum = mains_hum(samples, rate);
    }
    defects
}

/// Whether a channel of this unit holds a commanded motion or time.
fn commanded(unit: &Unit) -> bool {
    matches!(unit, Unit::Metre | Unit::MetrePerSecond | Unit::Second)
}

/// Whether a channel of this unit comes from a sensor; what a computer sends holds no hum.
fn measured(unit: &Unit) -> bool {
    !commanded(unit) && !matches!(unit, Unit::FullScale)
}

/// The parts of `samples` in which one value is held or the signal is at its floor, in the order of time.
#[cfg(feature = "modal")]
pub(crate) fn lost_parts(samples: &[f64], rate: SampleRate) -> Vec<Span> {
    let level::Lost { frozen, mut gaps } = level::lost(samples, rate);
    gaps.extend(frozen);
    gaps.sort_unstable_by_key(|span| span.from);
    gaps
}

/// The defects of a channel of `recording`. Lines that a drive has are no hum.
fn defects_of(recording: &Recording, channel: &Channel, clock: Clock) -> Defects {
    let samples = &channel.samples;
    let mut defects = inspect_samples(samples, clock.rate_hz, &channel.unit);
    let excited = |drive: &[f64]| hum::hum_beside(drive, samples, clock.rate_hz).is_none();
    let mut drives = recording.channels_with_clocks();
    let is_excited = drives.any(|(drive, of_drive)| {
        drive.unit == Unit::FullScale && of_drive == clock && excited(&drive.samples)
    });
    defects.hum = defects.hum.filter(|_| !is_excited);
    defects
}

/// Whether a channel of this name holds the codes of a trigger or the state of an amplifier, which are no signal: they rest and jump.
///
/// Source: names that `BioSemi`, EDF+, MNE-Python and EEGLAB give them (`Status`, `TRIG`, `Trigger`, `STI 014`).
#[must_use]
pub fn holds_codes(name: &str) -> bool {
    let upper = name.to_ascii_uppercase();
    let is_stim = upper.strip_prefix("STI").is_some_and(|rest| {
        let rest = rest.strip_prefix('M').unwrap_or(rest).trim_start();
        rest.bytes().all(|byte| byte.is_ascii_digit())
    });
    upper.contains("STATUS") || upper.contains("TRIG") || is_stim
}

/// The warnings about all channels of `recording` but those of codes, of each and of pairs. `limit_fraction` is the largest drive that can be played,
/// of full scale.
///
/// Source: [`inspect_samples`], [`copied`], [`transfer_warnings`].
#[must_use]
pub fn warnings_of(recording: &Recording, limit_fraction: f64) -> Warnings {
    let mut warnings = Warnings::new();
    for (channel, clock) in recording.channels_with_clocks() {
        let name = &channel.name;
        if holds_codes(name) {
            continue;
        }
        warnings.extend(defects_of(recording, channel, clock).warnings(name));
        if channel.unit == Unit::FullScale {
            warnings.extend(pair::beyond(&channel.samples, name, limit_fraction));
        }
    }
    warnings.extend(pair::copies_in(recording, None));
    warnings
}
