//! Fourier transforms in double precision, compiled once.
//!
//! The transforms of `rustfft` are generic over the number: every crate that makes a planner of its own compiles all of them again.
//! The planners here are not generic, so that all crates use the code of this one, which is optimised in every profile.

mod segments;

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::fmt;
use std::sync::Arc;

pub use realfft::{ComplexToReal, RealToComplex};
pub use rustfft::Fft;
pub use segments::{
    CrossSum, Detrend, Folded, PowerSum, SegmentTransform, segments_in, split_power, sum,
};

/// The weight of the periodic Hann window at `place`, 0 at its begin, 1 at its end, dimensionless, 0–1.
///
/// Source: definition, ½ − ½·cos(2π·place).
#[must_use]
pub fn hann(place: f64) -> f64 {
    0.5 - 0.5 * (std::f64::consts::TAU * place).cos()
}

/// The gain of a raised-cosine fade of which `share` has passed, 0–1; 1 beyond its end.
///
/// Source: definition, ½ − ½·cos(π·share).
#[must_use]
pub fn fade(share: f64) -> f64 {
    0.5 - 0.5 * (std::f64::consts::PI * share.min(1.0)).cos()
}

/// Plans transforms of complex values; it keeps what its plans have in common.
pub struct ComplexPlanner(rustfft::FftPlanner<f64>);

impl ComplexPlanner {
    /// A planner without plans.
    pub fn new() -> Self {
        Self(rustfft::FftPlanner::new())
    }

    /// The transform of `length` values to as many bins, not scaled.
    pub fn plan_fft_forward(&mut self, length: usize) -> Arc<dyn Fft<f64>> {
        self.0.plan_fft_forward(length)
    }

    /// The transform of `length` bins to as many values, not scaled.
    pub fn plan_fft_inverse(&mut self, length: usize) -> Arc<dyn Fft<f64>> {
        self.0.plan_fft_inverse(length)
    }
}

/// Plans transforms of real values; it keeps what its plans have in common.
pub struct RealPlanner(realfft::RealFftPlanner<f64>);

impl RealPlanner {
    /// A planner without plans.
    pub fn new() -> Self {
        Self(realfft::RealFftPlanner::new())
    }

    /// The transform of `length` real values to `length`/2 + 1 bins, not scaled.
    pub fn plan_fft_forward(&mut self, length: usize) -> Arc<dyn RealToComplex<f64>> {
        self.0.plan_fft_forward(length)
    }

    /// The transform of `length`/2 + 1 bins to `length` real values, not scaled.
    pub fn plan_fft_inverse(&mut self, length: usize) -> Arc<dyn ComplexToReal<f64>> {
        self.0.plan_fft_inverse(length)
    }
}

/// The sum of the lengths whose plans a thread keeps, in each of the three kinds: about 16 MB.
const MOST_KEPT: usize = 1 << 19;

/// Plans by their length. Each is made alone, so that what it computes does not depend on the plans before it, to the last bit.
struct Kept<P: ?Sized> {
    plans: BTreeMap<usize, Arc<P>>,
    lengths: usize,
}

impl<P: ?Sized> Kept<P> {
    const fn new() -> Self {
        Self {
            plans: BTreeMap::new(),
            lengths: 0,
        }
    }

    /// The plan of `length`. Long ones are not kept; where too many are kept, all are dropped.
    fn get(&mut self, length: usize, made: impl FnOnce() -> Arc<P>) -> Arc<P> {
        if let Some(kept) = self.plans.get(&length) {
            return Arc::clone(kept);
        }
        let plan = made();
        if length <= MOST_KEPT / 4 {
            if self.lengths + length > MOST_KEPT {
                *self = Self::new();
            }
            self.lengths += length;
            self.plans.insert(length, Arc::clone(&plan));
        }
        plan
    }
}

thread_local! {
    static REAL: RefCell<Kept<dyn RealToComplex<f64>>> = const { RefCell::new(Kept::new()) };
    static BACK: RefCell<Kept<dyn ComplexToReal<f64>>> = const { RefCell::new(Kept::new()) };
    static COMPLEX: RefCell<Kept<dyn Fft<f64>>> = const { RefCell::new(Kept::new()) };
}

/// The transform of `length` real values to `length`/2 + 1 bins, not scaled. A thread keeps the plans that come again.
pub fn real_forward(length: usize) -> Arc<dyn RealToComplex<f64>> {
    let made = || RealPlanner::new().plan_fft_forward(length);
    REAL.with_borrow_mut(|kept| kept.get(length, made))
}

/// The transform of `length`/2 + 1 bins to `length` real values, not scaled. A thread keeps the plans that come again.
pub fn real_inverse(length: usize) -> Arc<dyn ComplexToReal<f64>> {
    let made = || RealPlanner::new().plan_fft_inverse(length);
    BACK.with_borrow_mut(|kept| kept.get(length, made))
}

/// The transform of `length` complex values to as many bins, not scaled. A thread keeps the plans that come again.
pub fn complex_forward(length: usize) -> Arc<dyn Fft<f64>> {
    let made = || ComplexPlanner::new().plan_fft_forward(length);
    COMPLEX.with_borrow_mut(|kept| kept.get(length, made))
}

impl Default for ComplexPlanner {
    fn default() -> Self {
        Self::new()
    }
}

impl Default for RealPlanner {
    fn default() -> Self {
        Self::new()
    }
}

impl fmt::Debug for ComplexPlanner {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("ComplexPlanner").finish_non_exhaustive()
    }
}

impl fmt::Debug for RealPlanner {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("RealPlanner").finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plan_that_comes_again_is_kept_and_the_memory_is_bounded() {
        assert!(Arc::ptr_eq(&real_forward(4_800), &real_forward(4_800)));
        assert!(Arc::ptr_eq(
            &complex_forward(2_048),
            &complex_forward(2_048)
        ));
        let long = MOST_KEPT / 2;
        assert!(!Arc::ptr_eq(&real_inverse(long), &real_inverse(long)));
        let mut kept: Kept<dyn RealToComplex<f64>> = Kept::new();
        for length in 1..2_000 {
            let _plan = kept.get(length, || RealPlanner::new().plan_fft_forward(length));
            assert!(kept.lengths <= MOST_KEPT);
        }
        assert!(kept.plans.len() < 1_999);
    }

    /// Also where another length was planned before, of which this one is a part.
    #[test]
    fn a_kept_plan_computes_what_one_made_alone_does() {
        let values = |n: usize| -> Vec<f64> { (0..n).map(|i| ((i * i) as f64).sin()).collect() };
        for n in [14_400, 1_237, 7_200, 2_048] {
            let (mut x, mut y) = (values(n), values(n));
            let (kept, alone) = (real_forward(n), RealPlanner::new().plan_fft_forward(n));
            let mut found = [kept.make_output_vec(), alone.make_output_vec()];
            assert!(kept.process(&mut x, &mut found[0]).is_ok());
            assert!(alone.process(&mut y, &mut found[1]).is_ok());
            assert!(found[0] == found[1], "{n}");
        }
    }
}
