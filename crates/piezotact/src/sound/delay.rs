//! The delay and the gain of a loopback, and what it changed.

use crate::sound::SoundError;
use serde::{Deserialize, Serialize};

use std::f64::consts::TAU;

use crate::fourier::{Complex, RealTransform, fast_length};

/// A lower share of the energy that the delayed drive explains is no loopback.
const LEAST_SHARE: f64 = 0.5;

/// The delay from a drive to its recording.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Delay {
    /// In whole samples: negative where the recording began later than the drive.
    pub samples: i64,
    /// What lies beyond them, in samples, −0.5 to 0.5: a parabola through the correlation about its largest value.
    pub fraction: f64,
    /// The recorded value per played value; negative where the polarity is inverted.
    pub gain: f64,
    /// The share of the energy of the recording, about its mean, that the delayed drive explains, 0–1.
    pub explained: f64,
}

/// The delay of `drive` (any unit) in `recorded` (any unit) at the same rate, in samples, with the gain between them.
///
/// Formula: the lag of the largest absolute value of the cross-correlation Σ d\[n\]·r\[n + k\]; gain = Σ d·r / Σ d² over the samples that both have
/// there.
///
/// Source: G. C. Carter (1987), Proc. IEEE 75(2), 236–255.
///
/// # Errors
/// [`SoundError`] for silence, samples that are no numbers, and a recording of which the drive explains less than a half.
pub fn delay(drive: &[f64], recorded: &[f64]) -> Result<Delay, SoundError> {
    let (correlation, best) = correlated(drive, recorded)?;
    let length = correlation.len();
    let at = |place: usize| correlation[place % length].abs();
    let [before, here, after] = [at(best + length - 1), at(best), at(best + 1)];
    let fraction = crate::statistics::vertex([before, here, after]);
    let samples = lag_of(best, recorded.len(), length);
    let (mut dd, mut dr) = (0.0, 0.0);
    for (d, r) in overlap(drive, recorded, samples) {
        dd += d * d;
        dr += d * r;
    }
    let gain = if dd > 0.0 { dr / dd } else { 0.0 };
    let mean = crate::statistics::mean(recorded);
    let energy: f64 = recorded.iter().map(|r| (r - mean).powi(2)).sum();
    let explained = (gain * dr / energy.max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
    match explained >= LEAST_SHARE {
        true => Ok(Delay {
            samples,
            fraction,
            gain,
            explained,
        }),
        false => Err(SoundError::NotFound { explained }),
    }
}

/// The cross-correlation of both, and the place of its largest magnitude.
fn correlated(drive: &[f64], recorded: &[f64]) -> Result<(Vec<f64>, usize), SoundError> {
    for (what, samples) in [("drive", drive), ("recording", recorded)] {
        if samples.iter().any(|value| !value.is_finite()) {
            return Err(SoundError::NotFinite { what });
        }
        if samples.iter().all(|value| *value == 0.0) {
            return Err(SoundError::Silent { what });
        }
    }
    let length = fast_length(drive.len() + recorded.len());
    let mut transform = RealTransform::new(length);
    let played = transform.forward(drive);
    let mut bins = transform.forward_about(recorded, crate::statistics::mean(recorded));
    for (bin, played) in bins.iter_mut().zip(&played) {
        *bin *= played.conj();
    }
    let correlation = transform.inverse(bins);
    let valid = |place: &usize| *place < recorded.len() || *place + drive.len() > length;
    let best = (0..length)
        .filter(valid)
        .max_by(|a, b| correlation[*a].abs().total_cmp(&correlation[*b].abs()));
    Ok((correlation, best.unwrap_or(0)))
}

/// The lag at `place` of a cross-correlation of `length` lags with a recording of `recorded` samples.
fn lag_of(place: usize, recorded: usize, length: usize) -> i64 {
    match place < recorded {
        true => place as i64,
        false => place as i64 - length as i64,
    }
}

/// The delay of `burst` (any unit), which is heard once in `recorded` (any unit, the same rate), to a fraction of a sample, with the gain between
/// them: noise beside the burst counts for nothing.
///
/// Formula: the lag of the largest absolute value of the cross-correlation; the fraction by the slope of the phases of the cross-spectrum there, weighted
/// by its magnitudes; gain = Re Σ D*·R·exp(iωτ) / Σ |D|²; explained is the squared correlation within the length of the burst.
///
/// Source: C. H. Knapp, G. C. Carter (1976), IEEE Trans. ASSP 24(4), 320–327.
///
/// # Errors
/// As [`delay`].
pub fn burst_delay(burst: &[f64], recorded: &[f64]) -> Result<Delay, SoundError> {
    let (correlation, best) = correlated(burst, recorded)?;
    let samples = lag_of(best, recorded.len(), correlation.len());
    let skip = |by: i64| usize::try_from(by).unwrap_or(0);
    let there = recorded.iter().skip(skip(samples)).take(burst.len());
    let mut there: Vec<f64> = there.copied().collect();
    there.splice(0..0, vec![0.0; skip(-samples).min(burst.len())]);
    there.resize(burst.len(), 0.0);
    let about = crate::statistics::mean(&there);
    let length = fast_length(2 * burst.len());
    let mut transform = RealTransform::new(length);
    let played = transform.forward(burst);
    let heard = transform.forward_about(&there, about);
    let sum = |of: &mut dyn Iterator<Item = f64>| of.sum::<f64>();
    let product = sum(&mut burst.iter().zip(&there).map(|(d, r)| d * (r - about)));
    let energies = [
        sum(&mut burst.iter().map(|d| d * d)),
        sum(&mut there.iter().map(|r| (r - about).powi(2))),
    ];
    let fraction = phase_slope(&played, &heard, length, product.signum());
    let (mut over, mut under) = (0.0, 0.0);
    for (line, (played, heard)) in played.iter().zip(&heard).enumerate() {
        let turn = Complex::from_polar(1.0, TAU * line as f64 / length as f64 * fraction);
        over += (played.conj() * heard * turn).re;
        under += played.norm_sqr();
    }
    let explained = (product * product / (energies[0] * energies[1])).clamp(0.0, 1.0);
    match explained >= LEAST_SHARE {
        true => Ok(Delay {
            samples,
            fraction,
            gain: over / under,
            explained,
        }),
        false => Err(SoundError::NotFound { explained }),
    }
}

/// How much later, in samples, the spectrum `heard` is than `played`, both of `length` samples and nearly aligned, by the slope of the phases of their
/// cross-spectrum; `sign` is that of the gain between them.
pub(crate) fn phase_slope(
    played: &[Complex<f64>],
    heard: &[Complex<f64>],
    length: usize,
    sign: f64,
) -> f64 {
    let (mut over, mut under) = (0.0, 0.0);
    for (line, (played, heard)) in played.iter().zip(heard).enumerate().skip(1) {
        let cross = sign * heard * played.conj();
        let omega = TAU * line as f64 / length as f64;
        over -= cross.norm() * omega * cross.arg();
        under += cross.norm() * omega * omega;
    }
    over / f64::max(under, f64::MIN_POSITIVE)
}

/// Drive and recording where both have samples, the drive delayed by `lag`.
fn overlap<'a>(
    drive: &'a [f64],
    recorded: &'a [f64],
    lag: i64,
) -> impl Iterator<Item = (f64, f64)> + 'a {
    let skip = |by: i64| usize::try_from(by).unwrap_or(0);
    let drive = drive.iter().skip(skip(-lag));
    let recorded = recorded.iter().skip(skip(lag));
    drive.zip(recorded).map(|(d, r)| (*d, *r))
}

