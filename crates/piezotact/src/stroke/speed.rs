//! Passive touch: segmentation into strokes by the plateau of the surface's speed.

use crate::recording::{MissingChannel, Reached, RecordingWarning};
use crate::stroke::{ForceFault, ForceWarning};
use serde::{Deserialize, Serialize};

use super::agreement::{Limits, Pass, contradiction, reject_ways_back};
use super::contact::{Polyline, above_rest, events, quiet};
use super::criteria::{JudgedPart, StrokeCriterion};
use super::force::{HIGH_FRICTION, Judging, friction, oriented, zeros};
use super::force_warning::warnings_of_force;
use super::frames::{Frames, quantile, smoothed};
use super::sliding::{ForceNoise, slower_slips, stick_slip_in_friction};
use super::{
    CutBy, Expected, ForceZeros, Interval, MotionKind, Reason, Rejected, Rule, SegmentError,
    Segmentation, Signals, Stroke,
};
use crate::criterion::Limit;
use crate::quantity::{Newtons, SampleRate, Seconds};
use crate::roles::Roles;
use crate::statistics::{mean, standard_deviation};
use crate::warning::Warning;

/// The least share of a motion in contact for it to count as touched.
const LEAST_TOUCH: Limit = Limit::AtLeast {
    met: 0.1,
    not_met: 0.1,
};

/// How strokes are found in the speed of a surface.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct SpeedRule {
    /// The speed is smoothed over this time.
    pub smoothing_s: Seconds,
    /// The plateau holds its speed within this share of it.
    pub tolerance_share: f64,
    /// A speed below this share of the highest counts as rest.
    pub rest_share: f64,
    /// A plateau is at least this long.
    pub shortest_s: Seconds,
    /// The surface is touched when the normal force is above this, N above its baseline.
    pub touch_n: Newtons,
    /// The normal force that was asked for; a stroke's mean is within ±50 % of it. None when it is not known.
    pub load_n: Option<Newtons>,
    /// The speed that was asked for, m/s; none when it is not known.
    pub speed_m_s: Option<f64>,
    /// Whether plateaus are judged by how the finger slides.
    pub judging: Judging,
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
            load_n: expected.load_n,
            speed_m_s: expected.speed_m_s,
            judging: expected.judging,
        }
    }

    /// The rule for a hand that moves freely, where no force was measured to cut by: a stroke of 0.3 s and more at whatever speed.
    #[must_use]
    pub fn hand(expected: Expected) -> Self {
        Self {
            tolerance_share: HAND,
            ..Self::trapezoid(expected)
        }
    }
}

/// The speed of a hand is within this share of that of the middle of its stroke.
const HAND: f64 = 0.6;
/// Speeds are smoothed over this time unless stated, s.
pub(super) const SMOOTHING_S: f64 = 0.02;
/// A plateau is outside of its tolerance for this share of the time at most.
pub(super) const MOST_OUTSIDE: f64 = 0.1;
/// A surface stops below this share of the plateau's speed.
const STOPS: f64 = 0.5;
/// The noise of the speed at rest widens the tolerance by so many standard deviations.
const OF_NOISE: f64 = 2.0;
/// The median of the magnitude of a normal variable, in standard deviations.
const MEDIAN_OF_NORMAL: f64 = 0.6745;
/// A plateau this far from the speed asked for is a warning.
const OFF_SPEED: f64 = 0.1;

