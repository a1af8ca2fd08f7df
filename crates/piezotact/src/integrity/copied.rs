//! Channels that are one signal: the same but for a factor, an offset and a delay of whole samples.

use crate::clipping::step;
use crate::fourier::RealTransform;
use crate::statistics::{mean, rms, standard_deviation};

/// The relation of a copied signal to its original.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Copy {
    /// The copy over the original.
    pub factor: f64,
    /// How many samples later the copy is.
    pub later: i64,
}

/// Samples that are compared first, and how far a copy may be shifted.
const EXCERPT: usize = 8192;
/// Two signals whose shapes differ by more than this are not compared.
const ALIKE: f64 = 0.02;
/// The largest residual of an excerpt, for converters that round.
const LEFT_OF_EXCERPT: f64 = 0.05;
/// What may be left of the whole: the noise of two converters, −66 dB. What a device and a sensor make of a drive differs by more.
const LEFT: f64 = 5e-4;
/// A signal of fewer steps of a converter is not judged.
const FEWEST_STEPS: f64 = 20.0;
/// So many lags of a periodic signal are tried on the whole.
const MOST_LAGS: usize = 8;
/// Rounding of both, in steps.
const ROUNDED: f64 = 0.75;

/// The relation of `b` to `a` (factor and delay in samples) if `b` is a copy; both have one rate and length; otherwise `None`.
/// The residual may be the noise and rounding of converters: independent measurements are never so equal.
///
/// Formula: b(i) = factor·a(i − later) + offset, by the largest cross-correlation of their changes.
///
/// Source: house rule; coherence of 1 to rounding.
#[must_use]
pub fn copied(a: &[f64], b: &[f64]) -> Option<Copy> {
    let count = a.len().min(b.len());
    if count < 256 || Shape::of(a).differs(&Shape::of(b)) {
        return None;
    }
    let changes = |x: &[f64]| -> Vec<f64> { x.windows(2).map(|pair| pair[1] - pair[0]).collect() };
    // Where the copy is loudest.
    let length = EXCERPT.min(count / 4);
    let from = (0..count - length)
        .step_by((length / 2).max(1))
        .map(|from| {
            (
                from,
                rms(&b[from..from + length]),
                standard_deviation(&b[from..from + length]),
            )
        })
        .max_by(|x, y| x.2.total_cmp(&y.2))?
        .0;
    let excerpt = changes(&b[from..from + length]);
    let start = from.saturating_sub(EXCERPT);
    let wide = changes(&a[start..(from + length + EXCERPT).min(count)]);
    // The copy's sample `from` is the original's sample `start + lag`. A periodic signal is alike at many lags: the shortest delay counts.
    let later = |lag: usize| from as i64 - (start + lag) as i64;
    let mut lags = best_lags(&wide, &excerpt);
    lags.sort_by_key(|lag| later(*lag).abs());
    let is_copy = |lag: &usize| {
        let Some(original) = wide.get(*lag..lag + excerpt.len()) else {
            return false;
        };
        let (ab, aa) = sums(original, &excerpt);
        let factor = ab / aa;
        let left = left_over(original, &excerpt, factor);
        factor.is_finite() && factor != 0.0 && left <= LEFT_OF_EXCERPT * rms(&excerpt)
    };
    let mut alike = lags.into_iter().filter(is_copy).take(MOST_LAGS);
    alike.find_map(|lag| as_a_whole(&a[..count], &b[..count], later(lag)))
}

/// The relation of the whole of `b` to `a` that comes `later` samples before, with its offset; `None` if it is no copy.
fn as_a_whole(a: &[f64], b: &[f64], later: i64) -> Option<Copy> {
    let (x, y) = overlap(a, b, later);
    let (mean_x, mean_y) = (mean(x), mean(y));
    let (mut xy, mut xx) = (0.0, 0.0);
    for (x, y) in x.iter().zip(y) {
        xy += (x - mean_x) * (y - mean_y);
        xx += (x - mean_x) * (x - mean_x);
    }
    let factor = xy / xx;
    let offset = mean_y - factor * mean_x;
    let (mut square, mut most) = (0.0, 0.0_f64);
    for (x, y) in x.iter().zip(y) {
        let left = y - factor * x - offset;
        square += left * left;
        most = most.max(left.abs());
    }
    let left = (square / y.len() as f64).sqrt();
    let level = standard_deviation(y);
    let (step_x, step_y) = (step(x) * factor.abs(), step(y));
    let rounded = most <= ROUNDED * (step_x + step_y) && level >= FEWEST_STEPS * step_x.max(step_y);
    (level > 0.0 && (left <= LEFT * level || rounded)).then_some(Copy { factor, later })
}

/// Signal properties that a factor and a delay do not change.
struct Shape {
    mean_change: f64,
    next: f64,
}

impl Shape {
    fn of(samples: &[f64]) -> Self {
        let (mut all, mut squares, mut next, mut last) = (0.0, 0.0, 0.0, 0.0);
        for pair in samples.windows(2) {
            let change = pair[1] - pair[0];
            all += change.abs();
            squares += change * change;
            next += change * last;
            last = change;
        }
        let count = samples.len().max(2) as f64 - 1.0;
        let level = (squares / count).sqrt();
        Self {
            mean_change: all / count / level,
            next: next / squares,
        }
    }

    fn differs(&self, other: &Self) -> bool {
        let alike = |a: f64, b: f64| (a - b).abs() <= ALIKE;
        !(alike(self.mean_change, other.mean_change) && alike(self.next, other.next))
    }
}

/// Where in `wide` the correlation with `part` has a peak as high as the largest, but for [`ALIKE`].
fn best_lags(wide: &[f64], part: &[f64]) -> Vec<usize> {
    let size = (wide.len() + part.len()).next_power_of_two();
    let mut plan = RealTransform::new(size);
    let (x, y) = (plan.forward(wide), plan.forward(part));
    let product = x.iter().zip(&y).map(|(x, y)| x * y.conj()).collect();
    let correlation = plan.inverse(product);
    let lags = (wide.len() + 1).saturating_sub(part.len());
    let size = |lag: usize| correlation[lag].abs();
    let largest = (0..lags).map(size).fold(0.0, f64::max);
    if largest == 0.0 {
        return Vec::new();
    }
    let is_peak = |lag: &usize| {
        let beside = [lag.saturating_sub(1), (lag + 1).min(lags - 1)];
        size(*lag) >= (1.0 - ALIKE) * largest
            && beside.iter().all(|other| size(*other) <= size(*lag))
    };
    (0..lags).filter(is_peak).collect()
}

fn sums(a: &[f64], b: &[f64]) -> (f64, f64) {
    a.iter()
        .zip(b)
        .fold((0.0, 0.0), |(ab, aa), (a, b)| (ab + a * b, aa + a * a))
}

fn left_over(a: &[f64], b: &[f64], factor: f64) -> f64 {
    let square: f64 = a
        .iter()
        .zip(b)
        .map(|(a, b)| (b - factor * a) * (b - factor * a))
        .sum();
    (square / a.len().max(1) as f64).sqrt()
}

/// The parts of two signals that belong together when the second comes `later` samples later.
fn overlap<'a>(a: &'a [f64], b: &'a [f64], later: i64) -> (&'a [f64], &'a [f64]) {
    let shift = later.unsigned_abs() as usize;
    let kept = a.len().saturating_sub(shift);
    if later >= 0 {
        (&a[..kept], &b[shift..shift + kept])
    } else {
        (&a[shift..shift + kept], &b[..kept])
    }
}
