//! The line from the clock of a recording to that of a drive.

use super::{AlignError, MOST_DRIFT_PPM};
use crate::statistics::{Z_95, mean, median, t_quantile};

/// With fewer blocks there is no line with an uncertainty.
pub(super) const FEWEST_BLOCKS: usize = 4;
/// Residuals of more than so many robust standard deviations are left out.
const FAR: f64 = 5.0;
/// The median of absolute residuals of a normal distribution is its standard deviation over this.
const NORMAL: f64 = 1.4826;
/// A step is one with so many standard errors, more with few blocks.
const STEP_ERRORS: f64 = 5.0;
/// A smaller step is none, s.
pub(super) const LEAST_STEP_S: f64 = 2e-5;
/// A drift that changes by less is found, ppm.
const CONVERGED_PPM: f64 = 0.02;
/// Corrections that differ by more say how the drift that is found depends on them, ppm.
const LEAST_CHANGE_PPM: f64 = 2.0;

/// Something that was found on both clocks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Found {
    /// Its middle, by the clock of the recording, s.
    pub(super) recorded_s: f64,
    /// The same by the clock of the drive, s.
    pub(super) drive_s: f64,
    pub(super) correlation: f64,
}

/// A line from the clock of the recording to that of the drive, with its errors.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line {
    /// A time on both clocks that it goes through, s.
    middle: [f64; 2],
    /// Its slope less 1.
    slope: f64,
    /// The standard error there, s.
    middle_error: f64,
    slope_error: f64,
    /// How many standard errors make 95 %.
    quantile: f64,
    /// The standard deviation of single ones about it, s.
    pub(super) spread: f64,
}

impl Line {
    /// The least-squares line through those of `found` that are `used`.
    fn through(found: &[Found], used: &[bool]) -> Option<Self> {
        let own: Vec<&Found> = found
            .iter()
            .zip(used)
            .filter_map(|(one, used)| used.then_some(one))
            .collect();
        if own.len() < FEWEST_BLOCKS {
            return None;
        }
        let x: Vec<f64> = own.iter().map(|one| one.recorded_s).collect();
        // Less the time of the recording, so that no digit is lost.
        let y: Vec<f64> = own.iter().map(|one| one.drive_s - one.recorded_s).collect();
        let middle = [mean(&x), mean(&y)];
        let squares: f64 = x.iter().map(|x| (x - middle[0]).powi(2)).sum();
        let product = x.iter().zip(&y);
        let product: f64 = product
            .map(|(x, y)| (x - middle[0]) * (y - middle[1]))
            .sum();
        let slope = product / squares;
        let rest = x.iter().zip(&y);
        let rest: f64 = rest
            .map(|(x, y)| (y - middle[1] - slope * (x - middle[0])).powi(2))
            .sum();
        let count = own.len() as f64;
        let spread = (rest / (count - 2.0)).sqrt();
        let line = Self {
            middle,
            slope,
            middle_error: spread / count.sqrt(),
            slope_error: spread / squares.sqrt(),
            quantile: t_quantile(own.len() - 2)?,
            spread,
        };
        line.slope.is_finite().then_some(line)
    }

    /// The line through two that have the standard errors `errors`, s.
    pub(super) fn between(both: [&Found; 2], errors: [f64; 2]) -> Self {
        let weights = errors.map(|error| 1.0 / (error * error));
        let sum = weights[0] + weights[1];
        let weighted = |values: [f64; 2]| (weights[0] * values[0] + weights[1] * values[1]) / sum;
        let x = both.map(|one| one.recorded_s);
        let y = both.map(|one| one.drive_s - one.recorded_s);
        let middle = [weighted(x), weighted(y)];
        let squares: f64 = (0..2)
            .map(|i| weights[i] * (x[i] - middle[0]).powi(2))
            .sum();
        Self {
            middle,
            slope: (y[1] - y[0]) / (x[1] - x[0]),
            middle_error: sum.sqrt().recip(),
            slope_error: squares.sqrt().recip(),
            quantile: Z_95,
            spread: 0.0,
        }
    }

    /// The same with an error of its slope that is `gain` times as large.
    pub(super) fn with_gain(self, gain: f64) -> Self {
        Self {
            slope_error: gain * self.slope_error,
            ..self
        }
    }

    /// The time of the drive at a time of the recording, s.
    pub(super) fn at(&self, recorded_s: f64) -> f64 {
        recorded_s + self.middle[1] + self.slope * (recorded_s - self.middle[0])
    }

    pub(super) fn residual(&self, one: &Found) -> f64 {
        one.drive_s - self.at(one.recorded_s)
    }

    /// Half the 95 % interval at a time of the recording, s.
    pub(super) fn half_at(&self, recorded_s: f64) -> f64 {
        let along = (recorded_s - self.middle[0]) * self.slope_error;
        self.quantile * self.middle_error.hypot(along)
    }

    /// The drift, ppm.
    pub(super) fn drift_ppm(&self) -> f64 {
        drift_ppm(self.slope)
    }

    /// Its 95 % interval, ppm.
    pub(super) fn drift_interval_ppm(&self) -> [f64; 2] {
        let half = self.quantile * self.slope_error;
        [drift_ppm(self.slope + half), drift_ppm(self.slope - half)]
    }
}

