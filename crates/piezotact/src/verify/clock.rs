//! Clock drift and lost samples: how the delay of a measurement changes over time, and the measurement corrected to the
//! clock of its target.

use serde::{Deserialize, Serialize};

use crate::fourier::{RealTransform, fast_length};
use crate::quantity::{Band, SampleRate};
use crate::resample::at_places;
use crate::statistics::{mean, median, vertex};

/// Samples that a recording lost, or repeated.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Lost {
    /// When, on the time of the target, s.
    pub at_s: f64,
    /// How many, at the rate of the comparison; below zero where samples were repeated.
    pub samples: f64,
}

/// How the delay of a measurement changes over time.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Clock {
    /// How much slower the clock of the target runs than that of the measurement, parts per million; the delay grows at this
    /// rate. Absent when no drift was detected.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub drift_ppm: Option<f64>,
    /// Samples that the recording lost.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub lost: Vec<Lost>,
    /// The rms of the delay that drift and lost samples do not explain, s; absent when the delay could not be tracked.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub wander_s: Option<f64>,
    /// The delay at the target's first sample, samples.
    #[serde(skip)]
    begin: f64,
}

impl Clock {
    /// Whether the measurement needs a clock correction.
    pub(super) fn differs(&self) -> bool {
        self.drift_ppm.is_some() || !self.lost.is_empty()
    }

    /// The same clock with drift and lost samples reset: no correction was made.
    pub(super) fn uncorrected(self) -> Self {
        Self {
            drift_ppm: None,
            lost: Vec::new(),
            ..self
        }
    }

    /// The delay at the target's first sample, s.
    pub(super) fn begins_s(&self, rate_hz: f64) -> f64 {
        self.begin / rate_hz
    }

    /// The delay at sample `i` of the target, in samples.
    fn delay_at(&self, i: f64, rate_hz: f64) -> f64 {
        let lost = self
            .lost
            .iter()
            .filter(|lost| lost.at_s * rate_hz <= i)
            .map(|lost| -lost.samples)
            .sum::<f64>();
        self.begin + self.drift_ppm.unwrap_or(0.0) * 1e-6 * i + lost
    }
}

/// The shortest window in which a delay is looked for, s.
const WINDOW_S: f64 = 0.25;
/// The length of a window in periods of the lowest frequency.
const PERIODS: f64 = 6.0;
/// The search range for a delay on either side of the delay of the previous window, s.
const SEARCH_S: f64 = 0.01;
/// The lowest correlation at which a window is taken to follow its target.
const FOLLOWS: f64 = 0.6;
/// Windows with less than this share of the mean power are not used for delays.
const LEAST_POWER: f64 = 0.02;
/// The fewest windows from which a change of the delay is estimated.
const FEWEST: usize = 5;
/// The largest plausible difference between two clocks, parts per million.
const MOST_PPM: f64 = 500.0;
/// A smaller jump of the delay, in samples, is a wandering delay and not lost samples.
const LEAST_LOST: f64 = 0.7;
/// A longer jump of the delay is a pause and not lost samples, s.
const LONGEST_LOST_S: f64 = 0.01;
/// The largest number of places at which lost samples are looked for.
const MOST_PLACES: usize = 4;
/// A delay is steady when it scatters by less than this about its line, in samples.
const STEADY: f64 = 0.15;
/// The least distance between two steps, in windows: as windows overlap, one step shows in two consecutive windows.
const MIN_STEP_DISTANCE: usize = 3;

/// The delay of one window.
#[derive(Clone, Copy, Debug)]
struct Local {
    /// The middle of the window, samples of the target.
    at: f64,
    /// How much later the measurement is there, samples.
    delay: f64,
    weight: f64,
}

