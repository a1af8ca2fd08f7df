//! A constant, a line, steps, or a line with steps through delays, chosen by the Bayesian information criterion.

use std::ops::Range;

use crate::statistics::{mean, median};

/// The delay at one place of two signals; both in one unit, samples or s.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Local {
    pub(crate) at: f64,
    pub(crate) delay: f64,
    /// Its inverse variance, re that of others.
    pub(crate) weight: f64,
}

/// What becomes of delays far from a fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Outliers {
    /// They count as if they were 4 median residuals away.
    Held,
    /// Those further than five robust standard deviations are left out.
    LeftOut,
}

/// What a course of delays may be.
#[derive(Clone, Debug)]
pub(crate) struct Rules {
    /// How much larger the variance of a mean is, as the places overlap.
    pub(crate) overlap: f64,
    /// Places nearer to a step than so many distances between places are left out, as they hold what is before and behind.
    pub(crate) clear: f64,
    /// The fewest places on either side of a step.
    pub(crate) aside: usize,
    /// The largest number of steps.
    pub(crate) steps: usize,
    /// The size of a step.
    pub(crate) sizes: Range<f64>,
    /// Steps explain the delays where the rest scatters by less than this, or as neighbours do.
    pub(crate) steady: f64,
    /// A smaller median residual counts as this.
    pub(crate) least: f64,
    pub(crate) outliers: Outliers,
}

/// The numbers of standard errors above which a slope, and a step, are significant; more for a step among few places, which is
/// looked for at each of them.
const SIGNIFICANT: (f64, f64) = (3.0, 5.0);
/// A line is shown where its information criterion is lower than that of every course without one by this: very strong evidence.
const VERY_STRONG: f64 = 10.0;
/// The share of a step that its nearest places have to show: a delay that wanders has none.
const SUDDEN: f64 = 0.5;
/// What is left is no larger than this many times the variance of neighbours.
const AS_NEIGHBOURS: f64 = 4.0;
/// The median of absolute residuals of a normal distribution is its standard deviation over this.
const NORMAL: f64 = 1.4826;
/// The number of parts from which the error of a slope is estimated.
const PARTS: usize = 20;

/// Whether a course may have a slope.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Slope {
    None,
    Free,
}

/// How a delay changes.
#[derive(Clone, Debug)]
pub(crate) struct Course {
    /// The line with the steps, or the levels between them where no line is shown.
    pub(crate) fit: Fit,
    /// Where the delay jumps.
    pub(crate) steps: Vec<f64>,
    /// The slope and its standard error where a line is shown against steps and against none.
    pub(crate) slope: Option<[f64; 2]>,
}

impl Course {
    /// The course of `locals`, in the order of their places: the one of the lowest information criterion among a constant, a line, steps
    /// and a line with steps, whose steps are significant, sudden, and of a size that `rules` allow; `None` with too few places.
    ///
    /// Formula: BIC = n·ln(σ²) + p·ln(n), with n independent places, the variance σ² of the rest and p numbers, two for each step.
    ///
    /// Source: G. Schwarz (1978), Ann. Stat. 6(2), 461–464; R. E. Kass and A. E. Raftery (1995), J. Am. Stat. Assoc. 90, for the limit of 10.
    pub(crate) fn of(locals: &[Local], rules: &Rules) -> Option<Self> {
        let level = best(locals, Slope::None, rules);
        let line = best(locals, Slope::Free, rules);
        let line = line.filter(|(bic, fit, _)| {
            let shown = fit.slope.abs() > SIGNIFICANT.0 * fit.slope_error(locals, rules);
            shown
                && level
                    .as_ref()
                    .is_none_or(|(other, ..)| bic + VERY_STRONG < *other)
        });
        let (slope, (_, fit, steps)) = match (line, level) {
            (Some(line), _) => {
                let error = line.1.slope_error(locals, rules);
                (Some([line.1.slope, error]), line)
            }
            (None, level) => (None, level?),
        };
        Some(Self { fit, steps, slope })
    }

    /// The delay at `at`, re the beginning.
    pub(crate) fn change_at(&self, at: f64) -> f64 {
        let jumps = self.steps.iter().zip(&self.fit.jumps);
        let passed = jumps.filter(|(step, _)| **step <= at);
        self.fit.slope * at + passed.map(|(_, jump)| jump).sum::<f64>()
    }
}

