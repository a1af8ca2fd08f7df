//! Detection of clipping from the distribution of amplitudes: the share of samples at a limit.

/// The shares of samples at a lower and at an upper limit, 0–1 of all samples.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Limited {
    /// At the lower limit.
    pub low: f64,
    /// At the upper limit.
    pub high: f64,
}

impl Limited {
    /// Both together, 0–1.
    #[must_use]
    pub fn share(self) -> f64 {
        self.low + self.high
    }
}

/// The least number of visits to a limit; fewer visits are crests of a slow signal.
const FEWEST_VISITS: usize = 3;
/// Samples of exactly the extreme value are a limit from this number on.
const FEWEST_SAMPLES: usize = 6;
/// The extreme value has to come so much more often than any of the values beside it. A sine that is quantised has 2.4
/// times as many samples on its last step as on the one before, a crest that is flat to the third order 5.3 times.
const ABOVE_NEIGHBOURS: usize = 6;
/// The number of values beside the extreme that are examined.
const NEIGHBOURS: usize = 8;
/// A signal of no more steps than these of a converter stands at its limits without having been clipped.
const FEW_STEPS: usize = 16;
/// A single-sided extreme with more than this share of the samples is a rest level, not a limit.
const REST: f64 = 0.5;
/// One side alone, near zero, and held for so many samples at a time on average: a sensor at rest between contacts. Near zero: within this
/// part of the largest magnitude.
const LONG_REST: f64 = 256.0;
const NEAR_ZERO: f64 = 0.3;
/// Both sides, more than this share and plateaus of one length: a square wave.
const SQUARE: f64 = 0.65;

/// The shares of samples at the limits, 0–1 of all samples; 0 where nothing clips. Exact limits are values that come more often than
/// those beside them. Limits under noise, or behind a filter, are a narrow peak at the end of the distribution, higher
/// than the crests of any smooth wave make it.
///
/// Formula: a crest flat to the order m leaves N(w) ∝ w^(1/m) samples within w of it, so that the counts below predict
/// the count at the end; what exceeds three times the prediction for m ≤ 4 is a limit.
///
/// Source: the arcsine law of a sine's amplitudes, and Monte Carlo tests beside this code.
#[must_use]
pub fn limited(samples: &[f64]) -> Limited {
    let (mut low, mut high) = (f64::MAX, f64::MIN);
    for v in samples {
        low = low.min(*v);
        high = high.max(*v);
    }
    if samples.len() < 16
        || low >= high
        || !takes_more_than(FEW_STEPS, samples, SAME * (high - low))
    {
        return Limited::default();
    }
    // A square wave has its median at one of its ends.
    let quarter = 0.25 * (high - low);
    let middle = middle(samples, low, high).clamp(low + quarter, high - quarter);
    let side = |sign: f64, extreme: f64| {
        at_the_extreme(samples, sign, extreme, ROUNDING * (high - low))
            .unwrap_or_else(|| peak_at_the_end(samples, sign, extreme, middle))
    };
    let found = Limited {
        low: side(-1.0, low),
        high: side(1.0, high),
    };
    let one_sided = found.low <= 0.0 || found.high <= 0.0;
    let resting = |sign: f64, share: f64, extreme: f64| {
        share > 0.0 && rests_near_zero(samples, sign, extreme, middle, low.abs().max(high.abs()))
    };
    let rests = one_sided
        && (found.share() > REST
            || resting(-1.0, found.low, low)
            || resting(1.0, found.high, high));
    if rests || (found.share() > SQUARE && regular(samples, 0.5 * (low + high))) {
        Limited::default()
    } else {
        found
    }
}

/// Values that differ by less than this part of the range are one.
const ROUNDING: f64 = 1e-13;

/// The share of samples that equal the extreme, where that is a limit.
fn at_the_extreme(samples: &[f64], sign: f64, extreme: f64, rounding: f64) -> Option<f64> {
    // Silence is not clipping.
    if extreme == 0.0 {
        return Some(0.0);
    }
    let count = |value: f64| {
        let equal = samples.iter().map(|v| (v - value).abs() <= rounding);
        equal.map(usize::from).sum::<usize>()
    };
    let at_limit = count(extreme);
    if at_limit < FEWEST_SAMPLES {
        return None;
    }
    let mut beside = sign * extreme;
    for _ in 0..NEIGHBOURS {
        let below = beside - rounding;
        let next = samples.iter().map(|v| sign * v).filter(|v| *v < below);
        beside = next.fold(f64::MIN, f64::max);
        if at_limit < ABOVE_NEIGHBOURS * count(sign * beside) {
            return None;
        }
    }
    let (mut visits, mut inside) = (0, false);
    for v in samples {
        let now = (v - extreme).abs() <= rounding;
        visits += usize::from(now && !inside);
        inside = now;
    }
    Some(if visits < FEWEST_VISITS {
        0.0
    } else {
        at_limit as f64 / samples.len() as f64
    })
}

