//! Convolution in blocks of one length, for the callback of a sound device.

use crate::series::SeriesError;
use std::f64::consts::PI;
use std::sync::Arc;

use crate::fourier::{Complex, ComplexPlanner, Fft};

/// The longest block, samples: 1.4 s at 48 kHz.
pub const LONGEST_BLOCK: usize = 65_536;

/// Bins that are computed side by side.
const LANES: usize = 8;

/// Real parts and imaginary parts of [`LANES`] bins.
type Bins = [[f64; LANES]; 2];

/// Blocks whose sums are computed at a time.
const AHEAD: usize = 4;

/// Partitions from which it pays to compute ahead: fewer stay in the nearest cache with what they are multiplied with.
const FEWEST_AHEAD: usize = 16;

/// An impulse response as the spectra of its partitions, each as long as a block. It is made outside the callback.
#[derive(Clone)]
pub struct Partitions {
    block: usize,
    count: usize,
    /// The same bins of all partitions stand together, the first partition first, then zeros for what is ahead of the last
    /// one: [`Self::stride`] in all. Zeros follow the last bin.
    spectra: Vec<Bins>,
}

impl Partitions {
    /// The partitions of `impulse` (units of the output per unit of the input) for blocks of `block` samples; the last one is
    /// filled with zeros.
    ///
    /// Source: as [`BlockConvolver`].
    ///
    /// # Errors
    /// [`SeriesError::Block`] for a block of 0 or of more than [`LONGEST_BLOCK`] samples, [`SeriesError::NoImpulse`] for an
    /// empty impulse response, [`SeriesError::ImpulseNotFinite`] where a sample of it is no finite number.
    pub fn new(impulse: &[f64], block: usize) -> Result<Self, SeriesError> {
        if !(1..=LONGEST_BLOCK).contains(&block) {
            return Err(SeriesError::Block { found: block });
        }
        if impulse.is_empty() {
            return Err(SeriesError::NoImpulse);
        }
        if let Some(at) = impulse.iter().position(|tap| !tap.is_finite()) {
            let found = impulse[at];
            return Err(SeriesError::ImpulseNotFinite { at, found });
        }
        let count = impulse.len().div_ceil(block);
        let mut transform = Transform::new(block);
        let stride = Self::stride(count);
        let mut spectra = vec![Bins::default(); stride * block.div_ceil(LANES)];
        let (mut taps, silence) = (vec![0.0; block], vec![0.0; block]);
        for (at, part) in impulse.chunks(block).enumerate() {
            taps.fill(0.0);
            // The inverse is not scaled.
            for (tap, given) in taps.iter_mut().zip(part) {
                *tap = given / block as f64;
            }
            transform.forward(&taps, &silence);
            transform.store(&mut spectra, stride, at);
        }
        Ok(Self {
            block,
            count,
            spectra,
        })
    }

    fn stride(count: usize) -> usize {
        count + AHEAD - 1
    }

    /// Samples of a block.
    #[must_use]
    pub fn block(&self) -> usize {
        self.block
    }

    /// How many partitions there are.
    #[must_use]
    pub fn count(&self) -> usize {
        self.count
    }
}

impl std::fmt::Debug for Partitions {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Partitions")
            .field("block", &self.block)
            .field("count", &self.count)
            .finish_non_exhaustive()
    }
}

