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
    in_band_with_edges(samples, rate, band, EDGE_RATIO)
}

/// As [`in_band`], with edges whose width is the share `edge_ratio` of the band's ends.
pub(crate) fn in_band_with_edges(
    samples: &[f64],
    rate: SampleRate,
    band: Band,
    edge_ratio: f64,
) -> Vec<f64> {
    filtered(samples, rate, |hz| band.weight(hz, edge_ratio))
}

/// `samples` with their mean removed, limited to `bands` with sharp edges.
pub(super) fn in_bands(samples: &[f64], rate: SampleRate, bands: &[Band]) -> Vec<f64> {
    let inside = |hz: f64| bands.iter().any(|band| band.contains(hz));
    filtered(samples, rate, |hz| if inside(hz) { 1.0 } else { 0.0 })
}

fn filtered(samples: &[f64], rate: SampleRate, weight: impl Fn(f64) -> f64) -> Vec<f64> {
    // Zero padding of the same length: circular filtering must not wrap one end into the other.
    let n = fourier::fast_length(2 * samples.len());
    let mut bins = fourier::RealTransform::new(n).forward_about(samples, mean(samples));
    for (k, bin) in bins.iter_mut().enumerate() {
        *bin *= weight(k as f64 * rate.hz() / n as f64);
    }
    first(samples.len(), fourier::RealTransform::new(n).inverse(bins))
}

/// The first `count` of `samples`, in no more memory than they need.
pub(super) fn first(count: usize, mut samples: Vec<f64>) -> Vec<f64> {
    samples.truncate(count);
    samples.shrink_to_fit();
    samples
}

/// How many times finer than the samples the correlation is searched for its extremes: the maximum of a tone that falls between two
/// samples must not be smaller than the minimum beside it.
const FINER: usize = 4;

/// The bins of a transform of `n` samples that have a weight in `band`, with their weights.
struct InBand {
    first: usize,
    weights: Vec<f64>,
}

impl InBand {
    fn of(band: Band, rate_hz: f64, n: usize) -> Self {
        let weight = |k: usize| band.weight(k as f64 * rate_hz / n as f64, EDGE_RATIO);
        let first = (0..=n / 2).find(|k| weight(*k) > 0.0).unwrap_or(0);
        let weights = (first..=n / 2).map(weight);
        Self {
            first,
            weights: weights.take_while(|weight| *weight > 0.0).collect(),
        }
    }

    /// The bins with a weight among all `bins`.
    fn of_all<'a>(&self, bins: &'a [Complex<f64>]) -> &'a [Complex<f64>] {
        &bins[self.first..self.first + self.weights.len()]
    }

    /// What `of` makes of the number, the value and the weight of every one of `bins`, with the bins without a weight below them.
    fn whole(
        &self,
        bins: &[Complex<f64>],
        of: impl Fn(usize, Complex<f64>, f64) -> Complex<f64>,
    ) -> Vec<Complex<f64>> {
        let kept = bins.iter().zip(&self.weights).enumerate();
        let kept = kept.map(|(i, (bin, weight))| of(self.first + i, *bin, *weight));
        std::iter::repeat_n(Complex::default(), self.first)
            .chain(kept)
            .collect()
    }
}

/// An extreme of a correlation, and its place in samples.
#[derive(Clone, Copy)]
struct Extreme {
    value: f64,
    place: f64,
}

