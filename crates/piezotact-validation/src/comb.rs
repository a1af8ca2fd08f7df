//! The comb of a periodic surface in the spectra of single strokes, whose speeds nobody knows, and a peak in one band.

use piezotact::feature::{Statistics, StrokeSpectra};
use piezotact::statistics::mean;

/// The spacings that are tried, Hz, and the ratio of one to the next: 7 to 100 mm/s for 0.716 mm, more than the thesis claims.
const SPACINGS_HZ: [f64; 2] = [10.0, 140.0];
const FINER: f64 = 1.01;
/// The orders that say how far the peaks of a comb are apart.
const ORDERS: usize = 5;
/// The band of the harmonics of *thesis* 6.4, Hz.
const BAND_HZ: [f64; 2] = [50.0, 400.0];
/// A harmonic stands out where the power around it is 4 dB above that between it and its neighbours. The best of all spacings makes
/// 2.6 dB for the second of its harmonics out of noise, and 3.7 dB at most in 120 simulations of twelve strokes.
const STANDS_OUT: f64 = 2.51;

/// The comb in the strokes of one recording.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Comb {
    /// The distance of its peaks, the median over strokes, Hz.
    pub(super) spacing_hz: f64,
    /// How many harmonics stand out within 50–400 Hz.
    pub(super) harmonics: usize,
}

/// Power around multiples of a frequency in one spectrum.
struct Orders<'a> {
    psd: &'a [f64],
    step_hz: f64,
    spacing_hz: f64,
}

impl Orders<'_> {
    /// The lines within a tenth of an order.
    fn lines(&self, order: f64) -> std::ops::RangeInclusive<usize> {
        let line = |order: f64| (order * self.spacing_hz / self.step_hz).round().max(0.0) as usize;
        line(order - 0.1)..=line(order + 0.1)
    }

    /// The mean power of these lines.
    fn around(&self, order: f64) -> f64 {
        let lines = self.lines(order);
        let count = lines.clone().count() as f64;
        lines
            .map(|k| self.psd.get(k).copied().unwrap_or(0.0))
            .sum::<f64>()
            / count
    }

    /// How far the peaks rise above the valleys between them, in standard errors, up to a constant.
    ///
    /// Formula: Σ ln(P(n)/√(P(n − ½)·P(n + ½))) over √(Σ 1/m), with m lines around order n.
    fn contrast(&self) -> f64 {
        let (mut sum, mut variance) = (0.0, 0.0);
        for order in (1..=ORDERS).map(|order| order as f64) {
            let valleys = (self.around(order - 0.5) * self.around(order + 0.5)).sqrt();
            sum += (self.around(order) / valleys).ln();
            variance += 1.0 / self.lines(order).count() as f64;
        }
        if sum.is_finite() {
            sum / variance.sqrt()
        } else {
            f64::NEG_INFINITY
        }
    }
}

/// The distance of the peaks of the comb in one spectrum, Hz: that with the largest contrast.
fn spacing_hz(psd: &[f64], step_hz: f64) -> f64 {
    let [from, to] = SPACINGS_HZ;
    let count = ((to / from).ln() / FINER.ln()) as i32;
    let tried = (0..=count).map(|i| from * FINER.powi(i));
    let contrast = |spacing_hz: f64| {
        Orders {
            psd,
            step_hz,
            spacing_hz,
        }
        .contrast()
    };
    tried
        .map(|hz| (hz, contrast(hz)))
        .max_by(|a, b| a.1.total_cmp(&b.1))
        .map_or(f64::NAN, |(hz, _)| hz)
}

/// The comb of all strokes: every spectrum is averaged over multiples of its own spacing, since speeds differ.
pub(super) fn comb_of(psd: &StrokeSpectra) -> Comb {
    let step_hz = psd.resolution_hz;
    let spacings: Vec<f64> = psd
        .each
        .iter()
        .map(|psd| spacing_hz(psd, step_hz))
        .collect();
    let around = |order: f64| -> f64 {
        let each = psd.each.iter().zip(&spacings);
        let each = each.map(|(psd, spacing_hz)| {
            let orders = Orders {
                psd,
                step_hz,
                spacing_hz: *spacing_hz,
            };
            orders.around(order)
        });
        mean(&each.collect::<Vec<f64>>())
    };
    let usual_hz = Statistics::of(&mut spacings.clone()).map_or(f64::NAN, |of| of.median);
    let most = (BAND_HZ[1] / usual_hz) as usize;
    let harmonics = (1..=most)
        .map(|order| order as f64)
        .filter(|order| order * usual_hz >= BAND_HZ[0])
        .filter(|order| {
            // Between its valleys a spectrum that merely falls lies at their geometric mean.
            let valleys = (around(order - 0.5) * around(order + 0.5)).sqrt();
            around(*order) > STANDS_OUT * valleys
        })
        .count();
    Comb {
        spacing_hz: usual_hz,
        harmonics,
    }
}

/// A peak of a mean spectrum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct BandPeak {
    /// The centre of its power, Hz.
    pub(super) at_hz: f64,
    /// How far it rises above the higher of the lowest points within an octave on either side, dB.
    pub(super) prominence_db: f64,
}