/// A signal through a finite impulse response in real time: blocks of one length go in, and each comes out at once, in
/// the unit of the output and at the rate of both. Nothing is added to the delay of the block itself. [`Self::process`]
/// and [`Self::change`] allocate and free nothing and take no lock, and every block costs the same (but the one after a change).
///
/// Formula: y\[n\] = Σ h\[k\]·x\[n − k\], with the signal taken to be 0 before its first sample. With X₀ the spectrum of the
/// last two blocks of B samples, X₁ that of the two that end a block earlier and so on, and Hₚ that of the taps pB to pB + B − 1,
/// the output is the second half of the inverse transform of Σ Xₚ·Hₚ. Spectra are taken at the odd multiples of
/// π/2B: those of 2B real samples are one complex transform of B values, (x\[n\] − i·x\[n + B\])·exp(−iπn/2B), and of the inverse
/// only the half that wraps around with the other sign is spoiled, which overlap-save leaves out in any case.
///
/// A sample that is no finite number spoils its own block and those that it reaches, and nothing after them.
///
/// Source: uniformly partitioned overlap-save with a delay line of spectra, F. Wefers, *Partitioned convolution algorithms for
/// real-time auralization* (Logos, 2015), chapter 5; the transform, R. Crandall and B. Fagin, Discrete weighted transforms and
/// large-integer arithmetic, *Math. Comp.* 62 (1994), right-angle convolution.
///
/// ```
/// use piezotact::convolve::{BlockConvolver, Partitions};
///
/// let echo = Partitions::new(&[1.0, 0.0, 0.5], 2)?;
/// let mut convolver = BlockConvolver::new(echo);
/// let mut output = [0.0; 2];
/// convolver.process(&[1.0, 0.0], &mut output)?;
/// assert!((output[0] - 1.0).abs() < 1e-15);
/// convolver.process(&[0.0, 0.0], &mut output)?;
/// assert!((output[0] - 0.5).abs() < 1e-15);
/// # Ok::<(), piezotact::series::SeriesError>(())
/// ```
#[derive(Clone)]
pub struct BlockConvolver {
    partitions: Partitions,
    /// Where the impulse response changes: what it was until the last block. Otherwise no longer used.
    before: Partitions,
    fade: Fade,
    transform: Transform,
    history: History,
    ahead: Ahead,
    last: Vec<f64>,
    faded: Vec<f64>,
    simd: pulp::Arch,
}

/// Spectra of the input, as many as there are partitions.
#[derive(Clone)]
struct History {
    /// The same bins of all of them stand together, as in [`Partitions::spectra`].
    spectra: Vec<Bins>,
    count: usize,
    /// Which of them is of the last block; the one before follows it, and the first follows the last.
    newest: usize,
}

impl History {
    /// Bins number `group`, the newest first, in two parts.
    #[inline(always)]
    fn of(&self, group: usize) -> [&[Bins]; 2] {
        let (older, newer) = self.spectra[group * self.count..][..self.count].split_at(self.newest);
        [newer, older]
    }
}

/// What the input so far adds to blocks to come. Reading all spectra from memory takes longer than multiplying them: one reading
/// serves several blocks. At each block it is the turn of as many bins, so that all blocks cost the same.
#[derive(Clone)]
struct Ahead {
    /// How many blocks are served at a time: [`AHEAD`], or 1.
    blocks: usize,
    /// Blocks so far, modulo `blocks`.
    turn: usize,
    /// Sums of the first bins for the block of their turn and those after it, then of the next bins.
    sums: Vec<[Bins; AHEAD]>,
    /// For the same bins, blocks since their turn; [`NEVER`] where the impulse response changed after it.
    since: Vec<usize>,
}

const NEVER: usize = usize::MAX;

impl Ahead {
    fn new(groups: usize, count: usize) -> Self {
        let ahead = groups.is_multiple_of(AHEAD) && count >= FEWEST_AHEAD;
        Self {
            blocks: if ahead { AHEAD } else { 1 },
            turn: 0,
            sums: vec![[Bins::default(); AHEAD]; groups],
            since: vec![NEVER; groups],
        }
    }
}

/// Whether the next block goes from one impulse response to another.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Fade {
    Done,
    Due,
}

impl BlockConvolver {
    /// A convolver with the impulse response `partitions`, before the first block.
    #[must_use]
    pub fn new(partitions: Partitions) -> Self {
        let (block, count) = (partitions.block, partitions.count);
        let groups = block.div_ceil(LANES);
        Self {
            before: partitions.clone(),
            fade: Fade::Done,
            transform: Transform::new(block),
            history: History {
                spectra: vec![Bins::default(); groups * count],
                count,
                newest: 0,
            },
            ahead: Ahead::new(groups, count),
            last: vec![0.0; block],
            faded: vec![0.0; block],
            simd: pulp::Arch::new(),
            partitions,
        }
    }

