//! Plays what the bands of a parametric haptic file hold: curves, modulated oscillations, taps and wavelet blocks.

use crate::{AGAIN, HapticError};
use std::f64::consts::TAU;

use super::wavelet::wavelet_synthesis;
use super::{LONGEST, Lines, MOST_SAMPLES, require_few};
use piezotact::quantity::{Band, SampleRate, Seconds, Uncalibrated};
use piezotact::resample::resample;
use piezotact::series::Series;

/// How long a tap is played, s.
///
/// Source: ISO/IEC 23090-31 reference software, `TRANSIENT_DURATION_MS`.
const TAP_S: f64 = 0.022;

/// The shape of one period of an oscillation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// sin.
    Sine,
    /// +1 for half a period, then −1.
    Square,
    /// From 0 to 1 to −1 to 0.
    Triangle,
    /// From −1 to 1, then back at once.
    SawToothUp,
    /// From 1 to −1, then back at once.
    SawToothDown,
}

impl Shape {
    /// The value at a phase in periods, −1 to 1.
    fn at(self, periods: f64) -> f64 {
        let phase = periods.rem_euclid(1.0);
        match self {
            Self::Sine => (TAU * phase).sin(),
            Self::Square => {
                if phase < 0.5 {
                    1.0
                } else {
                    -1.0
                }
            }
            Self::Triangle => 1.0 - 4.0 * ((phase + 0.25).fract() - 0.5).abs(),
            Self::SawToothUp => 2.0 * phase - 1.0,
            Self::SawToothDown => 1.0 - 2.0 * phase,
        }
    }
}

/// How a curve runs between its keyframes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Course {
    /// Straight.
    Linear,
    /// As cubic Hermite splines whose slope at a keyframe is that between its neighbours.
    Cubic,
}

/// A keyframe: when, and how strong and at which frequency, where it says so.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Keyframe {
    /// When, from the start of its wave, s.
    pub time_s: f64,
    /// The amplitude, full scale = 1.
    pub amplitude: Option<f64>,
    pub frequency_hz: Option<f64>,
}

/// The meaning of the keyframes of a wave.
#[derive(Clone, Debug, PartialEq)]
pub enum WaveKind {
    /// The amplitudes are the signal.
    Curve(Course),
    /// The amplitudes and frequencies modulate an oscillation, whose frequency stays within limits.
    Oscillation {
        /// The shape of a period.
        shape: Shape,
        /// Where the frequency stays.
        limits: Band,
    },
    /// Each keyframe is a tap of 22 ms.
    Tap(Shape),
    /// Blocks of wavelet coefficients.
    Wavelet {
        /// The rate of the samples that the blocks hold.
        rate: SampleRate,
        /// The coefficients of one block, the coarsest first.
        coefficients: Vec<f64>,
    },
}

/// One effect of a band.
#[derive(Clone, Debug, PartialEq)]
pub struct Wave {
    pub kind: WaveKind,
    /// When it starts, s.
    pub start_s: f64,
    /// Where in its period an oscillation starts, rad.
    pub phase_rad: f64,
    /// What it is multiplied by.
    pub gain: f64,
    /// Its keyframes, in time; none for wavelets.
    pub keyframes: Vec<Keyframe>,
}

impl Wave {
    fn length_s(&self) -> f64 {
        let last_s = self.keyframes.last().map_or(0.0, |frame| frame.time_s);
        match &self.kind {
            WaveKind::Curve(_) | WaveKind::Oscillation { .. } => last_s,
            WaveKind::Tap(_) => last_s + TAP_S,
            WaveKind::Wavelet { rate, coefficients } => rate.duration_of(coefficients.len()).0,
        }
    }

