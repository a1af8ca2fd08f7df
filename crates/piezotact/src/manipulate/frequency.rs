//! Frequency manipulations: a shift by a number of Hz, or a scaling as by another sliding speed.

use std::f64::consts::TAU;

use num_complex::Complex;
use piezotact_fourier::ComplexPlanner;

use super::error::require_range;
use super::looping::longest_s;
use super::{
    JoinConfig, ManipulateError, Manipulated, about_mean, left_the_band, line_hz, looped,
    manipulated,
};
use crate::fourier::RealTransform;
use crate::lineage::{Operation, WarpedLength};
use crate::quantity::{Hertz, Quantity, SampleRate};
use crate::resample::Resampler;
use crate::series::Series;
use crate::statistics::mean;

/// The share of half the rate that a warp keeps: above it the resampler attenuates.
const KEPT_SHARE: f64 = 0.95;

/// `x` with every frequency shifted by `by`, its mean removed, in the unit of `x`; harmonic ratios are lost. Content that would
/// leave the range from 0 Hz to half the rate is removed before, with a warning.
///
/// Formula: Re{(x + i·H{x})·exp(2πi·Δf·t)}, H the Hilbert transform over the whole texture.
///
/// Source: Oppenheim and Schafer, Discrete-Time Signal Processing, section 12.4: single-sideband modulation.
///
/// # Errors
/// [`ManipulateError::Range`] for a shift of half the rate or more, [`ManipulateError::NothingLeft`] when all of it
/// leaves, [`ManipulateError::Silent`].
///
/// ```
/// use piezotact::manipulate::shift;
/// use piezotact::quantity::{Acceleration, Hertz, SampleRate};
/// let rate = SampleRate::new(1000.0).unwrap();
/// let tone = |hz: f64| -> Vec<f64> {
///     (0..1000).map(|i| (std::f64::consts::TAU * hz * f64::from(i) / 1000.0).cos()).collect()
/// };
/// let x = piezotact::Series::<Acceleration>::new(tone(100.0), rate).unwrap();
/// let y = shift(&x, Hertz(20.0)).unwrap().series;
/// assert!(y.samples().iter().zip(tone(120.0)).all(|(a, b)| (a - b).abs() < 1e-9));
/// ```
pub fn shift<Q: Quantity>(x: &Series<Q>, by: Hertz) -> Result<Manipulated<Q>, ManipulateError> {
    let (rate, nyquist) = (x.rate(), x.rate().nyquist());
    let range = (-nyquist.0, nyquist.0);
    require_range("a shift", by.0, range, " Hz", "shift by less")?;
    let (_, changing) = about_mean(x)?;
    let n = changing.len();
    let half = RealTransform::new(n).forward(&changing);
    let (mut kept, mut all) = (0.0, 0.0);
    let mut analytic = vec![Complex::default(); n];
    for (k, bin) in half.iter().enumerate().skip(1) {
        let power = bin.norm_sqr();
        all += power;
        let moved_hz = line_hz(k, n, rate) + by.0;
        if moved_hz > 0.0 && moved_hz < nyquist.0 {
            kept += power;
            analytic[k] = bin * if 2 * k == n { 1.0 } else { 2.0 } / n as f64;
        }
    }
    ComplexPlanner::new()
        .plan_fft_inverse(n)
        .process(&mut analytic);
    let samples = analytic
        .iter()
        .enumerate()
        .map(|(i, z)| {
            let turn = Complex::from_polar(1.0, TAU * by.0 * i as f64 / rate.hz());
            (z * turn).re
        })
        .collect();
    let operation = Operation::Shifted { by_hz: by.0 };
    let share = 1.0 - kept / all.max(f64::MIN_POSITIVE);
    let warnings = left_the_band(&operation, share, nyquist);
    manipulated(x, samples, operation, warnings)
}

/// `x` with every frequency multiplied by `ratio`, as for a sliding speed higher by that factor, its mean removed, in the unit of
/// `x`; the spectrum of a texture over f/v stays the same. Content that would leave the band is removed, with a warning.
///
/// Formula: y(t) = x(ratio·t), band-limited.
///
/// Source: thesis 3.2.3: spectra of one surface at several speeds lie on one line over f/v; [`Resampler`].
///
/// # Errors
/// [`ManipulateError::Range`] for a ratio that is not 0.1 to 10 or that makes more than an hour, [`ManipulateError::Ratio`] for one that no resampler
/// fits, those of [`looped`] where the length is kept, [`ManipulateError::NothingLeft`], [`ManipulateError::Silent`].
pub fn warp<Q: Quantity>(
    x: &Series<Q>,
    ratio: f64,
    length: WarpedLength,
) -> Result<Manipulated<Q>, ManipulateError> {
    require_range("a warp", ratio, (0.1, 10.0), "", "1 changes nothing")?;
    let rate = x.rate();
    require_range(
        "a length after the warp",
        x.duration().0 / ratio.max(f64::MIN_POSITIVE),
        (0.0, longest_s(rate).max(x.duration().0)),
        " s",
        "cut the texture first, or use a warp closer to 1",
    )?;
    let (_, changing) = about_mean(x)?;
    let at_ratio = |why| ManipulateError::Ratio { found: ratio, why };
    // The same samples, interpreted at a higher rate.
    let faster =
        SampleRate::new(rate.hz() * ratio).map_err(|_too_fast| ManipulateError::Range {
            expected: "rates from 0.001 to 1e7 Hz".into(),
            found: format!("{}", rate.hz() * ratio),
            todo: "use a warp closer to 1",
        })?;
    let highest_hz = KEPT_SHARE * faster.nyquist().0.min(rate.nyquist().0);
    let warped = if (ratio - 1.0).abs() > 0.0 {
        let resampler = Resampler::new(faster, rate, Hertz(highest_hz)).map_err(at_ratio)?;
        resampler.process(&changing)
    } else {
        changing.clone()
    };
    let warped = centred(warped);
    let n = changing.len();
    let (mut left, mut all) = (0.0, 0.0);
    for (k, bin) in RealTransform::new(n).forward(&changing).iter().enumerate() {
        let power = bin.norm_sqr();
        all += power;
        if line_hz(k, n, faster) > highest_hz {
            left += power;
        }
    }
    let operation = Operation::Warped { ratio, length };
    let mut warnings = left_the_band(&operation, left / all, rate.nyquist());
    let samples = match length {
        WarpedLength::Follows => warped,
        WarpedLength::Kept => {
            let warped = Series::<Q>::new(warped, rate)?;
            let kept = looped(&warped, x.duration(), &JoinConfig::usual(warped.duration()))?;
            warnings.extend(kept.warnings);
            centred(kept.series.into_samples())
        }
    };
    manipulated(x, samples, operation, warnings)
}

fn centred(mut samples: Vec<f64>) -> Vec<f64> {
    let mean = mean(&samples);
    for sample in &mut samples {
        *sample -= mean;
    }
    samples
}