/// 1e6·(1/(1 + slope) − 1), without the loss of digits.
fn drift_ppm(slope: f64) -> f64 {
    -1e6 * slope / (1.0 + slope)
}

/// The line through blocks without those that lie far from it, and which it was drawn with.
pub(super) fn robust(found: &[Found]) -> Result<(Line, Vec<bool>), AlignError> {
    let few = |found: usize| AlignError::FewBlocks { found };
    let mut used: Vec<bool> = vec![true; found.len()];
    let mut line = Line::through(found, &used).ok_or(few(found.len()))?;
    // Twice: what is far from the first line has moved it.
    for _ in 0..2 {
        let sizes = found.iter().map(|one| line.residual(one).abs());
        let sizes: Vec<f64> = sizes.collect();
        let usual = median(&mut sizes.clone()).unwrap_or(0.0);
        let limit = FAR * NORMAL * usual.max(1e-7);
        for (used, size) in used.iter_mut().zip(&sizes) {
            *used = *size <= limit;
        }
        let count = used.iter().filter(|used| **used).count();
        line = Line::through(found, &used).ok_or(few(count))?;
    }
    Ok((line, used))
}

/// Where the places of blocks step from one line to a parallel one: the time of the recording and the step, s; the most certain step.
pub(super) fn step(found: &[Found]) -> Option<[f64; 2]> {
    let n = found.len();
    let whole = squares(found, None)?;
    let mut best: Option<(f64, [f64; 2])> = None;
    for at in 2..n.saturating_sub(1) {
        let Some(split) = squares(found, Some(at)) else {
            continue;
        };
        let free = n as f64 - 3.0;
        let gain = (whole.0 - split.0).max(0.0);
        let errors = (gain / (split.0 / free).max(1e-18)).sqrt();
        if best.is_none_or(|(most, _)| errors > most) {
            let at_s = 0.5 * (found[at - 1].recorded_s + found[at].recorded_s);
            best = Some((errors, [at_s, split.1]));
        }
    }
    let (errors, [at_s, by_s]) = best?;
    let needed = STEP_ERRORS * (1.0 + 3.0 / (n as f64 - 3.0));
    (errors > needed && by_s.abs() >= LEAST_STEP_S).then_some([at_s, by_s])
}

/// The sum of squared residuals of a line, with a step before block `at` if there is one, and the step, s.
fn squares(found: &[Found], at: Option<usize>) -> Option<(f64, f64)> {
    if found.len() < FEWEST_BLOCKS + 2 {
        return None;
    }
    let parts = match at {
        Some(at) => vec![&found[..at], &found[at..]],
        None => vec![found],
    };
    // One slope, and a level for each part.
    let centred = parts.iter().map(|part| {
        let x = mean(&part.iter().map(|one| one.recorded_s).collect::<Vec<_>>());
        let y = part.iter().map(|one| one.drive_s - one.recorded_s);
        let y = mean(&y.collect::<Vec<_>>());
        (x, y)
    });
    let centred: Vec<(f64, f64)> = centred.collect();
    let each = || {
        parts.iter().zip(&centred).flat_map(|(part, (x, y))| {
            part.iter().map(move |one| {
                let along = one.recorded_s - x;
                (along, one.drive_s - one.recorded_s - y)
            })
        })
    };
    let slope = each().map(|(x, y)| x * y).sum::<f64>() / each().map(|(x, _)| x * x).sum::<f64>();
    let rest = each().map(|(x, y)| (y - slope * x).powi(2)).sum();
    let step = match centred.as_slice() {
        [before, behind] => behind.1 - before.1 - slope * (behind.0 - before.0),
        _ => 0.0,
    };
    slope.is_finite().then_some((rest, step))
}

/// What `measure` finds by a clock that is corrected for a drift, with that drift: the correction at which it finds no other; and by how much
/// the error of that drift is larger than the one of a line. A signal whose frequency changes with time is found too early or too
/// late by a clock that is not corrected.
pub(super) fn converged<T>(
    mut measure: impl FnMut(f64, Option<&T>) -> Result<(T, f64), AlignError>,
) -> Result<(T, f64), AlignError> {
    let (mut best, found) = measure(0.0, None)?;
    let (mut before, mut rest_before) = (0.0, found);
    let mut best_rest = found.abs();
    let (mut next, mut gain) = (found, 1.0);
    for _ in 0..4 {
        if best_rest < CONVERGED_PPM || !(-MOST_DRIFT_PPM..=MOST_DRIFT_PPM).contains(&next) {
            break;
        }
        let Ok((value, found)) = measure(next, Some(&best)) else {
            break;
        };
        let rest = found - next;
        if rest.abs() < best_rest {
            (best, best_rest) = (value, rest.abs());
        }
        let slope = (rest - rest_before) / (next - before);
        // Of two that hardly differ it is not known.
        if (next - before).abs() > LEAST_CHANGE_PPM && slope.is_finite() {
            gain = slope.abs().recip().clamp(0.5, 2.0);
        }
        (before, rest_before) = (next, rest);
        next -= rest / slope;
    }
    Ok((best, gain))
}
