//! Times of one device on the clock of another, and times without jitter: the algorithms of pyxdf 1.17.5 with its defaults, but for
//! samples that were lost and clock offsets that are wrong, over which pyxdf fits.

use std::ops::Range;

use super::losses::{self, LostBefore};

/// Above this, s, an offset counts as an outlier.
const WINSOR_S: f64 = 1e-4;
/// A gap is longer than this, s, and than so many samples.
const GAP_S: f64 = 1.0;
const GAP_SAMPLES: f64 = 500.0;
/// A reset of a clock comes with an interval between offsets that differs from the others by so many median absolute deviations
/// and s, and with an offset that does.
const RESET_INTERVAL: (f64, f64) = (5.0, 5.0);
const RESET_OFFSET: (f64, f64) = (10.0, 1.0);
/// How far a last clock offset is from the others, in intervals or standard deviations, if an ended outlet sent it.
const OUTLIER: f64 = 10.0;

/// How the samples of a stream of constant rate follow each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Spacing {
    /// Evenly, but for gaps.
    Even,
    /// Single ones may be missing, so that times are kept as they are.
    WithLosses,
}

fn median(values: impl Iterator<Item = f64>) -> f64 {
    piezotact::statistics::median(&mut values.collect::<Vec<_>>()).unwrap_or(f64::NAN)
}

fn steps(values: impl Iterator<Item = f64> + Clone) -> Vec<f64> {
    let next = values.clone().skip(1);
    values.zip(next).map(|(a, b)| b - a).collect()
}

/// Which of `steps` are outliers.
fn outliers(steps: &[f64], (deviations, least): (f64, f64)) -> Vec<bool> {
    let middle = median(steps.iter().copied());
    let spread = median(steps.iter().map(|step| (step - middle).abs())) + f64::EPSILON;
    let far = |step: &f64| {
        let away = (step - middle).abs();
        away / spread > deviations && away > least
    };
    steps.iter().map(far).collect()
}

/// The ranges between breaks: a break stands between an element and the next.
fn ranges(breaks: &[bool]) -> Vec<Range<usize>> {
    let ends = breaks
        .iter()
        .enumerate()
        .filter(|(_, b)| **b)
        .map(|(k, _)| k + 1);
    let ends: Vec<usize> = ends.chain([breaks.len() + 1]).collect();
    let starts = std::iter::once(0).chain(ends.iter().copied());
    starts
        .zip(ends.iter().copied())
        .map(|(a, b)| a..b)
        .collect()
}

/// Whether the last offset is one that an ended outlet sent.
pub(super) fn last_is_outlier(offsets: &[(f64, f64)]) -> bool {
    let [before @ .., last] = offsets else {
        return false;
    };
    if before.len() < 2 {
        return false;
    }
    let intervals = steps(offsets.iter().map(|(time, _)| *time));
    let (earlier, newest) = (
        &intervals[..intervals.len() - 1],
        intervals[intervals.len() - 1],
    );
    let usual = median(earlier.iter().copied());
    let late = match usual > 0.0 {
        true => newest.abs() / usual,
        false if newest != 0.0 => f64::INFINITY,
        false => 1.0,
    };
    let middle = median(before.iter().map(|(_, value)| *value));
    let spread = median(before.iter().map(|(_, value)| (value - middle).abs()));
    let away = match spread > f64::EPSILON {
        true => (last.1 - middle).abs() / (1.4826 * spread),
        false => 0.0,
    };
    late > OUTLIER || away > OUTLIER
}

/// What is wrong with the clock offsets of a stream.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Offsets {
    /// They are of one time, and were not used.
    OfOneTime,
    /// So many of them are up to so far, s, from the line through the others, which was used.
    Wrong { count: usize, of: usize, by_s: f64 },
    /// They are up to so far, s, from the line through all of them: too few to say which is wrong.
    Apart { by_s: f64 },
}

