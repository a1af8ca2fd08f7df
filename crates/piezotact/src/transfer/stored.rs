//! A transfer function that another program stored beside the spectra it came from.

use num_complex::Complex;
use serde::{Deserialize, Serialize};

use super::cross::CrossSpectra;
use super::{Estimator, StoredFault, TransferWarning};
use crate::quantity::Uncalibrated;
use crate::spectrum::EstimateError;
use crate::statistics::median;
use crate::warning::Warning;

/// Relative differences up to this are rounding of numbers stored in single precision.
const ROUNDING: f64 = 1e-4;

/// How a stored transfer function agrees with the spectra stored beside it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct StoredIdentities {
    /// The ratio of the stored spectra that is closest to the stored function at the median line.
    pub estimator: Estimator,
    /// Whether it is the ratio with the conjugate of the stored cross-spectrum.
    pub conjugate: bool,
    /// The largest difference between the stored function and this ratio, as a share of the ratio.
    pub response_difference: f64,
    /// Where, Hz.
    pub response_at_hz: f64,
    /// The largest difference between the stored coherence and |Sxy|²/(Sxx·Syy); absent where no coherence is stored.
    pub coherence_difference: Option<f64>,
    /// How many lines could be compared: those where both spectra have power.
    pub lines: usize,
}

impl StoredIdentities {
    /// Compares a stored `response` and `coherence` with the stored spectra: `drive_power` and `response_power` on one scale
    /// with `cross`, one value a line, from 0 Hz in steps of `resolution_hz`. `None` where no line has power in both spectra.
    ///
    /// Formula: H1 = Sxy/Sxx, H2 = Syy/Syx, Hv = √(Syy/Sxx)·Sxy/|Sxy|, γ² = |Sxy|²/(Sxx·Syy).
    ///
    /// Source: as [`super::estimate`].
    ///
    /// # Errors
    /// [`EstimateError::Mismatch`] when the lengths differ, [`EstimateError::TooShort`] for fewer than 2 lines.
    pub fn of(
        (response, coherence): (&[Complex<f64>], Option<&[f64]>),
        (drive_power, response_power): (&[f64], &[f64]),
        cross: &[Complex<f64>],
        resolution_hz: f64,
    ) -> Result<Option<Self>, EstimateError> {
        let spectra = CrossSpectra::<Uncalibrated, Uncalibrated>::from_parts(
            drive_power.to_vec(),
            response_power.to_vec(),
            cross.to_vec(),
            resolution_hz,
            0,
        )?;
        if response.len() != cross.len() {
            return Err(EstimateError::Mismatch {
                left: "stored transfer function",
                right: "cross-spectrum",
                what: "the number of lines",
                left_value: response.len().to_string(),
                right_value: cross.len().to_string(),
            });
        }
        let ratios = [Estimator::H1, Estimator::H2, Estimator::Hv]
            .map(|estimator| (estimator, spectra.ratio(estimator)));
        let candidates = ratios.iter().flat_map(|(estimator, ratio)| {
            let conjugate: Vec<Complex<f64>> = ratio.iter().map(Complex::conj).collect();
            [
                (*estimator, false, farthest(response, ratio)),
                (*estimator, true, farthest(response, &conjugate)),
            ]
        });
        let closest = candidates
            .filter_map(|(estimator, conjugate, found)| Some((estimator, conjugate, found?)))
            .min_by(|a, b| a.2.median.total_cmp(&b.2.median));
        let own = spectra.coherence();
        let coherence_difference = coherence.filter(|c| c.len() == own.len()).map(|stored| {
            let each = stored.iter().zip(&own).map(|(a, b)| (a - b).abs());
            each.fold(0.0, f64::max)
        });
        Ok(closest.map(|(estimator, conjugate, found)| Self {
            estimator,
            conjugate,
            response_difference: found.difference,
            response_at_hz: found.line as f64 * resolution_hz,
            coherence_difference,
            lines: found.lines,
        }))
    }

    /// Whether the stored function is the ratio, within the rounding of single precision.
    #[must_use]
    pub fn is_equal(&self) -> bool {
        self.response_difference <= ROUNDING
    }

