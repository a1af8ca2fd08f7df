//! What of a response was meant.

use num_complex::Complex;

use super::crest::smoothed;

/// A response, brought to the drive, in two parts: what was meant, times a gain, and the rest.
pub(super) struct Answers {
    meant_share: Vec<f64>,
    missing: Vec<Complex<f64>>,
}

/// The lines `answered`, a response brought to the drive by the inverse, as those that were `meant` times a gain that is the
/// same within `smooth` neighbours on either side, and a rest: the least-squares fit, as in H1.
pub(super) fn answers(meant: &[Complex<f64>], answered: &[Complex<f64>], smooth: usize) -> Answers {
    let both = || meant.iter().zip(answered).map(|(m, y)| m.conj() * y);
    let asked = smoothed(meant.iter().map(Complex::norm_sqr), smooth);
    let came = smoothed(answered.iter().map(Complex::norm_sqr), smooth);
    let real = smoothed(both().map(|both| both.re), smooth);
    let imaginary = smoothed(both().map(|both| both.im), smooth);
    let gains: Vec<Complex<f64>> = (0..asked.len())
        .map(|k| Complex::new(real[k], imaginary[k]) / asked[k].max(f64::MIN_POSITIVE))
        .collect();
    let powers = asked.iter().zip(&came);
    Answers {
        meant_share: gains
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

impl Answers {
    /// The share of a line's power that was meant, 0–1.
    pub(super) fn meant_share(&self, line: usize) -> f64 {
        self.meant_share[line]
    }

    /// What is missing of a line for it to be what was meant, with the phase in which it came: as drive.
    pub(super) fn missing(&self, line: usize) -> Complex<f64> {
        self.missing[line]
    }
}

/// How far each of the lines `missing` is to be believed, 0–1, when they scatter with the variance `spread`: what is left of
/// their power without it, averaged over `smooth` neighbours on either side.
pub(super) fn sure(missing: &[Complex<f64>], spread: &[f64], smooth: usize) -> Vec<f64> {
    let power = smoothed(missing.iter().map(Complex::norm_sqr), smooth);
    let spread = smoothed(spread.iter().copied(), smooth);
    let each = power.iter().zip(&spread);
    each.map(|(power, spread)| (1.0 - spread / power.max(f64::MIN_POSITIVE)).max(0.0))
        .collect()
}