/// The fit of the lowest information criterion with that criterion and its steps.
fn best(locals: &[Local], slope: Slope, rules: &Rules) -> Option<(f64, Fit, Vec<f64>)> {
    let noise = neighbours_variance(locals);
    let sums = Sums::of(locals);
    let mut steps: Vec<f64> = Vec::new();
    let mut fit = Fit::of(locals, &steps, slope, rules)?;
    let mut found = (fit.bic(locals, rules), fit, steps.clone());
    while steps.len() < rules.steps {
        let Some(place) = next_step(locals, &sums, &steps, slope, rules) else {
            break;
        };
        steps.push(place);
        steps.sort_by(f64::total_cmp);
        let Some(next) = Fit::of(locals, &steps, slope, rules) else {
            break;
        };
        fit = next;
        let bic = fit.bic(locals, rules);
        if bic < found.0 && fit.is_stepped(locals, &steps, noise, rules) {
            found = (bic, fit, steps.clone());
        }
    }
    Some(found)
}

/// The variance of a delay, from the differences of neighbours.
fn neighbours_variance(locals: &[Local]) -> f64 {
    let pairs = locals.windows(2);
    let mut sizes: Vec<f64> = pairs.map(|p| (p[1].delay - p[0].delay).abs()).collect();
    let usual = NORMAL * median(&mut sizes).unwrap_or(0.0);
    0.5 * usual * usual
}

/// The distance from one place to the next.
fn hop(locals: &[Local]) -> f64 {
    let pairs = locals.windows(2);
    pairs
        .map(|pair| pair[1].at - pair[0].at)
        .fold(f64::INFINITY, f64::min)
}

/// Sums over the places before each: weights, and the weighted places, delays and their products, about the means.
struct Sums(Vec<[f64; 6]>);

impl Sums {
    fn of(locals: &[Local]) -> Self {
        let middle = |of: fn(&Local) -> f64| mean(&locals.iter().map(of).collect::<Vec<_>>());
        let (at, delay) = (middle(|l| l.at), middle(|l| l.delay));
        let mut sum = [0.0; 6];
        let mut sums = vec![sum];
        for local in locals {
            let (w, x, y) = (local.weight, local.at - at, local.delay - delay);
            for (sum, more) in
                sum.iter_mut()
                    .zip([w, w * x, w * y, w * x * x, w * x * y, w * y * y])
            {
                *sum += more;
            }
            sums.push(sum);
        }
        Self(sums)
    }

    /// The weight, and the squares of places, products and squares of delays about their own means, of the places in `range`.
    fn about(&self, range: &Range<usize>) -> [f64; 4] {
        let part = |k: usize| self.0[range.end][k] - self.0[range.start][k];
        let [w, x, y, xx, xy, yy] = [0, 1, 2, 3, 4, 5].map(part);
        let w = w.max(f64::MIN_POSITIVE);
        [w, xx - x * x / w, xy - x * y / w, yy - y * y / w]
    }
}

/// The place between two neighbours at which one more step beside `steps` leaves the least.
fn next_step(
    locals: &[Local],
    sums: &Sums,
    steps: &[f64],
    slope: Slope,
    rules: &Rules,
) -> Option<f64> {
    let reach = rules.clear * hop(locals);
    // The places between the steps, without those at a step.
    let side = |from: f64, to: f64| {
        let first = locals.partition_point(|local| local.at <= from + reach);
        first..locals.partition_point(|local| local.at < to - reach)
    };
    let ends = |steps: &[f64]| -> Vec<Range<usize>> {
        let from = std::iter::once(f64::NEG_INFINITY).chain(steps.iter().copied());
        let to = steps.iter().copied().chain([f64::INFINITY]);
        from.zip(to).map(|(from, to)| side(from, to)).collect()
    };
    let left = |sides: &[[f64; 4]]| {
        let sum = |k: usize| sides.iter().map(|side| side[k]).sum::<f64>();
        let [w, xx, xy, yy] = [0, 1, 2, 3].map(sum);
        let along = match slope {
            Slope::Free => xy * xy / xx.max(f64::MIN_POSITIVE),
            Slope::None => 0.0,
        };
        (yy - along).max(0.0) / w
    };
    let whole: Vec<Range<usize>> = ends(steps);
    let parts: Vec<[f64; 4]> = whole.iter().map(|range| sums.about(range)).collect();
    let mut best: Option<(f64, f64)> = None;
    let mut tried = parts.clone();
    for (number, range) in whole.iter().enumerate() {
        for i in range.start + rules.aside..(range.end + 1).saturating_sub(rules.aside) {
            let place = 0.5 * (locals[i - 1].at + locals[i].at);
            let first = range.start
                ..locals
                    .partition_point(|local| local.at < place - reach)
                    .max(range.start);
            let last = locals
                .partition_point(|local| local.at <= place + reach)
                .min(range.end)..range.end;
            if first.len() < rules.aside.min(2) || last.len() < rules.aside.min(2) {
                continue;
            }
            tried.clear();
            tried.extend_from_slice(&parts);
            tried[number] = sums.about(&first);
            tried.push(sums.about(&last));
            let rest = left(&tried);
            if best.is_none_or(|(least, _)| rest < least) {
                best = Some((rest, place));
            }
        }
    }
    best.map(|(_, place)| place)
}