    /// Writes to `output`, in the unit of the output, the block that comes out while the block `input` goes in.
    ///
    /// Source: as [`BlockConvolver`].
    ///
    /// # Errors
    /// [`SeriesError::Lengths`] where `input` or `output` has not the length of the block; then nothing is done.
    pub fn process(&mut self, input: &[f64], output: &mut [f64]) -> Result<(), SeriesError> {
        let expected = self.partitions.block;
        for found in [input.len(), output.len()] {
            if found != expected {
                return Err(SeriesError::Lengths {
                    expected: [1, expected],
                    found: [1, found],
                });
            }
        }
        self.transform.forward(&self.last, input);
        self.last.copy_from_slice(input);
        let History {
            spectra,
            count,
            newest,
        } = &mut self.history;
        *newest = newest.checked_sub(1).unwrap_or(*count - 1);
        self.transform.store(spectra, *count, *newest);
        self.ahead.turn = (self.ahead.turn + 1) % self.ahead.blocks;
        self.simd.dispatch(Next {
            history: &self.history,
            partitions: &self.partitions,
            ahead: &mut self.ahead,
            sums: &mut self.transform.bins,
        });
        self.transform.inverse(output);
        if self.fade == Fade::Due {
            self.fade = Fade::Done;
            self.simd.dispatch(Products {
                history: &self.history,
                partitions: &self.before,
                sums: &mut self.transform.bins,
            });
            self.transform.inverse(&mut self.faded);
            let step = 1.0 / expected as f64;
            for ((i, new), old) in (1..).zip(output).zip(&self.faded) {
                *new = old + (*new - old) * (f64::from(i) * step);
            }
        }
        Ok(())
    }

    /// Changes the impulse response to `next`, which gets partitions that are no longer used, so that they can be freed
    /// elsewhere. The next block fades linearly from one to the other, and costs about twice as much as others.
    ///
    /// Source: Wefers (as [`BlockConvolver`]), exchange of filters by crossfading in the time domain.
    ///
    /// # Errors
    /// [`SeriesError::Lengths`] where `next` has another block or another number of partitions; then nothing is done.
    pub fn change(&mut self, next: &mut Partitions) -> Result<(), SeriesError> {
        let own = &self.partitions;
        if (own.block, own.count) != (next.block, next.count) {
            return Err(SeriesError::Lengths {
                expected: [own.count, own.block],
                found: [next.count, next.block],
            });
        }
        // Of two changes before one block the first was never played.
        if self.fade == Fade::Done {
            std::mem::swap(&mut self.before, &mut self.partitions);
            self.fade = Fade::Due;
        }
        std::mem::swap(&mut self.partitions, next);
        self.ahead.since.fill(NEVER);
        Ok(())
    }
}

impl std::fmt::Debug for BlockConvolver {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("BlockConvolver")
            .field("partitions", &self.partitions)
            .field("fade", &self.fade)
            .finish_non_exhaustive()
    }
}

/// The sums of a block, those that were computed before it among them, with the widest instructions that the machine has.
struct Next<'a> {
    history: &'a History,
    partitions: &'a Partitions,
    ahead: &'a mut Ahead,
    sums: &'a mut [Bins],
}

