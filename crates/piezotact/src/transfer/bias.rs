//! The bounds of the bias that noise on either signal gives a transfer function.

use serde::Serialize;

use super::TransferFunction;
use crate::quantity::{Band, Quantity};
use crate::statistics::median;

/// How far H2 lies above H1 over a band, dB: for a linear system with noise on both signals the true magnitude lies between.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Bias {
    /// The band.
    pub band_hz: Band,
    /// |H2| re |H1| at the median line, dB; absent where most lines have no coherence.
    pub median_db: Option<f64>,
    /// |H2| re |H1| where it is largest, dB; absent where a line has no coherence.
    pub largest_db: Option<f64>,
    /// Where it is largest, Hz.
    pub largest_at_hz: f64,
}

impl<I: Quantity, O: Quantity> TransferFunction<I, O> {
    /// |H1| and |H2| of every line, in units of `O` per `I`: for a linear system, noise on the drive makes |H1| too small
    /// and noise on the response makes |H2| too large. |H2| is infinite where the coherence is 0.
    ///
    /// Formula: |H2| = |H1|/γ².
    ///
    /// Source: J. S. Bendat and A. G. Piersol, *Random Data*, 4th ed., section 6.1.4.
    #[must_use]
    pub fn bias_bounds(&self) -> Vec<[f64; 2]> {
        let lines = self.response.iter().zip(&self.coherence);
        lines
            .map(|(value, coherence)| {
                let h1 = self.estimator.h1_of(*value, *coherence).norm();
                let h2 = if *coherence > 0.0 {
                    h1 / coherence.min(1.0)
                } else {
                    f64::INFINITY
                };
                [h1, h2]
            })
            .collect()
    }

    /// How far H2 lies above H1 over `band`; `None` when no line lies in it, or there is no coherence.
    ///
    /// Formula: 20·log10(|H2|/|H1|) = −20·log10 γ².
    ///
    /// Source: as [`Self::bias_bounds`].
    #[must_use]
    pub fn bias(&self, band: Band) -> Option<Bias> {
        if !self.has_coherence() {
            return None;
        }
        let above = |coherence: f64| -20.0 * coherence.clamp(0.0, 1.0).log10();
        let mut found_db: Vec<f64> = self
            .lines_in(band)
            .map(|(line, _)| above(self.coherence[line]))
            .collect();
        let lines = self
            .lines_in(band)
            .map(|(line, hz)| (above(self.coherence[line]), hz));
        let (largest_db, largest_at_hz) = lines.max_by(|a, b| a.0.total_cmp(&b.0))?;
        let known = |db: f64| db.is_finite().then_some(db);
        Some(Bias {
            band_hz: band,
            median_db: known(median(&mut found_db)?),
            largest_db: known(largest_db),
            largest_at_hz,
        })
    }
}