/// Delays by levels that jump at given places, on one slope.
#[derive(Clone, Debug)]
pub(crate) struct Fit {
    /// The change of the delay over a place.
    pub(crate) slope: f64,
    /// The mean place and delay of all that was used.
    pub(crate) middle: [f64; 2],
    /// How far the delay jumps at each step, and the standard error.
    pub(crate) jumps: Vec<f64>,
    pub(crate) jump_errors: Vec<f64>,
    /// The variance of the rest.
    pub(crate) variance: f64,
    /// How many were used.
    pub(crate) used: f64,
    /// How many numbers were fitted.
    fitted: f64,
    /// The residual of each delay; none for those at a step or left out.
    pub(crate) left: Vec<Option<f64>>,
    /// The sum of the squared distances along the line.
    pub(crate) along: f64,
}

impl Fit {
    /// The fit through `locals` with jumps at `steps`, by reweighted least squares: an outlier does not change the slope.
    pub(crate) fn of(locals: &[Local], steps: &[f64], slope: Slope, rules: &Rules) -> Option<Self> {
        let reach = rules.clear * hop(locals);
        let clear = |local: &Local| steps.iter().all(|step| (local.at - step).abs() > reach);
        let side = |at: f64| steps.iter().filter(|step| **step <= at).count();
        let sides = steps.len() + 1;
        let base = |local: &Local| if clear(local) { local.weight } else { 0.0 };
        let mut weights: Vec<f64> = locals.iter().map(base).collect();
        let fitted = sides as f64 + f64::from(u8::from(slope == Slope::Free));
        let mut fit = None;
        for _ in 0..3 {
            let used = weights.iter().filter(|w| **w > 0.0).count() as f64;
            if used <= fitted {
                return None;
            }
            let mut sums = vec![[0.0; 3]; sides];
            let mut counts = vec![0_usize; sides];
            for (local, w) in locals.iter().zip(&weights).filter(|(_, w)| **w > 0.0) {
                counts[side(local.at)] += 1;
                let sum = &mut sums[side(local.at)];
                *sum = [sum[0] + w, sum[1] + w * local.at, sum[2] + w * local.delay];
            }
            if counts.iter().any(|count| *count < 2) {
                return None;
            }
            let middle = |s: usize| [sums[s][1] / sums[s][0], sums[s][2] / sums[s][0]];
            let (mut across, mut along) = (0.0, 0.0);
            for (local, w) in locals.iter().zip(&weights) {
                let [at, delay] = middle(side(local.at));
                across += w * (local.at - at) * (local.delay - delay);
                along += w * (local.at - at).powi(2);
            }
            let slope = match slope {
                Slope::Free => across / along.max(f64::MIN_POSITIVE),
                Slope::None => 0.0,
            };
            let level = |s: usize| middle(s)[1] - slope * middle(s)[0];
            let left: Vec<f64> = locals
                .iter()
                .map(|local| local.delay - level(side(local.at)) - slope * local.at)
                .collect();
            let all: f64 = weights.iter().sum();
            let squares = left.iter().zip(&weights).map(|(v, w)| w * v * v);
            // Re a weight of 1.
            let variance = squares.sum::<f64>() / all * used / (used - fitted);
            let jump_errors = (1..sides).map(|s| {
                let apart = middle(s)[0] - middle(s - 1)[0];
                let part = 1.0 / sums[s][0] + 1.0 / sums[s - 1][0];
                let tilt = match fitted > sides as f64 {
                    true => apart * apart / along,
                    false => 0.0,
                };
                (rules.overlap * variance * all / used * (part + tilt)).sqrt()
            });
            let whole = |k: usize| sums.iter().map(|sum| sum[k]).sum::<f64>() / all;
            fit = Some(Self {
                slope,
                middle: [whole(1), whole(2)],
                jumps: (1..sides).map(|s| level(s) - level(s - 1)).collect(),
                jump_errors: jump_errors.collect(),
                variance,
                used,
                fitted,
                left: left
                    .iter()
                    .zip(&weights)
                    .map(|(v, w)| (*w > 0.0).then_some(*v))
                    .collect(),
                along: along * used / all,
            });
            let own = left.iter().zip(locals).filter(|(_, local)| clear(local));
            let mut sizes: Vec<f64> = own.map(|(v, _)| v.abs()).collect();
            let usual = median(&mut sizes).unwrap_or(0.0).max(rules.least);
            for ((w, v), local) in weights.iter_mut().zip(&left).zip(locals) {
                *w = base(local)
                    * match rules.outliers {
                        Outliers::Held => (4.0 * usual / v.abs().max(f64::MIN_POSITIVE)).min(1.0),
                        Outliers::LeftOut => f64::from(u8::from(v.abs() <= 5.0 * NORMAL * usual)),
                    };
            }
        }
        fit
    }

