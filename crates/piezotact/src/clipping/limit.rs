//! Detection of clipping from the distribution of amplitudes: the share of samples at a limit.

use std::cell::LazyCell;

use super::histogram::{FromEnd, Histogram};
use super::pass::{Ends, ends, near, next_below, tally};

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
/// A single-sided extreme with more than this share of the samples may be a rest level: where it is near zero, or where zero is far from
/// both ends, so that it is not known which of them is at rest.
const REST: f64 = 0.5;
/// Zero is far from both ends of a signal where the nearer one is at this part of the farther one, or more.
const FAR_FROM_ZERO: f64 = 0.5;
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
    limited_at(samples).0
}

/// The limits of a sensor that a whole recording shows: a part of it that stands at one may be too short or too clipped to show it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Rails {
    low: Option<f64>,
    high: Option<f64>,
}

impl Rails {
    /// The limits in `samples`, in their unit; none on a side where nothing clips.
    ///
    /// Source: [`limited`].
    pub(crate) fn of(samples: &[f64]) -> Self {
        limited_at(samples).1
    }

    /// The share of the samples of `part`, which is of the same recording, that are at these limits or at one that it shows itself, 0–1.
    pub(crate) fn share(self, part: &[f64]) -> f64 {
        let [low, high] = [self.low, self.high].map(|rail| rail.unwrap_or(f64::NAN));
        let at_rail = part.iter().filter(|v| **v <= low || **v >= high).count();
        let own = limited(part).share();
        match at_rail < FEWEST_SAMPLES {
            true => own,
            false => own.max(at_rail as f64 / part.len() as f64),
        }
    }
}

/// Where samples of an end stand.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Place {
    /// At one value.
    Exact,
    /// Around one value, or nowhere.
    Near,
}

/// [`limited`], with the places of the limits.
fn limited_at(samples: &[f64]) -> (Limited, Rails) {
    let nothing = Rails {
        low: None,
        high: None,
    };
    let Ends { low, high, step } = ends(samples);
    if samples.len() < 16
        || low >= high
        || !takes_more_than(FEW_STEPS, samples, SAME * (high - low))
    {
        return (Limited::default(), nothing);
    }
    let histogram = Histogram::of(samples, low, high);
    // A square wave has its median at one of its ends.
    let quarter = 0.25 * (high - low);
    let middle = histogram.median().clamp(low + quarter, high - quarter);
    let rounding = ROUNDING * (high - low);
    let at_ends = near(samples, [low, high], rounding);
    let bins = |sign: f64, extreme: f64| Bins::of(samples.len(), sign * (extreme - middle), step);
    let side = |sign: f64, extreme: f64, at_limit: usize| {
        // Silence is not clipping.
        if extreme == 0.0 {
            return (0.0, extreme, Place::Near);
        }
        let end = histogram.seen_from(sign);
        if let Some(share) = at_the_extreme(samples, (sign, extreme), at_limit, rounding) {
            return (share, extreme - sign * rounding, Place::Exact);
        }
        let (share, rail) = bins(sign, extreme)
            .filter(|bins| bins.may_hold_a_peak(end))
            .map_or((0.0, extreme), |bins| {
                peak_at_the_end(samples, sign, extreme, middle, bins)
            });
        (share, rail, Place::Near)
    };
    let (low_share, low_rail, low_place) = side(-1.0, low, at_ends[0]);
    let (high_share, high_rail, high_place) = side(1.0, high, at_ends[1]);
    let found = Limited {
        low: low_share,
        high: high_share,
    };
    let one_sided = found.low <= 0.0 || found.high <= 0.0;
    let resting = |sign: f64, share: f64, extreme: f64| {
        let counts = || bins(sign, extreme).map(|bins| Counts::of(samples, sign, extreme, bins));
        let largest = low.abs().max(high.abs());
        share > 0.0 && rests_near_zero(samples, sign, extreme, middle, largest, counts())
    };
    // A weight that lies on the finger gives a steady force with the noise of its cell: only what stands at one value is a limit.
    let held_at_rest = |place: Place, extreme: f64, other: f64| {
        let far = extreme * other > 0.0 && other.abs() > FAR_FROM_ZERO * extreme.abs();
        place == Place::Near || far || extreme.abs() <= NEAR_ZERO * other.abs()
    };
    let mostly_rests = found.share() > REST
        && match found.low > 0.0 {
            true => held_at_rest(low_place, low, high),
            false => held_at_rest(high_place, high, low),
        };
    // A steady load that comes and goes stands near two levels, for long at a time.
    let crossings = || {
        let pairs = samples.windows(2);
        pairs
            .filter(|pair| (pair[0] > middle) != (pair[1] > middle))
            .count()
    };
    let two_levels = found.share() > REST
        && [low_place, high_place] == [Place::Near; 2]
        && samples.len() as f64 > LONG_REST * (crossings() + 1) as f64;
    let rests = two_levels
        || one_sided
            && (mostly_rests || resting(-1.0, found.low, low) || resting(1.0, found.high, high));
    if rests || (found.share() > SQUARE && regular(samples, 0.5 * (low + high))) {
        (Limited::default(), nothing)
    } else {
        let rails = Rails {
            low: (found.low > 0.0).then_some(low_rail),
            high: (found.high > 0.0).then_some(high_rail),
        };
        (found, rails)
    }
}