impl pulp::WithSimd for Next<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, simd: S) {
        let Ahead {
            blocks,
            turn,
            sums: ahead,
            since,
        } = self.ahead;
        let spectra =
            (self.partitions.spectra).chunks_exact(Partitions::stride(self.history.count));
        let states = ahead.iter_mut().zip(since);
        for (group, ((sum, spectra), (ahead, since))) in
            self.sums.iter_mut().zip(spectra).zip(states).enumerate()
        {
            let inputs = self.history.of(group);
            if *blocks == 1 || (*since == NEVER && group % *blocks != *turn) {
                products(simd, inputs, spectra, sum);
            } else if group % *blocks == *turn {
                products_ahead(simd, inputs, spectra, ahead);
                (*sum, *since) = (ahead[0], 0);
            } else {
                *since += 1;
                // The blocks that came after those sums were computed.
                let [newer, older] = inputs;
                let newer = &newer[..newer.len().min(*since)];
                let older = &older[..*since - newer.len()];
                products(simd, [newer, older], spectra, sum);
                for (sum, ahead) in sum.iter_mut().zip(&ahead[*since]) {
                    for (sum, ahead) in sum.iter_mut().zip(ahead) {
                        *sum += ahead;
                    }
                }
            }
        }
    }
}

/// The sums of a block from all of its input.
struct Products<'a> {
    history: &'a History,
    partitions: &'a Partitions,
    sums: &'a mut [Bins],
}

impl pulp::WithSimd for Products<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, simd: S) {
        let spectra =
            (self.partitions.spectra).chunks_exact(Partitions::stride(self.history.count));
        for (group, (sum, spectra)) in self.sums.iter_mut().zip(spectra).enumerate() {
            products(simd, self.history.of(group), spectra, sum);
        }
    }
}

/// Σ Xₚ·Hₚ over all `inputs`.
#[inline(always)]
fn products<S: pulp::Simd>(simd: S, inputs: [&[Bins]; 2], spectra: &[Bins], sum: &mut Bins) {
    // The registers that hold the lanes: one with AVX-512, two with AVX2.
    let registers = LANES / S::F64_LANES;
    // Products of real and imaginary parts apart, so that no sum waits for another.
    let mut apart = [[simd.splat_f64s(0.0); LANES]; 4];
    let (first, rest) = spectra.split_at(inputs[0].len());
    for (inputs, spectra) in inputs.into_iter().zip([first, rest]) {
        for (x, h) in inputs.iter().zip(spectra) {
            let [xr, xi] = [S::as_simd_f64s(&x[0]).0, S::as_simd_f64s(&x[1]).0];
            let [hr, hi] = [S::as_simd_f64s(&h[0]).0, S::as_simd_f64s(&h[1]).0];
            for i in 0..registers {
                apart[0][i] = simd.mul_add_f64s(xr[i], hr[i], apart[0][i]);
                apart[1][i] = simd.mul_add_f64s(xi[i], hi[i], apart[1][i]);
                apart[2][i] = simd.mul_add_f64s(xr[i], hi[i], apart[2][i]);
                apart[3][i] = simd.mul_add_f64s(xi[i], hr[i], apart[3][i]);
            }
        }
    }
    let [re, im] = sum;
    let [re, im] = [S::as_mut_simd_f64s(re).0, S::as_mut_simd_f64s(im).0];
    for i in 0..registers {
        re[i] = simd.sub_f64s(apart[0][i], apart[1][i]);
        im[i] = simd.add_f64s(apart[2][i], apart[3][i]);
    }
}

/// Σ Xₚ·Hₚ₊ⱼ for j from 0: what all `inputs` add to this block and to those after it.
#[inline(always)]
fn products_ahead<S: pulp::Simd>(
    simd: S,
    inputs: [&[Bins]; 2],
    spectra: &[Bins],
    ahead: &mut [Bins; AHEAD],
) {
    let (first, rest) = (spectra, &spectra[inputs[0].len()..]);
    for i in 0..LANES / S::F64_LANES {
        let (mut re, mut im) = ([simd.splat_f64s(0.0); AHEAD], [simd.splat_f64s(0.0); AHEAD]);
        for (inputs, spectra) in inputs.into_iter().zip([first, rest]) {
            for (x, h) in inputs.iter().zip(spectra.windows(AHEAD)) {
                let [xr, xi] = [S::as_simd_f64s(&x[0]).0[i], S::as_simd_f64s(&x[1]).0[i]];
                let minus_xi = simd.neg_f64s(xi);
                for j in 0..AHEAD {
                    let [hr, hi] = [
                        S::as_simd_f64s(&h[j][0]).0[i],
                        S::as_simd_f64s(&h[j][1]).0[i],
                    ];
                    re[j] = simd.mul_add_f64s(xr, hr, re[j]);
                    im[j] = simd.mul_add_f64s(xr, hi, im[j]);
                    re[j] = simd.mul_add_f64s(minus_xi, hi, re[j]);
                    im[j] = simd.mul_add_f64s(xi, hr, im[j]);
                }
            }
        }
        for (j, [to_re, to_im]) in ahead.iter_mut().enumerate() {
            S::as_mut_simd_f64s(to_re).0[i] = re[j];
            S::as_mut_simd_f64s(to_im).0[i] = im[j];
        }
    }
}

