//! The scalp: places of electrodes and sources, and how the background is correlated over it.

use super::positions::POSITIONS;
use crate::parameters::EegParameters;

/// The channel of vertical eye movements and blinks, above minus below the eye.
pub const VEOG: &str = "VEOG";
/// The channel of horizontal eye movements, right minus left.
pub const HEOG: &str = "HEOG";

/// A direction from the centre of the head, of length 1.
pub(super) type Direction = [f64; 3];

/// The names of all channels in the order of a cap: 64 of the 10-10 system, then [`VEOG`] and [`HEOG`].
#[must_use]
pub fn all_channels() -> Vec<String> {
    let cap = POSITIONS.iter().map(|(name, _)| *name);
    cap.chain([VEOG, HEOG]).map(str::to_owned).collect()
}

/// Where the electrode `name` is; `None` for another name, and for the EOG.
pub(super) fn place(name: &str) -> Option<Direction> {
    POSITIONS
        .iter()
        .find(|(known, _)| *known == name)
        .map(|(_, place)| *place)
}

/// Between the electrodes `first` and `second` of the table.
pub(super) fn between(first: &str, second: &str) -> Direction {
    let [a, b] = [first, second].map(|name| place(name).unwrap_or_default());
    let sum = [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
    let length = dot(sum, sum).sqrt();
    sum.map(|v| v / length)
}

fn dot(a: Direction, b: Direction) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// The distance along a scalp of radius `head_m`, m.
pub(super) fn along_m(a: Direction, b: Direction, head_m: f64) -> f64 {
    head_m * dot(a, b).clamp(-1.0, 1.0).acos()
}

/// What of a source at `source` is left at `at`: exp(−d²/2s²).
pub(super) fn gain(at: Direction, source: Direction, source_m: f64, head_m: f64) -> f64 {
    let distance = along_m(at, source, head_m) / source_m;
    (-0.5 * distance * distance).exp()
}

/// The background of all electrodes as a mixture of independent ones.
///
/// The correlation of two electrodes is (1 − u)·exp(−d/l), with d straight through the head, which is positive definite in space; its
/// Cholesky factor is the mixture. The electrodes are ordered by their distance from the left sensorimotor cortex, so that the
/// first need few independent backgrounds, and an electrode is the same whatever others are recorded.
pub(super) struct Mixture {
    order: Vec<usize>,
    factor: Vec<Vec<f64>>,
}

impl Mixture {
    pub(super) fn of(eeg: &EegParameters) -> Self {
        let centre = between("C3", "CP3");
        let mut order: Vec<usize> = (0..POSITIONS.len()).collect();
        let far = |i: &usize| -dot(POSITIONS[*i].1, centre);
        order.sort_by(|a, b| far(a).total_cmp(&far(b)));
        let correlation = |i: usize, j: usize| {
            if i == j {
                return 1.0;
            }
            let (a, b) = (POSITIONS[order[i]].1, POSITIONS[order[j]].1);
            let apart_m = eeg.head_m * (2.0 - 2.0 * dot(a, b)).max(0.0).sqrt();
            (1.0 - eeg.background.own_share) * (-apart_m / eeg.background.correlation_m).exp()
        };
        let mut factor: Vec<Vec<f64>> = Vec::with_capacity(order.len());
        for i in 0..order.len() {
            let mut row: Vec<f64> = Vec::with_capacity(i + 1);
            for j in 0..=i {
                let above = factor.get(j).unwrap_or(&row);
                let known: f64 = row.iter().zip(above).take(j).map(|(a, b)| a * b).sum();
                let left = correlation(i, j) - known;
                // The own share keeps every pivot above zero.
                let value = if i == j {
                    left.max(0.0).sqrt()
                } else {
                    left / above[j]
                };
                row.push(value);
            }
            factor.push(row);
        }
        Self { order, factor }
    }

    /// The name and the shares of the independent backgrounds in the electrode `name`, in their order.
    pub(super) fn row(&self, name: &str) -> Option<&[f64]> {
        let at = self.order.iter().position(|i| POSITIONS[*i].0 == name)?;
        Some(&self.factor[at])
    }

    /// The name of the stream of independent background `number`.
    pub(super) fn stream(&self, number: usize) -> &'static str {
        POSITIONS[self.order[number]].0
    }
}