/// Brings `time_s` to the clock of the recording computer, with the offsets measured while it ran. Returns the parts between resets of
/// the device's clock, and what is wrong with the offsets.
pub(super) fn synchronise(
    time_s: &mut [f64],
    offsets: &[(f64, f64)],
) -> (Vec<Range<usize>>, Option<Offsets>) {
    if time_s.is_empty() || offsets.is_empty() {
        return (Vec::new(), None);
    }
    let parts = resets(offsets);
    let mut wrong = None;
    let maps: Vec<(f64, f64)> = parts
        .iter()
        .map(|part| {
            let own = &offsets[part.clone()];
            match own {
                [(_, only)] => (*only, 0.0),
                _ => match checked_line(own) {
                    Some((line, found)) => {
                        wrong = wrong.or(found);
                        line
                    }
                    None => {
                        wrong = wrong.or(Some(Offsets::OfOneTime));
                        (0.0, 0.0)
                    }
                },
            }
        })
        .collect();
    let mut segments = Vec::new();
    let mut from = 0;
    for (part, (constant, slope)) in parts.iter().zip(maps) {
        let end = match offsets.get(part.end) {
            // The part ends with the first time that is nearer to the next part.
            Some((next_s, _)) => {
                let last_s = offsets[part.end - 1].0;
                let own = time_s[from..].iter();
                let count = own
                    .take_while(|time| (**time - last_s).abs() < (**time - next_s).abs())
                    .count();
                from + count
            }
            None => time_s.len(),
        };
        if end > from {
            for time in &mut time_s[from..end] {
                *time += constant + slope * *time;
            }
            segments.push(from..end);
        }
        from = end;
    }
    (segments, wrong)
}

/// An offset is wrong where it is further than this, s, from the line of the others, and than so many of their median deviations.
const WRONG: (f64, f64) = (1e-3, 10.0);
/// Offsets that are closer to their line than this, s, need no warning.
const APART_S: f64 = 10e-3;
/// From so many offsets on, the others say which one is wrong; the slopes of pairs of so many at most are compared.
const COMPARED: (usize, usize) = (5, 500);

/// The line of [`robust_line`]; where offsets that are wrong have bent it, that of the others.
fn checked_line(offsets: &[(f64, f64)]) -> Option<((f64, f64), Option<Offsets>)> {
    let line = robust_line(offsets)?;
    let away = |(constant, slope): (f64, f64)| {
        move |(t, v): &(f64, f64)| (v - (constant + slope * t)).abs()
    };
    let largest = |line, of: &[(f64, f64)]| of.iter().map(away(line)).fold(0.0, f64::max);
    if offsets.len() < COMPARED.0 {
        let by_s = largest(line, offsets);
        return Some((line, (by_s > APART_S).then_some(Offsets::Apart { by_s })));
    }
    let some: Vec<(f64, f64)> = offsets
        .iter()
        .step_by(offsets.len().div_ceil(COMPARED.1))
        .copied()
        .collect();
    // Theil and Sen: the median of the slopes of all pairs.
    let first_s = offsets[0].0;
    let pairs = some.iter().enumerate().flat_map(|(k, a)| {
        let slope = |b: &(f64, f64)| (b.1 - a.1) / (b.0 - a.0);
        some[k + 1..].iter().map(slope).collect::<Vec<_>>()
    });
    let slope = median(pairs.filter(|slope| slope.is_finite()));
    let constant = median(some.iter().map(|(t, v)| v - slope * (t - first_s))) - slope * first_s;
    let of_most = (constant, slope);
    let spread = median(offsets.iter().map(away(of_most)));
    let limit = WRONG.0.max(WRONG.1 * spread);
    let (right, wrong): (Vec<_>, Vec<_>) =
        (offsets.iter().copied()).partition(|one| away(of_most)(one) <= limit);
    if wrong.is_empty() || largest(line, &right) <= limit {
        return Some((line, None));
    }
    let found = Offsets::Wrong {
        count: wrong.len(),
        of: offsets.len(),
        by_s: largest(of_most, &wrong),
    };
    Some((robust_line(&right)?, Some(found)))
}

