//! One input through several long impulse responses at once, sample by sample and without delay.

use std::sync::Arc;

use num_complex::Complex;
use piezotact_fourier::{ComplexToReal, RealPlanner, RealToComplex};

/// Sums that are kept side by side in a scalar product.
const LANES: usize = 8;

/// Impulse responses in parts of one block: the first as a sum, the others by transforms of what came in before the block.
/// All memory is allocated at the beginning.
///
/// Source: W. G. Gardner (1995), Efficient convolution without input-output delay, J. Audio Eng. Soc. 43, with parts of one size.
pub(crate) struct Partitions<const RESPONSES: usize> {
    block: usize,
    parts: usize,
    /// The first part of every response, last sample first.
    heads: [Vec<f64>; RESPONSES],
    /// The spectra of the other parts, one after the other.
    tails: [Vec<Complex<f64>>; RESPONSES],
    /// The spectra of the last `parts` pairs of blocks; the newest at `newest`.
    spectra: Vec<Complex<f64>>,
    newest: usize,
    /// The block before, and the one that fills.
    input: Vec<f64>,
    filled: usize,
    /// What the other parts add to the block that fills.
    owed: [Vec<f64>; RESPONSES],
    forward: Arc<dyn RealToComplex<f64>>,
    inverse: Arc<dyn ComplexToReal<f64>>,
    time: Vec<f64>,
    bins: Vec<Complex<f64>>,
    scratch: Vec<Complex<f64>>,
}

impl<const RESPONSES: usize> Partitions<RESPONSES> {
    /// The `impulses` in parts of `block` samples (1 at least).
    pub(crate) fn new(impulses: &[Vec<f64>; RESPONSES], block: usize) -> Self {
        let block = block.max(1);
        let longest = impulses.iter().map(Vec::len).max().unwrap_or(0);
        let parts = longest.div_ceil(block).saturating_sub(1);
        let mut planner = RealPlanner::new();
        let forward = planner.plan_fft_forward(2 * block);
        let inverse = planner.plan_fft_inverse(2 * block);
        let scratch = forward.get_scratch_len().max(inverse.get_scratch_len());
        let mut partitions = Self {
            block,
            parts,
            heads: impulses.each_ref().map(|impulse| {
                let head = (0..block).map(|i| impulse.get(i).copied().unwrap_or(0.0));
                head.rev().collect()
            }),
            tails: [(); RESPONSES].map(|()| Vec::new()),
            spectra: vec![Complex::default(); parts * (block + 1)],
            newest: 0,
            input: vec![0.0; 2 * block],
            filled: 0,
            owed: [(); RESPONSES].map(|()| vec![0.0; block]),
            time: forward.make_input_vec(),
            bins: forward.make_output_vec(),
            forward,
            inverse,
            scratch: vec![Complex::default(); scratch],
        };
        partitions.tails = impulses.each_ref().map(|impulse| {
            let parts = (1..=parts).flat_map(|part| {
                partitions.time.fill(0.0);
                let taps = impulse.iter().skip(part * block).take(block);
                for (time, tap) in partitions.time.iter_mut().zip(taps) {
                    *time = tap / (2 * block) as f64;
                }
                partitions.transform();
                partitions.bins.clone()
            });
            parts.collect()
        });
        partitions
    }

    /// What each response answers at the sample `value` of the input.
    pub(crate) fn next(&mut self, value: f64) -> [f64; RESPONSES] {
        let at = self.filled;
        self.input[self.block + at] = value;
        let window = &self.input[at + 1..=at + self.block];
        let mut answers = [0.0; RESPONSES];
        for ((answer, head), owed) in answers.iter_mut().zip(&self.heads).zip(&self.owed) {
            *answer = dot(head, window) + owed[at];
        }
        self.filled += 1;
        if self.filled == self.block {
            self.turn();
        }
        answers
    }

    /// A block is full: what all that came in adds to the next one.
    fn turn(&mut self) {
        self.filled = 0;
        let lines = self.block + 1;
        if self.parts > 0 {
            self.time.copy_from_slice(&self.input);
            self.transform();
            self.newest = (self.newest + self.parts - 1) % self.parts;
            self.spectra[self.newest * lines..][..lines].copy_from_slice(&self.bins);
            for (tail, owed) in self.tails.iter().zip(&mut self.owed) {
                self.bins.fill(Complex::default());
                // From the newest spectrum to the oldest, which goes round the end of the list.
                let (round, straight) = self.spectra.split_at(self.newest * lines);
                let (first, second) = tail.split_at(straight.len());
                add_products(&mut self.bins, straight, first);
                add_products(&mut self.bins, round, second);
                self.bins[0].im = 0.0;
                self.bins[self.block].im = 0.0;
                let done = self.inverse.process_with_scratch(
                    &mut self.bins,
                    &mut self.time,
                    &mut self.scratch,
                );
                debug_assert!(done.is_ok());
                owed.copy_from_slice(&self.time[self.block..]);
            }
        }
        self.input.copy_within(self.block.., 0);
    }

    /// The spectrum of `time`, in `bins`; `time` is used up.
    fn transform(&mut self) {
        let done =
            self.forward
                .process_with_scratch(&mut self.time, &mut self.bins, &mut self.scratch);
        debug_assert!(done.is_ok());
    }
}

impl<const RESPONSES: usize> std::fmt::Debug for Partitions<RESPONSES> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Partitions")
            .field("block", &self.block)
            .field("parts", &self.parts)
            .finish_non_exhaustive()
    }
}

/// Adds to `sums` the products of `spectra` and `tails`, line by line, for as many spectra as there are.
fn add_products(sums: &mut [Complex<f64>], spectra: &[Complex<f64>], tails: &[Complex<f64>]) {
    let lines = sums.len();
    for (spectrum, tail) in spectra.chunks_exact(lines).zip(tails.chunks_exact(lines)) {
        for ((sum, x), h) in sums.iter_mut().zip(spectrum).zip(tail) {
            *sum += x * h;
        }
    }
}

/// The sum of the products of two lists of one length.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; LANES];
    let (lanes_a, lanes_b) = (a.chunks_exact(LANES), b.chunks_exact(LANES));
    let rest = lanes_a.remainder().iter().zip(lanes_b.remainder());
    let rest: f64 = rest.map(|(a, b)| a * b).sum();
    for (a, b) in lanes_a.zip(lanes_b) {
        for ((sum, a), b) in sums.iter_mut().zip(a).zip(b) {
            *sum += a * b;
        }
    }
    sums.iter().sum::<f64>() + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wild(count: usize, pace: f64) -> Vec<f64> {
        (0..count).map(|i| ((i * i) as f64 * pace).sin()).collect()
    }

    /// The sum by definition, to the rounding of transforms of up to 128 samples, whatever the lengths are to a block.
    #[test]
    fn every_response_is_the_sum_by_definition() {
        let input = wild(1_500, 0.37);
        for block in [1, 2, 16, 64] {
            for taps in [0, 1, 15, 64, 65, 500] {
                let impulses = [wild(taps, 0.11), wild(taps / 2, 0.23)];
                let mut partitions = Partitions::new(&impulses, block);
                for (n, value) in input.iter().enumerate() {
                    let found = partitions.next(*value);
                    for (impulse, found) in impulses.iter().zip(found) {
                        let reach = impulse.len().min(n + 1);
                        let sum: f64 = (0..reach).map(|k| impulse[k] * input[n - k]).sum();
                        assert!(
                            (found - sum).abs() < 1e-11,
                            "block {block}, {taps} taps, sample {n}: {found} for {sum}"
                        );
                    }
                }
            }
        }
    }
}
