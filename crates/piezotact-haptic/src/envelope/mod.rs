//! A vibration as slow envelopes of its amplitude and frequency, and back: what haptic files for consumer devices hold
//! instead of a waveform.
//!
//! [`analyse`] turns a texture into [`Envelopes`], [`synthesise`] plays envelopes as one sine. The fine structure of a
//! texture does not survive the way there and back; its level and its brightness over time do. [`mix`] plays the bands
//! of parametric haptic files.

mod analysis;
mod core_haptics;
mod wave;
mod wavelet;

use crate::HapticError;
use serde::{Deserialize, Serialize};

use piezotact::quantity::{Band, Hertz, QuantityError, SampleRate, Seconds, Uncalibrated};
use piezotact::series::Series;

pub use analysis::{EnvelopeConfig, analyse};
pub use core_haptics::{continuous_intensity, sharpness_control, transient_intensity};
pub use wave::{Course, Keyframe, Shape, Wave, WaveKind, mix, mixed_length};
#[cfg(test)]
pub(crate) use wavelet::wavelet_analysis;
pub use wavelet::wavelet_synthesis;

/// The rate at which envelopes are played unless stated, Hz: eight samples a period at 1 kHz, where textures end.
pub const PLAYED_AT_HZ: f64 = 8000.0;

/// The longest signal that is made from envelopes: an hour. Beyond it a time is a mistake.
pub const LONGEST: Seconds = Seconds(3600.0);

/// The most samples that are made from a haptic file, all channels together: half a gigabyte.
pub const MOST_SAMPLES: usize = 1 << 26;

/// How long an emphasis is played, s.
const EMPHASIS_S: f64 = 0.02;

/// A short accent at a breakpoint: amplitude and frequency, both 0–1.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Emphasis {
    /// The amplitude, 0–1, at least that of its breakpoint.
    pub amplitude: f64,
    /// The frequency, 0–1 of a range that the player chooses.
    pub frequency: f64,
}

/// A breakpoint of an amplitude envelope; straight lines run between breakpoints.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AmplitudePoint {
    pub time_s: f64,
    /// The amplitude of a sine, 0–1 of full scale.
    pub amplitude: f64,
    /// An accent at this time.
    pub emphasis: Option<Emphasis>,
}

/// A breakpoint of a frequency envelope; straight lines run between breakpoints.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrequencyPoint {
    pub time_s: f64,
    /// The frequency, 0–1 of a range that the player chooses.
    pub frequency: f64,
}

/// An amplitude envelope with at least one breakpoint, and a frequency envelope that may have none. Times are finite, not
/// negative and do not fall; amplitudes and frequencies lie in 0–1; no emphasis is weaker than its breakpoint.
#[derive(Clone, Debug, PartialEq)]
pub struct Envelopes {
    amplitude: Vec<AmplitudePoint>,
    frequency: Vec<FrequencyPoint>,
}

impl Envelopes {
    /// Envelopes of these breakpoints.
    ///
    /// # Errors
    /// [`HapticError::Empty`] without a breakpoint of amplitude, [`HapticError::Point`] naming the first breakpoint
    /// that breaks a rule of [`Envelopes`].
    pub fn new(
        amplitude: Vec<AmplitudePoint>,
        frequency: Vec<FrequencyPoint>,
    ) -> Result<Self, HapticError> {
        if amplitude.is_empty() {
            return Err(HapticError::Empty);
        }
        let mut before_s = 0.0;
        for (at, point) in amplitude.iter().enumerate() {
            let place = Place::of("amplitude", at);
            place.time(point.time_s, before_s)?;
            place.share("an amplitude", point.amplitude)?;
            if let Some(emphasis) = &point.emphasis {
                place.share("an amplitude of the emphasis", emphasis.amplitude)?;
                place.share("a frequency of the emphasis", emphasis.frequency)?;
                if emphasis.amplitude < point.amplitude {
                    return Err(place.wrong(
                        &format!(
                            "an emphasis of at least the amplitude {} of its breakpoint",
                            point.amplitude
                        ),
                        emphasis.amplitude,
                    ));
                }
            }
            before_s = point.time_s;
        }
        before_s = 0.0;
        for (at, point) in frequency.iter().enumerate() {
            let place = Place::of("frequency", at);
            place.time(point.time_s, before_s)?;
            place.share("a frequency", point.frequency)?;
            before_s = point.time_s;
        }
        Ok(Self {
            amplitude,
            frequency,
        })
    }

