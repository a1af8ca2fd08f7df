//! Fourier transforms in double precision, compiled once.
//!
//! The transforms of `rustfft` are generic over the number: every crate that makes a planner of its own compiles all of them again.
//! The planners here are not generic, so that all crates use the code of this one, which is optimised in every profile.

use std::fmt;
use std::sync::Arc;

pub use realfft::{ComplexToReal, RealToComplex};
pub use rustfft::Fft;

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
