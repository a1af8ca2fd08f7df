//! Whole-signal Fourier transforms of real signals.

use num_complex::Complex;
use realfft::RealFftPlanner;

/// The n/2 + 1 bins of the real signal's transform, not scaled.
pub(crate) fn real_forward(x: &[f64]) -> Vec<Complex<f64>> {
    let plan = RealFftPlanner::new().plan_fft_forward(x.len());
    let mut input = x.to_vec();
    let mut output = plan.make_output_vec();
    // The only error is a wrong length, and both buffers have the plan's.
    let done = plan.process(&mut input, &mut output);
    debug_assert!(done.is_ok());
    output
}

/// The real signal of `n` samples with the given n/2 + 1 bins, scaled by 1/n. The imaginary parts of the
/// bins that must be real (0 Hz, and Nyquist for even n) are dropped.
pub(crate) fn real_inverse(mut bins: Vec<Complex<f64>>, n: usize) -> Vec<f64> {
    let plan = RealFftPlanner::new().plan_fft_inverse(n);
    bins.resize(n / 2 + 1, Complex::default());
    bins[0].im = 0.0;
    if n.is_multiple_of(2) {
        bins[n / 2].im = 0.0;
    }
    let mut output = plan.make_output_vec();
    let done = plan.process(&mut bins, &mut output);
    debug_assert!(done.is_ok());
    let scale = 1.0 / n as f64;
    for value in &mut output {
        *value *= scale;
    }
    output
}

/// The smallest even length from `n` up whose only prime factors are 2, 3 and 5: quick to transform.
pub(crate) fn fast_length(n: usize) -> usize {
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
            let back = real_inverse(real_forward(&x), n);
            assert!(
                x.iter().zip(&back).all(|(a, b)| (a - b).abs() < 1e-14),
                "{n}"
            );
        }
    }

    #[test]
    fn fast_lengths() {
        assert_eq!(
            [1, 7, 31, 97, 50_001].map(fast_length),
            [2, 8, 32, 100, 51_200]
        );
    }
}
