//! The even grid on which time stamps lie, with the breaks of their clock.

use piezotact::statistics::median;

use super::GAP;

/// Steps that differ by more than this share from the usual one, and by eight times the usual spread, are breaks of the clock.
const BREAK: f64 = 0.05;
/// Breaks up to this share of all steps are places at which samples were lost.
const MOST_BREAKS: f64 = 0.02;
/// How far a gap may be from whole steps, in steps, to be one of samples that were lost on a clock that ran on.
const WHOLE: f64 = 0.1;

/// Time stamps and the steps between them.
#[derive(Clone, Copy)]
pub(super) struct Rows<'a> {
    pub(super) times: &'a [f64],
    pub(super) steps: &'a [f64],
}

/// The grid on which rows lie, in the unit of their times.
pub(super) struct Grid {
    pub(super) period: f64,
    pub(super) gaps: Vec<(usize, usize)>,
    pub(super) residual: f64,
}

impl<'a> Rows<'a> {
    /// The rows before which the clock jumped. An error with a step where there are so many jumps that the rows have no grid.
    pub(super) fn breaks(self, usual: f64) -> Result<Vec<usize>, usize> {
        let mut off: Vec<f64> = self.steps.iter().map(|step| (step - usual).abs()).collect();
        let spread = 1.4826 * median(&mut off).unwrap_or(0.0);
        let most = ((self.steps.len() as f64 * MOST_BREAKS) as usize).max(3);
        let beyond = |limit: f64| -> Vec<usize> {
            let steps = self.steps.iter().enumerate();
            let found = steps.filter(|(_, step)| (*step - usual).abs() > limit);
            found.map(|(at, _)| at + 1).collect()
        };
        let wild = beyond(GAP * usual);
        if wild.len() > most {
            return Err(wild[0] - 1);
        }
        let limit = (8.0 * spread).clamp(BREAK * usual, 0.5 * usual);
        let found = beyond(limit);
        Ok(if found.len() > most { wild } else { found })
    }

    /// Whether rounded times are those of an even clock of this period.
    pub(super) fn fit(self, period: f64) -> bool {
        let range = |values: &mut dyn Iterator<Item = f64>| {
            let (least, most) = values.fold((f64::MAX, f64::MIN), |(least, most), value| {
                (least.min(value), most.max(value))
            });
            most - least
        };
        let times = self.times.iter().enumerate();
        let off = range(&mut times.map(|(k, time)| time - self.times[0] - period * k as f64));
        off <= range(&mut self.steps.iter().copied()) * (1.0 + 1e-3)
    }

    /// Whether the times are those of an even clock, rounded: their steps take two values that differ by a unit of a decimal, and
    /// all lie within that of a line.
    pub(super) fn are_rounded(self, usual: f64) -> bool {
        let (least, most) = self
            .steps
            .iter()
            .fold((f64::MAX, 0.0_f64), |(low, high), step| {
                (low.min(*step), high.max(*step))
            });
        let unit = most - least;
        let place = unit.log10();
        let is_at = |step: f64, value: f64| (step - value).abs() <= 1e-3 * unit;
        if unit > usual * (1.0 + 1e-6)
            || !(place.is_finite() && (place - place.round()).abs() < 1e-3)
        {
            return false;
        }
        if !self
            .steps
            .iter()
            .all(|step| is_at(*step, least) || is_at(*step, most))
        {
            return false;
        }
        let long = self.steps.iter().filter(|step| is_at(**step, most)).count();
        let rare = long.min(self.steps.len() - long) as f64;
        let line = self.on(&[0], &[0], None);
        (unit < 0.5 * usual || rare > 0.05 * self.steps.len() as f64)
            && line.residual * line.period <= unit * (1.0 + 1e-3)
    }

    /// The grid of the mean step.
    pub(super) fn even(self) -> Grid {
        let steps = self.steps.len() as f64;
        let mean = self.steps.iter().sum::<f64>() / steps;
        self.on(&[0], &[0], Some(mean))
    }

