//! Whether level or friction change from the first to the last stroke of a recording.

use super::StrokeFeatures;
use crate::quantity::Decibels;
use crate::statistics::{median, rank_correlation};
use crate::warning::{OverStrokes, Scatter, ScatterWarning, Warning};

/// Fewer strokes show no course.
const FEWEST: usize = 6;
/// A course has a smaller probability, were the order of strokes chance …
const P_VALUE: f64 = 0.01;
/// … and changes by at least this much from the first to the last third of the strokes: a level in dB, a coefficient of friction as a share.
const LEVEL_DB: f64 = 3.0;
const FRICTION_SHARE: f64 = 0.2;
/// A change is at once where a step leaves less than this share of the squares that a line leaves.
const STEP: f64 = 0.5;

/// The warnings that level or friction follow the order of `strokes`.
///
/// Formula: Spearman's ρ of the value and the number of the stroke; the change is the median of the last third minus that of the first.
///
/// Source: house rule; [`rank_correlation`].
pub(super) fn warnings(strokes: &[StrokeFeatures]) -> Vec<Warning> {
    let levels = strokes
        .iter()
        .map(|s| Decibels::from_amplitude_ratio(s.rms).0);
    let levels: Vec<f64> = levels.collect();
    let level = course(&levels).filter(|found| found.change.abs() >= LEVEL_DB);
    let level = level.map(|found| {
        OverStrokes::Level {
            change_db: found.change,
        }
        .at(found.step)
    });
    let friction = strokes.iter().map(|s| Some(s.friction_coefficient?.mean));
    let friction: Option<Vec<f64>> = friction.collect();
    let friction = friction.and_then(|values| {
        let found = course(&values)?;
        let share = found.change / found.first;
        (share.abs() >= FRICTION_SHARE).then(|| OverStrokes::Friction { share }.at(found.step))
    });
    let found = level.into_iter().chain(friction);
    found
        .map(|of| Warning::from(ScatterWarning::Scatter { of }))
        .collect()
}

/// How values follow their order.
struct Course {
    /// The median of the first third.
    first: f64,
    /// That of the last third minus it.
    change: f64,
    /// The number of values before a step; 0 where they change little by little.
    step: usize,
}

fn course(values: &[f64]) -> Option<Course> {
    let n = values.len();
    if n < FEWEST || values.iter().any(|value| !value.is_finite()) {
        return None;
    }
    let order: Vec<f64> = (0..n).map(|i| i as f64).collect();
    let found = rank_correlation(&order, values)?;
    if found.p_value >= P_VALUE {
        return None;
    }
    let third = n / 3;
    let first = median(&mut values[..third].to_vec())?;
    let last = median(&mut values[n - third..].to_vec())?;
    let squares = |part: &[f64]| {
        let mean = crate::statistics::mean(part);
        part.iter().map(|v| (v - mean).powi(2)).sum::<f64>()
    };
    let steps = (2..n - 1).map(|at| (at, squares(&values[..at]) + squares(&values[at..])));
    let (at, left) = steps.min_by(|a, b| a.1.total_cmp(&b.1))?;
    // What a line leaves: the squares about the mean less those that its slope takes.
    let (mean_at, mean) = (
        crate::statistics::mean(&order),
        crate::statistics::mean(values),
    );
    let both: f64 = order
        .iter()
        .zip(values)
        .map(|(i, v)| (i - mean_at) * (v - mean))
        .sum();
    let line = squares(values) - both.powi(2) / squares(&order);
    Some(Course {
        first,
        change: last - first,
        step: if left < STEP * line { at } else { 0 },
    })
}

impl OverStrokes {
    fn at(self, after: usize) -> Scatter {
        Scatter::OverStrokes { what: self, after }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::Draws;

    fn strokes(level_db: impl Fn(usize) -> f64, friction: impl Fn(usize) -> f64) -> Vec<Warning> {
        let stroke = |i: usize| {
            let mut coefficient = vec![friction(i)];
            StrokeFeatures {
                rms: 10f64.powf(level_db(i) / 20.0),
                friction_coefficient: super::super::Statistics::of(&mut coefficient),
                ..StrokeFeatures::default()
            }
        };
        warnings(&(0..12).map(stroke).collect::<Vec<_>>())
    }

    fn said(warnings: &[Warning]) -> Vec<ScatterWarning> {
        warnings.iter().filter_map(Warning::kind).collect()
    }

    /// A level that rises stroke by stroke, a sensor that comes loose, friction of a skin that gets moist; not the scatter of strokes, of
    /// which 1 % have a course by chance: 20 of 2,000, ± 4.5.
    #[test]
    fn a_course_over_strokes_is_said_and_scatter_is_not() {
        let wobble = |i: usize| 0.3 * f64::from((i as u32 * 7) % 5);
        let rises = strokes(|i| 0.5 * i as f64 + wobble(i), |_| 0.6);
        assert!(
            matches!(said(&rises)[..], [ScatterWarning::Scatter {
                of: Scatter::OverStrokes { what: OverStrokes::Level { change_db }, after: 0 }
            }] if (change_db - 4.0).abs() < 1.0),
            "{rises:?}"
        );
        let loose = strokes(|i| if i < 7 { 0.0 } else { -5.0 } + wobble(i), |_| 0.6);
        assert!(
            matches!(
                said(&loose)[..],
                [ScatterWarning::Scatter {
                    of: Scatter::OverStrokes {
                        what: OverStrokes::Level { .. },
                        after: 7
                    }
                }]
            ),
            "{loose:?}"
        );
        let moist = strokes(wobble, |i| 0.3 + 0.05 * i as f64);
        assert!(
            matches!(
                said(&moist)[..],
                [ScatterWarning::Scatter {
                    of: Scatter::OverStrokes {
                        what: OverStrokes::Friction { .. },
                        after: 0
                    }
                }]
            ),
            "{moist:?}"
        );
        let mut random = Draws::new(1);
        let mut by_chance = 0;
        for _ in 0..2_000 {
            let mut order: Vec<usize> = (0..12).collect();
            random.shuffle(&mut order);
            // Strokes within ±2.75 dB of their mean, and friction within ±18 %.
            let of = |i: usize| order[i] as f64 / 11.0 - 0.5;
            by_chance += usize::from(!strokes(|i| 5.5 * of(i), |i| 0.6 + 0.22 * of(i)).is_empty());
        }
        assert!(by_chance <= 34, "{by_chance}");
    }
}