/// The highest and the lowest value of the correlation with the bins `cross`, four times finer than the samples: the values between
/// the samples are those of the correlation delayed by a part of a sample, so that no longer transform is needed.
fn extremes(
    inverse: &mut fourier::RealTransform,
    in_band: &InBand,
    cross: &[Complex<f64>],
) -> [Extreme; 2] {
    let n = inverse.length();
    let (mut highest, mut deepest) = (
        Extreme {
            value: f64::MIN,
            place: 0.0,
        },
        Extreme {
            value: f64::MAX,
            place: 0.0,
        },
    );
    for part in 0..FINER {
        let later = part as f64 / FINER as f64;
        let turned = |k: usize, bin: Complex<f64>, _: f64| bin * turn(k, later, n);
        let correlation = inverse.inverse(in_band.whole(cross, turned));
        for (i, value) in correlation.into_iter().enumerate() {
            let place = i as f64 + later;
            // Of equal values the last maximum and the first minimum.
            let equal = |other: Extreme| value.total_cmp(&other.value).is_eq();
            if value > highest.value || (equal(highest) && place > highest.place) {
                highest = Extreme { value, place };
            }
            if value < deepest.value || (equal(deepest) && place < deepest.place) {
                deepest = Extreme { value, place };
            }
        }
    }
    [highest, deepest]
}

/// The turn of bin `k` of `n` samples that makes a signal earlier by `samples`.
fn turn(k: usize, samples: f64, n: usize) -> Complex<f64> {
    Complex::from_polar(1.0, TAU * k as f64 * samples / n as f64)
}

/// `measured` aligned with `target` at the strongest correlation within `band`, of either sign.
pub(crate) fn align<Q: Quantity>(
    target: &Series<Q>,
    measured: &Series<Q>,
    band: Band,
) -> Result<Aligned, VerifyError> {
    let (t, m) = (target.samples(), measured.samples());
    let n = fourier::fast_length(t.len() + m.len());
    let rate_hz = target.rate().hz();
    let in_band = InBand::of(band, rate_hz, n);
    let mut forward = fourier::RealTransform::new(n);
    // A mean would leave a step at both ends of the padding, and a step has power in every band.
    let target_bins = in_band.of_all(&forward.forward_about(t, mean(t))).to_vec();
    let measured_bins = forward.forward_about(m, mean(m));
    drop(forward);
    for (what, bins) in [
        ("the target", &target_bins[..]),
        ("the measurement", in_band.of_all(&measured_bins)),
    ] {
        let weighed = bins.iter().zip(&in_band.weights);
        let power: f64 = weighed.map(|(bin, w)| bin.norm_sqr() * w).sum();
        if power <= 0.0 {
            return Err(VerifyError::Silent { what, band });
        }
    }
    let mut cross: Vec<Complex<f64>> = target_bins
        .iter()
        .zip(in_band.of_all(&measured_bins))
        .zip(&in_band.weights)
        .map(|((t, m), w)| t.conj() * m * w * w)
        .collect();
    let mut inverse = fourier::RealTransform::new(n);
    let [highest, deepest] = extremes(&mut inverse, &in_band, &cross);
    // The correlation of a tone has an equally deep minimum half a period away: only a clearly deeper one is an inversion.
    let inverted = -deepest.value > 1.05 * highest.value;
    let place = if inverted { deepest } else { highest }.place;
    let whole = if place > m.len() as f64 {
        place - n as f64
    } else {
        place
    };
    // The correlation between samples is a sum of cosines; its extreme is within a quarter of a sample.
    let sign = if inverted { -1.0 } else { 1.0 };
    let at = |lag: f64| {
        let bins = cross.iter().enumerate();
        let turned = bins.map(|(i, bin)| (bin * turn(in_band.first + i, lag, n)).re);
        turned.sum::<f64>() * sign
    };
    let lag = golden_section_maximum(at, whole - 0.25, whole + 0.25);
    cross.clear();
    cross.shrink_to_fit();
    let target_in_band = in_band.whole(&target_bins, |_, bin, weight| bin * weight);
    drop(target_bins);
    let target_in_band = first(t.len(), inverse.inverse(target_in_band));
    let shifted = |k: usize, bin: Complex<f64>, weight: f64| bin * turn(k, lag, n) * weight;
    let measured_in_band = in_band.whole(in_band.of_all(&measured_bins), shifted);
    let measured_in_band = first(t.len(), inverse.inverse(measured_in_band));
    let mut turned = measured_bins;
    for (k, bin) in turned.iter_mut().enumerate() {
        *bin *= turn(k, lag, n);
    }
    let measured = first(t.len(), inverse.inverse(turned));
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
