//! Spectral manipulations in one transform over the whole texture. The texture is treated as one period, so that the result
//! has the same length and no delay, and can be looped as before.

use std::f64::consts::TAU;

use num_complex::Complex;

use super::error::require_range;
use super::{
    ManipulateError, Manipulated, Texture, about_mean, line_hz, manipulated, require_band,
    require_one_rate,
};
use crate::fourier::RealTransform;
use crate::lineage::{BandChange, Operation};
use crate::quantity::{Band, Decibels, Hertz, Quantity};
use crate::series::Series;
use crate::spectrum::{WelchConfig, welch};
use crate::statistics::random::Random;
use crate::statistics::standard_deviation;

/// The width of the edges of a changed band, outside it, as a ratio of its ends.
const EDGE_RATIO: f64 = 0.1;

/// `x` with every line multiplied by `gain` at its frequency in Hz; the mean is unchanged.
fn weighted<Q: Quantity>(
    x: &Series<Q>,
    gain: impl Fn(f64) -> f64,
) -> Result<Vec<f64>, ManipulateError> {
    let (mean, changing) = about_mean(x)?;
    let n = changing.len();
    let mut transform = RealTransform::new(n);
    let mut bins = transform.forward(&changing);
    for (k, bin) in bins.iter_mut().enumerate() {
        *bin *= gain(line_hz(k, n, x.rate()));
    }
    let mut samples = transform.inverse(bins);
    for sample in &mut samples {
        *sample += mean;
    }
    Ok(samples)
}

/// `x` with one band raised, lowered or removed, without delay; raised-cosine edges of 10 % of the band's ends lie
/// outside it.
///
/// Formula: X(f)·(1 + (g − 1)·W(f)), W = [`Band::weight`], g = 10^(dB/20), or 0 where the band is removed.
///
/// Source: Oppenheim and Schafer, Discrete-Time Signal Processing, section 5.7: a real gain has no phase.
///
/// # Errors
/// [`ManipulateError::BandAboveNyquist`], [`ManipulateError::Range`] for a gain beyond ±120 dB,
/// [`ManipulateError::Silent`], and [`ManipulateError::NothingLeft`] when the texture lies in the removed band.
pub fn change_band<Q: Quantity>(
    x: &Series<Q>,
    band: Band,
    change: BandChange,
) -> Result<Manipulated<Q>, ManipulateError> {
    require_band(band, x.rate())?;
    let ratio = match change {
        BandChange::Gain { gain_db } => {
            let range = (-120.0, 120.0);
            require_range("a gain", gain_db, range, " dB", "0 dB changes nothing")?;
            Decibels(gain_db).amplitude_ratio()
        }
        BandChange::Removed => 0.0,
    };
    let samples = weighted(x, |hz| 1.0 + (ratio - 1.0) * band.weight(hz, EDGE_RATIO))?;
    let operation = Operation::BandChanged {
        band_hz: band,
        change,
        edge_ratio: EDGE_RATIO,
    };
    manipulated(x, samples, operation, Vec::new())
}

/// A slope over frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tilt {
    /// The slope, dB an octave.
    pub db_per_octave: f64,
    /// The frequency of unit gain.
    pub pivot: Hertz,
    /// Below this frequency the gain is constant: a slope would grow without limit towards 0 Hz, where the gesture lies.
    pub held_below: Hertz,
}

