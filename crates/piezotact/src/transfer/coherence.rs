//! Coherence of a transfer function: over a band, too low, and impossible.

use serde::{Deserialize, Serialize};

use super::{StoredFault, TransferFunction, TransferWarning};
use crate::quantity::{Band, Quantity};
use crate::statistics::median;
use crate::warning::Warning;

/// Coherence over a band.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct CoherenceSummary {
    /// The band.
    pub band_hz: Band,
    /// The lowest coherence, 0–1.
    pub lowest: f64,
    /// Where it is lowest, Hz.
    pub lowest_at_hz: f64,
    /// The median coherence, 0–1.
    pub median: f64,
}

/// The tolerance for rounding of a coherence above 1; a larger excess is impossible for a pair of signals.
pub(crate) const COHERENCE_ROUNDING: f64 = 1e-6;

impl<I: Quantity, O: Quantity> TransferFunction<I, O> {
    /// The lowest coherence in `band`, where it is in Hz, and the median; `None` when no line lies in it, or there is no coherence.
    #[must_use]
    pub fn coherence_in(&self, band: Band) -> Option<CoherenceSummary> {
        if !self.has_coherence() {
            return None;
        }
        let mut coherence: Vec<f64> = self
            .lines_in(band)
            .map(|(k, _)| self.coherence[k])
            .collect();
        let lines = self.lines_in(band).map(|(k, hz)| (self.coherence[k], hz));
        let (lowest, lowest_at_hz) = lines.min_by(|a, b| a.0.total_cmp(&b.0))?;
        Some(CoherenceSummary {
            band_hz: band,
            lowest,
            lowest_at_hz,
            median: median(&mut coherence)?,
        })
    }

    /// The share of the lines in `band` whose coherence is below `least_coherence`, 0–1; 0 when no line lies in it.
    #[must_use]
    pub fn low_coherence_share(&self, band: Band, least_coherence: f64) -> f64 {
        let (mut below, mut lines) = (0, 0);
        for (line, _) in self.lines_in(band) {
            lines += 1;
            below += usize::from(self.coherence[line] < least_coherence);
        }
        below as f64 / lines.max(1) as f64
    }

    /// The warning about coherence below `least_coherence` in `band`, if there is one.
    #[must_use]
    pub fn low_coherence(&self, band: Band, least_coherence: f64) -> Option<Warning> {
        let share = self.low_coherence_share(band, least_coherence);
        let lines = self
            .lines_in(band)
            .map(|(k, frequency_hz)| (self.coherence[k], frequency_hz));
        let (lowest, at_hz) = lines.min_by(|a, b| a.0.total_cmp(&b.0))?;
        let low = TransferWarning::LowCoherence {
            asked: least_coherence,
            lowest,
            at_hz,
            share,
        };
        (share > 0.0).then(|| low.into())
    }
}

/// The warning about coherence outside 0–1, if there is any.
pub(super) fn impossible(coherence: &[f64], resolution_hz: f64) -> Vec<Warning> {
    let possible = -COHERENCE_ROUNDING..=1.0 + COHERENCE_ROUNDING;
    let impossible: Vec<(usize, f64)> = coherence
        .iter()
        .copied()
        .enumerate()
        .filter(|(_, found)| !possible.contains(found))
        .collect();
    let worst = impossible
        .iter()
        .max_by(|a, b| (a.1 - 0.5).abs().total_cmp(&(b.1 - 0.5).abs()));
    worst
        .map(|(line, found)| {
            Warning::from(TransferWarning::Stored {
                fault: StoredFault::Coherence {
                    at_hz: *line as f64 * resolution_hz,
                    found: *found,
                    lines: impossible.len(),
                },
            })
        })
        .into_iter()
        .collect()
}