/// Whether a signal stays on one side of `middle` always for the same time, within two samples or 5 %.
fn regular(samples: &[f64], middle: f64) -> bool {
    let mut lengths: Vec<usize> = samples
        .chunk_by(|a, b| (*a < middle) == (*b < middle))
        .map(<[f64]>::len)
        .collect();
    // The first and the last are cut.
    let last = lengths.len().saturating_sub(1);
    lengths = lengths.get(1..last).unwrap_or_default().to_vec();
    if lengths.is_empty() {
        return true;
    }
    lengths.sort_unstable();
    let (few, many) = (lengths.len() / 10, lengths.len() - 1 - lengths.len() / 10);
    lengths[many] - lengths[few] <= (lengths[many] / 20).max(2)
}

/// Values that differ by less than this part of the range are one step of a converter, computed otherwise.
const SAME: f64 = 1e-9;

/// Whether `samples` take more than `count` values that are further apart than `same`.
fn takes_more_than(count: usize, samples: &[f64], same: f64) -> bool {
    let mut seen: Vec<f64> = Vec::with_capacity(count + 1);
    samples.iter().any(|sample| {
        if !seen.iter().any(|known| (known - sample).abs() <= same) {
            seen.push(*sample);
        }
        seen.len() > count
    })
}

/// The most bins of the histogram from the middle of a distribution to its end, and the fewest steps of a converter.
const BINS: usize = 1024;
const FEWEST_BINS: usize = 64;
/// The narrowest peak that is looked for, in bins, and the widest, as a part of all.
const NARROWEST: usize = 2;
const WIDEST_PART: usize = 5;
/// The fewest samples for statistics of amplitudes.
const FEWEST_FOR_A_PEAK: usize = 1000;
/// A peak that is visited less often is a level that was held, such as a force.
const FEWEST_VISITS_OF_A_PEAK: usize = 50;
/// A wave that repeats itself sample by sample has peaks everywhere, unless a visit lasts for more samples than these.
const LONG_VISIT: f64 = 24.0;
/// The least share that is found under noise.
const LEAST_PEAK: f64 = 0.002;
/// The largest number of samples beyond a limit, as a share of those at the limit.
const BEYOND: f64 = 0.05;
/// The least ratio of the count in a peak to that expected from the crests of a smooth wave.
const ABOVE_PREDICTION: f64 = 3.0;
/// Between a crest that is flat to the third order and an even distribution: the ratio of counts in two widths and one.
const FLATTEST_CREST: f64 = 1.19;
const EVEN: f64 = 2.0;

/// The median, to 1/4096 of the range.
fn middle(samples: &[f64], low: f64, high: f64) -> f64 {
    const STEPS: usize = 4096;
    let scale = STEPS as f64 / (high - low);
    let mut counts = vec![0_usize; STEPS + 1];
    for v in samples {
        counts[((v - low) * scale) as usize] += 1;
    }
    let mut below = 0;
    for (bin, count) in counts.iter().enumerate() {
        below += count;
        if 2 * below >= samples.len() {
            return low + (bin as f64 + 0.5) / scale;
        }
    }
    high
}

/// The smallest change from one sample to the next that is none at all: the step of a converter.
pub(crate) fn step(samples: &[f64]) -> f64 {
    samples
        .windows(2)
        .map(|pair| (pair[1] - pair[0]).abs())
        .filter(|change| *change > 0.0)
        .fold(f64::MAX, f64::min)
}

/// The counts of samples from the end of a distribution on: `sums[k]` lie within k bins of `width` of it.
struct Counts {
    sums: Vec<usize>,
    width: f64,
}

impl Counts {
    fn of(samples: &[f64], sign: f64, extreme: f64, middle: f64) -> Option<Self> {
        let (range, step) = (sign * (extreme - middle), step(samples));
        // Bins of whole steps, so that each holds as many values.
        let width = step * (range / (BINS as f64 * step)).ceil().max(1.0);
        let bins = (range / width) as usize;
        if samples.len() < FEWEST_FOR_A_PEAK || bins < FEWEST_BINS {
            return None;
        }
        let mut sums = vec![0_usize; bins + 1];
        for v in samples {
            let from_end = (sign * (extreme - v) / width + 1e-6) as usize;
            if from_end < bins {
                sums[from_end + 1] += 1;
            }
        }
        for k in 1..=bins {
            sums[k] += sums[k - 1];
        }
        Some(Self { sums, width })
    }

    fn between(&self, from: usize, to: usize) -> f64 {
        let last = self.sums.len() - 1;
        (self.sums[to.min(last)] - self.sums[from.min(last)]) as f64
    }

