//! Active touch: strokes by the normal force.

use serde::{Deserialize, Serialize};

use super::contact::{Force, above_baseline, events};
use super::frames::{Frames, quantile};
use super::sliding::{
    floor, sliding_by_friction, sliding_parts, stick_slip_in_friction, stick_slip_in_vibration,
    vibration_level,
};
use super::{
    CutBy, ForceZeros, Interval, Reason, Rejected, Rule, SegmentError, Segmentation, Signals,
    Stroke,
};
use crate::doubt::Doubt;
use crate::quantity::{Newtons, Seconds};
use crate::roles::Roles;
use crate::series::mean;
use crate::verify::flat_top_fraction;

/// How strokes are found in a normal force.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ForceRule {
    /// A contact rises above this, N above the baseline.
    pub on_n: Newtons,
    /// It lasts while the force is above this, N above the baseline.
    pub off_n: Newtons,
    /// The force is smoothed over this time.
    pub smoothing_s: Seconds,
    /// What is cut away after the first touch.
    pub landing_s: Seconds,
    /// What is cut away before the last touch.
    pub take_off_s: Seconds,
    /// Moments off the surface up to this long do not end a contact: they make it discontinuous.
    pub longest_gap_s: Seconds,
    /// A stroke's steady part is at least this long.
    pub shortest_s: Seconds,
    /// The normal force that was asked for; without it the median of the strokes takes its place.
    pub load_n: Option<Newtons>,
    /// How far the mean force of a stroke may be from it, as a share of it.
    pub tolerance_share: f64,
}

impl ForceRule {
    /// The rule for semi-controlled active touch at `load`, 0.2 N where it is not stated: a contact begins at half
    /// the load and lasts to a twentieth of it; 100 ms of landing and 80 ms of take-off are cut away; strokes of
    /// 0.3 s and more within ±50 % of the load count.
    #[must_use]
    pub fn active(load: Option<Newtons>) -> Self {
        let reference_n = load.map_or(0.2, |load| load.0);
        Self {
            on_n: Newtons(0.5 * reference_n),
            off_n: Newtons(0.05 * reference_n),
            smoothing_s: Seconds(0.01),
            landing_s: Seconds(0.1),
            take_off_s: Seconds(0.08),
            longest_gap_s: Seconds(0.1),
            shortest_s: Seconds(0.3),
            load_n: load,
            tolerance_share: 0.5,
        }
    }

    fn check(&self) -> Result<(), SegmentError> {
        let rule = |expected, found: f64| {
            Err(SegmentError::Rule {
                expected,
                found: found.to_string(),
            })
        };
        if !(self.on_n.0.is_finite() && self.on_n.0 > 0.0) {
            return rule("a force above zero at which a contact begins", self.on_n.0);
        }
        if !(self.off_n.0 > 0.0 && self.off_n.0 <= self.on_n.0) {
            return rule(
                "a force above zero, and not above the one at which it begins, at which a contact ends",
                self.off_n.0,
            );
        }
        for time in [
            self.smoothing_s,
            self.landing_s,
            self.take_off_s,
            self.longest_gap_s,
            self.shortest_s,
        ] {
            if !(time.0 >= 0.0 && time.0.is_finite()) {
                return rule("times of zero or more", time.0);
            }
        }
        if !(self.tolerance_share > 0.0) {
            return rule("a tolerance above zero", self.tolerance_share);
        }
        if let Some(load) = self.load_n
            && !(load.0 > 0.0 && load.0.is_finite())
        {
            return rule("a load above zero", load.0);
        }
        Ok(())
    }
}

/// The shortest recording that can be cut, s.
const SHORTEST_RECORDING: Seconds = Seconds(0.5);
/// A contact this many times longer than the usual one may be two.
const LONG: f64 = 1.8;
/// Friction coefficients above this are rarely those of skin: the axes may be swapped.
const HIGH_FRICTION: f64 = 1.2;

