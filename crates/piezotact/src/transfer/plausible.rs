//! Transfer functions that no measurement gives: lines beyond half the rate, magnitudes of no device, more averages than segments,
//! and responses that come before their drive.

use super::{Confidence, Delay, StoredFault, TransferError, TransferFunction, TransferWarning};
use crate::quantity::Quantity;
use crate::warning::Warning;

/// The largest magnitude lies between these, in any SI units: far beyond what devices, fingers and structures have.
const MAGNITUDES: std::ops::RangeInclusive<f64> = 1e-30..=1e12;
/// Rounding of frequencies and counts in a file.
const ROUNDING: f64 = 1e-6;
/// Limits that differ from those of coherence and averages by more than this share were not computed from them.
const OTHER_LIMITS: f64 = 0.1;

/// Fewer lines may be real by chance.
const FEWEST_LINES: usize = 10;
/// Magnitudes that differ by less than this factor are those of a device that answers all frequencies alike.
const LEVEL_CHANGES: f64 = 1.1;

impl<I: Quantity, O: Quantity> TransferFunction<I, O> {
    /// Refuses what no measurement gives.
    ///
    /// # Errors
    /// [`TransferError::BeyondNyquist`] when the last line lies beyond half the rate, [`TransferError::Magnitude`] when the
    /// largest magnitude is beyond 1e-30 to 1e12, [`TransferError::Averages`] when there are more effective averages than averages.
    pub fn require_possible(&self) -> Result<(), TransferError> {
        let nyquist_hz = self.rate.hz() / 2.0;
        if self.highest_hz() > nyquist_hz * (1.0 + ROUNDING) {
            return Err(TransferError::BeyondNyquist {
                highest_hz: self.highest_hz(),
                nyquist_hz,
            });
        }
        let largest = self.response.iter().map(|h| h.norm()).fold(0.0, f64::max);
        if !MAGNITUDES.contains(&largest) {
            return Err(TransferError::Magnitude { largest });
        }
        // Averages may be effective ones, rounded.
        let most = (self.averages as f64 + 0.5) * (1.0 + ROUNDING);
        if self.averages > 0 && self.effective_averages > most {
            return Err(TransferError::Averages {
                averages: self.averages,
                effective: self.effective_averages,
            });
        }
        Ok(())
    }

    /// The warnings that its lines raise wherever they come from: a response that comes before its drive, a phase that is missing.
    #[must_use]
    pub fn warnings_of_its_lines(&self) -> Vec<Warning> {
        let early = self.delay().filter(Delay::is_early);
        let acausal = early.map(|delay| delay.acausal());
        acausal.into_iter().chain(self.without_phase()).collect()
    }

    /// The warning that only magnitudes are known. A device whose magnitude changes with frequency turns the phase (Bode); one that
    /// answers all frequencies alike may have none.
    fn without_phase(&self) -> Option<Warning> {
        let lines = self.response.iter().skip(1).filter(|h| h.norm() > 0.0);
        let (mut count, mut low, mut high) = (0, f64::INFINITY, 0.0_f64);
        for h in lines {
            if h.re < 0.0 || h.im.abs() > 1e-9 * h.re {
                return None;
            }
            count += 1;
            (low, high) = (low.min(h.re), high.max(h.re));
        }
        (count >= FEWEST_LINES && high > LEVEL_CHANGES * low).then(|| {
            Warning::from(TransferWarning::Stored {
                fault: StoredFault::NoPhase { lines: count },
            })
        })
    }