    /// The breakpoints of the amplitude, at least one.
    #[must_use]
    pub fn amplitude(&self) -> &[AmplitudePoint] {
        &self.amplitude
    }

    /// The breakpoints of the frequency; none where the player's own frequency is meant.
    #[must_use]
    pub fn frequency(&self) -> &[FrequencyPoint] {
        &self.frequency
    }

    /// The time of the last breakpoint of the amplitude: the length.
    #[must_use]
    pub fn duration(&self) -> Seconds {
        Seconds(self.amplitude.last().map_or(0.0, |point| point.time_s))
    }
}

/// Where in which envelope.
struct Place {
    envelope: &'static str,
    at: usize,
}

impl Place {
    fn of(envelope: &'static str, at: usize) -> Self {
        Self { envelope, at }
    }

    fn wrong(&self, expected: &str, found: f64) -> HapticError {
        HapticError::Point {
            envelope: self.envelope,
            at: self.at,
            expected: expected.into(),
            found,
        }
    }

    fn time(&self, time_s: f64, before_s: f64) -> Result<(), HapticError> {
        if !(0.0..=LONGEST.0).contains(&time_s) {
            return Err(self.wrong("a time from 0 to 3600 s", time_s));
        }
        if time_s < before_s {
            return Err(self.wrong(
                &format!("a time not before {before_s} s, that of the breakpoint before it"),
                time_s,
            ));
        }
        Ok(())
    }

    fn share(&self, what: &str, value: f64) -> Result<(), HapticError> {
        if (0.0..=1.0).contains(&value) {
            Ok(())
        } else {
            Err(self.wrong(&format!("{what} from 0 to 1"), value))
        }
    }
}

/// What 0 and 1 of a frequency envelope stand for. No haptic file says it: a player maps them to what its actuator can
/// do, so a program that reads or writes hertz has to choose, and to say what it chose.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FrequencyRange(Band);

impl FrequencyRange {
    /// The range from `low` to `high`, on a logarithmic scale.
    ///
    /// # Errors
    /// [`QuantityError::Band`] unless 0 < low < high and both are finite.
    pub fn new(low: Hertz, high: Hertz) -> Result<Self, QuantityError> {
        let band = Band::new(low, high)?;
        if low.0 > 0.0 {
            Ok(Self(band))
        } else {
            Err(QuantityError::Band {
                found: format!("{}..{}", low.0, high.0),
            })
        }
    }

    /// 20 to 1000 Hz, the band in which textures are rendered here unless stated.
    ///
    /// # Errors
    /// None with these numbers; [`QuantityError::Band`] by type.
    pub fn texture() -> Result<Self, QuantityError> {
        Self::new(Hertz(20.0), Hertz(1000.0))
    }

    /// The band.
    #[must_use]
    pub fn band(self) -> Band {
        self.0
    }

    /// The frequency at `share` of the range, low·(high/low)^share, Hz.
    #[must_use]
    pub fn hertz(self, share: f64) -> f64 {
        self.0.low().0 * (self.0.high().0 / self.0.low().0).powf(share)
    }

    /// Where `frequency_hz` lies in the range, 0–1; beyond its ends, the end.
    #[must_use]
    pub fn share(self, frequency_hz: f64) -> f64 {
        let low = self.0.low().0;
        ((frequency_hz / low).ln() / (self.0.high().0 / low).ln()).clamp(0.0, 1.0)
    }
}