/// The strokes in `signals` by their normal force: contacts by hysteresis above a baseline that follows the
/// cell's drift, freed of landing and take-off, and only where the finger slides. A force that is negative in
/// contact is taken with its sign reversed, with a doubt.
///
/// Source: the protocol of semi-controlled active touch (proximal strokes at 0.2 N with a lift after each), cut by
/// hand in L. Felicetti's thesis (2024), sections 2.3.1 and 3.1; here by rule.
///
/// # Errors
/// [`SegmentError::NothingToCutBy`] without a normal force, [`SegmentError::Dead`] when it never changes,
/// [`SegmentError::TooShort`] for a recording under 0.5 s, [`SegmentError::Rule`] for a rule that cannot be.
pub fn segment_by_force(
    signals: &Signals<'_>,
    rule: &ForceRule,
) -> Result<Segmentation, SegmentError> {
    rule.check()?;
    let normal_n = signals.normal_force_n.ok_or(SegmentError::NothingToCutBy)?;
    let found = signals.rate.duration_of(normal_n.len());
    if found < SHORTEST_RECORDING {
        return Err(SegmentError::TooShort {
            needed: SHORTEST_RECORDING,
            found,
        });
    }
    let frames = Frames::at(signals.rate);
    let mut doubts = Vec::new();
    let (force, sign) = oriented(frames.means(normal_n), &mut doubts)?;
    let smoothing = frames.in_time(rule.smoothing_s.0);
    let force = above_baseline(frames, &force, smoothing, rule.on_n.0);
    drift_doubt(rule, &force.baseline_n, &mut doubts);

    let touches = events(&force.level_n, rule.on_n.0, rule.off_n.0);
    let level = signals
        .vibration
        .map(|vibration| vibration_level(frames, vibration));
    let tangential: Vec<Vec<f64>> = signals
        .tangential_force_n
        .iter()
        .map(|axis| frames.means(axis))
        .collect();
    let cutter = Cutter {
        signals,
        rule,
        frames,
        level_n: &force.level_n,
        floor: level
            .as_ref()
            .and_then(|level| floor(frames, level, &touches)),
        vibration: level,
        friction: friction(&tangential, &force),
    };
    let mut strokes = Vec::new();
    let mut rejected = Vec::new();
    for contact in cutter.contacts(&touches) {
        match cutter.cut(&contact) {
            Ok(stroke) => strokes.push(stroke),
            Err(reason) => rejected.push(Rejected {
                interval: cutter.samples(contact.from, contact.to),
                reason,
            }),
        }
    }
    force_tolerance(&cutter, &mut strokes, &mut rejected);
    doubts.extend(cutter.doubts(&strokes, &rejected));
    Ok(Segmentation {
        strokes,
        rejected,
        rule: Rule::Force(rule.clone()),
        roles: Roles::default(),
        force_zeros: Some(ForceZeros {
            sign,
            zeros: force.zeros(frames, &tangential),
        }),
        cuts: None,
        doubts,
    })
}

/// The force with contact upwards, and the sign that this took.
fn oriented(mut force: Vec<f64>, doubts: &mut Vec<Doubt>) -> Result<(Vec<f64>, f64), SegmentError> {
    let mut sorted = force.clone();
    let low = quantile(&mut sorted, 0.0);
    let high = quantile(&mut sorted, 1.0);
    if high - low <= 1e-9 * high.abs().max(low.abs()).max(1e-9) {
        return Err(SegmentError::Dead {
            what: "the normal force",
            found: format!("{low} N"),
        });
    }
    // Contact is the rarer or the smaller half of the time: the rest level is where most lifts lie.
    let bottom = quantile(&mut sorted, 0.02);
    let top = quantile(&mut sorted, 0.98);
    if top.abs() < 0.5 * bottom.abs() && bottom < 0.0 {
        for value in &mut force {
            *value = -*value;
        }
        doubts.push(Doubt::SignReversed {
            channel: "the normal force".into(),
        });
        return Ok((force, -1.0));
    }
    Ok((force, 1.0))
}