/// The centre of a peak near `near_hz`, Hz, between the lines: the mean frequency of the power under a Gaussian window of 15 % around
/// itself, found by iteration.
fn centre_hz(psd: &StrokeSpectra, near_hz: f64) -> f64 {
    let mut centre_hz = near_hz;
    for _ in 0..10 {
        let lines = psd.mean.iter().enumerate();
        let (sum, first) = lines.fold((0.0, 0.0), |(sum, first), (k, power)| {
            let hz = k as f64 * psd.resolution_hz;
            let away = (hz / centre_hz - 1.0) / 0.15;
            let weight = power * (-0.5 * away * away).exp();
            (sum + weight, first + weight * hz)
        });
        centre_hz = first / sum;
    }
    centre_hz
}

/// The most prominent local maximum within a band of the mean spectrum, smoothed over ± 5 % of every frequency; `None` where it has
/// none. A spectrum that merely rises, falls or bends within the band has none, or one of little prominence.
pub(super) fn band_peak(psd: &StrokeSpectra, [low_hz, high_hz]: [f64; 2]) -> Option<BandPeak> {
    let line = |hz: f64| (hz / psd.resolution_hz).round() as usize;
    let smooth = |k: usize| {
        let hz = k as f64 * psd.resolution_hz;
        let lines = psd.mean.get(line(0.95 * hz)..=line(1.05 * hz));
        lines.map_or(f64::NAN, mean)
    };
    let lowest =
        |lines: std::ops::RangeInclusive<usize>| lines.map(smooth).fold(f64::NAN, f64::min);
    let inside =
        (low_hz / psd.resolution_hz).ceil() as usize..=(high_hz / psd.resolution_hz) as usize;
    let maxima = inside.filter(|k| smooth(*k) >= smooth(k - 1) && smooth(*k) > smooth(k + 1));
    let peaks = maxima.map(|k| {
        let beside = lowest(k / 2..=k).max(lowest(k..=2 * k));
        BandPeak {
            at_hz: centre_hz(psd, k as f64 * psd.resolution_hz),
            prominence_db: 10.0 * (smooth(k) / beside).log10(),
        }
    });
    peaks.max_by(|a, b| a.prominence_db.total_cmp(&b.prominence_db))
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezotact_bench::random::Random;

    const STEP_HZ: f64 = 2.44;

    /// Spectra of twelve strokes of `segments` segments, with the mean `power` in every line for a stroke's number.
    fn spectra(segments: usize, power: impl Fn(usize, f64) -> f64) -> StrokeSpectra {
        let mut random = Random::stream(5, 1, "spectra");
        let each = (0..12).map(|stroke| {
            let line = |k: usize| {
                let squares = (0..2 * segments)
                    .map(|_| random.normal().powi(2))
                    .sum::<f64>();
                power(stroke, k as f64 * STEP_HZ) * squares / (2 * segments) as f64
            };
            (0..=1_024).map(line).collect()
        });
        StrokeSpectra::over(each.collect(), STEP_HZ, String::new())
    }

    fn broad(hz: f64) -> f64 {
        1.0 / (1.0 + (hz / 220.0).powi(4))
    }

    /// Peaks 6 % wide at all multiples of `spacing_hz`.
    fn teeth(hz: f64, spacing_hz: f64) -> f64 {
        (1..=8)
            .map(|n| f64::from(n) * spacing_hz)
            .map(|at| 8.0 * (-0.5 * ((hz - at) / (0.06 * at)).powi(2)).exp())
            .sum()
    }

    #[test]
    fn a_comb_of_strokes_of_any_speed_is_found() {
        for usual_hz in [30.0, 45.0, 60.0] {
            let spacing = |stroke: usize| usual_hz * (0.8 + 0.04 * stroke as f64);
            let psd = spectra(2, |stroke, hz| {
                broad(hz) * (1.0 + teeth(hz, spacing(stroke)))
            });
            let comb = comb_of(&psd);
            assert!((comb.spacing_hz / usual_hz - 1.0).abs() < 0.06, "{comb:?}");
            assert!(comb.harmonics >= 2, "{comb:?}");
        }
    }

    /// Where there is none, no harmonic stands out, though the best spacing of every stroke is taken.
    #[test]
    fn noise_has_no_harmonics() {
        for segments in [2, 3, 6] {
            let comb = comb_of(&spectra(segments, |_, hz| broad(hz)));
            assert!(comb.harmonics < 2, "{segments} {comb:?}");
        }
    }

    #[test]
    fn a_peak_stands_above_what_lies_beside_it() {
        let with = |at_hz: f64, high: f64| {
            let psd = spectra(20, |_, hz| {
                let rising = hz * hz / (hz * hz + 2_000.0);
                rising * broad(hz) * (1.0 + high * (-0.5 * ((hz - at_hz) / 8.0).powi(2)).exp())
            });
            band_peak(&psd, [70.0, 110.0]).map_or((f64::NAN, 0.0), |p| (p.at_hz, p.prominence_db))
        };
        let (at_hz, db) = with(90.0, 3.0);
        assert!(
            (at_hz / 90.0 - 1.0).abs() < 0.03 && db > 4.5,
            "{at_hz} {db}"
        );
        // A hump between its rise and its fall, and a peak elsewhere, are none.
        for (at_hz, high) in [(90.0, 0.0), (200.0, 3.0)] {
            assert!(with(at_hz, high).1 < 3.0, "{:?}", with(at_hz, high));
        }
    }
}
