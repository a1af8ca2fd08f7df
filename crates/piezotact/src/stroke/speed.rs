//! Passive touch: strokes by the plateau of the surface's speed.

use serde::{Deserialize, Serialize};

use super::contact::{above_baseline, events};
use super::frames::{Frames, quantile, smoothed};
use super::{
    CutBy, Expected, Interval, MotionKind, Reason, Rejected, Rule, SegmentError, Segmentation,
    Signals, Stroke,
};
use crate::doubt::Doubt;
use crate::quantity::{Newtons, SampleRate, Seconds};
use crate::roles::Roles;
use crate::verify::flat_top_fraction;

/// How strokes are found in the speed of a surface.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SpeedRule {
    /// The speed is smoothed over this time.
    pub smoothing_s: Seconds,
    /// The plateau holds its speed within this share of it.
    pub tolerance_share: f64,
    /// What is slower than this share of the fastest is rest.
    pub rest_share: f64,
    /// A plateau is at least this long.
    pub shortest_s: Seconds,
    /// The surface is touched when the normal force is above this, N above its baseline.
    pub touch_n: Newtons,
    /// The speed that was asked for, m/s; none when it is not known.
    pub speed_m_s: Option<f64>,
}

impl SpeedRule {
    /// The rule for a trapezoidal speed: a plateau within ±5 %, of 0.3 s and more, while the finger touches with a
    /// quarter of the load (0.2 N where it is not stated).
    #[must_use]
    pub fn trapezoid(expected: Expected) -> Self {
        Self {
            smoothing_s: Seconds(SMOOTHING_S),
            tolerance_share: 0.05,
            rest_share: 0.2,
            shortest_s: Seconds(0.3),
            touch_n: Newtons(0.25 * expected.load_n.map_or(0.2, |load| load.0)),
            speed_m_s: expected.speed_m_s,
        }
    }
}

/// Speeds are smoothed over this time unless stated, s.
const SMOOTHING_S: f64 = 0.02;
/// A plateau this far from the speed asked for is a doubt.
const OFF_SPEED: f64 = 0.1;

/// The strokes in `signals` by their motion: the plateaus of the speed, while the finger touches where a normal
/// force was measured.
///
/// Source: the protocol of passive touch with a trapezoidal speed; L. Felicetti's thesis (2024), section 2.3.2.
///
/// # Errors
/// [`SegmentError::NothingToCutBy`] without a motion, [`SegmentError::Dead`] when nothing moves,
/// [`SegmentError::Rule`] for a rule that cannot be.
pub fn segment_by_speed(
    signals: &Signals<'_>,
    rule: &SpeedRule,
) -> Result<Segmentation, SegmentError> {
    if !(rule.tolerance_share > 0.0 && rule.rest_share > 0.0 && rule.rest_share < 1.0) {
        return Err(SegmentError::Rule {
            expected: "a tolerance above zero and a rest between 0 and 1",
            found: format!("{} and {}", rule.tolerance_share, rule.rest_share),
        });
    }
    let (motion, kind) = signals.motion.ok_or(SegmentError::NothingToCutBy)?;
    let frames = Frames::at(signals.rate);
    let speed = speed_m_s(frames, motion, kind, rule.smoothing_s.0);
    let fastest = speed.iter().fold(0.0f64, |fastest, v| fastest.max(v.abs()));
    if fastest <= 0.0 {
        return Err(SegmentError::Dead {
            what: "the motion",
            found: format!("{:.2e} m/s", fastest),
        });
    }
    let mut doubts = Vec::new();
    let touched = match signals.normal_force_n {
        Some(normal_n) => {
            let smoothing = frames.in_time(0.01);
            let means: Vec<f64> = frames.means(normal_n);
            let (on, off) = (rule.touch_n.0, 0.5 * rule.touch_n.0);
            // A finger that touches all along leaves no lift to take a baseline from.
            let raw = events(smoothed(&means, smoothing), on, off);
            let covers = |touches: &[(usize, usize)]| {
                touches.iter().map(|(a, b)| b - a).sum::<usize>() as f64 / means.len().max(1) as f64
            };
            if covers(&raw) > 0.95 {
                Some(raw)
            } else {
                let force = above_baseline(frames, &means, smoothing, on);
                Some(events(force.level_n, on, off))
            }
        }
        None => {
            doubts.push(Doubt::ContactAssumed);
            None
        }
    };
    let moving: Vec<f64> = speed.iter().map(|v| v.abs()).collect();
    let threshold = rule.rest_share * fastest;
    let mut strokes = Vec::new();
    let mut rejected = Vec::new();
    for (from, to) in events(moving.iter().copied(), threshold, threshold) {
        let motion = samples(frames, from, to);
        match plateau(frames, &moving[from..to], rule) {
            Err(reason) => rejected.push(Rejected {
                interval: motion,
                reason,
            }),
            Ok((a, b)) => {
                let steady = samples(frames, from + a, from + b);
                let reason = unfit(signals, frames, touched.as_deref(), steady);
                match reason {
                    Some(reason) => rejected.push(Rejected {
                        interval: motion,
                        reason,
                    }),
                    None => strokes.push(Stroke {
                        steady,
                        contact: motion,
                        cut_by: CutBy::Rule,
                    }),
                }
            }
        }
    }
    let plateaus: Vec<f64> = strokes
        .iter()
        .flat_map(|s| {
            let (from, to) = (s.steady.start / frames.size, s.steady.end / frames.size);
            &moving[from..to.min(moving.len())]
        })
        .copied()
        .collect();
    let reached = quantile(&plateaus, 0.5);
    if let Some(asked_m_s) = rule.speed_m_s
        && !strokes.is_empty()
        && (reached / asked_m_s - 1.0).abs() > OFF_SPEED
    {
        doubts.push(Doubt::SpeedOffTarget {
            mean_m_s: reached,
            target_m_s: asked_m_s,
        });
    }
    Ok(Segmentation {
        strokes,
        rejected,
        rule: Rule::Speed(rule.clone()),
        roles: Roles::default(),
        force_zeros: None,
        cuts: None,
        doubts,
    })
}