/// `x` with a spectrum that rises or falls over frequency, without delay.
///
/// Formula: X(f)·10^(s·log₂(max(f, f₀)/pivot)/20).
///
/// Source: definition of a slope in dB an octave.
///
/// # Errors
/// [`ManipulateError::Range`] for a slope beyond ±48 dB an octave, or frequencies that do not lie above 0 Hz and below
/// half the rate; [`ManipulateError::Silent`].
///
/// ```
/// use piezotact::manipulate::{Tilt, tilt};
/// use piezotact::quantity::{Acceleration, Hertz, SampleRate};
/// let rate = SampleRate::new(1000.0).unwrap();
/// let tone = (0..1000).map(|i| (std::f64::consts::TAU * 0.1 * f64::from(i)).sin()).collect();
/// let tone = piezotact::Series::<Acceleration>::new(tone, rate).unwrap();
/// let slope = Tilt { db_per_octave: 6.0, pivot: Hertz(50.0), held_below: Hertz(10.0) };
/// let done = tilt(&tone, slope).unwrap(); // 100 Hz, one octave above the pivot
/// assert!((20.0 * (done.series.rms() / tone.rms()).log10() - 6.0).abs() < 1e-9);
/// ```
pub fn tilt<Q: Quantity>(x: &Series<Q>, slope: Tilt) -> Result<Manipulated<Q>, ManipulateError> {
    require_range(
        "a slope",
        slope.db_per_octave,
        (-48.0, 48.0),
        " dB/octave",
        "3 dB/octave is already a large slope",
    )?;
    let highest = x.rate().nyquist().0;
    for (what, hertz) in [
        ("a pivot", slope.pivot),
        ("a lowest frequency", slope.held_below),
    ] {
        let range = (highest * 1e-6, highest);
        require_range(what, hertz.0, range, " Hz", "choose one within the texture")?;
    }
    let samples = weighted(x, |hz| {
        let octaves = (hz.max(slope.held_below.0) / slope.pivot.0).log2();
        Decibels(slope.db_per_octave * octaves).amplitude_ratio()
    })?;
    let operation = Operation::Tilted {
        db_per_octave: slope.db_per_octave,
        pivot_hz: slope.pivot.0,
        held_below_hz: slope.held_below.0,
    };
    manipulated(x, samples, operation, Vec::new())
}

/// `x` with the smooth spectrum of another texture, its own phases and its own level (rms about the mean).
///
/// Formula: |Y(k)| ∝ √PSD(k) of the other, interpolated between its lines; arg Y = arg X; rms(y) = rms(x).
///
/// Source: thesis 4.4, which decouples amplitude and frequency distribution; Welch (1967) for the PSD.
///
/// # Errors
/// [`ManipulateError::RatesDiffer`], [`ManipulateError::Spectrum`] when the other holds no segment,
/// [`ManipulateError::Silent`] for either.
pub fn spectrum_of<Q: Quantity>(
    x: &Series<Q>,
    other: &Texture<Q>,
    config: &WelchConfig,
) -> Result<Manipulated<Q>, ManipulateError> {
    require_one_rate(x, other, "spectrum")?;
    about_mean(&other.series)?;
    let psd = welch(&other.series, config).map_err(|why| ManipulateError::Spectrum {
        of: other.lineage.source.clone(),
        why,
    })?;
    let amplitude_at = |hz: f64| {
        let place = hz / psd.resolution_hz;
        let below = (place as usize).min(psd.values.len().saturating_sub(2));
        let share = (place - below as f64).clamp(0.0, 1.0);
        let at = |k: usize| psd.values.get(k).copied().unwrap_or(0.0);
        (at(below) * (1.0 - share) + at(below + 1) * share).sqrt()
    };
    let (_, changing) = about_mean(x)?;
    let n = changing.len();
    let mut transform = RealTransform::new(n);
    let mut bins = transform.forward(&changing);
    for (k, bin) in bins.iter_mut().enumerate() {
        // A mean has no phase.
        let amplitude = if k == 0 {
            0.0
        } else {
            amplitude_at(line_hz(k, n, x.rate()))
        };
        *bin = Complex::from_polar(amplitude, bin.arg());
    }
    let mut samples = transform.inverse(bins);
    let ratio = standard_deviation(&changing) / standard_deviation(&samples).max(f64::MIN_POSITIVE);
    for sample in &mut samples {
        *sample *= ratio;
    }
    let operation = Operation::SpectrumOf {
        of: other.lineage.clone(),
        resolution_hz: psd.resolution_hz,
        averages: psd.averages,
    };
    let mut warnings = other.warnings.clone();
    warnings.extend(psd.warnings);
    manipulated(x, samples, operation, warnings)
}

/// Phases that were drawn for [`randomise_phases`].
#[derive(Clone, Debug, PartialEq)]
pub struct DrawnPhases {
    /// One for each of [`phases_needed`] lines: the share of a turn, 0–1.
    pub turns: Vec<f64>,
    /// The generator and its seed, for the lineage.
    pub drawn_by: String,
}