    fn check(&self) -> Result<(), HapticError> {
        let wrong =
            |expected: &str, found: f64| HapticError::content(expected, found.to_string(), AGAIN);
        let mut before_s = 0.0;
        for frame in &self.keyframes {
            if !(before_s..=LONGEST.0).contains(&frame.time_s) {
                return Err(wrong(
                    "keyframes at times from 0 to 3600 s that do not decrease",
                    frame.time_s,
                ));
            }
            before_s = frame.time_s;
            for value in [frame.amplitude, frame.frequency_hz].into_iter().flatten() {
                if !(-1e6..=1e6).contains(&value) {
                    return Err(wrong("amplitudes and frequencies within ±1e6", value));
                }
            }
        }
        for value in [self.phase_rad, self.gain] {
            if !(-1e6..=1e6).contains(&value) {
                return Err(wrong("a phase and a gain within ±1e6", value));
            }
        }
        if let WaveKind::Wavelet { coefficients, .. } = &self.kind
            && let Some(bad) = coefficients.iter().find(|v| !(-1e6..=1e6).contains(*v))
        {
            return Err(wrong("wavelet coefficients within ±1e6", *bad));
        }
        let end_s = self.start_s + self.length_s();
        if !(0.0..=LONGEST.0).contains(&self.start_s) || end_s > LONGEST.0 {
            return Err(wrong("effects from 0 to 3600 s", self.start_s));
        }
        Ok(())
    }

    fn points(&self, value: impl Fn(&Keyframe) -> Option<f64>) -> Vec<(f64, f64)> {
        let point = |frame: &Keyframe| Some((frame.time_s, value(frame)?));
        self.keyframes.iter().filter_map(point).collect()
    }

    fn add_to(&self, samples: &mut [f64], rate: SampleRate) {
        let first = (self.start_s * rate.hz() - 1e-6).ceil().max(0.0) as usize;
        let end = ((self.start_s + self.length_s()) * rate.hz() + 1e-6).floor() as usize + 1;
        let into = samples.iter_mut().enumerate().skip(first);
        let into = into.take(end.saturating_sub(first));
        let since_start = |i: usize| i as f64 / rate.hz() - self.start_s;
        let amplitudes = self.points(|frame| frame.amplitude);
        match &self.kind {
            WaveKind::Curve(Course::Linear) => {
                let mut curve = Lines::of(&amplitudes);
                into.for_each(|(i, sample)| *sample += self.gain * curve.at(since_start(i) + 1e-9));
            }
            WaveKind::Curve(Course::Cubic) => {
                let mut curve = Hermite::of(&amplitudes);
                into.for_each(|(i, sample)| *sample += self.gain * curve.at(since_start(i)));
            }
            WaveKind::Oscillation { shape, limits } => {
                let frequencies = self.points(|frame| frame.frequency_hz);
                let whole = [(0.0, 1.0)];
                let amplitudes = if amplitudes.is_empty() {
                    whole.as_slice()
                } else {
                    &amplitudes
                };
                let (mut amplitude, mut frequency) =
                    (Lines::of(amplitudes), Lines::of(&frequencies));
                let mut periods = self.phase_rad / TAU;
                into.for_each(|(i, sample)| {
                    let at_s = since_start(i);
                    *sample += self.gain * amplitude.at(at_s) * shape.at(periods);
                    let hertz = frequency.at(at_s).clamp(limits.low().0, limits.high().0);
                    periods = (periods + hertz / rate.hz()).fract();
                });
            }
            WaveKind::Tap(shape) => {
                let taps: Vec<(f64, f64, f64)> = self
                    .keyframes
                    .iter()
                    .filter_map(|f| Some((f.time_s, f.amplitude?, f.frequency_hz?)))
                    .collect();
                let mut from = 0;
                into.for_each(|(i, sample)| {
                    let at_s = since_start(i);
                    while taps.get(from).is_some_and(|tap| tap.0 + TAP_S < at_s) {
                        from += 1;
                    }
                    for (time_s, amplitude, hertz) in &taps[from..] {
                        if *time_s > at_s {
                            break;
                        }
                        let periods = (at_s - time_s) * hertz + self.phase_rad / TAU;
                        *sample += self.gain * amplitude * shape.at(periods);
                    }
                });
            }
            // Blocks that follow each other are one signal: see below.
            WaveKind::Wavelet { .. } => {}
        }
    }
}

