//! Peaks of a spectrum above its own background, and which of them are harmonics of one another.

use serde::{Deserialize, Serialize};

use crate::quantity::Band;

/// A peak stands out by at least this, dB.
const PROMINENT_DB: f64 = 6.0;
/// Most peaks that are kept.
const MOST: usize = 8;
/// The background is the median over this ratio of frequencies below and above.
const BACKGROUND_RATIO: f64 = 1.5;
/// The ratio of neighbouring anchors of the background.
const ANCHORS: f64 = 1.25;
/// A harmonic lies this close to a multiple of its fundamental, as a share of the fundamental, or within one line
/// where that is less than a sixth of it; beyond the tenth multiple nothing can be told.
const HARMONIC: f64 = 0.06;
const HIGHEST_HARMONIC: f64 = 10.0;

/// A peak of a power spectral density.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Peak {
    /// Where it is, Hz, between lines by a parabola through the three highest in dB.
    pub frequency_hz: f64,
    /// Its value, unit²/Hz.
    pub density: f64,
    /// How far it stands above the background, dB.
    pub prominence_db: f64,
    /// Which multiple of a lower peak it is; 1 when it is none.
    pub harmonic: usize,
}

/// The peaks of a one-sided PSD with lines `resolution_hz` apart from 0 Hz, within `band`: at most eight, the
/// strongest in density first, each at least 6 dB above the median of the lines around it.
///
/// Source: local maxima over a running median on a logarithmic frequency axis; the parabola in dB after
/// J. O. Smith, *Spectral Audio Signal Processing* (2011), "Quadratic interpolation of spectral peaks".
#[must_use]
pub fn peaks(psd: &[f64], resolution_hz: f64, band: Band) -> Vec<Peak> {
    peaks_above(psd, resolution_hz, band, PROMINENT_DB)
}

/// The peaks as [`peaks`] finds them, that stand out by `least_db` or more.
pub(crate) fn peaks_above(psd: &[f64], resolution_hz: f64, band: Band, least_db: f64) -> Vec<Peak> {
    // Decibels only where they are needed: the median of powers is that of their levels.
    let level = |k: usize| 10.0 * psd[k].max(f64::MIN_POSITIVE).log10();
    let line = |hz: f64| ((hz / resolution_hz) as usize).min(psd.len());
    let background_db = Background::of(psd, line(band.low().0), line(band.high().0) + 1);
    let mut found: Vec<Peak> = (2..psd.len().saturating_sub(1))
        .filter(|&k| psd[k] >= psd[k - 1] && psd[k] > psd[k + 1])
        .filter(|&k| band.contains(k as f64 * resolution_hz))
        .map(|k| (k, level(k), level(k) - background_db.at(k)))
        .filter(|(_, _, prominence_db)| *prominence_db >= least_db)
        .map(|(k, top_db, prominence_db)| Peak {
            frequency_hz: (k as f64
                + crate::statistics::vertex([level(k - 1), top_db, level(k + 1)]))
                * resolution_hz,
            density: psd[k],
            prominence_db,
            harmonic: 1,
        })
        .collect();
    found.sort_by(|a, b| b.density.total_cmp(&a.density));
    found.truncate(MOST);
    let fundamentals: Vec<f64> = found.iter().map(|peak| peak.frequency_hz).collect();
    for peak in &mut found {
        let lower = fundamentals
            .iter()
            .filter(|f| **f < 0.75 * peak.frequency_hz)
            .copied()
            .min_by(f64::total_cmp);
        if let Some(fundamental_hz) = lower {
            let order = (peak.frequency_hz / fundamental_hz).round();
            let off_hz = (peak.frequency_hz - order * fundamental_hz).abs();
            let near_hz = (HARMONIC * fundamental_hz).max(resolution_hz.min(fundamental_hz / 6.0));
            if off_hz <= near_hz && order <= HIGHEST_HARMONIC {
                peak.harmonic = order as usize;
            }
        }
    }
    found
}

/// The level around every line: the median over the lines within a ratio of 1.5 below and above, at least three on
/// each side, taken at anchors 25 % apart, in dB, with straight lines between.
struct Background(Vec<(usize, f64)>);

impl Background {
    /// The background of the lines `first`…`last`.
    fn of(psd: &[f64], first: usize, last: usize) -> Self {
        let n = psd.len();
        let mut window = Vec::new();
        let mut anchors = Vec::new();
        let mut k = first.max(1);
        while k < n {
            let from = ((k as f64 / BACKGROUND_RATIO) as usize)
                .min(k.saturating_sub(3))
                .max(1);
            let to = ((k as f64 * BACKGROUND_RATIO) as usize + 1)
                .max(k + 4)
                .min(n);
            window.clear();
            // Some thirty lines are enough for a median.
            window.extend(psd[from.min(to)..to].iter().step_by(1 + (to - from) / 32));
            let power = crate::statistics::median(&mut window).unwrap_or(0.0);
            anchors.push((k, 10.0 * power.max(f64::MIN_POSITIVE).log10()));
            if k >= last {
                break;
            }
            k = (k + 1).max((k as f64 * ANCHORS) as usize);
        }
        Self(anchors)
    }

    fn at(&self, line: usize) -> f64 {
        let next = self.0.partition_point(|(at, _)| *at <= line);
        match (
            next.checked_sub(1).and_then(|i| self.0.get(i)),
            self.0.get(next),
        ) {
            (Some(a), Some(b)) => a.1 + (b.1 - a.1) * (line - a.0) as f64 / (b.0 - a.0) as f64,
            (Some(only), None) | (None, Some(only)) => only.1,
            (None, None) => 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantity::Hertz;

    #[test]
    fn a_comb_on_a_slope_is_one_fundamental_with_its_harmonics() {
        let psd: Vec<f64> = (0..500)
            .map(|k| {
                let f = f64::from(k) * 2.0;
                let comb: f64 = (1..4)
                    .map(|n| (-((f - 55.0 * f64::from(n)) / 3.0).powi(2)).exp() / f64::from(n * n))
                    .sum();
                1.0 / (1.0 + (f / 100.0).powi(2)) + 30.0 * comb
            })
            .collect();
        let band = Band::new(Hertz(10.0), Hertz(900.0)).unwrap();
        let found = peaks(&psd, 2.0, band);
        assert_eq!(found.len(), 3, "{found:?}");
        for (n, peak) in found.iter().enumerate() {
            assert!(
                (peak.frequency_hz - 55.0 * (n + 1) as f64).abs() < 0.7,
                "{found:?}"
            );
            assert_eq!(peak.harmonic, n + 1);
        }
        let smooth: Vec<f64> = (0..500).map(|k| 1.0 / (1.0 + f64::from(k))).collect();
        assert_eq!(peaks(&smooth, 2.0, band), []);
    }
}