impl DrawnPhases {
    /// `count` phases drawn by `seed`: evenly from 0 up to, not including, 1 turn.
    #[must_use]
    pub fn drawn(seed: u64, count: usize) -> Self {
        let mut random = Random::stream(seed, 0, "phases");
        Self {
            turns: (0..count).map(|_| random.uniform()).collect(),
            drawn_by: format!("ChaCha8, seed {seed}"),
        }
    }
}

/// The number of phases that a texture of `samples` samples has: one for each line but 0 Hz and half the rate.
///
/// Source: a real signal of n samples, ⌈n/2⌉ − 1.
///
/// ```
/// assert_eq!([8, 9].map(piezotact::manipulate::phases_needed), [3, 4]);
/// ```
#[must_use]
pub fn phases_needed(samples: usize) -> usize {
    samples.div_ceil(2).saturating_sub(1)
}

/// `x` with other phases, in the unit of `x`: the same power on every line, another waveform. An event in time is spread over
/// the whole texture.
///
/// Formula: |Y(k)| = |X(k)|, arg Y(k) = 2π·turns(k − 1); 0 Hz and half the rate stay.
///
/// Source: J. Theiler et al. (1992), Physica D 58: phase-randomised surrogates.
///
/// # Errors
/// [`ManipulateError::Phases`] when there are not [`phases_needed`] of them, or one is no number;
/// [`ManipulateError::Silent`].
pub fn randomise_phases<Q: Quantity>(
    x: &Series<Q>,
    phases: &DrawnPhases,
) -> Result<Manipulated<Q>, ManipulateError> {
    let (mean, changing) = about_mean(x)?;
    let expected = phases_needed(changing.len());
    let found = phases.turns.iter().filter(|turn| turn.is_finite()).count();
    if found != expected || phases.turns.len() != expected {
        return Err(ManipulateError::Phases { expected, found });
    }
    let mut transform = RealTransform::new(changing.len());
    let mut bins = transform.forward(&changing);
    for (bin, turn) in bins.iter_mut().skip(1).zip(&phases.turns) {
        *bin = Complex::from_polar(bin.norm(), TAU * turn);
    }
    let mut samples = transform.inverse(bins);
    for sample in &mut samples {
        *sample += mean;
    }
    let operation = Operation::PhasesRandomised {
        drawn_by: phases.drawn_by.clone(),
    };
    manipulated(x, samples, operation, Vec::new())
}

/// `x` backwards in time, in its unit: the same power on every line, the conjugate phases.
///
/// Formula: y(i) = x(n − 1 − i).
///
/// Source: Oppenheim and Schafer, Discrete-Time Signal Processing, table 2.1: time reversal conjugates the transform.
///
/// # Errors
/// [`ManipulateError::Silent`] for a texture that never changes.
///
/// ```
/// use piezotact::manipulate::time_reversed;
/// use piezotact::quantity::{Acceleration, SampleRate};
/// let rate = SampleRate::new(1000.0).unwrap();
/// let x = piezotact::Series::<Acceleration>::new(vec![1.0, 2.0, -3.0], rate).unwrap();
/// assert_eq!(time_reversed(&x).unwrap().series.samples(), [-3.0, 2.0, 1.0]);
/// ```
pub fn time_reversed<Q: Quantity>(x: &Series<Q>) -> Result<Manipulated<Q>, ManipulateError> {
    about_mean(x)?;
    let samples = x.samples().iter().rev().copied().collect();
    let operation = Operation::Named {
        operation: "time reversal".into(),
        parameters: Default::default(),
    };
    manipulated(x, samples, operation, Vec::new())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_seed_one_set_of_phases() {
        let drawn = DrawnPhases::drawn(7, 4);
        assert_eq!(drawn.drawn_by, "ChaCha8, seed 7");
        assert!(drawn.turns.iter().all(|turn| (0.0..1.0).contains(turn)));
        assert_eq!(drawn, DrawnPhases::drawn(7, 4));
        assert_ne!(drawn.turns, DrawnPhases::drawn(8, 4).turns);
    }
}
