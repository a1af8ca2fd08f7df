//! Level manipulations: a pure gain that changes nothing else.

use super::error::require_range;
use super::{
    ManipulateError, Manipulated, Texture, about_mean, line_hz, manipulated, require_band,
};
use crate::fourier::RealTransform;
use crate::lineage::{Level, Operation};
use crate::quantity::{Decibels, Quantity};
use crate::series::Series;
use crate::statistics::standard_deviation;

/// `x` with its mean removed, in the unit of `x`.
///
/// Formula: x − Σx/n.
///
/// Source: house rule: a mean (gravity, an offset of an amplifier) is not perceptible.
///
/// # Errors
/// [`ManipulateError::Silent`] when nothing is left.
pub fn without_mean<Q: Quantity>(x: &Series<Q>) -> Result<Manipulated<Q>, ManipulateError> {
    let (mean, samples) = about_mean(x)?;
    manipulated(x, samples, Operation::MeanTakenAway { mean }, Vec::new())
}

/// `x` louder or softer, −120 to 120 dB.
///
/// Formula: x·10^(dB/20).
///
/// Source: [`Decibels::amplitude_ratio`].
///
/// # Errors
/// [`ManipulateError::Range`] for a level that is not a number or out of range, [`ManipulateError::Silent`] for a constant
/// texture.
///
/// ```
/// use piezotact::manipulate::gain;
/// use piezotact::quantity::{Acceleration, Decibels, SampleRate};
/// let rate = SampleRate::new(1000.0).unwrap();
/// let x = piezotact::Series::<Acceleration>::new(vec![1.0, -1.0], rate).unwrap();
/// assert_eq!(gain(&x, Decibels(20.0)).unwrap().series.samples(), [10.0, -10.0]);
/// ```
pub fn gain<Q: Quantity>(
    x: &Series<Q>,
    level: Decibels,
) -> Result<Manipulated<Q>, ManipulateError> {
    require_range(
        "a gain",
        level.0,
        (-120.0, 120.0),
        " dB",
        "0 dB changes nothing",
    )?;
    about_mean(x)?;
    let samples = x.clone().amplified(level).into_samples();
    let operation = Operation::Gain { gain_db: level.0 };
    manipulated(x, samples, operation, Vec::new())
}

/// The level of a texture, rms about its mean, in its unit; for a band, the rms of the lines that lie in it, both ends
/// included.
///
/// Formula: √(Σ(x − mean)²/n), or √(2·Σ|X(k)|²)/n over the lines of the band.
///
/// Source: thesis 3.1.1 for the rms; Parseval for the band.
///
/// # Errors
/// [`ManipulateError::Silent`], [`ManipulateError::BandAboveNyquist`], and [`ManipulateError::SilentWithin`] where the
/// band holds nothing.
pub fn level<Q: Quantity>(x: &Series<Q>, measured: Level) -> Result<f64, ManipulateError> {
    let (_, changing) = about_mean(x)?;
    let Level::Within(band) = measured else {
        return Ok(standard_deviation(x.samples()));
    };
    require_band(band, x.rate())?;
    let n = changing.len();
    let power: f64 = RealTransform::new(n)
        .forward(&changing)
        .iter()
        .enumerate()
        .filter(|(k, _)| band.contains(line_hz(*k, n, x.rate())))
        .map(|(k, bin)| bin.norm_sqr() * if k == 0 || 2 * k == n { 1.0 } else { 2.0 })
        .sum();
    let level = power.sqrt() / n as f64;
    if level <= 1e-12 * standard_deviation(x.samples()) {
        return Err(ManipulateError::SilentWithin {
            what: format!("{:.3} of {}", x.duration(), Q::NAME),
            band,
        });
    }
    Ok(level)
}

/// `x` scaled to the level of another texture, over all frequencies or within a band, in the unit of `x`: a pure gain that keeps
/// the shape of its spectrum. The two may have different rates.
///
/// Formula: x·rms(other)/rms(x).
///
/// Source: thesis 4.4.1: "dividing the acceleration signal of S2 by the ratio between the RMS acceleration of S13 and
/// the RMS acceleration of S2" describes S2 at the level of S13 (the ratio is the other way round there).
///
/// # Errors
/// Those of [`level`] for either.
///
/// ```
/// use piezotact::manipulate::{Texture, rms_of};
/// use piezotact::lineage::Level;
/// use piezotact::quantity::{Acceleration, SampleRate};
/// let rate = SampleRate::new(1000.0).unwrap();
/// let series = |v: &[f64]| piezotact::Series::<Acceleration>::new(v.to_vec(), rate).unwrap();
/// let loud = Texture::of("S13", series(&[4.0, -4.0]));
/// let done = rms_of(&series(&[1.0, -1.0]), &loud, Level::Whole).unwrap();
/// assert_eq!(done.series.samples(), [4.0, -4.0]);
/// ```
pub fn rms_of<Q: Quantity>(
    x: &Series<Q>,
    other: &Texture<Q>,
    measured: Level,
) -> Result<Manipulated<Q>, ManipulateError> {
    let rms = level(&other.series, measured)?;
    let ratio = rms / level(x, measured)?;
    let samples = x.samples().iter().map(|v| v * ratio).collect();
    let operation = Operation::RmsOf {
        of: other.lineage.clone(),
        rms,
        measured,
        gain_db: Decibels::from_amplitude_ratio(ratio).0,
    };
    manipulated(x, samples, operation, other.warnings.clone())
}

/// Two textures with their levels exchanged: each at the rms of the other, each with its own shape.
///
/// Source: thesis 4.4.1, figure 62; see [`rms_of`].
///
/// # Errors
/// Those of [`rms_of`].
pub fn exchanged<Q: Quantity>(
    first: Texture<Q>,
    second: Texture<Q>,
) -> Result<[Texture<Q>; 2], ManipulateError> {
    let of_second = rms_of(&first.series, &second, Level::Whole)?;
    let of_first = rms_of(&second.series, &first, Level::Whole)?;
    Ok([first.then(of_second), second.then(of_first)])
}