fn samples(frames: Frames, from: usize, to: usize) -> Interval {
    Interval {
        start: from * frames.size,
        end: to * frames.size,
    }
}

/// The magnitude of the speed within `steady`, m/s, frame by frame.
pub(crate) fn stroke_speed_m_s(
    rate: SampleRate,
    motion: &[f64],
    kind: MotionKind,
    steady: Interval,
) -> Vec<f64> {
    let frames = Frames::at(rate);
    let mut speed = speed_m_s(frames, steady.of(motion), kind, SMOOTHING_S);
    for value in &mut speed {
        *value = value.abs();
    }
    speed
}

/// The smoothed speed frame by frame, m/s.
fn speed_m_s(frames: Frames, motion: &[f64], kind: MotionKind, smoothing_s: f64) -> Vec<f64> {
    let width = frames.in_time(smoothing_s);
    let means = frames.means(motion);
    match kind {
        MotionKind::Speed => smoothed(&means, width),
        MotionKind::Position => {
            let place = smoothed(&means, width.div_ceil(2));
            let reach = (width / 2).max(1);
            let last = place.len().saturating_sub(1);
            (0..place.len())
                .map(|i| {
                    let (a, b) = (i.saturating_sub(reach), (i + reach).min(last));
                    (place[b] - place[a]) * frames.rate_hz / (b - a).max(1) as f64
                })
                .collect()
        }
    }
}

/// The plateau in one motion: from the first to the last frame within the tolerance of the speed that its middle
/// holds.
fn plateau(frames: Frames, moving: &[f64], rule: &SpeedRule) -> Result<(usize, usize), Reason> {
    let quarter = moving.len() / 4;
    let level = quantile(&moving[quarter..moving.len() - quarter], 0.5);
    let within = |v: &f64| (v - level).abs() <= rule.tolerance_share * level;
    let from = moving.iter().position(within).unwrap_or(0);
    let to = moving.iter().rposition(within).map_or(0, |last| last + 1);
    let (found_s, needed_s) = (frames.seconds(to.saturating_sub(from)), rule.shortest_s.0);
    if found_s < needed_s {
        return Err(Reason::TooShort { found_s, needed_s });
    }
    let off = moving[from..to].iter().filter(|v| !within(v)).count();
    if off as f64 > 0.1 * (to - from) as f64 {
        return Err(Reason::Interrupted { parts: 2 });
    }
    Ok((from, to))
}

/// Why a plateau is no stroke, if it is none.
fn unfit(
    signals: &Signals<'_>,
    frames: Frames,
    touched: Option<&[(usize, usize)]>,
    steady: Interval,
) -> Option<Reason> {
    let (from, to) = (steady.start / frames.size, steady.end / frames.size);
    if let Some(touches) = touched {
        let overlap: usize = touches
            .iter()
            .map(|(a, b)| (*b).min(to).saturating_sub((*a).max(from)))
            .sum();
        if overlap * 10 < (to - from) {
            return Some(Reason::NoContact);
        }
        if overlap < to - from {
            return Some(Reason::DiscontinuousContact { gaps: 1 });
        }
    }
    let vibration = signals.vibration?;
    let fraction = flat_top_fraction(steady.of(vibration));
    (fraction > 0.0).then_some(Reason::Clipped { fraction })
}
