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
/// leaves them, 0–1. Fewer than three such runs are the crests of a slow signal, and more runs
/// elsewhere the steps of a coarse converter: 0.
///
/// Source: three equal neighbours at the extreme do not happen again and again unless something limits.
#[must_use]
pub fn flat_top_fraction(samples: &[f64]) -> f64 {
    let (low, high, at_extremes) = pulp::Arch::new().dispatch(
        #[inline(always)]
        || {
            let (low, high) = extremes(samples);
            let at = |v: &f64| u64::from(*v <= low) + u64::from(*v >= high);
            (low, high, samples.iter().map(at).sum::<u64>())
        },
    );
    // Three runs of three are nine samples: fewer are no clipping, and most signals end here.
    if low >= high || at_extremes < 9 {
        return 0.0;
    }
    let (mut runs, mut at_limit, mut elsewhere) = (0, 0, 0);
    for run in samples.chunk_by(|a, b| a == b).filter(|run| run.len() >= 3) {
        if run[0] <= low || run[0] >= high {
            runs += 1;
            at_limit += run.len();
        } else {
            elsewhere += run.len();
        }
    }
    // Steps of a coarse converter hold still everywhere, not only at the limit.
    if runs < 3 || elsewhere > at_limit {
        0.0
    } else {
        at_limit as f64 / samples.len() as f64
    }
}

/// The lowest and the highest of `samples`, in independent lanes.
#[inline(always)]
fn extremes(samples: &[f64]) -> (f64, f64) {
    const LANES: usize = 8;
    let (mut lows, mut highs) = ([f64::MAX; LANES], [f64::MIN; LANES]);
    let (chunks, rest) = samples.as_chunks::<LANES>();
    for chunk in chunks {
        for ((low, high), value) in lows.iter_mut().zip(&mut highs).zip(chunk) {
            *low = if value < low { *value } else { *low };
            *high = if value > high { *value } else { *high };
        }
    }
    let all = || rest.iter().chain(&lows).chain(&highs).copied();
    (
        all().fold(f64::MAX, f64::min),
        all().fold(f64::MIN, f64::max),
    )
}
