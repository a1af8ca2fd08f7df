//! Splits a response into the part explained by the intended drive and the residual.

use num_complex::Complex;

use super::crest::smoothed;

/// A response expressed as drive, in two parts: the intended drive times a gain, and the residual.
pub(super) struct ResponseSplit {
    explained_share: Vec<f64>,
    missing: Vec<Complex<f64>>,
}

/// Splits the lines `answered` (a response expressed as drive through the inverse) into the intended lines `meant` times a gain,
/// which is constant over `smooth` neighbours on either side, and a residual: a least-squares fit, as in H1.
pub(super) fn answers(
    meant: &[Complex<f64>],
    answered: &[Complex<f64>],
    smooth: usize,
) -> ResponseSplit {
    let both = || meant.iter().zip(answered).map(|(m, y)| m.conj() * y);
    let asked = smoothed(meant.iter().map(Complex::norm_sqr), smooth);
    let came = smoothed(answered.iter().map(Complex::norm_sqr), smooth);
    let real = smoothed(both().map(|both| both.re), smooth);
    let imaginary = smoothed(both().map(|both| both.im), smooth);
    let gains: Vec<Complex<f64>> = (0..asked.len())
        .map(|k| Complex::new(real[k], imaginary[k]) / asked[k].max(f64::MIN_POSITIVE))
        .collect();
    let powers = asked.iter().zip(&came);
    ResponseSplit {
        explained_share: gains
            .iter()
            .zip(powers)
            .map(|(gain, (asked, came))| {
                (gain.norm_sqr() * asked / came.max(f64::MIN_POSITIVE)).min(1.0)
            })
            .collect(),
        missing: gains
            .iter()
            .zip(meant.iter().zip(answered))
            .map(|(gain, (meant, answered))| {
                let norm = gain.norm().max(f64::MIN_POSITIVE);
                meant * gain / norm - answered
            })
            .collect(),
    }
}

impl ResponseSplit {
    /// The share of a line's power explained by the intended drive, 0–1.
    pub(super) fn explained_share(&self, line: usize) -> f64 {
        self.explained_share[line]
    }

    /// The missing part of a line, as drive: the intended magnitude at the phase of the response, minus the response.
    pub(super) fn missing(&self, line: usize) -> Complex<f64> {
        self.missing[line]
    }
}

/// The reliability of each of the lines `missing`, 0–1, when they scatter with the variance `spread`: the share of their power
/// left after subtracting it, averaged over `smooth` neighbours on either side.
pub(super) fn sure(missing: &[Complex<f64>], spread: &[f64], smooth: usize) -> Vec<f64> {
    let power = smoothed(missing.iter().map(Complex::norm_sqr), smooth);
    let spread = smoothed(spread.iter().copied(), smooth);
    let each = power.iter().zip(&spread);
    each.map(|(power, spread)| (1.0 - spread / power.max(f64::MIN_POSITIVE)).max(0.0))
        .collect()
}