fn drift_doubt(rule: &ForceRule, baseline_n: &[f64], doubts: &mut Vec<Doubt>) {
    let low = baseline_n.iter().copied().fold(f64::MAX, f64::min);
    let high = baseline_n.iter().copied().fold(f64::MIN, f64::max);
    if high - low > 0.5 * rule.off_n.0.max(0.2 * rule.on_n.0) {
        doubts.push(Doubt::ForceDrift {
            from_n: low,
            to_n: high,
            threshold_n: rule.on_n.0,
        });
    }
}

/// Tangential over normal force, frame by frame, 0 where nothing touches; `None` without tangential forces.
fn friction(axes: &[Vec<f64>], force: &Force) -> Option<Vec<f64>> {
    let mut squares = vec![0.0; force.level_n.len()];
    if axes.is_empty() {
        return None;
    }
    for means in axes {
        let zero = force.zero_of(means);
        for ((square, value), zero) in squares.iter_mut().zip(means).zip(&zero) {
            *square += (value - zero) * (value - zero);
        }
    }
    let touching = |(square, level): (&f64, &f64)| {
        if *level > 0.01 {
            square.sqrt() / level
        } else {
            0.0
        }
    };
    Some(squares.iter().zip(&force.level_n).map(touching).collect())
}

/// A contact in frames, with the moments off the surface inside it.
struct Contact {
    from: usize,
    to: usize,
    gaps: usize,
}

struct Cutter<'a> {
    signals: &'a Signals<'a>,
    rule: &'a ForceRule,
    frames: Frames,
    level_n: &'a [f64],
    vibration: Option<Vec<f64>>,
    floor: Option<f64>,
    friction: Option<Vec<f64>>,
}

