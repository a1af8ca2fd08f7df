//! A signal through an impulse response, block by block: what a device that is known by its transfer function answers.

mod block;

pub use block::{BlockConvolver, LONGEST_BLOCK, Partitions};

use std::collections::VecDeque;

use crate::fourier::{RealTransform, fast_length};

/// A signal of any length through a finite impulse response, fed as it comes: one output sample for every input sample,
/// at the rate of both. It holds one transform and one impulse response, however long the signal is.
///
/// Formula: y\[n\] = Σ h\[k\]·x\[n − k\], with the signal taken to be 0 before its first sample.
///
/// Source: overlap-add, Oppenheim and Schafer, *Discrete-Time Signal Processing*, 3rd ed., section 8.7.3.
///
/// ```
/// let mut echo = piezotact::convolve::Convolver::new(&[1.0, 0.0, 0.5]);
/// let mut heard = echo.feed(&[1.0, 0.0]);
/// heard.extend(echo.feed(&[0.0, 0.0]));
/// let error = |(a, b): (&f64, f64)| (a - b).abs();
/// assert!(heard.iter().zip([1.0, 0.0, 0.5, 0.0]).map(error).all(|e| e < 1e-15));
/// ```
#[derive(Clone, Debug)]
pub struct Convolver {
    taps: usize,
    /// Input samples that one transform takes.
    block: usize,
    bins: Vec<num_complex::Complex<f64>>,
    transform: RealTransform,
    /// What earlier input still adds to the output from the next sample on.
    owed: VecDeque<f64>,
}

impl Convolver {
    /// A plan for the impulse response `impulse`, in units of the output per unit of the input. An empty one answers
    /// with zeros.
    #[must_use]
    pub fn new(impulse: &[f64]) -> Self {
        let taps = impulse.len().max(1);
        // At least as much new as old in a transform, so that no more than half of it is wasted.
        let length = fast_length((2 * taps).max(4096));
        let mut transform = RealTransform::new(length);
        Self {
            taps,
            block: length + 1 - taps,
            bins: transform.forward(impulse),
            transform,
            owed: VecDeque::new(),
        }
    }

    /// What comes out while `input` goes in: as many samples, in the unit of the output.
    #[must_use]
    pub fn feed(&mut self, input: &[f64]) -> Vec<f64> {
        let mut output = Vec::with_capacity(input.len());
        for block in input.chunks(self.block) {
            let mut bins = self.transform.forward(block);
            for (bin, h) in bins.iter_mut().zip(&self.bins) {
                *bin *= h;
            }
            let answer = self.transform.inverse(bins);
            let reach = block.len() + self.taps - 1;
            if self.owed.len() < reach {
                self.owed.resize(reach, 0.0);
            }
            for (owed, new) in self.owed.iter_mut().zip(&answer[..reach]) {
                *owed += new;
            }
            output.extend(self.owed.drain(..block.len()));
        }
        output
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wild(count: usize) -> Vec<f64> {
        (0..count).map(|i| ((i * i) as f64 * 0.37).sin()).collect()
    }

    fn naive(impulse: &[f64], input: &[f64]) -> Vec<f64> {
        (0..input.len())
            .map(|n| {
                let reach = impulse.len().min(n + 1);
                (0..reach).map(|k| impulse[k] * input[n - k]).sum()
            })
            .collect()
    }

    /// Whatever the pieces, it is the sum by definition; the tolerance is the rounding of transforms of 4 096 samples.
    #[test]
    fn pieces_of_any_length_give_the_sum() {
        let input = wild(9_000);
        for taps in [1, 2, 100, 3_000] {
            let impulse = wild(taps);
            let expected = naive(&impulse, &input);
            for piece in [1, 7, 999, 9_000] {
                // A sample at a time costs a transform each.
                let until = if piece == 1 { 50 } else { input.len() };
                let mut convolver = Convolver::new(&impulse);
                let output: Vec<f64> = input[..until]
                    .chunks(piece)
                    .flat_map(|part| convolver.feed(part))
                    .collect();
                assert_eq!(output.len(), until);
                let worst = output
                    .iter()
                    .zip(&expected)
                    .map(|(a, b)| (a - b).abs())
                    .fold(0.0, f64::max);
                assert!(worst < 1e-10, "{taps} taps in {piece}: {worst:e}");
            }
        }
    }

    #[test]
    fn no_impulse_response_no_answer() {
        assert!(
            Convolver::new(&[])
                .feed(&wild(10))
                .iter()
                .all(|v| *v == 0.0)
        );
    }
}
