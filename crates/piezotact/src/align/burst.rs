//! Synchronisation bursts: short sweeps before and after a drive, by which a recording is found in it whatever the drive is.

use crate::align::AlignError;
use std::f64::consts::TAU;
use std::fmt;

use serde::{Deserialize, Serialize};

use super::matched::{Searched, peaks};
use crate::document::Content;
use crate::fourier::fade;
use crate::quantity::{Band, Drive, Hertz, SampleRate, Seconds};
use crate::recording::{Annotations, Event};
use crate::series::Series;

/// The kind of the event that is the burst before a drive.
pub const FIRST_BURST: &str = "sync_burst_first";
/// The kind of the event that is the burst after it.
pub const LAST_BURST: &str = "sync_burst_last";
/// The kind of the event that is the drive between them.
pub const DRIVE_BETWEEN: &str = "drive";

/// The least time-bandwidth product (number of independent values) at which a sweep is distinguishable from another signal.
pub(super) const LEAST_CELLS: f64 = 100.0;
/// The longest burst and the longest silence, s.
pub(super) const LONGEST_S: f64 = 10.0;
/// The shortest silence, s: what a device holds back has ended, and the filters of a search are apart.
pub(super) const SHORTEST_GUARD_S: f64 = 0.1;
/// The share of a burst over which it rises, and over which it falls.
const TAPER: f64 = 0.1;
/// A drive that is as like a burst somewhere cannot have one.
const LIKE: f64 = 0.3;
/// The share of the Nyquist frequency up to which a burst reaches.
const PASSBAND: f64 = 0.9;

/// How bursts are made. There is no default: it is stated, and goes into the result.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct BurstConfig {
    /// The band that each sweeps: upwards before the drive, downwards after it.
    pub band: Band,
    /// How long each is, s.
    pub duration_s: Seconds,
    /// The silence before and after each, s.
    pub guard_s: Seconds,
    /// The peak of each, of full scale.
    pub peak: f64,
}

impl BurstConfig {
    /// Half a second from 100 to 1000 Hz, as far as `rate` holds them, with a quarter of a second of silence, with a peak of `peak_share` of full scale.
    ///
    /// # Errors
    /// [`AlignError::BurstBand`] for a rate that holds no such band.
    pub fn usual(rate: SampleRate, peak_share: f64) -> Result<Self, AlignError> {
        let high = (PASSBAND * rate.nyquist().0).min(1000.0);
        let band =
            Band::new(Hertz(100.0), Hertz(high)).map_err(|_narrow| AlignError::BurstBand {
                high_hz: 1000.0,
                highest_hz: high,
            })?;
        Ok(Self {
            band,
            duration_s: Seconds(0.5),
            guard_s: Seconds(0.25),
            peak: peak_share,
        })
    }

    fn check(&self, rate: SampleRate) -> Result<(), AlignError> {
        let highest_hz = PASSBAND * rate.nyquist().0;
        if self.band.high().0 > highest_hz {
            return Err(AlignError::BurstBand {
                high_hz: self.band.high().0,
                highest_hz,
            });
        }
        let within = |value: f64, low: f64| value >= low && value <= LONGEST_S;
        if !within(self.duration_s.0, 0.0) || !within(self.guard_s.0, SHORTEST_GUARD_S) {
            return Err(AlignError::Lengths {
                duration_s: self.duration_s.0,
                guard_s: self.guard_s.0,
            });
        }
        let width_hz = self.band.high().0 - self.band.low().0;
        if width_hz * self.duration_s.0 < LEAST_CELLS {
            return Err(AlignError::Short {
                width_hz,
                duration_s: self.duration_s.0,
                least_s: LEAST_CELLS / width_hz,
            });
        }
        if !(self.peak > 0.0 && self.peak <= 1.0) {
            return Err(AlignError::Peak { found: self.peak });
        }
        Ok(())
    }

    /// The burst that sweeps upwards, at `rate`.
    fn rising(&self, rate: SampleRate) -> Vec<f64> {
        let count = rate.samples_in(self.duration_s);
        let (low, high) = (self.band.low().0, self.band.high().0);
        let sample = |i: usize| {
            // In the middles of samples, so that the burst backwards begins as it does.
            let share = (i as f64 + 0.5) / count as f64;
            let t = share * self.duration_s.0;
            let phase = TAU * t * (low + 0.5 * (high - low) * share);
            let edge = share.min(1.0 - share) / TAPER;
            let weight = fade(edge);
            self.peak * weight * phase.sin()
        };
        (0..count).map(sample).collect()
    }
}

/// One of the two bursts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Which {
    /// That before the drive.
    First,
    /// That after it.
    Last,
}

impl fmt::Display for Which {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::First => "the first one",
            Self::Last => "the last one",
        })
    }
}

/// A part of a drive.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Span {
    /// Where it begins, s.
    pub from_s: Seconds,
    /// How long it is, s.
    pub length_s: Seconds,
}

/// Where the bursts of a drive are, and the drive between them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Bursts {
    /// The burst before the drive.
    pub first: Span,
    /// The drive as it was.
    pub drive: Span,
    /// The burst after it.
    pub last: Span,
}

impl Bursts {
    /// The events that state them in a file.
    #[must_use]
    pub fn events(&self) -> Vec<Event> {
        let each = [
            (FIRST_BURST, self.first),
            (DRIVE_BETWEEN, self.drive),
            (LAST_BURST, self.last),
        ];
        let event = |(kind, span): (&str, Span)| Event {
            onset_s: span.from_s,
            duration_s: span.length_s,
            kind: kind.into(),
            value: None,
        };
        each.map(event).into()
    }

