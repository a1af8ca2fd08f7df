//! The line from the clock of a recording to that of a drive.

use super::{AlignError, MOST_DRIFT_PPM};
use crate::delay::{Course, Fit, Local, Outliers, Rules, Slope};
use crate::statistics::{Z_95, t_quantile};

/// With fewer blocks there is no line with an uncertainty.
pub(super) const FEWEST_BLOCKS: usize = 4;
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
    /// The line of a fit.
    fn of(fit: &Fit) -> Option<Self> {
        Some(Self {
            middle: fit.middle,
            slope: fit.slope,
            middle_error: (fit.variance / fit.used).sqrt(),
            slope_error: (fit.variance / fit.along).sqrt(),
            quantile: t_quantile(fit.used as usize - 2)?,
            spread: fit.variance.sqrt(),
        })
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

/// How the places of blocks may step.
fn rules() -> Rules {
    Rules {
        overlap: 1.0,
        clear: 0.0,
        aside: 2,
        steps: 1,
        sizes: LEAST_STEP_S..f64::INFINITY,
        steady: f64::INFINITY,
        least: 1e-7,
        outliers: Outliers::LeftOut,
    }
}

/// Less the time of the recording, so that no digit is lost.
fn locals(found: &[Found]) -> Vec<Local> {
    let local = |one: &Found| Local {
        at: one.recorded_s,
        delay: one.drive_s - one.recorded_s,
        weight: 1.0,
    };
    found.iter().map(local).collect()
}

/// The line through blocks without those that lie far from it, and which it was drawn with.
pub(super) fn robust(found: &[Found]) -> Result<(Line, Vec<bool>), AlignError> {
    let fit = Fit::of(&locals(found), &[], Slope::Free, &rules());
    let few = AlignError::FewBlocks { found: found.len() };
    let Some(fit) = fit.filter(|fit| fit.used >= FEWEST_BLOCKS as f64) else {
        return Err(few);
    };
    let line = Line::of(&fit).ok_or(few)?;
    Ok((line, fit.left.iter().map(Option::is_some).collect()))
}

/// Where the places of blocks step from one line to a parallel one: the time of the recording and the step, s; the most certain step.
pub(super) fn step(found: &[Found]) -> Option<[f64; 2]> {
    if found.len() < FEWEST_BLOCKS + 2 {
        return None;
    }
    // All of them count: what is behind a step lies far from the line before it.
    let rules = Rules {
        outliers: Outliers::Held,
        ..rules()
    };
    let Course { fit, steps, .. } = Course::of(&locals(found), &rules)?;
    Some([*steps.first()?, *fit.jumps.first()?])
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