/// How the delay of `measured` changes over the samples of `target`, to which it is otherwise aligned. Both
/// are limited to `band`; `sign` is −1 for a measurement with the sign reversed.
///
/// Source: the delay by cross-correlation of windows of 0.25 s or six periods, found from one window to the next; a line for
/// two clocks and steps for lost samples by least squares, each only where it explains the observed delays.
pub(super) fn clock(
    target: &[f64],
    measured: &[f64],
    rate: SampleRate,
    band: Band,
    sign: f64,
) -> Clock {
    let locals = followed(target, measured, rate, band, sign);
    if locals.len() < FEWEST {
        return Clock::default();
    }
    let most = LONGEST_LOST_S * rate.hz();
    let counted = |jump: &f64| (LEAST_LOST..=most).contains(&jump.abs());
    // The fewest steps after which the delay is steady. A delay that stays unsteady is not explained by lost samples, but
    // a drift may still explain it.
    let places = jumps(&locals);
    let (fit, steps) = (0..=places.len())
        .map(|count| {
            let mut steps = places[..count].to_vec();
            steps.sort_by(f64::total_cmp);
            (Fit::of(&locals, &steps), steps)
        })
        .find(|(fit, _)| fit.spread < STEADY && fit.jumps.iter().all(counted))
        .unwrap_or_else(|| (Fit::of(&locals, &[]), Vec::new()));
    let ppm = fit.slope * 1e6;
    let length = target.len() as f64;
    let shown = fit.slope.abs() > 3.0 * fit.slope_error
        && (fit.slope * length).abs() > STEADY
        && ppm.abs() <= MOST_PPM;
    let lost = steps.iter().zip(&fit.jumps).map(|(at, jump)| Lost {
        at_s: at / rate.hz(),
        // After a lost sample everything arrives one sample earlier.
        samples: whole(-jump),
    });
    Clock {
        drift_ppm: shown.then_some(ppm),
        lost: lost.collect(),
        wander_s: Some(fit.spread / rate.hz()),
        begin: fit.begin,
    }
}

/// Rounds to whole samples: a recording whose rate did not change loses whole samples.
fn whole(samples: f64) -> f64 {
    if (samples - samples.round()).abs() < 0.2 {
        samples.round()
    } else {
        samples
    }
}

/// The places, in samples of the target, where the delay changes most from one window to the next beyond its usual change:
/// the largest change first, and no more than [`MOST_PLACES`].
fn jumps(locals: &[Local]) -> Vec<f64> {
    let changes: Vec<f64> = locals
        .windows(2)
        .map(|pair| pair[1].delay - pair[0].delay)
        .collect();
    let usual = median(&mut changes.clone()).unwrap_or(0.0);
    let mut order: Vec<usize> = (0..changes.len()).collect();
    order.sort_by(|a, b| {
        let size = |i: usize| (changes[i] - usual).abs();
        size(*b).total_cmp(&size(*a))
    });
    let mut chosen: Vec<usize> = Vec::new();
    for i in order {
        if chosen.len() == MOST_PLACES {
            break;
        }
        if chosen
            .iter()
            .all(|other| i.abs_diff(*other) >= MIN_STEP_DISTANCE)
        {
            chosen.push(i);
        }
    }
    chosen
        .into_iter()
        .map(|i| 0.5 * (locals[i].at + locals[i + 1].at))
        .collect()
}

