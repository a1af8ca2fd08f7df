//! The excitation of a power spectrum, by band and in total: sums that are linear in its lines.

use super::Model;
use crate::quantity::{Band, Hertz};

/// The spreading of the excitation of a line over bands: a normal distribution of `ln f` with the standard deviation `width`, so
/// that a small shift of frequency across a band edge makes a small difference.
fn spreading(bands: &[Band], log_frequency: f64, width: f64) -> Vec<f64> {
    let weights: Vec<f64> = bands
        .iter()
        .map(|band| {
            let (low, high) = (band.low().0.ln(), band.high().0.ln());
            let away = (0.5 * (low + high) - log_frequency) / width;
            (high - low) * (-0.5 * away * away).exp()
        })
        .collect();
    let sum: f64 = weights.iter().sum::<f64>().max(f64::MIN_POSITIVE);
    weights.iter().map(|w| w / sum).collect()
}

/// The contribution of one line to the sums, per unit of its density.
#[derive(Clone, Debug)]
struct LineWeights {
    line: usize,
    /// The bands that hold a part of it, and how much, Hz.
    parts: Vec<(usize, f64)>,
    /// Its share in every sum of [`Excitation::sums`].
    sums: Vec<f64>,
}

/// The computation of excitations of spectra with the same lines, planned once.
#[derive(Clone, Debug)]
pub struct ExcitationPlan {
    bands: Vec<Band>,
    lines: Vec<LineWeights>,
}

impl ExcitationPlan {
    /// A plan for one-sided PSDs of `bins` lines, `resolution_hz` apart from 0 Hz, over the third octaves of the model's band.
    ///
    /// Source: [`crate::score::score`].
    #[must_use]
    pub fn new(model: &Model, bins: usize, resolution_hz: f64) -> Self {
        let bands = model.band.third_octaves();
        let width = model.spreading();
        let mut lines = Vec::new();
        for line in 1..bins {
            let centre_hz = line as f64 * resolution_hz;
            let mut parts = Vec::new();
            for (band, limits) in bands.iter().enumerate() {
                let low_hz = (centre_hz - 0.5 * resolution_hz).max(limits.low().0);
                let high_hz = (centre_hz + 0.5 * resolution_hz).min(limits.high().0);
                if low_hz < high_hz {
                    parts.push((band, high_hz - low_hz));
                }
            }
            if parts.is_empty() {
                continue;
            }
            let held_hz: f64 = parts.iter().map(|(_, width_hz)| width_hz).sum();
            let total = held_hz * model.sensitivity(Hertz(centre_hz));
            let log_frequency = centre_hz.ln();
            let mut sums: Vec<f64> = spreading(&bands, log_frequency, width)
                .into_iter()
                .map(|felt| felt * total)
                .collect();
            sums.extend([total, total * log_frequency]);
            lines.push(LineWeights { line, parts, sums });
        }
        Self { bands, lines }
    }

    /// The third octaves.
    #[must_use]
    pub fn bands(&self) -> &[Band] {
        &self.bands
    }

    /// What `psd`, in (m/s²)²/Hz, excites.
    ///
    /// Source: [`crate::score::score`].
    #[must_use]
    pub fn of(&self, psd: &[f64]) -> Excitation {
        let mut power = vec![0.0; self.bands.len()];
        let mut sums = vec![0.0; self.bands.len() + 2];
        for weights in &self.lines {
            let density = psd.get(weights.line).copied().unwrap_or(0.0);
            for (band, width_hz) in &weights.parts {
                power[*band] += density * width_hz;
            }
            for (sum, weight) in sums.iter_mut().zip(&weights.sums) {
                *sum += density * weight;
            }
        }
        Excitation { power, sums }
    }

    /// The contribution of each line of `psd` to the sum Σ gradient·sums.
    pub(super) fn line_terms(&self, psd: &[f64], gradient: &[f64]) -> Vec<f64> {
        let mut terms = vec![0.0; psd.len()];
        for weights in &self.lines {
            let weight: f64 = weights.sums.iter().zip(gradient).map(|(w, g)| w * g).sum();
            terms[weights.line] = psd[weights.line] * weight;
        }
        terms
    }
}

/// The excitation of a vibration: sums that are linear in its power, so that the sums of a mean are the mean of the sums.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Excitation {
    /// The power of each band, (m/s²)².
    pub power: Vec<f64>,
    /// What each band feels, its neighbours' share with it, then the total, both as multiples of threshold power, and
    /// last the total of excitation·ln(f/Hz).
    pub sums: Vec<f64>,
}

impl Excitation {
    /// The mean of `all`, which have the same bands.
    #[must_use]
    pub(crate) fn mean(all: &[Self]) -> Self {
        let mean_of = |part: fn(&Self) -> &[f64]| -> Vec<f64> {
            let mut mean = vec![0.0; all.first().map_or(0, |one| part(one).len())];
            for one in all {
                for (sum, value) in mean.iter_mut().zip(part(one)) {
                    *sum += value / all.len() as f64;
                }
            }
            mean
        };
        Self {
            power: mean_of(|one| &one.power),
            sums: mean_of(|one| &one.sums),
        }
    }

    /// The level of all together over the detection threshold, as a power ratio: at 1 it is just detected.
    #[must_use]
    pub fn total(&self) -> f64 {
        total(&self.sums)
    }

    /// The mean of ln(f/Hz), weighed by excitation.
    #[must_use]
    pub fn log_centroid(&self) -> f64 {
        log_centroid(&self.sums)
    }
}

/// The total of all bands in `sums`.
pub(super) fn total(sums: &[f64]) -> f64 {
    sums.get(sums.len().wrapping_sub(2)).copied().unwrap_or(0.0)
}

/// The mean of ln(f/Hz) in `sums`; 0 of nothing.
pub(super) fn log_centroid(sums: &[f64]) -> f64 {
    let all = total(sums);
    if all > 0.0 {
        sums.last().copied().unwrap_or(0.0) / all
    } else {
        0.0
    }
}
