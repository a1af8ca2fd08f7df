//! A signal in shares of its full scale: what files hold whose samples are limited to ±1.

use crate::number::digits;
use crate::quantity::{Measure, SampleRate, Uncalibrated, Unit};
use crate::recording::RecordingWarning;
use crate::resample::converted;
use crate::series::{Series, SeriesError};
use crate::statistics::mean;
use crate::warning::Warning;

/// A mean of at most this share of full scale is neglected: a converter's last bit leaves as much.
const NO_MEAN_SHARE: f64 = 1e-2;

/// A signal in shares of its full scale.
#[derive(Clone, Debug, PartialEq)]
pub struct Shares {
    /// The samples, −1 to 1.
    pub shares: Series<Uncalibrated>,
    /// What 1 stands for.
    pub full_scale: Measure,
    /// The mean that was removed, in the unit of the full scale; 0 of a drive, which keeps its own.
    pub removed_mean: f64,
    /// That its rate was converted, if it was.
    pub converted: Option<Warning>,
}

impl Shares {
    /// What limits a file of the kind `format` that holds these shares: a converted rate, a lost mean.
    #[must_use]
    pub fn warnings(&self, format: &str) -> Vec<Warning> {
        let lost = self.removed_mean.abs() > NO_MEAN_SHARE * self.full_scale.value;
        let mean = lost.then(|| {
            Warning::from(RecordingWarning::FormatLoses {
                format: format.into(),
                what: format!(
                    "the mean of {} {}",
                    digits(self.removed_mean),
                    self.full_scale.unit
                ),
            })
        });
        self.converted.iter().cloned().chain(mean).collect()
    }
}

/// `signal` in `unit`, called `what`, in shares of full scale, at `rate` where one is given: a drive as it is, everything
/// else about its mean in shares of its largest magnitude.
///
/// Formula: (x − x̄)/max|x − x̄|; of a drive x.
///
/// Source: peak normalisation, by definition.
///
/// ```
/// use piezotact::share::shares_of_full_scale;
/// use piezotact::quantity::{SampleRate, Uncalibrated, Unit};
/// let signal = piezotact::Series::<Uncalibrated>::new(vec![3.0, 1.0, 2.0], SampleRate::new(1000.0).unwrap()).unwrap();
/// let found = shares_of_full_scale("a", signal, &Unit::Newton, None).unwrap();
/// assert_eq!(found.shares.samples(), [1.0, -1.0, 0.0]);
/// assert_eq!((found.full_scale.value, found.removed_mean), (1.0, 2.0));
/// ```
///
/// # Errors
/// [`SeriesError::FullScale`] for a constant signal, [`SeriesError::Drive`] for a drive beyond full scale,
/// [`SeriesError::Silence`] for a drive of zeros, [`SeriesError::Ratio`] or [`SeriesError::Passband`] where the rate cannot be reached.
pub fn shares_of_full_scale(
    what: &str,
    signal: Series<Uncalibrated>,
    unit: &Unit,
    rate: Option<SampleRate>,
) -> Result<Shares, SeriesError> {
    let rate = rate.unwrap_or(signal.rate());
    if *unit == Unit::FullScale {
        let at_rate = converted(what, signal, rate)?;
        let peak = at_rate.series.peak();
        if peak > 1.0 {
            return Err(SeriesError::Drive { peak });
        }
        if peak <= 0.0 {
            return Err(SeriesError::Silence);
        }
        return Ok(Shares {
            shares: at_rate.series,
            full_scale: Measure {
                value: 1.0,
                unit: Unit::FullScale,
            },
            removed_mean: 0.0,
            converted: at_rate.warning,
        });
    }
    let recorded = signal.rate();
    // A mean that begins and ends would be a step at both ends of what is resampled: it is removed first.
    let first = about_mean(&signal)?;
    let at_rate = converted(what, first.shares, rate)?;
    let (shares, full_scale) = if at_rate.series.rate() != recorded {
        let again = about_mean(&at_rate.series)?;
        (again.shares, first.full_scale * again.full_scale)
    } else {
        (at_rate.series, first.full_scale)
    };
    Ok(Shares {
        shares,
        full_scale: Measure {
            value: full_scale,
            unit: unit.clone(),
        },
        removed_mean: first.mean,
        converted: at_rate.warning,
    })
}