/// Values that differ by less than this part of the range are one.
const ROUNDING: f64 = 1e-13;

/// The share of samples that equal the extreme, as `at_limit` of them do, where that is a limit.
fn at_the_extreme(
    samples: &[f64],
    (sign, extreme): (f64, f64),
    at_limit: usize,
    rounding: f64,
) -> Option<f64> {
    if at_limit < FEWEST_SAMPLES {
        return None;
    }
    let mut beside = sign * extreme;
    for _ in 0..NEIGHBOURS {
        beside = next_below(samples, sign, beside - rounding);
        let [count] = near(samples, [sign * beside], rounding);
        if at_limit < ABOVE_NEIGHBOURS * count {
            return None;
        }
    }
    let (mut begins, mut inside) = (Vec::new(), false);
    for (at, v) in samples.iter().enumerate() {
        let now = (v - extreme).abs() <= rounding;
        if now && !inside {
            begins.push(at);
        }
        inside = now;
    }
    let single = at_limit <= CREST * begins.len() && evenly(&begins);
    Some(if begins.len() < FEWEST_VISITS || single {
        0.0
    } else {
        at_limit as f64 / samples.len() as f64
    })
}

/// A crest of a wave whose period is a whole number of samples is one sample, or two of the same value on either side of it.
const CREST: usize = 2;
/// The least share of distances between visits that are the same in such a wave; the first ones are on its way to it.
const EVENLY: f64 = 0.9;