    /// The warning that lower limits of the magnitude, as `stored`, do not follow from coherence and averages: one of them was
    /// changed.
    #[must_use]
    pub fn warning_of_limits(&self, stored: &[f64], of: super::Limits) -> Option<Warning> {
        let Confidence { of: own, low, .. } = self.confidence()?;
        if own != of || low.len() != stored.len() {
            return None;
        }
        let lines = self.response.iter().zip(low.iter().zip(stored));
        let mut ratios: Vec<f64> = lines
            .filter_map(|(h, (own, stored))| {
                let (own, stored) = (h.norm() - own, h.norm() - stored);
                (own > 0.0).then_some(stored / own)
            })
            .collect();
        let ratio = crate::statistics::median(&mut ratios)?;
        ((ratio - 1.0).abs() > OTHER_LIMITS).then(|| {
            Warning::from(TransferWarning::Stored {
                fault: StoredFault::Limits { ratio },
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantity::{Acceleration, Drive, SampleRate};
    use crate::transfer::Estimator;
    use num_complex::Complex;

    /// A resonance at 200 Hz with a delay in s, times a factor; lines in steps of 2 Hz up to 1000 Hz.
    fn function(delay_s: f64, factor: f64, rate_hz: f64) -> TransferFunction<Drive, Acceleration> {
        let lines = (0..=500).map(|k| {
            let f = 2.0 * f64::from(k);
            let resonance = 1.0 / Complex::new(1.0 - (f / 200.0).powi(2), 0.1 * f / 200.0);
            factor * resonance * Complex::from_polar(1.0, -std::f64::consts::TAU * f * delay_s)
        });
        let lines: Vec<Complex<f64>> = lines.collect();
        let coherence = vec![0.95; lines.len()];
        let rate = SampleRate::new(rate_hz).unwrap();
        TransferFunction::from_lines(lines, coherence, 2.0, rate, Estimator::H1, 100).unwrap()
    }

    #[test]
    fn what_no_measurement_gives_is_refused() {
        assert_eq!(function(1e-3, 1.0, 2000.0).require_possible(), Ok(()));
        let refused = |function: TransferFunction<Drive, Acceleration>| {
            function.require_possible().unwrap_err().to_string()
        };
        assert!(refused(function(1e-3, 1.0, 1000.0)).contains("up to 500 Hz"));
        assert!(
            refused(function(1e-3, 1e90, 2000.0))
                .contains("largest magnitude is between 1e-30 and 1e12")
        );
        assert!(
            refused(function(1e-3, 1e-60, 2000.0))
                .contains("largest magnitude is between 1e-30 and 1e12")
        );
        let mut more = function(1e-3, 1.0, 2000.0);
        more.effective_averages = 5000.0;
        assert!(refused(more).contains("at most 100"));
    }

    #[test]
    fn magnitudes_alone_are_reported() {
        let whole = function(1e-3, 1.0, 2000.0);
        let magnitudes = whole.response().iter().map(|h| Complex::new(h.norm(), 0.0));
        let of = |lines: Vec<Complex<f64>>| {
            let coherence = vec![0.95; lines.len()];
            let rate = SampleRate::new(2000.0).unwrap();
            let function: TransferFunction<Drive, Acceleration> =
                TransferFunction::from_lines(lines, coherence, 2.0, rate, Estimator::H1, 100)
                    .unwrap();
            function.warnings_of_its_lines()
        };
        let found = of(magnitudes.collect());
        assert!(matches!(
            found[0].kind(),
            Some(TransferWarning::Stored {
                fault: StoredFault::NoPhase { lines: 500 }
            })
        ));
        // A wire has no phase.
        assert_eq!(of(vec![Complex::new(2.0, 0.0); 501]), []);
        assert_eq!(whole.warnings_of_its_lines(), []);
    }

    #[test]
    fn a_response_before_its_drive_is_reported() {
        assert_eq!(function(1e-3, 1.0, 2000.0).warnings_of_its_lines(), []);
        let codes = |delay_s| {
            let warnings = function(delay_s, 1.0, 2000.0).warnings_of_its_lines();
            warnings
                .iter()
                .map(|warning| warning.code.to_string())
                .collect::<Vec<_>>()
        };
        assert_eq!(codes(-20e-3), ["acausal"]);
    }

    #[test]
    fn limits_follow_from_coherence_and_averages() {
        let mut measured = function(1e-3, 1.0, 2000.0);
        let stored = measured.confidence().unwrap();
        assert_eq!(measured.warning_of_limits(&stored.low, stored.of), None);
        measured.effective_averages = 4.0;
        assert!(measured.warning_of_limits(&stored.low, stored.of).is_some());
    }
}
