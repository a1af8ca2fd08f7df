//! Whole-signal Fourier transforms of real signals, and the planners for other uses.

use std::sync::Arc;

pub use num_complex::Complex;
pub use piezotact_fourier::{
    ComplexPlanner, ComplexToReal, Fft, RealPlanner, RealToComplex, fade, hann,
};

/// The transforms of real signals of one length. Each direction is planned at its first use, as the plan and the scratch memory of
/// a long signal are larger than the signal.
///
/// Source: [`piezotact_fourier`].
#[derive(Clone)]
pub struct RealTransform {
    length: usize,
    forward: Option<Arc<dyn RealToComplex<f64>>>,
    inverse: Option<Arc<dyn ComplexToReal<f64>>>,
    scratch: Vec<Complex<f64>>,
    input: Vec<f64>,
}

impl RealTransform {
    /// The transforms of signals of `length` samples.
    #[must_use]
    pub fn new(length: usize) -> Self {
        Self {
            length,
            forward: None,
            inverse: None,
            scratch: Vec::new(),
            input: Vec::new(),
        }
    }

    /// The number of samples.
    #[must_use]
    pub fn length(&self) -> usize {
        self.length
    }

    /// The n/2 + 1 bins of `x`, which is cut or filled with zeros to the length; not scaled.
    #[must_use]
    pub fn forward(&mut self, x: &[f64]) -> Vec<Complex<f64>> {
        self.forward_about(x, 0.0)
    }

    /// As [`Self::forward`], of `x` less `mean`.
    pub(crate) fn forward_about(&mut self, x: &[f64], mean: f64) -> Vec<Complex<f64>> {
        let length = self.length;
        let plan = (self.forward).get_or_insert_with(|| piezotact_fourier::real_forward(length));
        self.input.clear();
        let kept = x.iter().take(length).map(|value| value - mean);
        self.input.extend(kept);
        self.input.resize(length, 0.0);
        let needed = plan.get_scratch_len().max(self.scratch.len());
        self.scratch.resize(needed, Complex::default());
        let mut output = plan.make_output_vec();
        // The only error is a wrong length, and every buffer has the plan's.
        let done = plan.process_with_scratch(&mut self.input, &mut output, &mut self.scratch);
        debug_assert!(done.is_ok());
        output
    }

    /// The signal with the given n/2 + 1 bins, scaled by 1/n. The imaginary parts of the bins that must be
    /// real (0 Hz, and Nyquist for even n) are dropped.
    #[must_use]
    pub fn inverse(&mut self, mut bins: Vec<Complex<f64>>) -> Vec<f64> {
        let length = self.length;
        let plan = (self.inverse).get_or_insert_with(|| piezotact_fourier::real_inverse(length));
        bins.resize(length / 2 + 1, Complex::default());
        bins[0].im = 0.0;
        if length.is_multiple_of(2) {
            bins[length / 2].im = 0.0;
        }
        let needed = plan.get_scratch_len().max(self.scratch.len());
        self.scratch.resize(needed, Complex::default());
        let mut output = plan.make_output_vec();
        let done = plan.process_with_scratch(&mut bins, &mut output, &mut self.scratch);
        debug_assert!(done.is_ok());
        let scale = 1.0 / self.length as f64;
        for value in &mut output {
            *value *= scale;
        }
        output
    }
}

impl std::fmt::Debug for RealTransform {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("RealTransform")
            .field("length", &self.length)
            .finish_non_exhaustive()
    }
}

/// The phases, rad, of the minimum-phase signal of `length` samples (even) with the given length/2 + 1 magnitudes, all above
/// zero: the Hilbert transform of their logarithm, by folding the cepstrum.
pub(crate) fn minimum_phase(magnitudes: &[f64], length: usize) -> Vec<f64> {
    let mut transform = RealTransform::new(length);
    let logarithms = magnitudes.iter().map(|m| Complex::from(m.ln())).collect();
    let mut cepstrum = transform.inverse(logarithms);
    for (i, value) in cepstrum.iter_mut().enumerate() {
        *value *= match i {
            0 => 1.0,
            i if 2 * i < length => 2.0,
            i if 2 * i == length => 1.0,
            _ => 0.0,
        };
    }
    transform
        .forward(&cepstrum)
        .into_iter()
        .map(|bin| bin.im)
        .collect()
}

/// The smallest even length from `n` up whose only prime factors are 2, 3 and 5: quick to transform.
///
/// Source: J. W. Cooley and J. W. Tukey (1965), Math. Comput. 19(90).
#[must_use]
pub fn fast_length(n: usize) -> usize {
    let smooth = |mut m: usize| {
        for p in [2, 3, 5] {
            while m.is_multiple_of(p) {
                m /= p;
            }
        }
        m == 1
    };
    (n.max(2)..)
        .find(|&m| m.is_multiple_of(2) && smooth(m))
        .unwrap_or(n)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_and_back() {
        for n in [1, 2, 3, 7, 30, 49] {
            let x: Vec<f64> = (0..n).map(|i| ((i * i) as f64).sin()).collect();
            let mut transform = RealTransform::new(n);
            let bins = transform.forward(&x);
            let back = transform.inverse(bins);
            assert!(
                x.iter().zip(&back).all(|(a, b)| (a - b).abs() < 1e-14),
                "{n}"
            );
        }
    }

    /// 1 + 0.5·z⁻¹ has its zero inside the unit circle: it is its own minimum phase.
    #[test]
    fn a_minimum_phase_is_found_from_its_magnitude() {
        let n = 128;
        let h: Vec<Complex<f64>> = (0..=n / 2)
            .map(|k| 1.0 + Complex::from_polar(0.5, -std::f64::consts::TAU * k as f64 / n as f64))
            .collect();
        let magnitudes: Vec<f64> = h.iter().map(|h| h.norm()).collect();
        let phases = minimum_phase(&magnitudes, n);
        assert!(
            h.iter()
                .zip(phases)
                .all(|(h, phase)| (h.arg() - phase).abs() < 1e-12)
        );
    }

    #[test]
    fn fast_lengths() {
        assert_eq!(
            [1, 7, 31, 97, 50_001].map(fast_length),
            [2, 8, 32, 100, 51_200]
        );
    }
}