/// The surface moves from this share of its usual speed on.
const MOVES: f64 = 0.5;
/// A way back is faster than the strokes from this ratio on.
const FASTER: f64 = 1.2;

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
    let moving: Vec<f64> = speed.iter().map(|v| v.abs()).collect();
    let fastest = moving.iter().copied().fold(0.0, f64::max);
    if fastest <= 0.0 {
        return Err(SegmentError::Dead {
            what: "the motion",
            found: format!("{fastest:.2e} m/s"),
        });
    }
    let mut warnings = Vec::new();
    let limits = Limits::of(signals);
    // The threshold of rest follows the usual speed, not the fastest return or one wrong sample of an encoder.
    let moved: Vec<f64> = moving
        .iter()
        .copied()
        .filter(|v| *v > 0.05 * fastest)
        .collect();
    let measured = quantile(&moved, 0.5);
    let moves: Vec<bool> = moving.iter().map(|v| *v > MOVES * measured).collect();
    let held = held(signals, rule, (frames, &moves), &mut warnings)?;
    let usual = rule.speed_m_s.unwrap_or(measured);
    let threshold = rule.rest_share * usual;
    let resting = moving.iter().copied().filter(|v| *v <= threshold);
    let rest_m_s = quantile(&resting.collect::<Vec<_>>(), 0.5) / MEDIAN_OF_NORMAL;
    let (mut strokes, mut rejected) = (Vec::new(), Vec::new());
    for (from, to) in events(moving.iter().copied(), threshold, threshold) {
        let motion = samples(frames, from, to);
        let touched = held.as_ref().is_none_or(|held| held.touch_within(from, to));
        let mut judged = JudgedPart::default();
        let found = match touched {
            true => plateau(frames, &moving[from..to], (rule, rest_m_s), &mut judged),
            false => judged
                .require(StrokeCriterion::TouchShare, 0.0, LEAST_TOUCH, || {
                    Reason::NoContact
                })
                .map(|()| (0, 0)),
        };
        let cut = found.and_then(|(a, b)| {
            let steady = samples(frames, from + a, from + b);
            let held = held.as_ref();
            fit(&limits, signals, frames, (rule, held), steady, &mut judged).map(|()| steady)
        });
        match cut {
            Err(reason) => rejected.push(judged.rejects(motion, reason)),
            Ok(steady) => strokes.push(Stroke {
                steady,
                contact: motion,
                cut_by: CutBy::Rule,
                criteria: judged.criteria(),
            }),
        }
    }
    if let Some(held) = &held {
        let pass = |stroke: &Stroke| {
            let (from, to) = (
                stroke.steady.start / frames.size,
                stroke.steady.end / frames.size,
            );
            Pass {
                is_forward: mean(&speed[from..to]) > 0.0,
                force_n: mean(&held.level_n[from..to]),
            }
        };
        let passes: Vec<Pass> = strokes.iter().map(pass).collect();
        let vibration = signals.vibration;
        reject_ways_back(frames, vibration, &passes, &mut strokes, &mut rejected);
    }
    let usual_m_s = |part: Interval| {
        let (from, to) = (part.start / frames.size, part.end / frames.size);
        quantile(&moving[from..to.min(moving.len())], 0.5)
    };
    let speeds: Vec<f64> = strokes.iter().map(|s| usual_m_s(s.steady)).collect();
    let fastest_m_s = FASTER * quantile(&speeds, 0.5);
    // A motor vibrates more on a faster way back.
    let slow = rejected
        .iter()
        .filter(|r| usual_m_s(r.interval) <= fastest_m_s);
    let slow: Vec<Rejected> = slow.cloned().collect();
    let of_force = |reason: &Reason| *reason == Reason::NoContact;
    let parts = (strokes.as_slice(), slow.as_slice());
    warnings.extend(contradiction(frames, signals.vibration, parts, of_force));
    if let (Some(held), Judging::Sliding) = (&held, rule.judging) {
        warnings.extend(held.hidden_slips(signals, frames, &strokes));
    }
    let coefficient = held
        .as_ref()
        .map_or(0.0, |held| held.median_friction(signals, frames, &strokes));
    if coefficient > HIGH_FRICTION {
        warnings.push(Warning::from(ForceWarning::Doubtful {
            fault: ForceFault::HighFriction { coefficient },
        }));
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
        warnings.push(Warning::from(RecordingWarning::ConditionDiffers {
            what: Reached::Speed {
                mean_m_s: reached,
                target_m_s: asked_m_s,
            },
        }));
    }
    Ok(Segmentation {
        strokes,
        rejected,
        rule: Rule::Speed(rule.clone()),
        roles: Roles::default(),
        force_zeros: held.map(|held| held.zeros),
        cuts: None,
        untouched: None,
        warnings,
    })
}

/// The normal force of a finger that is held on a surface.
struct Held {
    /// N above the zero, frame by frame.
    level_n: Vec<f64>,
    touches: Vec<(usize, usize)>,
    tangential: Vec<Polyline>,
    noise: ForceNoise,
    zeros: ForceZeros,
}

impl Held {
    /// Whether the finger touches for a tenth of the frames `from`…`to` or more: a lift that is not quite over when
    /// the surface moves on is no stroke.
    fn touch_within(&self, from: usize, to: usize) -> bool {
        let common = |(a, b): &(usize, usize)| (*b).min(to).saturating_sub((*a).max(from));
        10 * self.touches.iter().map(common).sum::<usize>() >= to - from
    }

    /// The median over `strokes` of each one's median friction.
    fn median_friction(&self, signals: &Signals<'_>, frames: Frames, strokes: &[Stroke]) -> f64 {
        let each: Vec<f64> = strokes
            .iter()
            .filter_map(|s| {
                let (from, to) = (s.steady.start / frames.size, s.steady.end / frames.size);
                self.friction(signals, frames, from, to)
            })
            .map(|ratio| quantile(&ratio, 0.5))
            .collect();
        quantile(&each, 0.5)
    }