    /// The peak that exceeds what crests predict by the most: its count without the background, and where it ends, in bins.
    fn peak(&self, least: f64) -> Option<(f64, usize)> {
        let bins = self.sums.len() - 1;
        let mut best: Option<(f64, f64, usize)> = None;
        let mut width = NARROWEST;
        while width <= bins / WIDEST_PART {
            for from in 0..bins / 2 {
                let to = from + width;
                let (beyond, inside) = (self.between(0, from), self.between(from, to));
                if beyond > BEYOND * inside {
                    if beyond > least {
                        break;
                    }
                    continue;
                }
                let (next, after) = (
                    self.between(to, to + width),
                    self.between(to + width, to + 3 * width),
                );
                let ratio = (after / next.max(1.0)).clamp(FLATTEST_CREST, EVEN);
                let predicted = next / (ratio - 1.0);
                let sure = inside - ABOVE_PREDICTION * predicted - 6.0 * (predicted + 1.0).sqrt();
                if inside > least && sure > 0.0 && best.is_none_or(|(most, ..)| sure > most) {
                    // The distribution goes on under half of the peak.
                    best = Some((sure, inside + beyond - 0.5 * next, to));
                }
            }
            width = (width * 5 / 4).max(width + 1);
        }
        best.map(|(_, count, to)| (count, to))
    }
}

/// The share of samples in a narrow peak at the end of the distribution.
fn peak_at_the_end(samples: &[f64], sign: f64, extreme: f64, middle: f64) -> f64 {
    let found = Counts::of(samples, sign, extreme, middle).and_then(|counts| {
        let (count, to) = counts.peak(LEAST_PEAK * samples.len() as f64)?;
        Some((count, extreme - sign * to as f64 * counts.width))
    });
    let Some((count, limit)) = found else {
        return 0.0;
    };
    let visits = visits(samples, sign, middle, limit);
    let held = visits < FEWEST_VISITS_OF_A_PEAK;
    if held || (count < LONG_VISIT * visits as f64 && repeats(samples)) {
        0.0
    } else {
        count / samples.len() as f64
    }
}

/// Whether the peak at the end of the distribution is a rest level: near zero, re the `largest` magnitude, and held for
/// long times.
fn rests_near_zero(samples: &[f64], sign: f64, extreme: f64, middle: f64, largest: f64) -> bool {
    let end = Counts::of(samples, sign, extreme, middle)
        .and_then(|counts| {
            let (_, to) = counts.peak(LEAST_PEAK * samples.len() as f64)?;
            Some(extreme - sign * to as f64 * counts.width)
        })
        .unwrap_or(extreme);
    let at_rest = samples.iter().filter(|v| sign * (*v - end) >= 0.0).count();
    let visits = visits(samples, sign, middle, end).max(1);
    end.abs().max(extreme.abs()) <= NEAR_ZERO * largest
        && at_rest as f64 >= LONG_REST * visits as f64
}

/// How often a signal goes beyond `limit` after it was on the other side of `middle`.
fn visits(samples: &[f64], sign: f64, middle: f64, limit: f64) -> usize {
    let (mut count, mut been) = (0, false);
    for v in samples {
        if sign * (v - limit) >= 0.0 {
            count += usize::from(!been);
            been = true;
        } else if sign * (v - middle) < 0.0 {
            been = false;
        }
    }
    count
}

/// The longest period of a wave that repeats itself, in samples, and of how many of them it is looked at.
const LONGEST_PERIOD: usize = 2048;
const LOOKED_AT: usize = 1024;
/// What two periods differ by at most, as a part of the power: one after the other, and half a signal apart, where a period
/// that is not quite whole has moved on.
const ALIKE: f64 = 0.02;
const ALIKE_FAR: f64 = 0.5;

/// Whether a signal is a wave that repeats itself after a whole number of samples, from one time to the next and far away.
fn repeats(samples: &[f64]) -> bool {
    // Silence at the ends says nothing.
    let quiet = |v: &f64, end: f64| (v - end).abs() <= 0.0;
    let (first, last) = (samples[0], samples[samples.len() - 1]);
    let from = samples.iter().position(|v| !quiet(v, first)).unwrap_or(0);
    let to = samples.iter().rposition(|v| !quiet(v, last)).unwrap_or(0);
    let samples = &samples[from.min(to)..=to];
    let far = samples.len() / 2;
    if far < 16 {
        return false;
    }
    let longest = LONGEST_PERIOD.min(far / 2);
    let first = &samples[..LOOKED_AT.min(far / 2)];
    let mean = first.iter().sum::<f64>() / first.len() as f64;
    let power: f64 = first.iter().map(|v| (v - mean) * (v - mean)).sum();
    let alike = |lag: usize, share: f64| {
        let mut difference = 0.0;
        for (a, b) in first.chunks(64).zip(samples[lag..].chunks(64)) {
            difference += a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>();
            if difference > 2.0 * share * power {
                return false;
            }
        }
        true
    };
    (2..longest).any(|lag| alike(lag, ALIKE) && alike(far / lag * lag, ALIKE_FAR))
}