/// The delays of the windows of `target` that `measured` follows, in the order of time.
fn followed(
    target: &[f64],
    measured: &[f64],
    rate: SampleRate,
    band: Band,
    sign: f64,
) -> Vec<Local> {
    let length = ((WINDOW_S.max(PERIODS / band.low().0.max(1.0))) * rate.hz()) as usize;
    let search = ((SEARCH_S * rate.hz()) as usize).max(2);
    let hop = length / 2;
    if length < 16 || target.len() < 3 * length || measured.len() < target.len() {
        return Vec::new();
    }
    let power = |x: &[f64]| x.iter().map(|v| v * v).sum::<f64>();
    let least = LEAST_POWER * power(target) * length as f64 / target.len() as f64;
    let mut transform = RealTransform::new(fast_length(2 * length + 2 * search + 1));
    let count = (target.len() - length) / hop + 1;
    // The delay of window `w`, looked for around `around`, and its correlation.
    let mut at = |w: usize, around: f64| -> Option<(f64, f64)> {
        let from = w * hop;
        let cut = &target[from..from + length];
        let own = power(cut);
        if own < least {
            return None;
        }
        let begin = from as i64 + around.round() as i64 - search as i64;
        let wide: Vec<f64> = (begin..begin + (length + 2 * search) as i64)
            .map(|i| {
                let sample = usize::try_from(i).ok().and_then(|i| measured.get(i));
                sign * sample.copied().unwrap_or(0.0)
            })
            .collect();
        let (a, b) = (transform.forward(cut), transform.forward(&wide));
        let cross = a.iter().zip(&b).map(|(a, b)| a.conj() * b).collect();
        let products = transform.inverse(cross);
        // The power of the measurement under the window at every lag.
        let mut under = power(&wide[..length]);
        let normed: Vec<f64> = (0..=2 * search)
            .map(|lag| {
                if lag > 0 {
                    under += wide[length + lag - 1].powi(2) - wide[lag - 1].powi(2);
                }
                products[lag] / (own * under.max(1e-12 * own)).sqrt()
            })
            .collect();
        let largest = normed.iter().copied().fold(0.0, f64::max);
        if largest < FOLLOWS {
            return None;
        }
        // Of equally high maxima the nearest: the correlation of a periodic signal has one every period.
        let middle = search as f64 + around - around.round();
        let crest = (1..2 * search)
            .filter(|&k| normed[k] >= normed[k - 1] && normed[k] >= normed[k + 1])
            .filter(|&k| normed[k] > 0.9 * largest)
            .min_by(|&a, &b| {
                (a as f64 - middle)
                    .abs()
                    .total_cmp(&(b as f64 - middle).abs())
            })?;
        let on = normed[crest];
        let part = vertex([normed[crest - 1], on, normed[crest + 1]]);
        let delay = around.round() + crest as f64 + part - search as f64;
        Some((delay, on.min(1.0)))
    };
    let Some((start, first)) = (0..count)
        .filter_map(|w| Some((w, at(w, 0.0)?)))
        .max_by(|a, b| a.1.1.total_cmp(&b.1.1))
    else {
        return Vec::new();
    };
    let local = |w: usize, (delay, correlation): (f64, f64)| Local {
        at: w as f64 * hop as f64 + 0.5 * length as f64,
        delay,
        weight: correlation.powi(2) / (1.001 - correlation.powi(2)),
    };
    let mut found = vec![local(start, first)];
    let mut near = first.0;
    for w in start + 1..count {
        if let Some(next) = at(w, near) {
            near = next.0;
            found.push(local(w, next));
        }
    }
    near = first.0;
    for w in (0..start).rev() {
        if let Some(next) = at(w, near) {
            near = next.0;
            found.push(local(w, next));
        }
    }
    found.sort_by(|a, b| a.at.total_cmp(&b.at));
    found
}

/// A line with steps through delays.
struct Fit {
    /// Samples of delay a sample.
    slope: f64,
    slope_error: f64,
    /// The delay at the first sample.
    begin: f64,
    /// How far the delay jumps at each place, samples.
    jumps: Vec<f64>,
    /// The rms of what is left, samples.
    spread: f64,
}