    /// The grid of rows whose clock jumped before `breaks`.
    pub(super) fn grid(self, breaks: &[usize], usual: f64) -> Grid {
        let starts: Vec<usize> = std::iter::once(0).chain(breaks.iter().copied()).collect();
        if breaks.is_empty() {
            return self.on(&starts, &[0], None);
        }
        let lines: Vec<Line> = self.segments(&starts).map(Line::of).collect();
        let (xx, xy) = lines
            .iter()
            .fold((0.0, 0.0), |(xx, xy), l| (xx + l.xx, xy + l.xy));
        let period = if xx > 0.0 { xy / xx } else { usual };
        let first = |k: usize| lines[k].mean - period * 0.5 * (lines[k].count - 1) as f64;
        // Gaps of whole steps are counted one by one; others lie where the clock says.
        let mut whole = true;
        let (mut chained, mut nearest) = (vec![0_usize], vec![0_usize]);
        for k in 1..lines.len() {
            let before = lines[k - 1].count;
            let gap = (first(k) - first(k - 1)) / period - (before - 1) as f64;
            whole &= (gap - gap.round()).abs() <= WHOLE && gap > 0.5;
            let steps = gap.round().max(1.0) as usize;
            chained.push(
                chained[k - 1]
                    .saturating_add(before - 1)
                    .saturating_add(steps),
            );
            let place = ((first(k) - first(0)) / period).round().max(0.0) as usize;
            nearest.push(place.max(nearest[k - 1].saturating_add(before)));
        }
        match whole {
            true => self.on(&starts, &chained, None),
            false => self.on(&starts, &nearest, Some(period)),
        }
    }

    fn segments<'s>(self, starts: &'s [usize]) -> impl Iterator<Item = &'a [f64]> + use<'a, 's> {
        let ends = starts.iter().skip(1).copied().chain([self.times.len()]);
        starts
            .iter()
            .zip(ends)
            .map(|(from, to)| &self.times[*from..to])
    }

    /// The grid on which the segments at `starts` begin at `places`, of this `period` or else of the one that fits best.
    fn on(self, starts: &[usize], places: &[usize], period: Option<f64>) -> Grid {
        let mut place = Vec::with_capacity(self.times.len());
        for (segment, first) in self.segments(starts).zip(places) {
            place.extend((0..segment.len()).map(|k| first.saturating_add(k) as f64));
        }
        let count = place.len() as f64;
        let mean = |values: &mut dyn Iterator<Item = f64>| values.sum::<f64>() / count;
        let at = mean(&mut place.iter().copied());
        let origin = self.times[0];
        let of = origin + mean(&mut self.times.iter().map(|time| time - origin));
        let pairs = || place.iter().zip(self.times);
        let period = period.unwrap_or_else(|| {
            let (xx, xy) = pairs().fold((0.0, 0.0), |(xx, xy), (x, t)| {
                (xx + (x - at) * (x - at), xy + (x - at) * (t - of))
            });
            xy / xx
        });
        let residual = pairs()
            .map(|(x, t)| ((t - of) / period - (x - at)).abs())
            .fold(0.0, f64::max);
        let gaps = starts.iter().enumerate().skip(1).filter_map(|(k, row)| {
            let before = places[k - 1].saturating_add(row - starts[k - 1]);
            let missing = places[k].saturating_sub(before);
            (missing > 0).then_some((*row, missing))
        });
        Grid {
            period,
            gaps: gaps.collect(),
            residual,
        }
    }
}

/// The sums of a line through the times of one segment.
struct Line {
    count: usize,
    mean: f64,
    xx: f64,
    xy: f64,
}

impl Line {
    fn of(times: &[f64]) -> Self {
        let count = times.len();
        let origin = times[0];
        let mean = origin + times.iter().map(|time| time - origin).sum::<f64>() / count as f64;
        let middle = 0.5 * (count - 1) as f64;
        let sums = times
            .iter()
            .enumerate()
            .fold((0.0, 0.0), |(xx, xy), (k, time)| {
                let x = k as f64 - middle;
                (xx + x * x, xy + x * (time - mean))
            });
        Self {
            count,
            mean,
            xx: sums.0,
            xy: sums.1,
        }
    }
}