/// Adds the blocks of wavelets: those of one rate as one signal, so that no edge is heard between them.
fn add_wavelets(waves: &[Wave], samples: &mut [f64], rate: SampleRate) -> Result<(), HapticError> {
    let mut signals: Vec<(SampleRate, Vec<f64>)> = Vec::new();
    for wave in waves {
        let WaveKind::Wavelet {
            rate: from,
            coefficients,
        } = &wave.kind
        else {
            continue;
        };
        let block = wavelet_synthesis(coefficients)?;
        let start = from.samples_in(Seconds(wave.start_s));
        let end = start + block.len();
        // Blocks of other rates are held at the same time.
        let others = signals.iter().filter(|(known, _)| known != from);
        let held: usize = others.map(|(_, signal)| signal.len()).sum();
        if held.saturating_add(end) > MOST_SAMPLES {
            return Err(HapticError::content(
                format!("wavelets of at most {MOST_SAMPLES} samples in all"),
                format!("one that ends at sample {end}, and {held} at other rates"),
                AGAIN,
            ));
        }
        let at = signals.iter().position(|(known, _)| known == from);
        let at = at.unwrap_or_else(|| {
            signals.push((*from, Vec::new()));
            signals.len() - 1
        });
        let signal = &mut signals[at].1;
        if signal.len() < end {
            signal.resize(end, 0.0);
        }
        for (sum, value) in signal[start..end].iter_mut().zip(&block) {
            *sum += wave.gain * value;
        }
    }
    for (from, signal) in signals {
        let signal = Series::<Uncalibrated>::new(signal, from)?;
        let signal = resample(&signal, rate).map_err(|error| {
            HapticError::content(
                format!("wavelets at a rate that divides {rate}"),
                error.to_string(),
                AGAIN,
            )
        })?;
        for (sample, value) in samples.iter_mut().zip(signal.samples()) {
            *sample += value;
        }
    }
    Ok(())
}

/// The number of samples that [`mix`] makes of `waves` at `rate`.
///
/// Source: the end of the last of them, times the rate.
///
/// # Errors
/// Those of [`mix`].
pub fn mixed_length(waves: &[Wave], rate: SampleRate) -> Result<usize, HapticError> {
    let mut end_s = 0.0f64;
    for wave in waves {
        wave.check()?;
        end_s = end_s.max(wave.start_s + wave.length_s());
    }
    if end_s <= 0.0 {
        return Err(HapticError::NoLength {
            found: format!("{} effects of 0 s", waves.len()),
        });
    }
    let count = (end_s * rate.hz() + 1e-6).floor() as usize + 1;
    let count = count.min(rate.samples_in(LONGEST));
    require_few(count, Seconds(end_s), rate)?;
    Ok(count)
}

/// The sum of `waves` at `rate`, full scale = 1, from 0 s to the end of the last of them.
///
/// Source: ISO/IEC 23090-31:2025, 5.7 and 5.8 (bands, effects, keyframes), as its reference software plays them
/// (MPEGGroup/HapticReferenceSoftware, `source/Types/src/Band.cpp` and `Effect.cpp`); oscillations keep their phase
/// across keyframes.
///
/// # Errors
/// [`HapticError::Content`] when times fall, are negative or lie beyond an hour, values are no numbers within ±1e6, or a
/// wavelet block cannot be transformed; [`HapticError::NoLength`] when nothing lasts, [`HapticError::TooMany`]
/// beyond [`MOST_SAMPLES`].
pub fn mix(waves: &[Wave], rate: SampleRate) -> Result<Series<Uncalibrated>, HapticError> {
    let mut samples = vec![0.0; mixed_length(waves, rate)?];
    for wave in waves {
        wave.add_to(&mut samples, rate);
    }
    add_wavelets(waves, &mut samples, rate)?;
    Ok(Series::new(samples, rate)?)
}

/// Cubic Hermite splines through points, read off at times that rise.
struct Hermite<'a> {
    points: &'a [(f64, f64)],
    at: usize,
}

impl<'a> Hermite<'a> {
    fn of(points: &'a [(f64, f64)]) -> Self {
        Self { points, at: 0 }
    }

