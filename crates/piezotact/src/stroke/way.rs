//! The way along a surface at every sample of a stroke, from a channel of speed or position.

use super::frames::smoothed;
use super::speed::SMOOTHING_S;
use super::{Interval, MotionKind, Signals};
use crate::quantity::{SampleRate, Seconds};

/// A part of a stroke counts while it moves one way, faster than this share of the stroke's usual speed …
const MOVES: f64 = 0.5;
/// … and is at least this long, s.
const SHORTEST_S: f64 = 0.1;
/// Longer parts are cut, s: a spectrum takes memory as its longest part.
const LONGEST_S: f64 = 10.0;

/// A part of a stroke that moves one way.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Way {
    /// Its samples.
    pub(crate) part: Interval,
    /// The way from its first sample at each of its samples, m; it rises throughout.
    pub(crate) way_m: Vec<f64>,
    /// The slowest and the fastest speed in it, m/s.
    pub(crate) slowest_m_s: f64,
    pub(crate) fastest_m_s: f64,
}

impl Way {
    /// Its whole length, m.
    pub(crate) fn length_m(&self) -> f64 {
        self.way_m.last().copied().unwrap_or(0.0)
    }

    /// The mean speed, m/s.
    pub(crate) fn speed_m_s(&self, rate: SampleRate) -> f64 {
        self.length_m() / rate.duration_of(self.way_m.len().saturating_sub(1)).0
    }
}

/// The parts of `stroke` that move one way, were the motion recorded `late`; none without a channel of motion.
///
/// Formula: s = ∫v dt, or the position between the samples at which it changes (a tracker holds its last value, an encoder counts
/// steps), smoothed over 20 ms.
///
/// Source: house rule.
pub(crate) fn ways(signals: &Signals<'_>, stroke: Interval, late: Seconds) -> Vec<Way> {
    let Some((motion, kind)) = signals.motion else {
        return Vec::new();
    };
    let rate = signals.rate;
    let late = (late.0 * rate.hz()).round() as isize;
    let moved = |sample: usize| sample.saturating_add_signed(late).min(motion.len());
    let first = stroke.start;
    let stroke = Interval {
        start: moved(stroke.start),
        end: moved(stroke.end),
    };
    let width = rate.samples_in(Seconds(SMOOTHING_S)).max(1);
    // The motion around the stroke is smoothed with it, so that its ends are those of the motion.
    let outer = Interval {
        start: stroke.start.saturating_sub(2 * width),
        end: (stroke.end + 2 * width).min(motion.len()),
    };
    let around = outer.of(motion);
    let place_m = match kind {
        MotionKind::Speed => {
            let mut place_m = 0.0;
            let speed = smoothed(around, width);
            let each = speed.iter().map(|v| {
                place_m += v / rate.hz();
                place_m
            });
            each.collect()
        }
        MotionKind::Position => smoothed(&between_changes(around), width),
    };
    let inside = Interval {
        start: stroke.start - outer.start,
        end: stroke.end.min(outer.end) - outer.start,
    };
    let place_m = inside.of(&place_m);
    let reach = (width / 2).max(1);
    let last = place_m.len().saturating_sub(1);
    let speed_m_s: Vec<f64> = (0..place_m.len())
        .map(|i| {
            let (a, b) = (i.saturating_sub(reach), (i + reach).min(last));
            (place_m[b] - place_m[a]) * rate.hz() / (b - a).max(1) as f64
        })
        .collect();
    let mut fast: Vec<f64> = speed_m_s.iter().map(|v| v.abs()).collect();
    let Some(usual_m_s) = crate::statistics::median(&mut fast).filter(|usual| *usual > 0.0) else {
        return Vec::new();
    };
    let direction = |v: f64| match v.abs() >= MOVES * usual_m_s {
        true => v.signum() as i8,
        false => 0,
    };
    let shortest = rate.samples_in(Seconds(SHORTEST_S));
    let longest = rate.samples_in(Seconds(LONGEST_S));
    let mut ways = Vec::new();
    let mut from = 0;
    while from < speed_m_s.len() {
        let sign = direction(speed_m_s[from]);
        let run = speed_m_s[from..].iter().take(longest.max(1));
        let to = from + run.take_while(|v| direction(**v) == sign).count();
        if sign != 0 && to - from > shortest.max(2) {
            ways.push(way(
                first + from,
                &place_m[from..to],
                &speed_m_s[from..to],
                f64::from(sign),
            ));
        }
        from = to;
    }
    ways
}

fn way(start: usize, place_m: &[f64], speed_m_s: &[f64], sign: f64) -> Way {
    let mut highest_m = 0.0f64;
    let way_m = place_m.iter().map(|place| {
        // Noise of a position may step back.
        highest_m = highest_m.max(sign * (place - place_m[0]));
        highest_m
    });
    let speeds = || speed_m_s.iter().map(|v| v.abs());
    Way {
        part: Interval {
            start,
            end: start + place_m.len(),
        },
        way_m: way_m.collect(),
        slowest_m_s: speeds().fold(f64::MAX, f64::min),
        fastest_m_s: speeds().fold(0.0, f64::max),
    }
}

/// `values` with straight lines between the samples at which they change.
fn between_changes(values: &[f64]) -> Vec<f64> {
    let mut lines = values.to_vec();
    let mut known = 0;
    for i in 1..values.len() {
        if values[i] == values[i - 1] {
            continue;
        }
        let (from, to) = (values[known], values[i]);
        let length = (i - known) as f64;
        for (j, value) in lines[known..i].iter_mut().enumerate() {
            *value = from + (to - from) * j as f64 / length;
        }
        known = i;
    }
    lines
}