    /// The bursts that `events` state; `None` where they do not state both, in order, each once.
    #[must_use]
    pub fn of_events(events: &[Event]) -> Option<Self> {
        let only = |kind: &str| {
            let mut found = events.iter().filter(|event| event.kind == kind);
            let first = found.next().filter(|_| found.next().is_none())?;
            let span = Span {
                from_s: first.onset_s,
                length_s: first.duration_s,
            };
            let fits = span.from_s.0 >= 0.0 && span.length_s.0 > 0.0;
            fits.then_some(span)
        };
        let (first, last) = (only(FIRST_BURST)?, only(LAST_BURST)?);
        let end_s = first.from_s.0 + first.length_s.0;
        // Others may call something else a drive.
        let drive = only(DRIVE_BETWEEN).unwrap_or(Span {
            from_s: Seconds(end_s),
            length_s: Seconds(last.from_s.0 - end_s),
        });
        (end_s <= last.from_s.0).then_some(Self { first, drive, last })
    }
}

/// A drive with bursts, and where they are.
#[derive(Clone, Debug, PartialEq)]
pub struct WithBursts {
    /// The drive, of full scale.
    pub drive: Series<Drive>,
    /// Where the bursts are.
    pub bursts: Bursts,
}

impl WithBursts {
    /// What was stated of the drive, with its events at their new times and those of the bursts.
    #[must_use]
    pub fn annotations(&self, before: &Annotations) -> Annotations {
        let moved = before.events.iter().map(|event| Event {
            onset_s: Seconds(event.onset_s.0 + self.bursts.drive.from_s.0),
            ..event.clone()
        });
        let mut events: Vec<Event> = moved.chain(self.bursts.events()).collect();
        events.sort_by(|a, b| a.onset_s.0.total_cmp(&b.onset_s.0));
        Annotations {
            events,
            ..before.clone()
        }
    }
}

/// `drive` with a burst before and one after it: silence, the sweep upwards, silence, the drive as it is, silence, the sweep downwards,
/// silence; of full scale at the rate of `drive`. Both bursts have one spectrum, so that a device delays both alike, and neither is found for
/// the other.
///
/// Formula: p·w(t)·sin 2π(f₁t + (f₂ − f₁)t²/2T) with edges of a tenth that rise and fall as cosines; the last burst is the first one backwards.
///
/// Source: C. E. Cook and M. Bernfeld, *Radar Signals* (1967), for linear sweeps; docs/decisions/sound.md.
///
/// # Errors
/// [`AlignError`] for a band that the rate does not hold, other lengths than 0.1 to 10 s of silence, a burst with fewer than 100 independent
/// values, a peak beyond full scale, and a drive that contains such a sweep.
pub fn with_bursts(drive: &Series<Drive>, config: &BurstConfig) -> Result<WithBursts, AlignError> {
    let rate = drive.rate();
    config.check(rate)?;
    let rising = config.rising(rate);
    let falling: Vec<f64> = rising.iter().rev().copied().collect();
    refuse_alike(drive, [&rising, &falling])?;
    let guard = vec![0.0; rate.samples_in(config.guard_s)];
    let parts: [&[f64]; 7] = [
        &guard,
        &rising,
        &guard,
        drive.samples(),
        &guard,
        &falling,
        &guard,
    ];
    let span = |part: usize| Span {
        from_s: rate.duration_of(parts[..part].iter().map(|part| part.len()).sum()),
        length_s: rate.duration_of(parts[part].len()),
    };
    let bursts = Bursts {
        first: span(1),
        drive: span(3),
        last: span(5),
    };
    Ok(WithBursts {
        drive: Series::new(parts.concat(), rate)?,
        bursts,
    })
}

/// Refuses a drive in which one of the bursts would be found.
fn refuse_alike(drive: &Series<Drive>, bursts: [&[f64]; 2]) -> Result<(), AlignError> {
    let (samples, longest) = (drive.samples(), bursts[0].len());
    let usual = samples.iter().map(|v| v * v).sum::<f64>() / samples.len() as f64;
    let searched = Searched::of(samples, longest, longest, usual);
    for burst in bursts {
        let common = searched.common(burst);
        let found = peaks(&common.correlations(samples.len() + longest), longest);
        if let Some(place) = found.first().filter(|place| place.correlation > LIKE) {
            let at = place.at - longest as f64;
            return Err(AlignError::Alike {
                at_s: at / drive.rate().hz(),
                correlation: place.correlation,
            });
        }
    }
    Ok(())
}

/// What was written with bursts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct BurstDocument {
    /// The drive that was given.
    pub drive: String,
    /// The file with the bursts.
    pub out: String,
    /// Its rate.
    pub rate_hz: SampleRate,
    /// Its length, s.
    pub length_s: Seconds,
    /// How the bursts were made.
    pub config: BurstConfig,
    /// Where they are.
    pub bursts: Bursts,
}

impl Content for BurstDocument {
    const SCHEMA: &'static str = "burst";
}

impl BurstDocument {
    /// What was done in one sentence.
    #[must_use]
    pub fn sentence(&self) -> String {
        let Bursts { first, drive, last } = self.bursts;
        format!(
            "bursts of {:.3} s over {}, peak {} of full scale, at {:.3} s (upwards) and {:.3} s (downwards); the drive is from {:.3} s to {:.3} s of {:.3} s",
            first.length_s.0,
            self.config.band,
            crate::number::digits(self.config.peak),
            first.from_s.0,
            last.from_s.0,
            drive.from_s.0,
            drive.from_s.0 + drive.length_s.0,
            self.length_s.0
        )
    }
}
