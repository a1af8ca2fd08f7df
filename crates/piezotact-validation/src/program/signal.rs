//! Signal processing of the benchmark, independent of the code under test: whole-signal transforms, random draws, interpolation.

use std::cell::RefCell;
use std::f64::consts::{PI, TAU};

use num_complex::Complex;
use piezotact::manipulate::DrawnPhases;
use piezotact_fourier::RealPlanner;

/// The rate of every signal here, Hz.
pub(super) const RATE_HZ: f64 = 5_000.0;

/// A seeded stream of random numbers, `ChaCha8` behind [`DrawnPhases::drawn`].
pub(super) struct Draws {
    key: u64,
    block: u64,
    turns: Vec<f64>,
}

impl Draws {
    /// The stream `name` under `seed`.
    pub(super) fn of(seed: u64, name: &str) -> Self {
        // FNV-1a.
        let key = name
            .bytes()
            .chain(seed.to_le_bytes())
            .fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
                (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
            });
        Self {
            key,
            block: 0,
            turns: Vec::new(),
        }
    }

    /// Evenly from 0 up to, not including, 1.
    pub(super) fn uniform(&mut self) -> f64 {
        if let Some(turn) = self.turns.pop() {
            return turn;
        }
        self.turns = DrawnPhases::drawn(self.key.wrapping_add(self.block), 4_096).turns;
        self.block += 1;
        self.uniform()
    }

    /// Evenly between `low` and `high`.
    pub(super) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.uniform()
    }

    /// Of the standard normal distribution (Box and Muller 1958).
    pub(super) fn normal(&mut self) -> f64 {
        let radius = (-2.0 * (1.0 - self.uniform()).ln()).sqrt();
        radius * (TAU * self.uniform()).cos()
    }

    /// White noise of variance 1.
    pub(super) fn white(&mut self, samples: usize) -> Vec<f64> {
        (0..samples).map(|_| self.normal()).collect()
    }
}

thread_local! {
    /// It keeps the plans that it made.
    static PLANNER: RefCell<RealPlanner> = RefCell::new(RealPlanner::new());
}

/// The bins of `x` filled with zeros to `length`, not scaled.
pub(super) fn bins_of(x: &[f64], length: usize) -> Vec<Complex<f64>> {
    let plan = PLANNER.with_borrow_mut(|planner| planner.plan_fft_forward(length));
    let mut input = x.to_vec();
    input.resize(length, 0.0);
    let mut bins = plan.make_output_vec();
    let done = plan.process(&mut input, &mut bins);
    debug_assert!(done.is_ok());
    bins
}

/// The signal of `length` samples that has these bins.
pub(super) fn signal_of(mut bins: Vec<Complex<f64>>, length: usize) -> Vec<f64> {
    let plan = PLANNER.with_borrow_mut(|planner| planner.plan_fft_inverse(length));
    bins.resize(length / 2 + 1, Complex::default());
    bins[0].im = 0.0;
    if length.is_multiple_of(2) {
        bins[length / 2].im = 0.0;
    }
    let mut samples = plan.make_output_vec();
    let done = plan.process(&mut bins, &mut samples);
    debug_assert!(done.is_ok());
    samples.iter().map(|v| v / length as f64).collect()
}

/// The frequency of bin `k` of `length`, Hz.
pub(super) fn hz_of(k: usize, length: usize) -> f64 {
    k as f64 * RATE_HZ / length as f64
}

/// `x` through the response `h` of frequency in Hz; as much silence behind it, so that what leaves one end does not come in at
/// the other.
pub(super) fn filtered(x: &[f64], h: impl Fn(f64) -> Complex<f64>) -> Vec<f64> {
    let length = 2 * x.len();
    let mut bins = bins_of(x, length);
    for (k, bin) in bins.iter_mut().enumerate() {
        *bin *= h(hz_of(k, length));
    }
    let mut samples = signal_of(bins, length);
    samples.truncate(x.len());
    samples
}

/// `x` through gains without phase.
pub(super) fn shaped(x: &[f64], gain: impl Fn(f64) -> f64) -> Vec<f64> {
    filtered(x, |hz| Complex::from(gain(hz)))
}

/// The samples on either side that an interpolation looks at.
const REACH: i64 = 24;

/// `x` at the times `at`, in samples, by a sinc in a raised-cosine window: exact to 1e-4 of what lies below 1200 Hz.
pub(super) fn at_times(x: &[f64], at: impl Iterator<Item = f64>) -> Vec<f64> {
    at.map(|place| {
        let whole = place.floor();
        let share = place - whole;
        let i = whole as i64;
        if share < 1e-12 {
            return usize::try_from(i)
                .ok()
                .and_then(|i| x.get(i))
                .copied()
                .unwrap_or(0.0);
        }
        // The sine of every tap's distance is the same but for its sign.
        let sine = (PI * share).sin();
        (1 - REACH..=REACH)
            .filter_map(|j| {
                let sample = usize::try_from(i + j).ok().and_then(|k| x.get(k))?;
                let away = j as f64 - share;
                let window = 0.5 + 0.5 * (PI * away / (REACH as f64 + 1.0)).cos();
                let sign = if j.rem_euclid(2) == 0 { -1.0 } else { 1.0 };
                Some(sample * window * sign * sine / (PI * away))
            })
            .sum()
    })
    .collect()
}

/// `x` later by `samples`.
pub(super) fn delayed(x: &[f64], samples: f64) -> Vec<f64> {
    at_times(x, (0..x.len()).map(|i| i as f64 - samples))
}

/// The sum of squares.
pub(super) fn energy(x: &[f64]) -> f64 {
    x.iter().map(|v| v * v).sum()
}

/// 10·log10, not below −120 dB.
pub(super) fn decibels(power_ratio: f64) -> f64 {
    10.0 * power_ratio.max(1e-12).log10()
}

/// The amplitude ratio of a level.
pub(super) fn amplitude(db: f64) -> f64 {
    10f64.powf(db / 20.0)
}

/// Levels in windows of `window` samples, `hop` apart, as mean squares.
pub(super) fn short_time(x: &[f64], window: usize, hop: usize) -> Vec<f64> {
    (0..)
        .map(|i| i * hop)
        .take_while(|from| from + window <= x.len())
        .map(|from| energy(&x[from..from + window]) / window as f64)
        .collect()
}
