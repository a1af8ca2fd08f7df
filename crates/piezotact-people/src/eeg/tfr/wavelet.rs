//! Morlet wavelets.

use std::f64::consts::{PI, SQRT_2, TAU};

use piezotact::fourier::Complex;

/// A Morlet wavelet of standard deviation `sd_s`, cut at five of them on either side, with a norm of √2.
///
/// Formula: exp(−t²/2σ²)·(exp(2πi·f·t) − κ), where κ = exp(−2(π·f·σ)²) makes the mean zero.
pub(super) fn morlet(frequency_hz: f64, sd_s: f64, rate_hz: f64) -> Vec<Complex<f64>> {
    let half = count_below(5.0 * sd_s, rate_hz);
    let offset = (-2.0 * (PI * frequency_hz * sd_s).powi(2)).exp();
    let times = (1..half)
        .rev()
        .map(|i| -(i as f64))
        .chain((0..half).map(|i| i as f64));
    let wavelet: Vec<Complex<f64>> = times
        .map(|i| {
            let t = i * (1.0 / rate_hz);
            let envelope = (-(t * t) / (2.0 * sd_s * sd_s)).exp();
            (Complex::from_polar(1.0, TAU * frequency_hz * t) - offset) * envelope
        })
        .collect();
    scaled(wavelet)
}

/// The number of samples of a Morlet wavelet.
pub(super) fn morlet_length(sd_s: f64, rate_hz: f64) -> usize {
    count_below(5.0 * sd_s, rate_hz).saturating_mul(2) - 1
}

/// How many samples from 0 are before `end_s`, as NumPy's `arange(0, end, 1/rate)` counts them.
pub(super) fn count_below(end_s: f64, rate_hz: f64) -> usize {
    (end_s / (1.0 / rate_hz)).ceil().max(1.0) as usize
}

fn scaled(mut wave: Vec<Complex<f64>>) -> Vec<Complex<f64>> {
    let norm = wave
        .iter()
        .map(|value| value.norm_sqr())
        .sum::<f64>()
        .sqrt();
    for value in &mut wave {
        *value *= SQRT_2 / norm;
    }
    wave
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The standard deviation of |wave|² in time, times √2: that of the amplitude envelope of a Morlet wavelet, s.
    fn smear_s(wave: &[Complex<f64>], rate_hz: f64) -> f64 {
        let total: f64 = wave.iter().map(|value| value.norm_sqr()).sum();
        let moment = |power: i32, about: f64| {
            wave.iter()
                .enumerate()
                .map(|(i, value)| (i as f64 - about).powi(power) * value.norm_sqr())
                .sum::<f64>()
                / total
        };
        let mean = moment(1, 0.0);
        (2.0 * moment(2, mean)).sqrt() / rate_hz
    }

    #[test]
    fn a_wavelet_has_norm_mean_and_width() {
        let sd = 7.0 / (TAU * 8.0);
        let wavelet = morlet(8.0, sd, 1000.0);
        let norm: f64 = wavelet.iter().map(|v| v.norm_sqr()).sum();
        assert!((norm - 2.0).abs() < 1e-12);
        assert!(wavelet.iter().sum::<Complex<f64>>().norm() < 1e-4);
        // Cut at five standard deviations.
        assert!((smear_s(&wavelet, 1000.0) - sd).abs() < 1e-6 * sd);
        assert!(wavelet.len() % 2 == 1);
    }
}
