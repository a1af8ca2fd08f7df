//! Whether something clipped on the way from the drive to the sensor.

use crate::doubt::Doubt;
use crate::quantity::{Drive, Quantity};
use crate::render::Headroom;
use crate::series::Series;

/// How much of a measurement stood at a limit.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Clipping {
    /// The largest of the shares found, 0–1.
    pub fraction: f64,
    /// One for each place where something clipped.
    pub doubts: Vec<Doubt>,
}

/// What clipped while `response` was measured, at the rate it was acquired with: the sensor (flat tops), the
/// drive that was played beside it (beyond the limit, full scale = 1), and the drive as it was rendered.
///
/// Source: [`flat_top_fraction`]; [`crate::render::headroom`].
#[must_use]
pub fn clipping<Q: Quantity>(
    response: &Series<Q>,
    drive: Option<(&Series<Drive>, f64)>,
    rendered: Option<&Headroom>,
) -> Clipping {
    let played = drive.map_or(0.0, |(drive, limit)| {
        let beyond = drive
            .samples()
            .iter()
            .filter(|sample| sample.abs() > limit)
            .count();
        beyond as f64 / drive.samples().len() as f64
    });
    let device = rendered
        .map_or(0.0, |headroom| headroom.clipped_fraction)
        .max(played);
    let sensor = flat_top_fraction(response.samples());
    let found = [
        (sensor, format!("the measured {}", Q::NAME)),
        (device, "the drive that was played".into()),
    ];
    Clipping {
        fraction: sensor.max(device),
        doubts: found
            .into_iter()
            .filter(|(fraction, _)| *fraction > 0.0)
            .map(|(fraction, what)| Doubt::Clipped { what, fraction })
            .collect(),
    }
}

/// The share of samples that stand in runs of three or more at the same extreme value, as a clipping sensor
/// leaves them, 0–1. Fewer than three such runs are the crests of a slow signal; more samples that hold still
/// elsewhere, or no more than eight values at all, are the steps of a coarse converter: 0. Silence counts as one crest.
///
/// Source: three equal neighbours at the extreme do not happen again and again unless something limits.
#[must_use]
pub fn flat_top_fraction(samples: &[f64]) -> f64 {
    // Three runs of three hold six pairs of equal neighbours: fewer are no clipping, and most signals end here.
    if equal_neighbours(samples) < 6 {
        return 0.0;
    }
    let low = samples.iter().copied().fold(f64::MAX, f64::min);
    let high = samples.iter().copied().fold(f64::MIN, f64::max);
    if low >= high {
        return 0.0;
    }
    let held = || samples.chunk_by(|a, b| a == b).filter(|run| run.len() >= 3);
    let is_limit = |run: &&[f64]| run[0] <= low || run[0] >= high;
    let (mut runs, mut at_limit, mut longest) = (0, 0, 0);
    for run in held().filter(is_limit) {
        runs += 1;
        at_limit += run.len();
        longest = longest.max(run.len());
    }
    // Steps of a coarse converter hold still everywhere, not only at the limit; silence holds still once, and counts as no
    // longer than a crest.
    let elsewhere: usize = held()
        .filter(|run| !is_limit(run))
        .map(|run| run.len().min(longest))
        .sum();
    if runs < 3 || elsewhere > at_limit || !takes_more_than(FEW_STEPS, samples) {
        0.0
    } else {
        at_limit as f64 / samples.len() as f64
    }
}

/// A signal of no more steps than these of a converter stands at its limits without having been clipped.
const FEW_STEPS: usize = 8;

/// Whether `samples` take more than `count` values.
fn takes_more_than(count: usize, samples: &[f64]) -> bool {
    let mut seen: Vec<f64> = Vec::with_capacity(count + 1);
    samples.iter().any(|sample| {
        if !seen.contains(sample) {
            seen.push(*sample);
        }
        seen.len() > count
    })
}

/// How many samples equal the one before.
fn equal_neighbours(samples: &[f64]) -> u64 {
    pulp::Arch::new().dispatch(
        #[inline(always)]
        || {
            let pairs = samples.iter().zip(samples.iter().skip(1));
            pairs.map(|(a, b)| u64::from(a == b)).sum()
        },
    )
}