    /// The warning about a stored function that does not follow from the spectra stored beside it, if it does not.
    #[must_use]
    pub fn warning(&self) -> Option<Warning> {
        let coherence = self.coherence_difference.unwrap_or(0.0);
        (!self.is_equal() || coherence > ROUNDING).then(|| {
            Warning::from(TransferWarning::Stored {
                fault: StoredFault::Spectra {
                    difference: self.response_difference,
                    at_hz: self.response_at_hz,
                    coherence_difference: coherence,
                },
            })
        })
    }
}

/// The relative difference of two functions of frequency: its median, where it is largest, and over how many lines.
struct Farthest {
    median: f64,
    difference: f64,
    line: usize,
    lines: usize,
}

fn farthest(stored: &[Complex<f64>], ratio: &[Complex<f64>]) -> Option<Farthest> {
    let lines = stored.iter().zip(ratio).enumerate();
    let each: Vec<(f64, usize)> = lines
        .filter(|(_, (_, ratio))| ratio.norm_sqr() > 0.0)
        .map(|(line, (stored, ratio))| ((stored - ratio).norm() / ratio.norm(), line))
        .collect();
    let (difference, line) = *each.iter().max_by(|a, b| a.0.total_cmp(&b.0))?;
    Some(Farthest {
        median: median(&mut each.iter().map(|(one, _)| *one).collect::<Vec<_>>())?,
        difference,
        line,
        lines: each.len(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spectra() -> ([Vec<f64>; 2], Vec<Complex<f64>>) {
        let lines = 0..40;
        let cross = lines
            .clone()
            .map(|k| Complex::from_polar(1.0 + f64::from(k), 0.1 * f64::from(k)));
        let x = lines.clone().map(|k| 0.5 + 0.01 * f64::from(k)).collect();
        let y = lines.map(|k| 3.0 * (1.0 + f64::from(k)).powi(2)).collect();
        ([x, y], cross.collect())
    }

    fn checked(response: &[Complex<f64>], coherence: Option<&[f64]>) -> StoredIdentities {
        let ([x, y], cross) = spectra();
        StoredIdentities::of((response, coherence), (&x, &y), &cross, 2.0)
            .unwrap()
            .unwrap()
    }

    #[test]
    fn the_stored_ratio_is_named_and_a_difference_is_reported() {
        let ([x, y], cross) = spectra();
        let h1: Vec<Complex<f64>> = cross.iter().zip(&x).map(|(c, x)| c / x).collect();
        let h2: Vec<Complex<f64>> = cross.iter().zip(&y).map(|(c, y)| y / c.conj()).collect();
        let coherence: Vec<f64> = cross
            .iter()
            .zip(x.iter().zip(&y))
            .map(|(c, (x, y))| c.norm_sqr() / (x * y))
            .collect();
        let found = checked(&h1, Some(&coherence));
        assert_eq!(
            (found.estimator, found.conjugate, found.lines),
            (Estimator::H1, false, 40)
        );
        assert!(found.response_difference < 1e-15 && found.coherence_difference < Some(1e-15));
        assert_eq!(found.warning(), None);
        let found = checked(&h2, None);
        assert_eq!(
            (found.estimator, found.conjugate, found.coherence_difference),
            (Estimator::H2, false, None)
        );
        let conjugate: Vec<Complex<f64>> = h1.iter().map(Complex::conj).collect();
        let found = checked(&conjugate, None);
        assert_eq!((found.estimator, found.conjugate), (Estimator::H1, true));

        let mut damaged = h1.clone();
        damaged[17] *= 1.01;
        let found = checked(&damaged, Some(&coherence));
        assert!((found.response_difference - 0.01).abs() < 1e-12 && found.response_at_hz == 34.0);
        assert!(found.warning().is_some());
        let mut impossible = coherence.clone();
        impossible[3] = 0.9;
        assert!(checked(&h1, Some(&impossible)).warning().is_some());
    }

    #[test]
    fn spectra_that_do_not_fit_are_refused() {
        let ([x, y], cross) = spectra();
        let short = &cross[..39];
        assert!(matches!(
            StoredIdentities::of((short, None), (&x, &y), &cross, 2.0),
            Err(EstimateError::Mismatch { .. })
        ));
        let silent = vec![Complex::default(); 40];
        assert_eq!(
            StoredIdentities::of((&silent, None), (&x, &y), &silent, 2.0).unwrap(),
            None
        );
    }
}
