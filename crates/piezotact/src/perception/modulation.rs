//! The sustained modulation of a level in bands.

use std::f64::consts::FRAC_PI_2;

use num_complex::Complex;

use super::course::about_mean;
use super::parameters::MODULATION_BANDS_HZ;
use crate::fourier::RealTransform;
use crate::statistics::median;

/// What is left out at both ends, s.
const MARGIN_S: f64 = 0.030;
/// The fewest values.
const SHORTEST: usize = 40;
/// The fewest periods of a band's centre.
pub(super) const MIN_PERIODS: f64 = 5.0;
/// The share of each end that is faded.
const FADED: f64 = 0.10;
/// Parts whose scatter says how sure the modulation is.
const BLOCKS: usize = 8;
/// The degrees of freedom of a band, per period of its centre.
const FREEDOM: f64 = 0.6;
/// The median of a squared Rayleigh deviate over its mean, ln 2.
const MEDIAN_SHARE: f64 = 0.693;

/// The modulation in one band.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Modulation {
    /// Mean square, dB², of what lasts: a single gap counts little.
    pub(super) power: f64,
    /// The variance of its natural logarithm.
    pub(super) variance: f64,
}

/// The modulation of `level_db` in each band; `None` where it is too short for the band.
pub(super) fn modulation(
    level_db: &[f64],
    step_s: f64,
) -> [Option<Modulation>; MODULATION_BANDS_HZ.len()] {
    let mut found = [None; MODULATION_BANDS_HZ.len()];
    let margin = (MARGIN_S / step_s).round() as usize;
    let n = level_db.len().saturating_sub(2 * margin);
    if n < SHORTEST {
        return found;
    }
    let mut v = about_mean(&level_db[margin..margin + n]);
    let place = |i: usize| (i as f64 + 0.5) / n as f64 - 0.5;
    let (mut with, mut own) = (0.0, 0.0);
    for (i, value) in v.iter().enumerate() {
        with += place(i) * value;
        own += place(i) * place(i);
    }
    for (i, value) in v.iter_mut().enumerate() {
        let share = ((0.5 - place(i).abs()) / FADED).min(1.0);
        *value = (*value - place(i) * with / own) * (FRAC_PI_2 * share).sin().powi(2);
    }
    let bins = RealTransform::new(n).forward(&v);
    let power: Vec<f64> = bins
        .iter()
        .map(|bin| 2.0 * bin.norm_sqr() / (n as f64 * n as f64))
        .collect();
    let length_s = n as f64 * step_s;
    for (band, found) in MODULATION_BANDS_HZ.into_iter().zip(&mut found) {
        if band * length_s >= MIN_PERIODS {
            *found = Some(in_band(band, &bins, &power, n, length_s));
        }
    }
    found
}

fn in_band(
    band_hz: f64,
    bins: &[Complex<f64>],
    power: &[f64],
    n: usize,
    length_s: f64,
) -> Modulation {
    let gain = |k: usize| {
        if k == 0 {
            return 0.0;
        }
        let f = k as f64 / length_s;
        1.0 / (1.0 + (f / band_hz - band_hz / f).powi(2)).sqrt()
    };
    let mut values = vec![Complex::default(); n];
    let (mut all, mut width, mut near) = (0.0, 0.0, Vec::new());
    for (k, bin) in bins.iter().enumerate() {
        let (h, f) = (gain(k), k as f64 / length_s);
        values[k] = (2.0 * bin * h).conj();
        all += h * h * power[k];
        width += h * h;
        if (band_hz / 2.0..=band_hz * 2.0).contains(&f) {
            near.push(power[k]);
        }
    }
    piezotact_fourier::complex_forward(n).process(&mut values);
    let roots: Vec<f64> = values[n / 10..n - n / 10]
        .iter()
        .map(|v| (v.norm() / n as f64).sqrt())
        .collect();
    let mean_of = |part: &[f64]| part.iter().sum::<f64>() / part.len().max(1) as f64;
    let size = roots.len() / BLOCKS;
    let blocks: Vec<f64> = roots.chunks_exact(size).take(BLOCKS).map(mean_of).collect();
    let middle = mean_of(&blocks);
    let scatter = blocks.iter().map(|b| (b - middle).powi(2)).sum::<f64>() / (BLOCKS - 1) as f64;
    let of_blocks = 16.0 * scatter / BLOCKS as f64 / middle.max(1e-9).powi(2);

    let floor = median(&mut near).unwrap_or(0.0) / MEDIAN_SHARE * width;
    let noise = all.min(floor);
    let share = (noise * noise + 2.0 * noise * (all - noise)) / all.max(1e-12).powi(2);
    let of_noise = share * trigamma((FREEDOM * band_hz * length_s).max(1.0));
    Modulation {
        power: 0.5 * mean_of(&roots).powi(4),
        variance: of_noise.max(of_blocks),
    }
}

/// The variance of the logarithm of a gamma deviate of shape `n`.
fn trigamma(mut n: f64) -> f64 {
    let mut sum = 0.0;
    while n < 10.0 {
        sum += n.powi(-2);
        n += 1.0;
    }
    let i = 1.0 / n;
    sum + i + i * i / 2.0 + i.powi(3) / 6.0 - i.powi(5) / 30.0 + i.powi(7) / 42.0 - i.powi(9) / 30.0
}

#[cfg(test)]
mod tests {
    use super::trigamma;

    /// π²/6 and π²/2.
    #[test]
    fn trigamma_of_one_and_a_half() {
        assert!((trigamma(1.0) - 1.644_934_066_848_226_4).abs() < 1e-10);
        assert!((trigamma(0.5) - 4.934_802_200_544_679).abs() < 1e-10);
    }
}