/// The signal that `envelopes` stand for, full scale = 1: one sine whose amplitude and frequency follow them, and for
/// every emphasis 20 ms of a sine under a Hann window. Without a frequency envelope the sine has the middle of `range`.
///
/// Formula: x(t) = a(t)·sin 2π∫f dt, with a and the place of f in `range` interpolated linearly between breakpoints.
///
/// Source: the model of `.haptic` clips, an amplitude- and a frequency-modulated continuous signal with emphasised
/// breakpoints (Lofelt `NiceVibrations`, `core/datamodel/src/v1.rs`); the range and the shape of an emphasis are chosen here.
///
/// # Errors
/// [`HapticError::NoLength`] when the last breakpoint lies before the first sample's end, [`HapticError::TooMany`]
/// beyond [`MOST_SAMPLES`].
pub fn synthesise(
    envelopes: &Envelopes,
    range: FrequencyRange,
    rate: SampleRate,
) -> Result<Series<Uncalibrated>, HapticError> {
    let count = rate.samples_in(envelopes.duration());
    if count == 0 {
        return Err(HapticError::NoLength {
            found: format!("a clip of {} s", envelopes.duration().0),
        });
    }
    require_few(count, envelopes.duration(), rate)?;
    let middle = [FrequencyPoint {
        time_s: 0.0,
        frequency: 0.5,
    }];
    let frequency = if envelopes.frequency.is_empty() {
        middle.as_slice()
    } else {
        &envelopes.frequency
    };
    let amplitudes: Vec<(f64, f64)> = envelopes
        .amplitude
        .iter()
        .map(|point| (point.time_s, point.amplitude))
        .collect();
    let frequencies: Vec<(f64, f64)> = frequency
        .iter()
        .map(|point| (point.time_s, point.frequency))
        .collect();
    let (mut amplitude, mut frequency) = (Lines::of(&amplitudes), Lines::of(&frequencies));
    let step_s = 1.0 / rate.hz();
    let mut phase = 0.0f64;
    let mut samples: Vec<f64> = (0..count)
        .map(|i| {
            let time_s = i as f64 * step_s;
            let sample = amplitude.at(time_s) * (std::f64::consts::TAU * phase).sin();
            phase = (phase + range.hertz(frequency.at(time_s)) * step_s).fract();
            sample
        })
        .collect();
    for point in &envelopes.amplitude {
        let Some(emphasis) = &point.emphasis else {
            continue;
        };
        let first = rate.samples_in(Seconds(point.time_s));
        let length = rate.samples_in(Seconds(EMPHASIS_S)).max(1);
        let hertz = range.hertz(emphasis.frequency);
        for (k, sample) in samples.iter_mut().skip(first).take(length).enumerate() {
            let window = (std::f64::consts::PI * (k as f64 + 0.5) / length as f64).sin();
            *sample += emphasis.amplitude
                * window
                * window
                * (std::f64::consts::TAU * hertz * k as f64 * step_s).sin();
        }
    }
    Ok(Series::new(samples, rate)?)
}

/// Refuses a signal of more samples than are made, before there is memory for it.
fn require_few(count: usize, duration: Seconds, rate: SampleRate) -> Result<(), HapticError> {
    if count > MOST_SAMPLES {
        return Err(HapticError::TooMany {
            found: format!("{count} ({} s at {rate})", duration.0),
        });
    }
    Ok(())
}

/// Straight lines between points whose times do not fall, read off at times that rise.
pub(crate) struct Lines<'a> {
    points: &'a [(f64, f64)],
    next: usize,
}

impl<'a> Lines<'a> {
    pub(crate) fn of(points: &'a [(f64, f64)]) -> Self {
        Self { points, next: 0 }
    }

