//! Aligns a measurement with its target in time, to a fraction of a sample.

use std::f64::consts::TAU;

use num_complex::Complex;

use super::VerifyError;
use crate::fourier;
use crate::quantity::{Band, Quantity, SampleRate, Seconds};
use crate::series::Series;
use crate::statistics::mean;

/// A measurement aligned with its target in time.
pub(crate) struct Aligned {
    /// How much later the measurement is.
    pub(crate) delay: Seconds,
    /// The measurement resampled at the target's times, one sample for each sample of the target.
    pub(crate) measured: Vec<f64>,
    pub(crate) measured_in_band: Vec<f64>,
    pub(crate) target_in_band: Vec<f64>,
    /// The part of the target that the measurement covers.
    pub(crate) from: usize,
    pub(crate) to: usize,
    band: Band,
}

impl Aligned {
    /// The correlation of target and measurement over the part that is compared.
    pub(super) fn correlation(&self) -> f64 {
        let (t, m) = (
            &self.target_in_band[self.from..self.to],
            &self.measured_in_band[self.from..self.to],
        );
        crate::statistics::correlation(t, m)
    }

    /// The same alignment for a measurement that is `lag` whole samples later than the target.
    pub(super) fn moved_to<Q: Quantity>(self, lag: f64, response: &Series<Q>) -> Self {
        let rate = response.rate();
        let count = self.target_in_band.len();
        let limited = in_band(response.samples(), rate, self.band);
        let about = mean(response.samples());
        let taken = |x: &[f64], about: f64| -> Vec<f64> {
            (0..count as i64)
                .map(|i| {
                    let place = usize::try_from(i + lag as i64).ok();
                    place.and_then(|i| x.get(i)).map_or(0.0, |v| v - about)
                })
                .collect()
        };
        let to = (response.samples().len() as f64 - lag).clamp(0.0, count as f64) as usize;
        Self {
            delay: Seconds(lag / rate.hz()),
            measured: taken(response.samples(), about),
            measured_in_band: taken(&limited, 0.0),
            from: ((-lag).max(0.0) as usize).min(to),
            to,
            ..self
        }
    }
}

/// The largest edge width of the band-pass filter applied to both waveforms before the comparison, as a share of the band's ends.
const EDGE_RATIO: f64 = 0.1;

/// `samples` with their mean removed, limited to `band`: the filter that both waveforms pass before the comparison.
pub(super) fn in_band(samples: &[f64], rate: SampleRate, band: Band) -> Vec<f64> {
    filtered(samples, rate, |hz| band.weight(hz, EDGE_RATIO))
}

/// `samples` with their mean removed, limited to `bands` with sharp edges.
pub(super) fn in_bands(samples: &[f64], rate: SampleRate, bands: &[Band]) -> Vec<f64> {
    let inside = |hz: f64| bands.iter().any(|band| band.contains(hz));
    filtered(samples, rate, |hz| if inside(hz) { 1.0 } else { 0.0 })
}

fn filtered(samples: &[f64], rate: SampleRate, weight: impl Fn(f64) -> f64) -> Vec<f64> {
    let mean = mean(samples);
    let about_mean: Vec<f64> = samples.iter().map(|sample| sample - mean).collect();
    // Zero padding of the same length: circular filtering must not wrap one end into the other.
    let n = fourier::fast_length(2 * samples.len());
    let mut transform = fourier::RealTransform::new(n);
    let mut bins = transform.forward(&about_mean);
    for (k, bin) in bins.iter_mut().enumerate() {
        *bin *= weight(k as f64 * rate.hz() / n as f64);
    }
    let mut limited = transform.inverse(bins);
    limited.truncate(samples.len());
    limited
}