/// The ranges of offsets between resets of the clock.
fn resets(offsets: &[(f64, f64)]) -> Vec<Range<usize>> {
    let times = steps(offsets.iter().map(|(time, _)| *time));
    let values = steps(offsets.iter().map(|(_, value)| *value));
    let late = outliers(&times, RESET_INTERVAL);
    let far = outliers(&values, RESET_OFFSET);
    let reset = |k: usize| times[k] < 0.0 || (late[k] && far[k]);
    let breaks: Vec<bool> = (0..times.len()).map(reset).collect();
    ranges(&breaks)
}

/// The line `constant + slope·time` through offsets with the least Huber loss, by the alternating direction method of multipliers with
/// 1000 steps; `None` where all offsets are of one time.
///
/// Source: Boyd et al. 2011, *Distributed optimization and statistical learning via ADMM*, `huber_fit`.
fn robust_line(offsets: &[(f64, f64)]) -> Option<(f64, f64)> {
    const STEPS: usize = 1000;
    let scaled: Vec<(f64, f64)> = offsets
        .iter()
        .map(|(t, v)| (t / WINSOR_S, v / WINSOR_S))
        .collect();
    let first = scaled.iter().map(|(t, _)| *t).fold(f64::INFINITY, f64::min);
    let rows: Vec<(f64, f64)> = scaled.iter().map(|(t, v)| (t - first, *v)).collect();
    let count = rows.len() as f64;
    let sum: f64 = rows.iter().map(|(t, _)| t).sum();
    let squares: f64 = rows.iter().map(|(t, _)| t * t).sum();
    // The factors of the normal equations.
    let corner = count.sqrt();
    let side = sum / corner;
    let below = squares - side * side;
    if below.is_nan() || below <= 0.0 {
        return None;
    }
    let below = below.sqrt();
    let mut auxiliary = vec![0.0; rows.len()];
    let mut dual = vec![0.0; rows.len()];
    let (mut constant, mut slope) = (0.0, 0.0);
    for _ in 0..STEPS {
        let (mut right, mut right_t) = (0.0, 0.0);
        for (((t, v), z), u) in rows.iter().zip(&auxiliary).zip(&dual) {
            let target = v + (z - u);
            right += target;
            right_t += t * target;
        }
        let forward = right / corner;
        let forward_t = (right_t - side * forward) / below;
        slope = forward_t / below;
        constant = (forward - side * slope) / corner;
        for (((t, v), z), u) in rows.iter().zip(&mut auxiliary).zip(&mut dual) {
            let d = constant + slope * t - v + *u;
            let inverse = if d == 0.0 { 0.0 } else { 1.0 / d };
            let shrunk = (1.0 - 2.0 * inverse.abs()).max(0.0);
            *z = 0.5 * d + 0.5 * shrunk * d;
            *u = d - *z;
        }
    }
    let at_zero = constant - slope * first;
    (at_zero.is_finite() && slope.is_finite()).then_some((at_zero * WINSOR_S, slope))
}

/// The times of a stream, as they were brought to a constant rate.
#[derive(Debug, Default)]
pub(super) struct Even {
    /// The parts without a long gap.
    pub(super) segments: Vec<Range<usize>>,
    /// Samples missing within them.
    pub(super) lost: Vec<LostBefore>,
    /// The rate in Hz.
    pub(super) rate_hz: Option<f64>,
    /// How far the time stamps of a second leave the constant rate, s; at most.
    pub(super) residual_s: f64,
}

