//! Texture manipulations: another level, another spectrum, other phases, another length.
//!
//! Every function returns a [`Manipulated`]: the new texture, the [`Step`] that states the operation with its
//! parameters, and its warnings. A [`Texture`] keeps all steps as its [`Lineage`], so that the origin of a played texture
//! is always known. Levels are rms about the mean, since a mean is not perceptible.

mod document;
mod error;
mod frequency;
mod level;
mod looping;
mod page;
mod source;
mod spectral;
mod warning;

// All public items of each module: a new manipulation is a function in one file.
pub use document::ManipulateDocument;
pub use error::*;
pub use frequency::*;
pub use level::*;
pub use looping::*;
pub use page::BeforeAndAfter;
pub use source::*;
pub use spectral::*;
pub use warning::*;

use crate::feature::{FeatureConfig, FeatureError};
use crate::lineage::{Lineage, Operation, Step};
use crate::quantity::{Band, Decibels, Hertz, Quantity, SampleRate};
use crate::series::Series;
use crate::spectrum::{Spectrum, welch};
use crate::statistics::{mean, standard_deviation};
use crate::warning::Warning;

/// A warning is raised when at least this share of the power leaves the band.
pub const WARNING_LOST_SHARE: f64 = 1e-3;

/// A mean below this share of the rms is neglected.
const NO_MEAN_RATIO: f64 = 0.01;

/// A remainder below this share of the rms of a texture is rounding error.
const ROUNDING_RATIO: f64 = 1e-9;

/// A texture after one operation.
#[derive(Clone, Debug, PartialEq)]
pub struct Manipulated<Q: Quantity> {
    pub series: Series<Q>,
    pub step: Step,
    /// What a person should know before relying on it.
    pub warnings: Vec<Warning>,
}

/// A texture with everything that was done to it.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture<Q: Quantity> {
    pub series: Series<Q>,
    /// What it was made from, and how.
    pub lineage: Lineage,
    /// What a person should know before relying on it.
    pub warnings: Vec<Warning>,
}

/// The PSDs of `textures`, in the unit of `Q` squared per Hz: Hann windows, lines about 5 Hz apart, overlapping by half.
///
/// Formula: that of [`welch`].
///
/// Source: as [`FeatureConfig::usual`].
///
/// # Errors
/// [`FeatureError`] for a texture of fewer than eight samples.
pub fn spectra_of<'a, Q: Quantity>(
    textures: impl IntoIterator<Item = &'a Texture<Q>>,
) -> Result<Vec<Spectrum<Q>>, FeatureError> {
    let of = |texture: &Texture<Q>| {
        let length = texture.series.samples().len();
        let usual = FeatureConfig::usual(texture.series.rate(), &[length], None)?;
        welch(&texture.series, &usual.welch).map_err(FeatureError::Estimate)
    };
    textures.into_iter().map(of).collect()
}

impl<Q: Quantity> Texture<Q> {
    /// Its level, rms about the mean, relative to `other`, dB.
    #[must_use]
    pub fn level_re_db(&self, other: &Self) -> f64 {
        let [own, other] = [self, other].map(|texture| texture.series.rms_about_mean().value);
        Decibels::from_amplitude_ratio(own / other).0
    }

    /// A texture as it was recorded, called `source`.
    #[must_use]
    pub fn of(source: impl Into<String>, series: Series<Q>) -> Self {
        Self {
            series,
            lineage: Lineage::of(source),
            warnings: Vec::new(),
        }
    }

    /// The texture without its mean; unchanged when the mean is below 1 % of its rms, which changes the rms by 0.005 %.
    ///
    /// # Errors
    /// [`ManipulateError::Silent`] when nothing is left.
    pub fn with_mean_removed(self) -> Result<Self, ManipulateError> {
        let (mean, _) = about_mean(&self.series)?;
        if mean.abs() < NO_MEAN_RATIO * standard_deviation(self.series.samples()) {
            return Ok(self);
        }
        let done = without_mean(&self.series)?;
        Ok(self.then(done))
    }

    /// The texture after one more operation on its samples.
    ///
    /// ```
    /// use piezotact::manipulate::{Texture, gain};
    /// use piezotact::quantity::{Acceleration, Decibels, SampleRate};
    /// let rate = SampleRate::new(1000.0).unwrap();
    /// let series = piezotact::Series::<Acceleration>::new(vec![1.0, -1.0], rate).unwrap();
    /// let texture = Texture::of("S2", series);
    /// let louder = gain(&texture.series, Decibels(6.0)).unwrap();
    /// let texture = texture.then(louder);
    /// assert_eq!(texture.lineage.to_string(), "S2 (gain +6.000 dB)");
    /// ```
    #[must_use]
    pub fn then(self, done: Manipulated<Q>) -> Self {
        let mut warnings = self.warnings;
        warnings.extend(done.warnings);
        Self {
            series: done.series,
            lineage: self.lineage.then(done.step),
            warnings,
        }
    }
}

/// What `operation` made of `before`.
fn manipulated<Q: Quantity>(
    before: &Series<Q>,
    samples: Vec<f64>,
    operation: Operation,
    warnings: Vec<Warning>,
) -> Result<Manipulated<Q>, ManipulateError> {
    let series = Series::new(samples, before.rate())?;
    let floor = ROUNDING_RATIO * standard_deviation(before.samples());
    if standard_deviation(series.samples()) <= floor {
        return Err(ManipulateError::NothingLeft {
            after: operation.to_string(),
        });
    }
    Ok(Manipulated {
        step: Step::between(operation, before.rms_about_mean(), series.rms_about_mean()),
        series,
        warnings,
    })
}

/// The mean of a texture and what changes about it.
fn about_mean<Q: Quantity>(x: &Series<Q>) -> Result<(f64, Vec<f64>), ManipulateError> {
    let mean = mean(x.samples());
    let changing: Vec<f64> = x.samples().iter().map(|v| v - mean).collect();
    let largest = crate::statistics::peak(&changing);
    // Subtracting the mean from a constant leaves rounding errors.
    if largest <= 1e-13 * mean.abs() {
        return Err(ManipulateError::Silent {
            quantity: Q::NAME,
            duration: x.duration(),
        });
    }
    Ok((mean, changing))
}

fn require_band(band: Band, rate: SampleRate) -> Result<(), ManipulateError> {
    if band.high().0 > rate.nyquist().0 {
        return Err(ManipulateError::BandAboveNyquist {
            band,
            nyquist: rate.nyquist(),
        });
    }
    Ok(())
}

fn require_one_rate<Q: Quantity>(
    x: &Series<Q>,
    of: &Texture<Q>,
    taken: &'static str,
) -> Result<(), ManipulateError> {
    if x.rate() != of.series.rate() {
        return Err(ManipulateError::RatesDiffer {
            taken,
            of: of.lineage.source.clone(),
            its_rate: of.series.rate(),
            rate: x.rate(),
        });
    }
    Ok(())
}

/// The frequency of line `k` of a transform over `n` samples, Hz.
fn line_hz(k: usize, n: usize, rate: SampleRate) -> f64 {
    k as f64 * rate.hz() / n as f64
}

/// The warning about the share of the power that left the band, if it reaches [`WARNING_LOST_SHARE`].
fn left_the_band(operation: &Operation, share: f64, nyquist: Hertz) -> Vec<Warning> {
    if share <= WARNING_LOST_SHARE {
        return Vec::new();
    }
    vec![Warning::from(ManipulateWarning::LeftTheBand {
        operation: operation.to_string(),
        share,
        nyquist_hz: nyquist.0,
    })]
}
