//! Drives made to fit: less peaked, and where that is not enough, softer where they cost most.

use num_complex::Complex;

use crate::fourier::RealTransform;
use crate::series::{peak, rms};

/// Rounds of clipping and filtering.
const ROUNDS: usize = 24;
/// What clipping and filtering may take from the level, dB.
const LOST_DB: f64 = 0.3;
/// Lines over which the cost of a line is averaged on either side.
const SMOOTH: usize = 40;
/// Halvings between too weak and too strong.
const HALVINGS: usize = 18;

/// A drive that fits, and the share that is left of every line, 0–1; 1 where nothing had to be taken.
pub(super) struct Fitted {
    pub(super) samples: Vec<f64>,
    pub(super) shares: Vec<f64>,
}

/// The drive with the lines `bins`, within ±`room`: its crests are pressed down as far as costs next to nothing of its
/// level, and what still does not fit is turned down by 1/(1 + λ·cost), the cost being a line's own power.
///
/// Clipping and filtering: J. Armstrong (2002), Electronics Letters 38(5), repeated.
pub(super) fn fitted(transform: &mut RealTransform, bins: &[Complex<f64>], room: f64) -> Fitted {
    let samples = transform.inverse(bins.to_vec());
    if peak(&samples) <= room {
        return Fitted {
            samples,
            shares: vec![1.0; bins.len()],
        };
    }
    if let Some(samples) = pressed(transform, bins, samples, room) {
        return Fitted {
            samples,
            shares: vec![1.0; bins.len()],
        };
    }
    let cost = costs(bins);
    let (mut weak, mut strong) = (-4.0f64, 6.0f64);
    let mut best = None;
    for _ in 0..HALVINGS {
        let middle = 0.5 * (weak + strong);
        let strength = 10f64.powf(middle);
        let shares: Vec<f64> = cost
            .iter()
            .map(|cost| 1.0 / (1.0 + strength * cost))
            .collect();
        let turned: Vec<Complex<f64>> = bins
            .iter()
            .zip(&shares)
            .map(|(bin, share)| bin * *share)
            .collect();
        let samples = transform.inverse(turned.clone());
        match pressed(transform, &turned, samples, room) {
            Some(samples) => {
                strong = middle;
                best = Some(Fitted { samples, shares });
            }
            None => weak = middle,
        }
    }
    best.unwrap_or_else(|| {
        // Nothing in the range fits: everything is turned down alike.
        let samples = transform.inverse(bins.to_vec());
        let share = room / peak(&samples);
        Fitted {
            samples: samples.iter().map(|x| x * share).collect(),
            shares: vec![share; bins.len()],
        }
    })
}

/// `samples` with their crests pressed down to `room`; `None` when that costs more of their level than it may.
fn pressed(
    transform: &mut RealTransform,
    bins: &[Complex<f64>],
    mut samples: Vec<f64>,
    room: f64,
) -> Option<Vec<f64>> {
    let level = rms(&samples);
    for _ in 0..ROUNDS {
        if peak(&samples) <= room {
            break;
        }
        for sample in &mut samples {
            *sample = sample.clamp(-0.97 * room, 0.97 * room);
        }
        // What clipping adds outside of the lines that are driven is taken away again.
        let mut lines = transform.forward(&samples);
        for (line, bin) in lines.iter_mut().zip(bins) {
            if bin.norm_sqr() <= 0.0 {
                *line = Complex::default();
            }
        }
        samples = transform.inverse(lines);
    }
    let lost_db = 20.0 * (level / rms(&samples).max(f64::MIN_POSITIVE)).log10();
    (peak(&samples) <= room && lost_db <= LOST_DB).then_some(samples)
}

/// The power of every line, averaged over its neighbours, re the median of the driven ones.
fn costs(bins: &[Complex<f64>]) -> Vec<f64> {
    let mut sums = vec![0.0; bins.len() + 1];
    for (k, bin) in bins.iter().enumerate() {
        sums[k + 1] = sums[k] + bin.norm_sqr();
    }
    let mut cost: Vec<f64> = (0..bins.len())
        .map(|k| {
            let (from, to) = (k.saturating_sub(SMOOTH), (k + SMOOTH + 1).min(bins.len()));
            (sums[to] - sums[from]) / (to - from) as f64
        })
        .collect();
    let mut driven: Vec<f64> = cost.iter().copied().filter(|c| *c > 0.0).collect();
    driven.sort_by(f64::total_cmp);
    let median = driven.get(driven.len() / 2).copied().unwrap_or(1.0);
    for value in &mut cost {
        *value /= median;
    }
    cost
}