impl Fit {
    /// The fit of one slope with jumps at `steps` to `locals`; windows on a step are left out.
    fn of(locals: &[Local], steps: &[f64]) -> Self {
        let sides = steps.len() + 1;
        let side = |at: f64| steps.iter().filter(|step| **step <= at).count();
        let hop = locals
            .windows(2)
            .map(|pair| pair[1].at - pair[0].at)
            .fold(f64::INFINITY, f64::min);
        let clear = |local: &&Local| steps.iter().all(|step| (local.at - step).abs() > 0.6 * hop);
        let used: Vec<Local> = locals.iter().filter(clear).copied().collect();
        let mut weights: Vec<f64> = used.iter().map(|local| local.weight.min(50.0)).collect();
        let (mut slope, mut levels) = (0.0, vec![0.0; sides]);
        let mut left: Vec<f64> = Vec::new();
        // Reweighted least squares: an outlying window does not change the slope.
        for _ in 0..4 {
            let mut sums = vec![(0.0, 0.0, 0.0); sides];
            for (local, w) in used.iter().zip(&weights) {
                let sum = &mut sums[side(local.at)];
                *sum = (sum.0 + w, sum.1 + w * local.at, sum.2 + w * local.delay);
            }
            let middle = |s: usize| {
                let (w, at, delay) = sums[s];
                (at / w.max(1e-12), delay / w.max(1e-12))
            };
            let (mut across, mut along) = (0.0, 0.0);
            for (local, w) in used.iter().zip(&weights) {
                let (at, delay) = middle(side(local.at));
                across += w * (local.at - at) * (local.delay - delay);
                along += w * (local.at - at).powi(2);
            }
            slope = if along > 0.0 { across / along } else { 0.0 };
            for (s, level) in levels.iter_mut().enumerate() {
                let (at, delay) = middle(s);
                *level = delay - slope * at;
            }
            left = used
                .iter()
                .map(|local| local.delay - levels[side(local.at)] - slope * local.at)
                .collect();
            let mut sizes: Vec<f64> = left.iter().map(|v| v.abs()).collect();
            let usual = median(&mut sizes).unwrap_or(0.0).max(1e-3);
            for ((w, local), v) in weights.iter_mut().zip(&used).zip(&left) {
                *w = local.weight.min(50.0) * (3.0 * usual / v.abs().max(1e-9)).min(1.0);
            }
        }
        let n = used.len() as f64;
        let squares: f64 = left.iter().map(|v| v * v).sum();
        let middle = mean(&used.iter().map(|local| local.at).collect::<Vec<f64>>());
        let along: f64 = used.iter().map(|local| (local.at - middle).powi(2)).sum();
        let freedom = (n - 1.0 - sides as f64).max(1.0);
        Self {
            slope,
            begin: levels[0],
            // Windows overlap by half: two of them count as about 1.5 independent ones.
            slope_error: (1.5 * squares / freedom / along.max(1e-12)).sqrt(),
            jumps: levels.windows(2).map(|pair| pair[1] - pair[0]).collect(),
            spread: (squares / n.max(1.0)).sqrt(),
        }
    }
}

impl Clock {
    /// The places of lost samples, refined to the sample: those with the least difference between `target` and
    /// `measured`, which are aligned but for this clock.
    pub(super) fn refined(mut self, target: &[f64], measured: &[f64], rate_hz: f64) -> Self {
        for place in 0..self.lost.len() {
            let (mut without, mut with) = (self.clone(), self.clone());
            without.lost.remove(place);
            with.lost[place].at_s = f64::NEG_INFINITY;
            let around = self.lost[place].at_s * rate_hz;
            let reach = 2.0 * WINDOW_S * rate_hz;
            let from = (around - reach).max(0.0) as usize;
            let to = ((around + reach) as usize).min(target.len());
            let differences = |clock: &Self| -> Vec<f64> {
                let taken = at_places(measured, to - from, |i| {
                    let i = (from + i) as f64;
                    i + clock.delay_at(i, rate_hz)
                });
                let pairs = taken.iter().zip(&target[from..to]);
                pairs.map(|(m, t)| (m - t).powi(2)).collect()
            };
            let (before, after) = (differences(&without), differences(&with));
            let mut best = (f64::INFINITY, 0);
            let mut sum: f64 = after.iter().sum();
            for i in 0..before.len() {
                if sum < best.0 {
                    best = (sum, i);
                }
                sum += before[i] - after[i];
            }
            self.lost[place].at_s = (from + best.1) as f64 / rate_hz;
        }
        self
    }

    /// `samples` interpolated at each of `count` samples of the target; sample `later` belongs to the target's first.
    pub(super) fn corrected(
        &self,
        samples: &[f64],
        count: usize,
        later: f64,
        rate_hz: f64,
    ) -> Vec<f64> {
        let about = mean(samples);
        let samples: Vec<f64> = samples.iter().map(|sample| sample - about).collect();
        at_places(&samples, count, |i| {
            let i = i as f64;
            i + later + self.delay_at(i, rate_hz)
        })
    }
}