/// The transform of two blocks at the odd multiples of π/2B, and back to the second of them, not scaled.
#[derive(Clone)]
struct Transform {
    forward: Arc<dyn Fft<f64>>,
    inverse: Arc<dyn Fft<f64>>,
    /// exp(−iπn/2B).
    twist: Vec<Complex<f64>>,
    values: Vec<Complex<f64>>,
    scratch: Vec<Complex<f64>>,
    /// The bins that the inverse is of.
    bins: Vec<Bins>,
    simd: pulp::Arch,
}

impl Transform {
    fn new(block: usize) -> Self {
        let mut planner = ComplexPlanner::new();
        let forward = planner.plan_fft_forward(block);
        let inverse = planner.plan_fft_inverse(block);
        let scratch = (forward.get_inplace_scratch_len()).max(inverse.get_inplace_scratch_len());
        let angle = |n| -PI * n as f64 / (2 * block) as f64;
        Self {
            twist: (0..block)
                .map(|n| Complex::from_polar(1.0, angle(n)))
                .collect(),
            values: vec![Complex::default(); block],
            scratch: vec![Complex::default(); scratch],
            bins: vec![Bins::default(); block.div_ceil(LANES)],
            simd: pulp::Arch::new(),
            forward,
            inverse,
        }
    }

    /// The spectrum of `first` and the block `second` after it.
    fn forward(&mut self, first: &[f64], second: &[f64]) {
        let values = &mut self.values;
        let samples = first.iter().zip(second).zip(&self.twist);
        self.simd.dispatch(
            #[inline(always)]
            || {
                for (value, ((first, second), twist)) in values.iter_mut().zip(samples) {
                    *value = Complex::new(*first, -second) * twist;
                }
            },
        );
        (self.forward).process_with_scratch(&mut self.values, &mut self.scratch);
    }

    /// Keeps the spectrum as number `at` of `count`.
    fn store(&self, spectra: &mut [Bins], count: usize, at: usize) {
        let places = spectra.chunks_exact_mut(count);
        self.simd.dispatch(
            #[inline(always)]
            || {
                for (place, values) in places.zip(self.values.chunks(LANES)) {
                    let [re, im] = &mut place[at];
                    for ((re, im), value) in re.iter_mut().zip(im).zip(values) {
                        (*re, *im) = (value.re, value.im);
                    }
                }
            },
        );
    }

    /// The second block of what has the spectrum in `bins`.
    fn inverse(&mut self, output: &mut [f64]) {
        let (values, bins) = (self.values.chunks_mut(LANES), &self.bins);
        self.simd.dispatch(
            #[inline(always)]
            || {
                for (values, [re, im]) in values.zip(bins) {
                    for (value, (re, im)) in values.iter_mut().zip(re.iter().zip(im)) {
                        *value = Complex::new(*re, *im);
                    }
                }
            },
        );
        (self.inverse).process_with_scratch(&mut self.values, &mut self.scratch);
        let values = self.values.iter().zip(&self.twist);
        self.simd.dispatch(
            #[inline(always)]
            || {
                for (out, (value, twist)) in output.iter_mut().zip(values) {
                    *out = -(value * twist.conj()).im;
                }
            },
        );
    }
}

#[cfg(test)]
mod tests;