/// Frees the times of a stream of a constant rate from jitter: within each part without a long gap they lie on the line of least squares,
/// with whole steps left out where samples are missing.
pub(super) fn without_jitter(time_s: &mut [f64], nominal_hz: f64, spacing: Spacing) -> Even {
    let mut even = Even::default();
    let count = time_s.len();
    if count == 0 {
        return even;
    }
    if nominal_hz == 0.0 {
        even.segments.push(0..count);
        return even;
    }
    let gap_s = GAP_S.max(GAP_SAMPLES / nominal_hz);
    let breaks: Vec<bool> = steps(time_s.iter().copied())
        .iter()
        .map(|step| step.abs() > gap_s)
        .collect();
    even.segments = ranges(&breaks);
    let (mut intervals, mut lasts_s) = (0.0, 0.0);
    for part in &even.segments {
        let own = &mut time_s[part.clone()];
        let lost = losses::lost(own);
        let places: Vec<f64> = losses::places(own.len(), &lost).map(|k| k as f64).collect();
        let (start, step) = line(&places, own);
        let residuals: Vec<f64> = (own.iter().zip(&places))
            .map(|(time, k)| time - (start + step * k))
            .collect();
        // Jitter of single stamps is freed; what a second has in common stays.
        let second = (nominal_hz.min(1e6) as usize).max(10);
        for one in residuals.chunks_exact(second) {
            even.residual_s = even.residual_s.max(median(one.iter().copied()).abs());
        }
        if spacing == Spacing::Even {
            for (time, k) in own.iter_mut().zip(&places) {
                *time = start + step * k;
            }
        }
        let last = places.last().copied().unwrap_or(0.0);
        intervals += last;
        lasts_s += step * last;
        even.lost.extend(lost.into_iter().map(|lost| LostBefore {
            at: lost.at + part.start,
            ..lost
        }));
    }
    even.rate_hz = (lasts_s > 0.0).then(|| intervals / lasts_s);
    even
}

/// The value at place 0 and the slope of the line of least squares through values at `places`.
fn line(places: &[f64], values: &[f64]) -> (f64, f64) {
    let count = values.len() as f64;
    let middle = places.iter().sum::<f64>() / count;
    // Counted from the first one, so that large times lose no digits.
    let first = values.first().copied().unwrap_or(0.0);
    let mean = values.iter().map(|value| value - first).sum::<f64>() / count;
    let (mut both, mut squares) = (0.0, 0.0);
    for (place, value) in places.iter().zip(values) {
        let away = place - middle;
        both += away * (value - first - mean);
        squares += away * away;
    }
    let slope = if squares > 0.0 { both / squares } else { 0.0 };
    (first + mean - slope * middle, slope)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_outlier_does_not_bend_the_line() {
        let mut offsets: Vec<(f64, f64)> = (0..50)
            .map(|k| (f64::from(k) * 5.0, 2.0 + 1e-5 * f64::from(k) * 5.0))
            .collect();
        offsets[20].1 += 0.05;
        let (constant, slope) = robust_line(&offsets).unwrap();
        assert!(
            (constant - 2.0).abs() < 1e-4 && (slope - 1e-5).abs() < 1e-6,
            "{constant} {slope}"
        );
        assert_eq!(robust_line(&[(1.0, 2.0), (1.0, 2.0)]), None);
    }

    /// pyxdf 1.17.5 has 17 to 50 ms for the first of these.
    #[test]
    fn a_wrong_offset_moves_no_time() {
        for (at, by_s) in [(11, 0.5), (11, 3000.0), (0, -0.5), (5, 0.5)] {
            let mut offsets: Vec<(f64, f64)> = (0..12)
                .map(|k| (700.0 + 5.0 * f64::from(k), 300.0 + 2e-5 * f64::from(k % 3)))
                .collect();
            offsets[at].1 += by_s;
            let mut times = [702.0, 754.0];
            let (_, found) = synchronise(&mut times, &offsets);
            // The offsets scatter by 40 µs.
            assert!(
                (times[0] - 1002.0).abs() < 1e-4 && (times[1] - 1054.0).abs() < 1e-4,
                "{by_s}: {times:?}"
            );
            if (at, by_s) != (5, 0.5) {
                assert!(
                    matches!(
                        found,
                        Some(Offsets::Wrong {
                            count: 1,
                            of: 12,
                            ..
                        })
                    ),
                    "{found:?}"
                );
            }
        }
    }

    #[test]
    fn gaps_divide_a_stream() {
        let mut times: Vec<f64> = (0..100).map(|k| f64::from(k) * 0.01).collect();
        times.extend((0..50).map(|k| 11.0 + f64::from(k) * 0.01));
        let even = without_jitter(&mut times, 100.0, Spacing::Even);
        assert_eq!(even.segments, [0..100, 100..150]);
        assert!((even.rate_hz.unwrap() - 100.0).abs() < 1e-9);
    }
}
