//! Events that silence parts: pulses, taps, rhythms.

use super::Parameters;
use super::parameters::taken_off;
use crate::statistics::median;

/// The depth of the dips between events, dB.
const DEPTH_DB: f64 = 15.0;
/// Pulses are as many where dips of this depth part them, dB; peaks of noise are more, and how many depends on the level.
const SURE_DB: f64 = 10.0;
/// Noise has dips of this depth between them, dB; events have none.
const RIPPLE_DB: f64 = 6.0;
/// Where an event begins and ends, dB below its top.
const EDGE_DB: f64 = 6.0;
/// Silence is this far below the strongest event, dB,
const QUIET_DB: f64 = 20.0;
/// or this level at most, dB,
const QUIET_LEVEL_DB: f64 = 3.0;
/// and lasts this long between events, s: where half of them or more are shorter, events fuse to a buzz.
const SILENCE_S: f64 = 0.040;
/// The longest pulse, s.
const LONGEST_PULSE_S: f64 = 0.025;
/// What the envelope takes off a gap, s.
const SMEAR_S: f64 = 0.008;
/// The error of an onset, s.
const ONSET_ERROR_S: f64 = 0.005;
/// Events of a sequence that is remembered in order.
const IN_ORDER: usize = 10;
/// The fewest events that have a metre.
const METRE: usize = 6;

/// The rate of pulses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Rate {
    /// The logarithm of the inverse gap, 1/s.
    pub(super) log: f64,
    pub(super) error: f64,
}

/// A sequence of events.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Sequence {
    onsets_s: Vec<f64>,
    levels_db: Vec<f64>,
}

/// The maxima of `level_db` between dips of at least `depth_db`.
fn peaks(level_db: &[f64], depth_db: f64) -> Vec<usize> {
    let Some(&first) = level_db.first() else {
        return Vec::new();
    };
    let mut found = Vec::new();
    let (mut high, mut low, mut at, mut rising) = (first, first, 0, true);
    for (i, &v) in level_db.iter().enumerate() {
        if rising {
            if v > high {
                (high, at) = (v, i);
            }
            if v < high - depth_db {
                found.push(at);
                (rising, low) = (false, v);
            }
        } else {
            low = low.min(v);
            if v > low + depth_db {
                (rising, high, at) = (true, v, i);
            }
        }
    }
    if rising && high - low > depth_db {
        found.push(at);
    }
    found
}

/// The rate of short pulses in `level_db`, from the gaps between them, weighted by their length; `None` where there are none.
pub(super) fn rate(level_db: &[f64], step_s: f64) -> Option<Rate> {
    let tops = peaks(level_db, DEPTH_DB);
    if tops.len() < 4 || peaks(level_db, SURE_DB).len() > tops.len() {
        return None;
    }
    let width = |&top: &usize| {
        let near = &level_db[top.saturating_sub(40)..(top + 41).min(level_db.len())];
        let above = near.iter().filter(|l| **l > level_db[top] - EDGE_DB);
        above.count() as f64
    };
    let mut widths: Vec<f64> = tops.iter().map(width).collect();
    if median(&mut widths)? * step_s > LONGEST_PULSE_S {
        return None;
    }
    let gap = |pair: &[usize]| {
        let edge = level_db[pair[0]].min(level_db[pair[1]]) - EDGE_DB;
        let between = &level_db[pair[0]..=pair[1]];
        let first = between.iter().position(|l| *l < edge)?;
        let last = between.iter().rposition(|l| *l < edge)?;
        Some((last - first + 1) as f64 * step_s + SMEAR_S)
    };
    let gaps: Vec<f64> = tops.windows(2).map(gap).collect::<Option<_>>()?;
    let count = gaps.len() as f64;
    let sum: f64 = gaps.iter().sum();
    let squares: f64 = gaps.iter().map(|g| g * g).sum();
    let variance = (gaps.iter().map(|g| (g - sum / count).powi(2)).sum::<f64>() / count).max(0.0);
    Some(Rate {
        log: (sum / squares).ln(),
        error: 2.0 * variance.sqrt() / (sum / count) / count.sqrt(),
    })
}