/// Whether nearly all of `begins`, in samples, are as far from the one before.
fn evenly(begins: &[usize]) -> bool {
    let mut apart: Vec<usize> = begins.windows(2).map(|pair| pair[1] - pair[0]).collect();
    apart.sort_unstable();
    let Some(usual) = apart.get(apart.len() / 2) else {
        return false;
    };
    let same = apart.iter().filter(|one| *one == usual).count();
    same as f64 >= EVENLY * apart.len() as f64
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

/// The bins from the end of a distribution to its middle in which a peak is looked for.
#[derive(Clone, Copy)]
struct Bins {
    count: usize,
    width: f64,
    /// The least number of samples in a peak.
    least: f64,
}

impl Bins {
    /// The bins of `samples` samples over `range`, in whole steps, so that each holds as many values; none where there is too
    /// little for a peak.
    fn of(samples: usize, range: f64, step: f64) -> Option<Self> {
        let width = step * (range / (BINS as f64 * step)).ceil().max(1.0);
        let count = (range / width) as usize;
        (samples >= FEWEST_FOR_A_PEAK && count >= FEWEST_BINS).then_some(Self {
            count,
            width,
            least: LEAST_PEAK * samples as f64,
        })
    }

    /// The widths of the peaks that are looked for, in bins.
    fn widths(self) -> impl Iterator<Item = usize> {
        let next = |width: &usize| Some((width * 5 / 4).max(width + 1));
        let widest = self.count / WIDEST_PART;
        std::iter::successors(Some(NARROWEST), next).take_while(move |width| *width <= widest)
    }

    /// The bins at which a peak may begin: with few samples `beyond` them re those `inside` the widest peak.
    fn starts(
        self,
        beyond: impl Fn(usize) -> f64,
        inside: impl Fn(usize, usize) -> f64,
    ) -> Vec<usize> {
        let widest = self.widths().last().unwrap_or(NARROWEST);
        let mut starts = Vec::new();
        for from in 0..self.count / 2 {
            let (beyond, inside) = (beyond(from), inside(from, from + widest));
            if beyond <= BEYOND * inside {
                starts.extend((inside > self.least).then_some(from));
            } else if beyond > self.least {
                break;
            }
        }
        starts
    }

    /// Whether there may be a peak at `end`: false only where the bounds of the counts exclude that [`Counts::peak`] finds one. Places
    /// at which it may begin are excluded several at a time.
    fn may_hold_a_peak(self, end: FromEnd<'_>) -> bool {
        let edge = |bins: usize| bins as f64 * self.width;
        let most = |bins: usize| f64::from(end.at_most(edge(bins)));
        let least = |bins: usize| f64::from(end.at_least(edge(bins)));
        let widths: Vec<usize> = self.widths().collect();
        let widest = widths.last().copied().unwrap_or(NARROWEST);
        let looked_at = 0..self.count / 2 + AT_A_TIME + 2 * widest;
        // Many places are seldom looked at more closely.
        let both = LazyCell::new(|| -> Vec<[f64; 2]> {
            looked_at.map(|bins| [most(bins), least(bins)]).collect()
        });
        let may_exceed = |from: usize| {
            let both: &[[f64; 2]] = &both;
            let inside = |width: usize| both[from + width][0] - both[from][1];
            let exceeds = |width: &usize| {
                let (to, inside) = (from + width, inside(*width));
                // At the flattest slope the samples after a peak predict as many as they are.
                let predicted = (both[to + width][1] - both[to][0]).max(0.0) / (EVEN - 1.0);
                inside > self.least
                    && inside > ABOVE_PREDICTION * predicted
                    && excess(inside, predicted) > 0.0
            };
            inside(widest) > self.least && widths.iter().any(exceeds)
        };
        for from in (0..self.count / 2).step_by(AT_A_TIME) {
            let (beyond, inside) = (least(from), most(from + AT_A_TIME + widest) - least(from));
            if beyond > BEYOND * inside && beyond > self.least {
                break;
            }
            let open = beyond <= BEYOND * inside && inside > self.least;
            if open && (from..from + AT_A_TIME).any(may_exceed) {
                return true;
            }
        }
        false
    }
}

/// How many places at which a peak may begin are excluded at a time.
const AT_A_TIME: usize = 8;

/// By how many samples a peak exceeds what is certain to come from crests.
fn excess(inside: f64, predicted: f64) -> f64 {
    inside - ABOVE_PREDICTION * predicted - 6.0 * (predicted + 1.0).sqrt()
}

/// The counts of samples from the end of a distribution on: `sums[k]` lie within k bins of it.
struct Counts {
    sums: Vec<usize>,
    bins: Bins,
}

impl Counts {
    fn of(samples: &[f64], sign: f64, extreme: f64, bins: Bins) -> Self {
        let place = move |v: f64| sign * (extreme - v) / bins.width + 1e-6;
        let counts = tally(samples, bins.count as u32, place);
        let mut sums = vec![0_usize; bins.count + 1];
        for k in 1..=bins.count {
            sums[k] = sums[k - 1] + counts[k - 1] as usize;
        }
        Self { sums, bins }
    }

    fn between(&self, from: usize, to: usize) -> f64 {
        let last = self.sums.len() - 1;
        (self.sums[to.min(last)] - self.sums[from.min(last)]) as f64
    }

    /// The peak that exceeds what crests predict by the most: its count without the background, and how far from the end of the
    /// distribution it ends.
    fn peak(&self) -> Option<(f64, f64)> {
        let mut best: Option<(f64, f64, usize)> = None;
        let starts = self.bins.starts(
            |from| self.between(0, from),
            |from, to| self.between(from, to),
        );
        for width in self.bins.widths() {
            for from in &starts {
                let (from, to) = (*from, from + width);
                let (beyond, inside) = (self.between(0, from), self.between(from, to));
                if beyond > BEYOND * inside {
                    if beyond > self.bins.least {
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
                let sure = excess(inside, predicted);
                let enough = inside > self.bins.least && sure > 0.0;
                if enough && best.is_none_or(|(most, ..)| sure > most) {
                    // The distribution goes on under half of the peak.
                    best = Some((sure, inside + beyond - 0.5 * next, to));
                }
            }
        }
        best.map(|(_, count, to)| (count, to as f64 * self.bins.width))
    }
}

/// The share of samples in a narrow peak at the end of the distribution, and where the peak begins.
fn peak_at_the_end(
    samples: &[f64],
    sign: f64,
    extreme: f64,
    middle: f64,
    bins: Bins,
) -> (f64, f64) {
    let found = Counts::of(samples, sign, extreme, bins).peak();
    let Some((count, end)) = found else {
        return (0.0, extreme);
    };
    let limit = extreme - sign * end;
    let visits = visits(samples, sign, middle, limit);
    let held = visits < FEWEST_VISITS_OF_A_PEAK;
    if held || (count < LONG_VISIT * visits as f64 && repeats(samples)) {
        (0.0, limit)
    } else {
        (count / samples.len() as f64, limit)
    }
}

/// Whether the peak at the end of the distribution is a rest level: near zero, re the `largest` magnitude, and held for
/// long times.
fn rests_near_zero(
    samples: &[f64],
    sign: f64,
    extreme: f64,
    middle: f64,
    largest: f64,
    counts: Option<Counts>,
) -> bool {
    let peak = counts.and_then(|counts| counts.peak());
    let end = peak.map_or(extreme, |(_, end)| extreme - sign * end);
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

/// What is below this part of the largest distance from the middle at both ends of a signal is rest.
const REST_LEVEL: f64 = 0.3;

/// Whether a signal is a wave that repeats itself after a whole number of samples, from one time to the next and far away; rest before and
/// behind it, and its first and last tenth, say nothing.
fn repeats(samples: &[f64]) -> bool {
    let mean = samples.iter().sum::<f64>() / samples.len() as f64;
    let largest = samples.iter().map(|v| (v - mean).abs()).fold(0.0, f64::max);
    let moves = |v: &f64| (v - mean).abs() > REST_LEVEL * largest;
    let from = samples.iter().position(moves).unwrap_or(0);
    let to = samples.iter().rposition(moves).unwrap_or(0);
    let tenth = (to.saturating_sub(from)) / 10;
    let samples = samples
        .get(from + tenth..(to + 1).saturating_sub(tenth))
        .unwrap_or_default();
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

#[cfg(test)]
mod tests {
    use crate::clipping::step;
    use crate::statistics::random::Random;

    use super::*;

    /// Noise and waves of many distributions, clipped before or after noise, some in the steps of a converter.
    fn signal(random: &mut Random) -> Vec<f64> {
        let mut uniform = |low: f64, high: f64| low + (high - low) * random.uniform();
        let samples = uniform(1000.0, 9000.0) as usize;
        let [noise, wave, offset] = [uniform(0.0, 1.0), uniform(0.0, 2.0), uniform(-3.0, 3.0)];
        let [low, high] = [uniform(-6.0, -0.5), uniform(0.5, 6.0)];
        let (period, order) = (uniform(5.0, 700.0), uniform(1.0, 4.0) as i32);
        let (after, step) = (uniform(-0.1, 0.1).max(0.0), uniform(-0.02, 0.02).max(0.0));
        (0..samples)
            .map(|i| {
                let phase = std::f64::consts::TAU * i as f64 / period;
                let value = wave * phase.sin().powi(order) + noise * random.normal();
                let value = offset + value.clamp(low, high) + after * random.normal();
                if step > 0.0 {
                    (value / step).round() * step
                } else {
                    value
                }
            })
            .collect()
    }

    /// A tone of `period` samples with its crest at the phase `shift`, through a resonance that settles, so that the crests before it lie below.
    fn settled(period: usize, shift: f64, limit: f64) -> Vec<f64> {
        (0..40_000)
            .map(|i| {
                let phase = std::f64::consts::TAU * (i % period) as f64 / period as f64;
                let settling = 1.0 - (-(i as f64) / 700.0).exp();
                (settling * (phase + shift).cos()).clamp(-limit, limit)
            })
            .collect()
    }

    #[test]
    fn a_tone_of_a_whole_number_of_samples_is_not_clipped_until_it_is() {
        for period in [8, 10, 20, 48, 100, 441, 600] {
            for shift in [0.0, 0.1, std::f64::consts::PI / period as f64] {
                let clean = limited(&settled(period, shift, 2.0));
                assert_eq!(clean, Limited::default(), "{period} {shift}");
                if period >= 20 {
                    let clipped = limited(&settled(period, shift, 0.8));
                    // cos⁻¹(0.8)/π of the time, but for the settling.
                    let share = 0.8_f64.acos() / std::f64::consts::PI;
                    assert!(
                        (clipped.share() - 2.0 * share).abs() < 0.1,
                        "{period} {clipped:?}"
                    );
                    assert!(clipped.low > 0.0 && clipped.high > 0.0);
                }
            }
        }
    }

    /// A force of 0 to 1 N that stands at its upper limit for most of the time is clipped; one that rests at zero for as long is not.
    #[test]
    fn rest_is_at_zero_and_not_at_an_extreme() {
        let mut random = Random::stream(3, 0, "rest");
        let presses = |i: usize| i % 2000 < 1300;
        let noise: Vec<f64> = (0..40_000).map(|_| random.normal()).collect();
        let force = |rest_n: f64, press_n: f64| -> Vec<f64> {
            let of = |(i, noise): (usize, &f64)| {
                let level_n = if presses(i) { press_n } else { rest_n };
                level_n + 0.05 * noise
            };
            noise.iter().enumerate().map(of).collect()
        };
        for sign in [1.0, -1.0] {
            let saturated: Vec<f64> = force(0.0, 2.0).iter().map(|v| sign * v.min(1.0)).collect();
            let found = limited(&saturated);
            assert!((found.share() - 0.65).abs() < 0.01, "{sign}: {found:?}");
            // Each part of it, though it holds nothing but the limit and what lies close below.
            let rails = Rails::of(&saturated);
            assert!(rails.share(&saturated[..1300]) > 0.99, "{sign}: {rails:?}");
            assert_eq!(rails.share(&saturated[1300..2000]), 0.0, "{sign}");
            // The amplifier shows nothing below 0.2 N, four times its noise.
            let resting: Vec<f64> = force(1.0, 0.0).iter().map(|v| sign * v.max(0.2)).collect();
            assert_eq!(limited(&resting), Limited::default(), "{sign}");
            // A weight that lies on the finger for as long, with the noise of the cell.
            let weight: Vec<f64> = force(0.0, 2.0).iter().map(|v| sign * v).collect();
            assert_eq!(limited(&weight), Limited::default(), "{sign}");
            for samples in [40_000, 400_000] {
                let still: Vec<f64> = (0..samples)
                    .map(|i| {
                        sign * 0.15 * f64::from(u8::from(presses(i))) + 0.001 * noise[i % 40_000]
                    })
                    .collect();
                assert_eq!(limited(&still), Limited::default(), "{sign} {samples}");
            }
            // Where zero lies outside of the range, either end may be rest.
            let far: Vec<f64> = resting.iter().map(|v| v + sign * 200.0).collect();
            assert_eq!(limited(&far), Limited::default(), "{sign}");
        }
    }

    #[test]
    fn a_peak_that_the_histogram_excludes_is_not_there() {
        let mut random = Random::stream(17, 0, "clipping");
        let (mut excluded, mut found, mut missed) = (0, 0, 0);
        for _ in 0..300 {
            let samples = signal(&mut random);
            let low = samples.iter().copied().fold(f64::MAX, f64::min);
            let high = samples.iter().copied().fold(f64::MIN, f64::max);
            let histogram = Histogram::of(&samples, low, high);
            let middle = histogram.median();
            for (sign, extreme) in [(-1.0, low), (1.0, high)] {
                let range = sign * (extreme - middle);
                let Some(bins) = Bins::of(samples.len(), range, step(&samples)) else {
                    continue;
                };
                let peak = Counts::of(&samples, sign, extreme, bins).peak();
                let possible = bins.may_hold_a_peak(histogram.seen_from(sign));
                excluded += usize::from(!possible);
                found += usize::from(peak.is_some());
                missed += usize::from(peak.is_some() && !possible);
            }
        }
        assert_eq!(missed, 0);
        // Both happen often, so that the rule above is tested.
        assert!(excluded > 100 && found > 50, "{excluded}, {found}");
    }
}