    /// The information criterion of the course with these steps.
    fn bic(&self, locals: &[Local], rules: &Rules) -> f64 {
        let n = (locals.len() as f64 / rules.overlap).max(2.0);
        // The place of a step is a number too.
        let numbers = self.fitted + self.jumps.len() as f64;
        n * self.variance.max(rules.least * rules.least).ln() + numbers * n.ln()
    }

    /// Whether every jump is significant, sudden and of an allowed size, and what is left is steady.
    fn is_stepped(&self, locals: &[Local], steps: &[f64], noise: f64, rules: &Rules) -> bool {
        let few = 1.0 + 3.0 / (self.used - 3.0).max(1.0);
        let significant = self
            .jumps
            .iter()
            .zip(&self.jump_errors)
            .all(|(jump, error)| {
                rules.sizes.contains(&jump.abs()) && jump.abs() > SIGNIFICANT.1 * few * error
            });
        let steady = self.variance <= (AS_NEIGHBOURS * noise).max(rules.steady * rules.steady);
        let reach = rules.clear * hop(locals);
        let sudden = || {
            steps.iter().zip(&self.jumps).all(|(step, jump)| {
                let tilted = |local: &Local| local.delay - self.slope * (local.at - step);
                let before = locals.iter().rev().filter(|l| l.at < step - reach);
                let behind = locals.iter().filter(|l| l.at > step + reach);
                let before: Vec<f64> = before.take(rules.aside).map(tilted).collect();
                let behind: Vec<f64> = behind.take(rules.aside).map(tilted).collect();
                let (a, b) = (before.len().max(1) as f64, behind.len().max(1) as f64);
                let doubt = 2.0 * (noise * (1.0 / a + 1.0 / b)).sqrt();
                (mean(&behind) - mean(&before)) / jump >= SUDDEN - doubt / jump.abs()
            })
        };
        significant && steady && sudden()
    }

    /// The standard error of the slope: the larger of that of single places and that of longer parts, in which a delay that wanders
    /// shows.
    pub(crate) fn slope_error(&self, locals: &[Local], rules: &Rules) -> f64 {
        let of_places = (rules.overlap * self.variance / self.along).sqrt();
        let count = locals.len().div_ceil(PARTS).max(1);
        let pairs = locals.iter().zip(&self.left);
        let pairs: Vec<(f64, f64)> = pairs
            .filter_map(|(l, left)| Some((l.at, (*left)?)))
            .collect();
        let parts = pairs.chunks(count).map(|part| {
            let of = |f: fn(&(f64, f64)) -> f64| mean(&part.iter().map(f).collect::<Vec<_>>());
            [of(|p| p.0), of(|p| p.1)]
        });
        let parts: Vec<[f64; 2]> = parts.collect();
        let middle = mean(&parts.iter().map(|p| p[0]).collect::<Vec<f64>>());
        let along: f64 = parts.iter().map(|p| (p[0] - middle).powi(2)).sum();
        let squares: f64 = parts.iter().map(|p| p[1] * p[1]).sum();
        let freedom = (parts.len() as f64 - 2.0 - self.jumps.len() as f64).max(1.0);
        of_places.max((squares / freedom / along.max(f64::MIN_POSITIVE)).sqrt())
    }
}