/// The events of `level_db`; `None` of fewer than three, where no silence parts half of them, and in noise.
pub(super) fn sequence(level_db: &[f64], step_s: f64) -> Option<Sequence> {
    let tops = peaks(level_db, DEPTH_DB);
    if tops.len() < 3 || peaks(level_db, RIPPLE_DB).len() != tops.len() {
        return None;
    }
    let loudest = level_db.iter().copied().fold(f64::MIN, f64::max);
    let quiet_db = QUIET_LEVEL_DB.max(loudest - QUIET_DB);
    let (mut onsets_s, mut fused) = (Vec::with_capacity(tops.len()), 0);
    for (i, &top) in tops.iter().enumerate() {
        let start = if i == 0 { 0 } else { tops[i - 1] };
        let part = &level_db[start..=top];
        let silent = part.iter().filter(|l| **l < quiet_db).count();
        fused += usize::from(i > 0 && (silent as f64) * step_s < SILENCE_S);
        let below = part.iter().rposition(|l| *l < level_db[top] - EDGE_DB);
        onsets_s.push((start + below.map_or(0, |at| at + 1)) as f64 * step_s);
    }
    let levels_db = tops.iter().map(|top| level_db[*top]).collect();
    (2 * fused < tops.len() - 1).then_some(Sequence {
        onsets_s,
        levels_db,
    })
}

/// The autocorrelation of event levels over 2, 3 and 4 events, and their standard deviation, dB.
fn metre(levels_db: &[f64]) -> ([f64; 3], f64) {
    let v = super::course::about_mean(levels_db);
    let own = v.iter().map(|v| v * v).sum::<f64>() / v.len() as f64;
    if own < 1e-9 {
        return ([0.0; 3], 0.0);
    }
    let correlations = [2, 3, 4].map(|lag| {
        let pairs = v.iter().zip(&v[lag..]);
        pairs.map(|(a, b)| a * b).sum::<f64>() / (v.len() - lag) as f64 / own
    });
    (correlations, own.sqrt())
}

impl Sequence {
    fn intervals_s(&self) -> Vec<f64> {
        self.onsets_s.windows(2).map(|w| w[1] - w[0]).collect()
    }

    /// How far the accents of two sequences are apart, JND, where one of level is `level_jnd_db`.
    pub(super) fn accents_jnd(&self, other: &Self, level_jnd_db: f64) -> f64 {
        if self.levels_db.len().min(other.levels_db.len()) < METRE {
            return 0.0;
        }
        let both = [self, other].map(|s| (metre(&s.levels_db), s.levels_db.len() as f64));
        let variance: f64 = both
            .iter()
            .map(|((r, sd), n)| {
                let regular = r.iter().copied().fold(0.0, f64::max).min(1.0);
                2.0 * sd * sd * (1.0 - regular) / n
            })
            .sum();
        let [((a, sd_a), _), ((b, sd_b), _)] = both;
        let square: f64 = a
            .iter()
            .zip(&b)
            .map(|(a, b)| (a * sd_a - b * sd_b).powi(2))
            .sum();
        super::left((square / 3.0).sqrt(), variance, taken_off::ACCENTS) / level_jnd_db
    }

    /// How far their intervals are apart, JND: in order where both have few, or the middle one.
    pub(super) fn rhythm_jnd(&self, other: &Self, p: &Parameters) -> f64 {
        let apart = |x: f64, y: f64| {
            let error = |i: f64| 2.0 * (ONSET_ERROR_S / i).powi(2);
            super::left((y / x).ln(), error(x) + error(y), taken_off::INTERVALS)
        };
        let (mut a, mut b) = (self.intervals_s(), other.intervals_s());
        let found = if a.len().max(b.len()) < IN_ORDER {
            let squares = a.iter().zip(&b).map(|(x, y)| apart(*x, *y).powi(2));
            (squares.sum::<f64>() / a.len().min(b.len()) as f64).sqrt()
        } else {
            match (median(&mut a), median(&mut b)) {
                (Some(x), Some(y)) => apart(x, y),
                _ => 0.0,
            }
        };
        found / p.duration_share.ln_1p()
    }
}
