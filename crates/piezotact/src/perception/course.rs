//! The slow course of a level or a pitch over a vibration: coefficients of a cosine transform, and how much of them is chance.

use std::f64::consts::{PI, SQRT_2};

/// The coefficients that are compared.
pub(super) const SLOW: usize = 6;
/// Those from which the part of chance is estimated come behind them.
pub(super) const ALL: usize = 30;
/// Of these, so many of the smallest count: lines of a periodic course are among the others.
const SMALLEST: usize = 18;
/// The mean of the 18 smallest of 24 squares of normal deviates.
const SMALLEST_MEAN: f64 = 0.3962;
/// Coefficients in which a slow change of an excerpt shows.
const WANDERING: usize = 4;
/// Points at which the difference of two courses is evaluated.
const POINTS: usize = 64;

/// The coefficients 1–30 of `values`, in their unit: their squares sum to the variance.
pub(super) fn coefficients(values: &[f64]) -> [f64; ALL] {
    let n = values.len();
    let mut sums = [0.0; ALL];
    for (i, value) in values.iter().enumerate() {
        let c = (PI * (i as f64 + 0.5) / n as f64).cos();
        let (mut before, mut now) = (1.0, c);
        for sum in &mut sums {
            *sum += value * now;
            (before, now) = (now, 2.0 * c * now - before);
        }
    }
    sums.map(|sum| SQRT_2 * sum / n.max(1) as f64)
}

/// The variance of one coefficient of chance, from those behind the slow ones.
pub(super) fn chance(coefficients: &[f64; ALL]) -> f64 {
    let mut squares: Vec<f64> = coefficients[SLOW..].iter().map(|c| c * c).collect();
    squares.sort_by(f64::total_cmp);
    squares[..SMALLEST].iter().sum::<f64>() / SMALLEST as f64 / SMALLEST_MEAN
}

/// The variance of the mean of an excerpt: what wanders slowly shows in the first coefficients.
pub(super) fn wandering(coefficients: &[f64; ALL]) -> f64 {
    let slow = &coefficients[..WANDERING];
    chance(coefficients).max(slow.iter().map(|c| c * c).sum::<f64>() / WANDERING as f64)
}

/// `values` less their mean.
pub(super) fn about_mean(values: &[f64]) -> Vec<f64> {
    let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
    values.iter().map(|v| v - mean).collect()
}

/// How coefficients are weighted by the blur of perceived time over `length_s`: as squares.
pub(super) fn blur(length_s: f64, tau_s: f64) -> [f64; SLOW] {
    std::array::from_fn(|i| {
        let turn = PI * (i + 1) as f64 / length_s * tau_s;
        (1.0 + turn * turn).powi(-2)
    })
}

/// The size of the difference `delta` of two courses, where the squares `noise` of each coefficient are chance: the mean of the
/// `power`-th power over the course, of as many coefficients as make most of it.
pub(super) fn size(delta: &[f64; SLOW], noise: &[f64; SLOW], times: f64, power: f64) -> f64 {
    let (mut own, mut chance, mut best) = (0.0, 0.0, 0.0f64);
    let mut wave = [0.0; POINTS];
    for k in 0..SLOW {
        own += delta[k] * delta[k];
        chance += times * noise[k];
        for (i, value) in wave.iter_mut().enumerate() {
            let place = (i as f64 + 0.5) / POINTS as f64;
            *value += delta[k] * SQRT_2 * (PI * (k + 1) as f64 * place).cos();
        }
        if own > chance {
            let mean = wave.iter().map(|v| v.abs().powf(power)).sum::<f64>() / POINTS as f64;
            best = best.max((1.0 - chance / own).sqrt() * mean.powf(1.0 / power));
        }
    }
    best
}