    fn slope(&self, k: usize) -> f64 {
        let (a, b) = (
            self.points[k.saturating_sub(1)],
            self.points[(k + 1).min(self.points.len() - 1)],
        );
        if b.0 > a.0 {
            (b.1 - a.1) / (b.0 - a.0)
        } else {
            0.0
        }
    }

    fn at(&mut self, time_s: f64) -> f64 {
        let (Some(first), Some(last)) = (self.points.first(), self.points.last()) else {
            return 0.0;
        };
        if time_s <= first.0 {
            return first.1;
        }
        if time_s >= last.0 {
            return last.1;
        }
        while self.points[self.at + 1].0 <= time_s {
            self.at += 1;
        }
        let ((t0, v0), (t1, v1)) = (self.points[self.at], self.points[self.at + 1]);
        let (h, u) = (t1 - t0, (time_s - t0) / (t1 - t0));
        let (m0, m1) = (self.slope(self.at), self.slope(self.at + 1));
        let (u2, u3) = (u * u, u * u * u);
        (2.0 * u3 - 3.0 * u2 + 1.0) * v0
            + (u3 - 2.0 * u2 + u) * h * m0
            + (3.0 * u2 - 2.0 * u3) * v1
            + (u3 - u2) * h * m1
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezotact::quantity::Hertz;

    fn frames(values: &[(f64, f64, f64)]) -> Vec<Keyframe> {
        let frame = |(time_s, amplitude, hertz): &(f64, f64, f64)| Keyframe {
            time_s: *time_s,
            amplitude: Some(*amplitude),
            frequency_hz: Some(*hertz),
        };
        values.iter().map(frame).collect()
    }

    fn wave(kind: WaveKind, keyframes: Vec<Keyframe>) -> Wave {
        Wave {
            kind,
            start_s: 0.0,
            phase_rad: 0.0,
            gain: 1.0,
            keyframes,
        }
    }

    #[test]
    fn a_curve_with_a_keyframe_a_sample_is_the_signal() {
        let rate = SampleRate::new(8000.0).unwrap();
        let signal: Vec<f64> = (0..500).map(|i| (f64::from(i) * 0.7).sin()).collect();
        let points: Vec<(f64, f64, f64)> = signal
            .iter()
            .enumerate()
            .map(|(i, v)| (i as f64 / 8000.0, *v, 0.0))
            .collect();
        for course in [Course::Linear, Course::Cubic] {
            let played = mix(&[wave(WaveKind::Curve(course), frames(&points))], rate).unwrap();
            assert_eq!(played.samples().len(), 500);
            for (a, b) in played.samples().iter().zip(&signal) {
                assert!((a - b).abs() < 1e-4, "{course:?}: {a} {b}");
            }
        }
    }

    #[test]
    fn an_oscillation_has_its_amplitude_and_stays_in_its_band() {
        let rate = SampleRate::new(8000.0).unwrap();
        let kind = WaveKind::Oscillation {
            shape: Shape::Sine,
            limits: Band::new(Hertz(50.0), Hertz(100.0)).unwrap(),
        };
        let played = mix(
            &[wave(kind, frames(&[(0.0, 0.5, 400.0), (1.0, 0.5, 400.0)]))],
            rate,
        );
        let played = played.unwrap();
        assert!((played.rms() - 0.5 / 2f64.sqrt()).abs() < 1e-3);
        let rising = |pair: &&[f64]| pair[0] < 0.0 && pair[1] >= 0.0;
        assert_eq!(played.samples().windows(2).filter(rising).count(), 99);
    }

    #[test]
    fn a_tap_lasts_22_ms_and_shapes_have_their_corners() {
        let rate = SampleRate::new(8000.0).unwrap();
        let tap = wave(WaveKind::Tap(Shape::Square), frames(&[(0.0, 0.7, 100.0)]));
        let played = mix(&[tap], rate).unwrap();
        assert_eq!(played.samples().len(), 177);
        assert!((played.samples()[10] - 0.7).abs() < 1e-12);
        for (shape, quarter) in [
            (Shape::Sine, 1.0),
            (Shape::Triangle, 1.0),
            (Shape::SawToothUp, -0.5),
            (Shape::SawToothDown, 0.5),
        ] {
            assert!((shape.at(0.25) - quarter).abs() < 1e-12, "{shape:?}");
        }
        assert!(Shape::Triangle.at(0.0).abs() < 1e-12);
    }

    #[test]
    fn blocks_of_wavelets_join_without_an_edge() {
        let (from, rate) = (
            SampleRate::new(1000.0).unwrap(),
            SampleRate::new(8000.0).unwrap(),
        );
        let signal = |t_s: f64| (TAU * 60.0 * t_s).sin();
        let samples: Vec<f64> = (0..1024).map(|i| signal(f64::from(i) / 1000.0)).collect();
        let blocks: Vec<Wave> = samples
            .chunks(256)
            .enumerate()
            .map(|(k, block)| Wave {
                start_s: k as f64 * 0.256,
                ..wave(
                    WaveKind::Wavelet {
                        rate: from,
                        coefficients: crate::envelope::wavelet_analysis(block).unwrap(),
                    },
                    vec![],
                )
            })
            .collect();
        let played = mix(&blocks, rate).unwrap();
        // Away from the ends of the signal, where the resampler has nothing to lean on.
        for (i, v) in played.samples().iter().enumerate().skip(800).take(6400) {
            assert!((v - signal(i as f64 / 8000.0)).abs() < 1e-3, "{i}: {v}");
        }
        let mut late = blocks[0].clone();
        late.start_s = 3599.0;
        late.kind = WaveKind::Wavelet {
            rate: SampleRate::new(1e6).unwrap(),
            coefficients: vec![0.0; 8],
        };
        assert!(mix(&[late], rate).is_err());
        // Each rate alone would fit.
        let at = |from: f64| Wave {
            start_s: 3000.0,
            kind: WaveKind::Wavelet {
                rate: SampleRate::new(from).unwrap(),
                coefficients: vec![0.0; 8],
            },
            ..blocks[0].clone()
        };
        let error = mix(&[at(15_000.0), at(15_001.0)], rate).unwrap_err();
        assert!(error.to_string().contains("at other rates"), "{error}");
    }

    #[test]
    fn times_that_fall_or_never_end_are_refused() {
        let rate = SampleRate::new(8000.0).unwrap();
        let curve = |points: &[(f64, f64, f64)]| {
            mix(
                &[wave(WaveKind::Curve(Course::Cubic), frames(points))],
                rate,
            )
        };
        assert!(curve(&[(0.1, 0.0, 0.0), (0.0, 0.0, 0.0)]).is_err());
        assert!(curve(&[(0.0, 0.0, 0.0), (1e9, 0.0, 0.0)]).is_err());
        assert!(curve(&[(0.0, 1e300, 0.0), (1.0, 0.0, 0.0)]).is_err());
        assert!(curve(&[(0.0, 1.0, 0.0)]).is_err());
        assert!(mix(&[], rate).is_err());
    }

    /// Before there is memory for it: an hour at 10 MHz would be 288 GB.
    #[test]
    fn more_than_half_a_gigabyte_is_refused() {
        let rate = SampleRate::new(1e7).unwrap();
        let hour = frames(&[(0.0, 0.0, 0.0), (3600.0, 1.0, 0.0)]);
        let error = mix(&[wave(WaveKind::Curve(Course::Linear), hour)], rate).unwrap_err();
        assert!(matches!(error, HapticError::TooMany { .. }), "{error}");
        let point = |time_s, amplitude| crate::envelope::AmplitudePoint {
            time_s,
            amplitude,
            emphasis: None,
        };
        let clip =
            crate::envelope::Envelopes::new(vec![point(0.0, 0.0), point(3600.0, 1.0)], vec![]);
        let range = crate::envelope::FrequencyRange::texture().unwrap();
        let error = crate::envelope::synthesise(&clip.unwrap(), range, rate).unwrap_err();
        assert!(error.to_string().contains("lower rate"), "{error}");
    }
}