/// What a loopback changed beyond its delay and gain.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct LoopResidual {
    /// The largest difference of a sample, as a share of the largest recorded sample.
    pub largest: f64,
    /// The rms of the differences, as a share of the rms of the recording.
    pub rms: f64,
    /// The first sample of the drive that differs by more than the stated share.
    pub first_different: Option<u64>,
    /// How many samples differ by more than that.
    pub different: u64,
}

/// The samples of `recorded` less those of `drive` through `delay`, as shares of the recording; samples that differ by more than `share` of its
/// largest one are counted.
///
/// Formula: r\[n + k\] − g·d\[n\], k and g of the delay.
///
/// Source: docs/decisions/sound.md.
#[must_use]
pub fn loop_residual(drive: &[f64], recorded: &[f64], delay: &Delay, share: f64) -> LoopResidual {
    let pairs = || overlap(drive, recorded, delay.samples);
    let peak = pairs().fold(0.0, |most: f64, (_, r)| most.max(r.abs()));
    let (mut largest, mut squares, mut energy) = (0.0_f64, 0.0, 0.0);
    let (mut first_different, mut different) = (None, 0);
    for (n, (d, r)) in pairs().enumerate() {
        let off = (r - delay.gain * d).abs();
        largest = largest.max(off);
        squares += off * off;
        energy += r * r;
        if off > share * peak {
            first_different.get_or_insert(n as u64);
            different += 1;
        }
    }
    LoopResidual {
        largest: largest / peak.max(f64::MIN_POSITIVE),
        rms: (squares / energy.max(f64::MIN_POSITIVE)).sqrt(),
        first_different,
        different,
    }
}

/// The parts of `samples` that hold at least `at_least` zeros in a row, as \[first, behind the last\], in samples, with samples that are not zero on
/// both sides.
///
/// Source: a known fault of sound engines: part of each buffer is silent (docs/decisions/sound.md).
#[must_use]
pub fn silent_runs(samples: &[f64], at_least: usize) -> Vec<[usize; 2]> {
    let mut runs = Vec::new();
    let mut last_sound: Option<usize> = None;
    for (i, value) in samples.iter().enumerate() {
        if *value == 0.0 {
            continue;
        }
        if let Some(last) = last_sound
            && i - last > at_least.max(1)
        {
            runs.push([last + 1, i]);
        }
        last_sound = Some(i);
    }
    runs
}