/// A signal about its mean in shares of its largest magnitude.
#[derive(Clone, Debug, PartialEq)]
struct AboutMean {
    /// The samples without their mean, −1 to 1.
    shares: Series<Uncalibrated>,
    /// What 1 stands for, in the unit of the signal.
    full_scale: f64,
    /// The mean that was taken away, in the unit of the signal.
    mean: f64,
}

/// `x` without its mean, in shares of the largest magnitude that is left: (x − x̄)/max|x − x̄|.
fn about_mean(x: &Series<Uncalibrated>) -> Result<AboutMean, SeriesError> {
    let mean = mean(x.samples());
    let mut shares: Vec<f64> = x.samples().iter().map(|v| v - mean).collect();
    let full_scale = crate::statistics::peak(&shares);
    // The rounding errors of a constant are not a signal.
    if full_scale <= 1e-12 * mean.abs() || full_scale < f64::MIN_POSITIVE {
        return Err(SeriesError::FullScale { found: 0.0 });
    }
    for share in &mut shares {
        *share = (*share / full_scale).clamp(-1.0, 1.0);
    }
    Ok(AboutMean {
        shares: Series::new(shares, x.rate())?,
        full_scale,
        mean,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn series(samples: &[f64], hz: f64) -> Series<Uncalibrated> {
        Series::new(samples.to_vec(), SampleRate::new(hz).unwrap()).unwrap()
    }

    /// A drive keeps its level and its mean; beyond full scale, or without a sample that is not 0, there is none.
    #[test]
    fn a_drive_stays_as_it_is() {
        let of = |samples: &[f64]| {
            shares_of_full_scale("drive", series(samples, 1000.0), &Unit::FullScale, None)
        };
        let found = of(&[0.5, 0.25]).unwrap();
        assert_eq!(found.shares.samples(), [0.5, 0.25]);
        assert_eq!(found.full_scale.value, 1.0);
        assert!(found.warnings("WAV").is_empty());
        assert_eq!(of(&[0.5, -1.5]), Err(SeriesError::Drive { peak: 1.5 }));
        assert_eq!(of(&[0.0, 0.0]), Err(SeriesError::Silence));
    }

    /// Shares at another rate, times their full scale, are the signal at that rate without its mean; both changes are said.
    #[test]
    fn another_rate_keeps_the_level() {
        let wave: Vec<f64> = (0..4000)
            .map(|i| 2.0 + 0.3 * (f64::from(i) * 0.05 * std::f64::consts::TAU).sin())
            .collect();
        let rate = SampleRate::new(2000.0).unwrap();
        let found =
            shares_of_full_scale("`a`", series(&wave, 1000.0), &Unit::Newton, Some(rate)).unwrap();
        let level = found.shares.rms_about_mean().value * found.full_scale.value;
        // Both ends of what is resampled are short of a few samples.
        assert!((level / (0.3 / 2f64.sqrt()) - 1.0).abs() < 1e-2, "{level}");
        assert_eq!((found.shares.rate(), found.shares.peak()), (rate, 1.0));
        let warnings: Vec<String> = found
            .warnings("WAV")
            .iter()
            .map(ToString::to_string)
            .collect();
        assert_eq!(warnings.len(), 2, "{warnings:?}");
        assert!(warnings[1].contains("the mean of 2.00 N"), "{warnings:?}");
    }

    /// The rounding errors of a constant are not a signal, and a mean of a converter's last bit is not a loss.
    #[test]
    fn a_constant_has_no_full_scale() {
        let of = |samples: &[f64]| {
            shares_of_full_scale("a", series(samples, 1000.0), &Unit::Newton, None)
        };
        assert_eq!(
            of(&[0.1 + 0.2, 0.3]),
            Err(SeriesError::FullScale { found: 0.0 })
        );
        assert!(of(&[1.0, -0.999]).unwrap().warnings("WAV").is_empty());
    }
}