    /// Slips in the friction `ratio` of the frames `from`…`to`; `None` unless they make stick-slip.
    fn slips(&self, frames: Frames, ratio: &[f64], from: usize, to: usize) -> Option<(usize, f64)> {
        let noise = self.noise.of_friction(ratio, self.level_n.get(from..to)?);
        stick_slip_in_friction(frames, ratio, noise)
    }

    /// The warning that noise hides slips in `strokes` of the given friction.
    fn hidden_slips(
        &self,
        signals: &Signals<'_>,
        frames: Frames,
        strokes: &[Stroke],
    ) -> Option<Warning> {
        let each = strokes.iter().filter_map(|s| {
            let (from, to) = (s.steady.start / frames.size, s.steady.end / frames.size);
            let ratio = self.friction(signals, frames, from, to)?;
            Some(self.noise.least_slip(&ratio, self.level_n.get(from..to)?))
        });
        self.noise.warning(quantile(&each.collect::<Vec<_>>(), 0.5))
    }

    /// Tangential over normal force in the frames `from`…`to`; `None` without tangential forces.
    fn friction(
        &self,
        signals: &Signals<'_>,
        frames: Frames,
        from: usize,
        to: usize,
    ) -> Option<Vec<f64>> {
        let level_n = self.level_n.get(from..to)?;
        let axes = signals.tangential_force_n.iter().zip(&self.tangential);
        friction(
            frames,
            axes.map(|(axis, zero)| (*axis, zero)),
            level_n,
            from,
        )
    }
}

/// Where the finger touches, and the zeros of its forces; `None` where no force was measured.
fn held(
    signals: &Signals<'_>,
    rule: &SpeedRule,
    (frames, moves): (Frames, &[bool]),
    warnings: &mut Vec<Warning>,
) -> Result<Option<Held>, SegmentError> {
    let Some(normal_n) = signals.normal_force_n else {
        warnings.push(Warning::from(RecordingWarning::ChannelMissing {
            what: MissingChannel::Contact,
        }));
        return Ok(None);
    };
    let means = frames.means(normal_n);
    let (means, sign) = oriented(frames, means, signals, Some(moves), warnings)?;
    let (on_n, off_n) = (rule.touch_n.0, 0.5 * rule.touch_n.0);
    let smooth_n = quiet(frames, &means, (0.01, on_n), warnings);
    let Some(force) = above_rest(frames, smooth_n.clone(), on_n) else {
        // One level all along: the finger touches always or never, and the zeros are not known.
        warnings.push(Warning::from(ForceWarning::Doubtful {
            fault: ForceFault::ZeroUnknown,
        }));
        return Ok(Some(Held {
            touches: events(smooth_n.iter().copied(), on_n, off_n),
            tangential: vec![Polyline(Vec::new()); signals.tangential_force_n.len()],
            level_n: smooth_n,
            noise: ForceNoise::default(),
            zeros: ForceZeros {
                sign,
                zeros: Vec::new(),
            },
        }));
    };
    warnings.extend(warnings_of_force(normal_n, &force, on_n));
    let tangential: Vec<Polyline> = signals
        .tangential_force_n
        .iter()
        .map(|axis| force.zero_of(frames, axis))
        .collect();
    Ok(Some(Held {
        touches: events(force.level_n.iter().copied(), on_n, off_n),
        zeros: ForceZeros {
            sign,
            zeros: zeros(frames, &force, &tangential),
        },
        noise: ForceNoise::of(
            frames,
            (&force.level_n, normal_n),
            &signals.tangential_force_n,
            &force.lifts,
        ),
        tangential,
        level_n: force.level_n,
    }))
}

fn samples(frames: Frames, from: usize, to: usize) -> Interval {
    Interval {
        start: from * frames.size,
        end: to * frames.size,
    }
}