impl Cutter<'_> {
    fn samples(&self, from: usize, to: usize) -> Interval {
        Interval {
            start: from * self.frames.size,
            end: to * self.frames.size,
        }
    }

    /// Touches with short gaps between them are one contact, unless one of them is a tap.
    fn contacts(&self, touches: &[(usize, usize)]) -> Vec<Contact> {
        let gap = self.frames.in_time(self.rule.longest_gap_s.0);
        let mut contacts: Vec<Contact> = Vec::new();
        for (from, to) in touches {
            match contacts.last_mut() {
                Some(last) if from - last.to <= gap => {
                    last.to = *to;
                    last.gaps += 1;
                }
                _ => contacts.push(Contact {
                    from: *from,
                    to: *to,
                    gaps: 0,
                }),
            }
        }
        contacts
    }

    fn cut(&self, contact: &Contact) -> Result<Stroke, Reason> {
        let Contact { from, to, gaps } = *contact;
        if from == 0 || to == self.level_n.len() {
            return Err(Reason::CutByRecording);
        }
        let needed_s = self.rule.shortest_s.0;
        let landing = (self.rule.landing_s.0 * self.frames.rate_hz).round() as usize;
        let take_off = (self.rule.take_off_s.0 * self.frames.rate_hz).round() as usize;
        let (inner_from, inner_to) = (from + landing, to.saturating_sub(take_off));
        let long_enough = |from: usize, to: usize| {
            let found_s = self.frames.seconds(to.saturating_sub(from));
            if found_s < needed_s {
                Err(Reason::TooShort { found_s, needed_s })
            } else {
                Ok(())
            }
        };
        long_enough(inner_from, inner_to)?;
        if gaps > 0 {
            return Err(Reason::DiscontinuousContact { gaps });
        }
        if let Some((slips, rate_hz)) = self.stick_slip(inner_from, inner_to) {
            return Err(Reason::StickSlip { slips, rate_hz });
        }
        let (slide_from, slide_to) = match self.sliding(from, to).as_slice() {
            [] => return Err(Reason::NoSliding),
            [only] => (from + only.0, from + only.1),
            parts => return Err(Reason::Interrupted { parts: parts.len() }),
        };
        let (start, end) = (inner_from.max(slide_from), inner_to.min(slide_to));
        long_enough(start, end)?;
        let steady = self.samples(start, end);
        if let Some(vibration) = self.signals.vibration {
            let fraction = flat_top_fraction(steady.of(vibration));
            if fraction > 0.0 {
                return Err(Reason::Clipped { fraction });
            }
        }
        Ok(Stroke {
            steady,
            contact: self.samples(from, to),
            cut_by: CutBy::Rule,
        })
    }

    fn stick_slip(&self, from: usize, to: usize) -> Option<(usize, f64)> {
        if let Some(friction) = &self.friction {
            return stick_slip_in_friction(self.frames, part(friction, from, to));
        }
        let level = self.vibration.as_ref()?;
        stick_slip_in_vibration(self.frames, part(level, from, to))
    }

    /// Where the finger slides within the contact: by its vibration where one was measured and there is a lift
    /// to compare it with, else by the friction; else all of it.
    fn sliding(&self, from: usize, to: usize) -> Vec<(usize, usize)> {
        match (&self.vibration, self.floor, &self.friction) {
            (Some(level), Some(floor), _) => {
                sliding_parts(self.frames, part(level, from, to), floor)
            }
            (_, _, Some(friction)) => sliding_by_friction(self.frames, part(friction, from, to)),
            _ => vec![(0, to - from)],
        }
    }

    fn mean_force_n(&self, stroke: &Stroke) -> f64 {
        let size = self.frames.size;
        mean(part(
            self.level_n,
            stroke.steady.start / size,
            stroke.steady.end / size,
        ))
    }

    fn doubts(&self, strokes: &[Stroke], rejected: &[Rejected]) -> Vec<Doubt> {
        let mut doubts = Vec::new();
        if strokes.is_empty() && rejected.is_empty() {
            doubts.push(Doubt::NoContact {
                largest_n: self.level_n.iter().copied().fold(0.0, f64::max),
                threshold_n: self.rule.on_n.0,
            });
        }
        if self.vibration.is_none() && self.friction.is_none() {
            doubts.push(Doubt::SlidingAssumed);
        }
        let mut lengths: Vec<f64> = strokes.iter().map(|s| s.contact.len() as f64).collect();
        let usual = quantile(&mut lengths, 0.5);
        for stroke in strokes {
            if strokes.len() > 2 && stroke.contact.len() as f64 > LONG * usual {
                doubts.push(Doubt::LongStroke {
                    at_s: stroke.contact.start as f64 / self.signals.rate.hz(),
                    times: stroke.contact.len() as f64 / usual,
                });
            }
        }
        if let Some(friction) = &self.friction {
            let mut sliding: Vec<f64> = strokes
                .iter()
                .flat_map(|stroke| {
                    let size = self.frames.size;
                    part(
                        friction,
                        stroke.steady.start / size,
                        stroke.steady.end / size,
                    )
                })
                .copied()
                .collect();
            let coefficient = quantile(&mut sliding, 0.5);
            if coefficient > HIGH_FRICTION {
                doubts.push(Doubt::HighFriction { coefficient });
            }
        }
        doubts
    }
}

fn part(values: &[f64], from: usize, to: usize) -> &[f64] {
    let to = to.min(values.len());
    &values[from.min(to)..to]
}

/// Rejects the strokes whose mean force is too far from the load, or without one from their median.
fn force_tolerance(cutter: &Cutter<'_>, strokes: &mut Vec<Stroke>, rejected: &mut Vec<Rejected>) {
    let forces: Vec<f64> = strokes.iter().map(|s| cutter.mean_force_n(s)).collect();
    let target_n = match cutter.rule.load_n {
        Some(load) => load.0,
        None => quantile(&mut forces.clone(), 0.5),
    };
    let reach_n = cutter.rule.tolerance_share * target_n;
    let mut forces = forces.into_iter();
    strokes.retain(|stroke| {
        let mean_n = forces.next().unwrap_or(target_n);
        let kept = (mean_n - target_n).abs() <= reach_n;
        if !kept {
            rejected.push(Rejected {
                interval: stroke.contact,
                reason: Reason::ForceOutsideTolerance {
                    mean_n,
                    low_n: target_n - reach_n,
                    high_n: target_n + reach_n,
                },
            });
        }
        kept
    });
    rejected.sort_by_key(|r| r.interval.start);
}