    /// The value at `time_s`; before the first point the first value, after the last the last, 0 without points.
    pub(crate) fn at(&mut self, time_s: f64) -> f64 {
        while self
            .points
            .get(self.next)
            .is_some_and(|(t, _)| *t <= time_s)
        {
            self.next += 1;
        }
        let after = self.points.get(self.next);
        let before = self.next.checked_sub(1).and_then(|k| self.points.get(k));
        match (before, after) {
            (Some((t0, v0)), Some((t1, v1))) if t1 > t0 => {
                v0 + (v1 - v0) * (time_s - t0) / (t1 - t0)
            }
            (Some((_, value)), _) | (None, Some((_, value))) => *value,
            (None, None) => 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezotact::quantity::{Acceleration, Unit};
    use piezotact::share::shares_of_full_scale;
    use piezotact::spectrum::amplitude_spectrum;

    fn point(time_s: f64, amplitude: f64) -> AmplitudePoint {
        AmplitudePoint {
            time_s,
            amplitude,
            emphasis: None,
        }
    }

    #[test]
    fn a_sine_goes_there_and_back() {
        let rate = SampleRate::new(8000.0).unwrap();
        let sine: Vec<f64> = (0..16_000)
            .map(|i| 3.0 * (std::f64::consts::TAU * 200.0 * f64::from(i) / 8000.0).sin())
            .collect();
        let x = Series::<Acceleration>::new(sine, rate).unwrap();
        let config = EnvelopeConfig::texture().unwrap();
        let envelopes = analyse(&x, 6.0, &config).unwrap();
        for point in envelopes.amplitude() {
            assert!((point.amplitude - 0.5).abs() < 0.01, "{point:?}");
        }
        for point in envelopes.frequency() {
            let hertz = config.range.hertz(point.frequency);
            assert!((hertz - 200.0).abs() < 8.0, "{hertz}");
        }
        let back = synthesise(&envelopes, config.range, rate).unwrap();
        assert_eq!(back.samples().len(), 16_000);
        assert!(
            (back.rms() - 0.5 / 2f64.sqrt()).abs() < 0.005,
            "{}",
            back.rms()
        );
        let (frequencies_hz, amplitudes) = amplitude_spectrum(&back);
        let strongest = (0..amplitudes.len())
            .max_by(|a, b| amplitudes[*a].total_cmp(&amplitudes[*b]))
            .unwrap();
        assert!((frequencies_hz[strongest] - 200.0).abs() < 3.0);
    }

    #[test]
    fn shares_lie_within_one_and_silence_has_none() {
        let rate = SampleRate::new(1000.0).unwrap();
        let of = |samples: &[f64]| {
            let series = Series::new(samples.to_vec(), rate).unwrap();
            shares_of_full_scale("a", series, &Unit::MetrePerSecondSquared, None)
        };
        let shares = of(&[11.0, 9.0, 14.0, 6.0]).unwrap();
        assert_eq!((shares.full_scale.value, shares.removed_mean), (4.0, 10.0));
        assert_eq!(shares.shares.samples(), [0.25, -0.25, 1.0, -1.0]);
        for silent in [&[0.0, 0.0][..], &[9.81; 7]] {
            assert!(of(silent).is_err());
        }
    }

    #[test]
    fn what_breaks_a_rule_is_named_with_its_place() {
        let emphasised = |amplitude, emphasis: f64| AmplitudePoint {
            emphasis: Some(Emphasis {
                amplitude: emphasis,
                frequency: 0.5,
            }),
            ..point(0.0, amplitude)
        };
        for (points, part) in [
            (vec![], "no breakpoint of amplitude"),
            (vec![point(-0.1, 0.0)], "a time from 0"),
            (vec![point(0.0, 0.0), point(f64::NAN, 0.0)], "breakpoint 1"),
            (vec![point(0.0, 1.01)], "an amplitude from 0 to 1"),
            (vec![point(1.0, 0.0), point(0.5, 0.0)], "not before 1 s"),
            (vec![emphasised(0.5, 0.4)], "at least the amplitude 0.5"),
            (vec![emphasised(0.5, 1.4)], "of the emphasis from 0 to 1"),
        ] {
            let error = Envelopes::new(points, vec![]).unwrap_err().to_string();
            assert!(error.contains(part), "{error}");
        }
        let bad = FrequencyPoint {
            time_s: 0.0,
            frequency: -1.0,
        };
        assert!(Envelopes::new(vec![point(0.0, 0.0)], vec![bad]).is_err());
    }

    #[test]
    fn an_emphasis_is_heard_and_a_clip_without_length_refused() {
        let rate = SampleRate::new(8000.0).unwrap();
        let range = FrequencyRange::texture().unwrap();
        let silent = Envelopes::new(vec![point(0.0, 0.0), point(0.2, 0.0)], vec![]).unwrap();
        assert!(synthesise(&silent, range, rate).unwrap().peak() < 1e-12);
        let accent = AmplitudePoint {
            emphasis: Some(Emphasis {
                amplitude: 0.8,
                frequency: 0.5,
            }),
            ..point(0.1, 0.0)
        };
        let accented =
            Envelopes::new(vec![point(0.0, 0.0), accent, point(0.2, 0.0)], vec![]).unwrap();
        let peak = synthesise(&accented, range, rate).unwrap().peak();
        assert!((0.6..=0.8).contains(&peak), "{peak}");
        let nothing = Envelopes::new(vec![point(0.0, 1.0)], vec![]).unwrap();
        assert!(synthesise(&nothing, range, rate).is_err());
    }
}