/// `measured` aligned with `target` at the strongest correlation within `band`, of either sign.
pub(crate) fn align<Q: Quantity>(
    target: &Series<Q>,
    measured: &Series<Q>,
    band: Band,
) -> Result<Aligned, VerifyError> {
    let (t, m) = (target.samples(), measured.samples());
    let n = fourier::fast_length(t.len() + m.len());
    let mut transform = fourier::RealTransform::new(n);
    let rate_hz = target.rate().hz();
    let weights: Vec<f64> = (0..=n / 2)
        .map(|k| band.weight(k as f64 * rate_hz / n as f64, EDGE_RATIO))
        .collect();
    // A mean would leave a step at both ends of the padding, and a step has power in every band.
    let about_mean = |samples: &[f64]| -> Vec<f64> {
        let mean = mean(samples);
        samples.iter().map(|sample| sample - mean).collect()
    };
    let (target_bins, measured_bins) = (
        transform.forward(&about_mean(t)),
        transform.forward(&about_mean(m)),
    );
    for (what, bins) in [
        ("the target", &target_bins),
        ("the measurement", &measured_bins),
    ] {
        let power: f64 = bins
            .iter()
            .zip(&weights)
            .map(|(bin, w)| bin.norm_sqr() * w)
            .sum();
        if power <= 0.0 {
            return Err(VerifyError::Silent { what, band });
        }
    }
    let cross: Vec<Complex<f64>> = target_bins
        .iter()
        .zip(&measured_bins)
        .zip(&weights)
        .map(|((t, m), w)| t.conj() * m * w * w)
        .collect();
    // Four times oversampled: the maximum of a tone that falls between two samples must not be smaller than the
    // minimum beside it.
    let fine = 4 * n;
    let correlation = fourier::RealTransform::new(fine).inverse(cross.clone());
    let highest = (0..fine)
        .max_by(|&a, &b| correlation[a].total_cmp(&correlation[b]))
        .unwrap_or(0);
    let deepest = (0..fine)
        .min_by(|&a, &b| correlation[a].total_cmp(&correlation[b]))
        .unwrap_or(0);
    // The correlation of a tone has an equally deep minimum half a period away: only a clearly deeper one is an inversion.
    let inverted = -correlation[deepest] > 1.05 * correlation[highest];
    let strongest = if inverted { deepest } else { highest };
    let place = strongest as f64 / 4.0;
    let whole = if place > m.len() as f64 {
        place - n as f64
    } else {
        place
    };
    // The correlation between samples is a sum of cosines; its extreme is within a quarter of a sample.
    let sign = if inverted { -1.0 } else { 1.0 };
    let at = |lag: f64| {
        cross
            .iter()
            .enumerate()
            .filter(|(_, bin)| bin.norm_sqr() > 0.0)
            .map(|(k, bin)| (bin * Complex::from_polar(1.0, TAU * k as f64 * lag / n as f64)).re)
            .sum::<f64>()
            * sign
    };
    let lag = golden_section_maximum(at, whole - 0.25, whole + 0.25);
    let mut shifted = |in_band: bool| {
        let bins = measured_bins
            .iter()
            .zip(&weights)
            .enumerate()
            .map(|(k, (bin, w))| {
                let turned = bin * Complex::from_polar(1.0, TAU * k as f64 * lag / n as f64);
                if in_band { turned * w } else { turned }
            });
        let mut samples = transform.inverse(bins.collect());
        samples.truncate(t.len());
        samples
    };
    let (measured, measured_in_band) = (shifted(false), shifted(true));
    let mut target_in_band = transform.inverse(
        target_bins
            .iter()
            .zip(&weights)
            .map(|(bin, w)| bin * w)
            .collect(),
    );
    target_in_band.truncate(t.len());
    let from = (-lag).ceil().max(0.0) as usize;
    let to = (m.len() as f64 - lag).floor().clamp(0.0, t.len() as f64) as usize;
    Ok(Aligned {
        delay: Seconds(lag / rate_hz),
        measured,
        measured_in_band,
        target_in_band,
        from: from.min(to),
        to,
        band,
    })
}

/// Where `f` is largest between `low` and `high`, to 1e-4 of a sample.
fn golden_section_maximum(f: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    let golden = (5f64.sqrt() - 1.0) / 2.0;
    let (mut a, mut b) = (high - golden * (high - low), low + golden * (high - low));
    let (mut fa, mut fb) = (f(a), f(b));
    while high - low > 1e-4 {
        if fa > fb {
            (high, b, fb) = (b, a, fa);
            a = high - golden * (high - low);
            fa = f(a);
        } else {
            (low, a, fa) = (a, b, fb);
            b = low + golden * (high - low);
            fb = f(b);
        }
    }
    0.5 * (low + high)
}
