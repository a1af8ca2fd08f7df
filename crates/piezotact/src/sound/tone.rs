//! The level of one tone in a signal.

use crate::sound::SoundError;
use std::f64::consts::{SQRT_2, TAU};

use serde::{Deserialize, Serialize};

use crate::quantity::{Hertz, SampleRate};

/// Fewer periods do not separate a tone from its mean.
pub(super) const FEWEST_PERIODS: f64 = 5.0;

/// Steps of a golden section: each leaves 0.618 of the interval.
const REFINED: usize = 24;

/// A tone of known frequency in a signal.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Tone {
    /// Its rms, in the unit of the signal.
    pub rms: f64,
    /// Its phase at the first sample, rad: that of a cosine.
    pub phase_rad: f64,
    /// What is left without the tone and the mean, rms, in the unit of the signal.
    pub residual_rms: f64,
    /// The mean, in the unit of the signal.
    pub mean: f64,
}

impl Tone {
    /// How much of the signal about its mean is the tone, in dB: the ratio of the tone to what is left.
    ///
    /// Formula: 20·log10(rms / residual).
    ///
    /// Source: IEEE Std 1057-2017, signal to noise and distortion ratio.
    #[must_use]
    pub fn above_residual_db(&self) -> f64 {
        20.0 * (self.rms / self.residual_rms.max(f64::MIN_POSITIVE)).log10()
    }
}

/// The tone of `frequency` in `samples` at `rate`: rms, phase, mean and residual in the unit of the samples.
///
/// Formula: least squares of a·cos(2πft) + b·sin(2πft) + c; rms = √((a² + b²)/2).
///
/// Source: IEEE Std 1057-2017, annex B: three-parameter sine fit.
///
/// # Errors
/// [`SoundError`] for a frequency outside 0 to half the rate, fewer than five periods, and samples that are no numbers.
pub fn tone(samples: &[f64], rate: SampleRate, frequency: Hertz) -> Result<Tone, SoundError> {
    let (hz, half) = (frequency.0, rate.nyquist().0);
    if !(hz > 0.0 && hz < half) {
        return Err(SoundError::Frequency {
            below_hz: half,
            found_hz: hz,
        });
    }
    let periods = samples.len() as f64 * hz / rate.hz();
    if periods < FEWEST_PERIODS {
        return Err(SoundError::Short { hz, found: periods });
    }
    if samples.iter().any(|value| !value.is_finite()) {
        return Err(SoundError::NotFinite { what: "signal" });
    }
    let basis = |i: usize| {
        let (sin, cos) = (TAU * hz * i as f64 / rate.hz()).sin_cos();
        [cos, sin, 1.0]
    };
    let (mut normal, mut right) = ([[0.0; 3]; 3], [0.0; 3]);
    for (i, sample) in samples.iter().enumerate() {
        let row = basis(i);
        for (j, a) in row.iter().enumerate() {
            right[j] += a * sample;
            for (k, b) in row.iter().enumerate() {
                normal[j][k] += a * b;
            }
        }
    }
    let [a, b, mean] = solved(normal, right);
    let left = samples.iter().enumerate().map(|(i, sample)| {
        let [cos, sin, _] = basis(i);
        (sample - a * cos - b * sin - mean).powi(2)
    });
    let residual_rms = (left.sum::<f64>() / samples.len() as f64).sqrt();
    Ok(Tone {
        rms: a.hypot(b) / SQRT_2,
        phase_rad: (-b).atan2(a),
        residual_rms,
        mean,
    })
}

/// The tone nearest to `frequency` in `samples` at `rate`, whose own frequency differs from it by up to `most_share`: a calibrator and its recorder have
/// two clocks. Its frequency, Hz, and the tone as by [`tone`].
///
/// Formula: the frequency with the least residual of the three-parameter fit: the best of a grid finer than half the resolution, then by golden section.
///
/// Source: IEEE Std 1057-2017, annex B: four-parameter sine fit.
///
/// # Errors
/// As [`tone`].
pub fn tone_near(
    samples: &[f64],
    rate: SampleRate,
    frequency: Hertz,
    most_share: f64,
) -> Result<(Hertz, Tone), SoundError> {
    let reach = frequency.0 * most_share.abs();
    let length_s = rate.duration_of(samples.len()).0;
    let steps = (4.0 * reach * length_s).ceil().max(1.0);
    let step = reach / steps;
    let residual = |hz: f64| tone(samples, rate, Hertz(hz)).map(|found| found.residual_rms);
    let mut best = (frequency.0, residual(frequency.0)?);
    for k in 1..=steps as i64 {
        for sign in [-1.0, 1.0] {
            let hz = frequency.0 + sign * step * k as f64;
            // What lies beyond half the rate is no tone here.
            match residual(hz) {
                Ok(found) if found < best.1 => best = (hz, found),
                _ => {}
            }
        }
    }
    let share = 0.5 * (5f64.sqrt() - 1.0);
    let (mut low, mut high) = (best.0 - step, best.0 + step);
    for _ in 0..REFINED {
        let inner = [high - share * (high - low), low + share * (high - low)];
        let [left, right] = [residual(inner[0])?, residual(inner[1])?];
        match left < right {
            true => high = inner[1],
            false => low = inner[0],
        }
    }
    let middle = 0.5 * (low + high);
    let hz = match residual(middle)? <= best.1 {
        true => middle,
        false => best.0,
    };
    Ok((Hertz(hz), tone(samples, rate, Hertz(hz))?))
}

/// The solution of three normal equations, by elimination; they are far from singular where a tone has five periods.
fn solved(mut m: [[f64; 3]; 3], mut r: [f64; 3]) -> [f64; 3] {
    for i in 0..3 {
        for j in i + 1..3 {
            let share = m[j][i] / m[i][i];
            let pivot = m[i];
            for (left, above) in m[j].iter_mut().zip(pivot) {
                *left -= share * above;
            }
            r[j] -= share * r[i];
        }
    }
    let mut x = [0.0; 3];
    for i in (0..3).rev() {
        let known: f64 = (i + 1..3).map(|k| m[i][k] * x[k]).sum();
        x[i] = (r[i] - known) / m[i][i];
    }
    x
}