/// The magnitude of the speed within `steady`, m/s, frame by frame. The motion around it is smoothed with it, so
/// that its ends are those of the motion.
pub(crate) fn stroke_speed_m_s(
    rate: SampleRate,
    motion: &[f64],
    kind: MotionKind,
    steady: Interval,
) -> Vec<f64> {
    let frames = Frames::at(rate);
    let margin = 2 * frames.in_time(SMOOTHING_S);
    let (first, last) = (steady.start / frames.size, steady.end / frames.size);
    let outer = first.saturating_sub(margin);
    let around = samples(frames, outer, last + margin);
    let speed = speed_m_s(frames, around.of(motion), kind, SMOOTHING_S);
    let inner = speed.iter().skip(first - outer).take(last - first);
    inner.map(|v| v.abs()).collect()
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
fn plateau(
    frames: Frames,
    moving: &[f64],
    (rule, rest_m_s): (&SpeedRule, f64),
    judged: &mut JudgedPart,
) -> Result<(usize, usize), Reason> {
    let quarter = moving.len() / 4;
    let level = quantile(&moving[quarter..moving.len() - quarter], 0.5);
    let reach = rule.tolerance_share * level;
    let within = |v: &f64| (v - level).abs() <= reach;
    let from = moving.iter().position(within).unwrap_or(0);
    let to = moving.iter().rposition(within).map_or(0, |last| last + 1);
    let (found_s, needed_s) = (frames.seconds(to.saturating_sub(from)), rule.shortest_s.0);
    let long_enough = Limit::at_least(needed_s);
    judged.require(StrokeCriterion::SteadyPart, found_s, long_enough, || {
        Reason::TooShort { found_s, needed_s }
    })?;
    let held = &moving[from..to];
    let outside = |reach: f64| {
        let off = held.iter().filter(|v| (*v - level).abs() > reach).count();
        off as f64 / held.len().max(1) as f64
    };
    // What is the noise of the sensor is no change of the speed.
    let noisy_reach = reach + OF_NOISE * rest_m_s;
    if outside(reach) <= MOST_OUTSIDE || outside(noisy_reach) <= MOST_OUTSIDE {
        return Ok((from, to));
    }
    if held.iter().any(|v| *v < STOPS * level) {
        let parts = events(
            held.iter().map(|v| f64::from(u8::from(within(v)))),
            0.5,
            0.5,
        );
        let (count, one) = (parts.len(), Limit::at_most(1.0));
        judged.require(StrokeCriterion::SlidingParts, count as f64, one, || {
            Reason::Interrupted { parts: count }
        })?;
    }
    let (outside, most) = (outside(noisy_reach), Limit::at_most(MOST_OUTSIDE));
    judged.require(StrokeCriterion::UnsteadyShare, outside, most, || {
        Reason::UnsteadySpeed {
            deviation_share: standard_deviation(held) / level,
            tolerance_share: noisy_reach / level,
            outside,
        }
    })?;
    Ok((from, to))
}

/// Judges whether a plateau is a stroke; otherwise returns the reason.
fn fit(
    limits: &Limits<'_>,
    signals: &Signals<'_>,
    frames: Frames,
    (rule, held): (&SpeedRule, Option<&Held>),
    steady: Interval,
    judged: &mut JudgedPart,
) -> Result<(), Reason> {
    use StrokeCriterion as What;
    let none = Limit::at_most(0.0);
    let (from, to) = (steady.start / frames.size, steady.end / frames.size);
    if let Some(held) = held {
        let inside = |(a, b): &(usize, usize)| (*b).min(to).saturating_sub((*a).max(from));
        let touching: usize = held.touches.iter().map(inside).sum();
        let share = touching as f64 / (to - from) as f64;
        judged.require(What::TouchShare, share, LEAST_TOUCH, || Reason::NoContact)?;
        let apart = |touch: &&(usize, usize)| inside(touch) > 0;
        let gaps = match touching < to - from {
            true => held.touches.iter().filter(apart).count(),
            false => 0,
        };
        judged.require(What::Gaps, gaps as f64, none, || {
            Reason::DiscontinuousContact { gaps }
        })?;
        if let Some(load) = rule.load_n {
            let mean_n = mean(&held.level_n[from..to.min(held.level_n.len())]);
            let (low_n, high_n) = (0.5 * load.0, 1.5 * load.0);
            let within = Limit::Within {
                reach: 0.5 * load.0,
            };
            judged.require(What::ForceDeviation, mean_n - load.0, within, || {
                Reason::ForceOutsideTolerance {
                    mean_n,
                    target_n: load.0,
                    low_n,
                    high_n,
                }
            })?;
        }
    }
    let friction = held.and_then(|held| held.friction(signals, frames, from, to));
    if let (Some(friction), Judging::Sliding) = (&friction, rule.judging)
        && let Some((slips, rate_hz)) = held.and_then(|held| held.slips(frames, friction, from, to))
    {
        judged.require(What::SlipRate, rate_hz, slower_slips(), || {
            Reason::StickSlip { slips, rate_hz }
        })?;
    }
    let fraction = limits.clipped(steady);
    judged.require(What::ClippedShare, fraction, none, || Reason::Clipped {
        fraction,
    })
}
