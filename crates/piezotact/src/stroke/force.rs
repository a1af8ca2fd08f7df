//! Active touch: segmentation into strokes by the normal force.

use crate::recording::{MissingChannel, RecordingWarning, ReversedSign};
use crate::stroke::{ForceFault, ForceWarning, StrokeWarning, Unusual};
use serde::{Deserialize, Serialize};

use super::agreement::{Limits, contradiction, is_of_force, usual_force_n};
use super::contact::{
    Force, HUM_SMOOTHING_S, Polyline, above_drifting_zero, events, polarity, quiet,
};
use super::criteria::{JudgedPart, StrokeCriterion};
use super::force_warning::warnings_of_force;
use super::frames::{Frames, quantile, smoothed};
use super::sliding::{
    ABOVE_FLOOR, CLEARLY_ABOVE_FLOOR, Floors, ForceNoise, friction_level, loudness,
    sliding_by_friction, sliding_parts, slower_slips, stick_slip_in_friction,
    stick_slip_in_vibration, vibration_level,
};
use super::{
    CutBy, ForceZeros, Interval, Reason, Rejected, Rule, SegmentError, Segmentation, Signals,
    Stroke,
};
use crate::criterion::{Criterion, Limit, Outcome};
use crate::quantity::{Newtons, SampleRate, Seconds};
use crate::roles::Roles;
use crate::statistics::mean;
use crate::warning::Warning;

/// How strokes are found in a normal force.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct ForceRule {
    /// A contact rises above this, N above the baseline.
    pub on_n: Newtons,
    /// It lasts while the force is above this, N above the baseline.
    pub off_n: Newtons,
    /// The force is smoothed over this time.
    pub smoothing_s: Seconds,
    /// The time cut away after the first touch (landing).
    pub landing_s: Seconds,
    /// The time cut away before the last touch (take-off).
    pub take_off_s: Seconds,
    /// Moments off the surface up to this long do not end a contact: they make it discontinuous.
    pub longest_gap_s: Seconds,
    /// A stroke's steady part is at least this long.
    pub shortest_s: Seconds,
    /// The target normal force; if absent, the median of the strokes is used.
    pub load_n: Option<Newtons>,
    /// How far the mean force of a stroke may be from it, as a share of it.
    pub tolerance_share: f64,
    /// Whether contacts are judged by how the finger slides.
    pub judging: Judging,
}

/// The condition for a contact to be a stroke.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Judging {
    /// Only steady sliding counts; parts with stick-slip are rejected.
    Sliding,
    /// Every contact is a stroke: for textures that stick and slip, which are to be analysed all the same.
    ContactOnly,
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
            judging: Judging::Sliding,
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
        if self.tolerance_share.is_nan() || self.tolerance_share <= 0.0 {
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

/// A part with vibration below this share of the usual stroke is rejected.
const QUIET: f64 = 0.1;
/// A light touch above this share of the contact threshold is listed among the rejected parts.
const LIGHT: f64 = 0.5;
/// The shortest recording that can be cut, s.
const SHORTEST_RECORDING: Seconds = Seconds(0.5);
/// A contact this many times longer than the usual one may be two.
const LONG: f64 = 1.8;
/// A stroke longer than this is longer than a sample, s.
const LONGEST_S: f64 = 6.0;
/// Friction coefficients above this are rarely those of skin: the axes may be swapped.
pub(super) const HIGH_FRICTION: f64 = 1.2;

/// The strokes in `signals` by their normal force: contacts by hysteresis above a baseline that follows the
/// cell's drift, freed of landing and take-off, and only where the finger slides. A force that is negative in
/// contact is taken with its sign reversed, with a warning.
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
    let mut warnings = Vec::new();
    let (force, sign) = oriented(frames, frames.means(normal_n), signals, None, &mut warnings)?;
    let smoothing = (rule.smoothing_s.0, rule.on_n.0);
    let smooth_n = quiet(frames, &force, smoothing, &mut warnings);
    let force = above_drifting_zero(frames, smooth_n, rule.on_n.0);
    warnings.extend(warnings_of_force(normal_n, &force, rule.on_n.0));

    let touches = events(force.level_n.iter().copied(), rule.on_n.0, rule.off_n.0);
    let tangential: Vec<Tangential<'_>> = signals
        .tangential_force_n
        .iter()
        .map(|axis| Tangential {
            samples: axis,
            zero: force.zero_of(frames, axis),
        })
        .collect();
    let tangential_zeros: Vec<Polyline> = tangential.iter().map(|axis| axis.zero.clone()).collect();
    let mut cutter = Cutter {
        signals,
        rule,
        frames,
        level_n: &force.level_n,
        limits: Limits::of(signals),
        floors: signals
            .vibration
            .filter(|_| rule.judging == Judging::Sliding)
            .and_then(|vibration| Floors::of(frames, vibration, &force.lifts)),
        noise: ForceNoise::of(
            frames,
            (&force.level_n, normal_n),
            &signals.tangential_force_n,
            &force.lifts,
        ),
        tangential,
        usual_friction: 0.0,
    };
    let contacts = cutter.contacts(&touches);
    if cutter.floors.is_none() && rule.judging == Judging::Sliding {
        let levels: Vec<f64> = contacts
            .iter()
            .filter_map(|contact| cutter.friction(contact.from, contact.to))
            .map(|ratio| friction_level(&ratio))
            .collect();
        cutter.usual_friction = quantile(&levels, 0.5);
    }
    if rule.judging == Judging::Sliding {
        let each = contacts.iter().filter_map(|one| {
            let (ratio, level_n) = (
                cutter.friction(one.from, one.to)?,
                &cutter.level_n[one.from..one.to],
            );
            Some(cutter.noise.least_slip(&ratio, level_n))
        });
        let least_slip = quantile(&each.collect::<Vec<_>>(), 0.5);
        warnings.extend(cutter.noise.warning(least_slip));
    }
    let (mut strokes, mut rejected) = (Vec::new(), Vec::new());
    let mut friction = Vec::new();
    for contact in &contacts {
        let mut judged = JudgedPart::default();
        match cutter.cut(contact, &mut judged) {
            Ok((stroke, median)) => {
                strokes.push(Stroke {
                    criteria: judged.criteria(),
                    ..stroke
                });
                friction.extend(median);
            }
            Err(reason) => {
                rejected.push(judged.rejects(cutter.samples(contact.from, contact.to), reason));
            }
        }
    }
    // Where most contacts do not show sliding, it is the vibration that shows nothing.
    let still = |one: &&mut Rejected| one.reason == Reason::NoSliding;
    if 2 * rejected.iter_mut().filter(still).count() > contacts.len() {
        for one in rejected.iter_mut().filter(still) {
            let (from, to) = (
                one.interval.start / frames.size,
                one.interval.end / frames.size,
            );
            let unclear = cutter.unclear(from, to, ABOVE_FLOOR);
            one.reason = unclear.unwrap_or(Reason::NoSliding);
        }
    }
    cutter.reject_quiet(&mut strokes, &mut rejected);
    rejected.extend(cutter.light_touches(&contacts));
    force_tolerance(&cutter, &mut strokes, &mut rejected);
    let largest_n = cutter.level_n.iter().copied().fold(0.0, f64::max);
    let is_untouched = strokes.is_empty() && rejected.is_empty();
    let mut found = Segmentation {
        strokes,
        rejected,
        rule: Rule::Force(rule.clone()),
        roles: Roles::default(),
        force_zeros: Some(ForceZeros {
            sign,
            zeros: zeros(frames, &force, &tangential_zeros),
        }),
        cuts: None,
        untouched: is_untouched.then_some([largest_n, rule.on_n.0]),
        warnings,
    };
    found.warnings.extend(found.untouched_warning());
    let parts = (found.strokes.as_slice(), found.rejected.as_slice());
    (found.warnings).extend(contradiction(frames, signals.vibration, parts, |reason| {
        is_of_force(reason, rule)
    }));
    found.warnings.extend(cutter.warnings(&friction));
    Ok(found)
}

/// The warnings about strokes at `rate` that are much longer than the others, or than any slide.
pub(super) fn long_strokes(strokes: &[Stroke], rate: SampleRate) -> Vec<Warning> {
    let lengths: Vec<f64> = strokes.iter().map(|s| s.contact.len() as f64).collect();
    let usual = quantile(&lengths, 0.5);
    let warning = |(stroke, length): (&Stroke, &f64)| {
        let length_s = length / rate.hz();
        let is_long = strokes.len() > 2 && *length > LONG * usual || length_s > LONGEST_S;
        is_long.then(|| {
            Warning::from(StrokeWarning::UnusualStroke {
                what: Unusual::Long {
                    at_s: stroke.contact.start as f64 / rate.hz(),
                    length_s,
                    usual_s: usual / rate.hz(),
                },
            })
        })
    };
    strokes.iter().zip(&lengths).filter_map(warning).collect()
}

/// The force, positive in contact, and the sign by which it was multiplied; with a warning when the sign is −1. `moves` says of
/// every frame whether the surface moves, where that was measured.
pub(super) fn oriented(
    frames: Frames,
    mut force: Vec<f64>,
    signals: &Signals<'_>,
    moves: Option<&[bool]>,
    warnings: &mut Vec<Warning>,
) -> Result<(Vec<f64>, f64), SegmentError> {
    let first = force.first().copied().unwrap_or(0.0);
    let still = 1e-9 * first.abs().max(1e-9);
    if force.iter().all(|value| (value - first).abs() <= still) {
        return Err(SegmentError::Dead {
            what: "the normal force",
            found: format!("{first} N"),
        });
    }
    let (sign, contradiction) = match signals.contact_sign {
        Some(known) => (known, None),
        None => polarity(frames, &force, signals, moves),
    };
    warnings.extend(contradiction.map(|ratio| {
        let fault = ForceFault::LiftsVibrate { ratio };
        Warning::from(ForceWarning::Doubtful { fault })
    }));
    if sign < 0.0 {
        for value in &mut force {
            *value = -*value;
        }
        warnings.push(Warning::from(RecordingWarning::Sign {
            of: ReversedSign::Contact {
                channel: "the normal force".into(),
            },
        }));
    }
    Ok((force, sign))
}

/// The zeros at the middle of every lift: sample, and one value for each axis, the normal one first.
pub(super) fn zeros(
    frames: Frames,
    force: &Force,
    tangential: &[Polyline],
) -> Vec<(usize, Vec<f64>)> {
    let lifts = force.lifts.iter().map(|(from, to)| (from + to) / 2);
    lifts
        .map(|at| {
            let others = tangential.iter().map(|zero| zero.at(at));
            let all = std::iter::once(force.baseline.at(at)).chain(others);
            (at * frames.size, all.collect())
        })
        .collect()
}

/// A tangential force and its zero.
struct Tangential<'a> {
    samples: &'a [f64],
    zero: Polyline,
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
    limits: Limits<'a>,
    /// The levels of the vibration while nothing touches.
    floors: Option<Floors>,
    tangential: Vec<Tangential<'a>>,
    noise: ForceNoise,
    /// The median level of friction of the contacts, where sliding is judged by it; else 0.
    usual_friction: f64,
}

impl Cutter<'_> {
    fn samples(&self, from: usize, to: usize) -> Interval {
        Interval {
            start: from * self.frames.size,
            end: to * self.frames.size,
        }
    }

    /// Touches with short gaps between them are one contact.
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

    /// The stroke in a contact and its median friction coefficient, or the reason for its rejection; with the judged criteria.
    fn cut(
        &self,
        contact: &Contact,
        judged: &mut JudgedPart,
    ) -> Result<(Stroke, Option<f64>), Reason> {
        use StrokeCriterion as What;
        let Contact { from, to, gaps } = *contact;
        let none = Limit::at_most(0.0);
        let outside = u8::from(from == 0) + u8::from(to == self.level_n.len());
        judged.require(What::EndsOutside, f64::from(outside), none, || {
            Reason::CutByRecording
        })?;
        let needed_s = self.rule.shortest_s.0;
        let landing = (self.rule.landing_s.0 * self.frames.rate_hz).round() as usize;
        let take_off = (self.rule.take_off_s.0 * self.frames.rate_hz).round() as usize;
        let (inner_from, inner_to) = (from + landing, to.saturating_sub(take_off));
        let long_enough = |judged: &mut JudgedPart, from: usize, to: usize| {
            let found_s = self.frames.seconds(to.saturating_sub(from));
            let limit = Limit::at_least(needed_s);
            judged.require(What::SteadyPart, found_s, limit, || Reason::TooShort {
                found_s,
                needed_s,
            })
        };
        long_enough(judged, inner_from, inner_to)?;
        judged.require(What::Gaps, gaps as f64, none, || {
            Reason::DiscontinuousContact { gaps }
        })?;
        let (start, end, friction) = match self.rule.judging {
            Judging::ContactOnly => (inner_from, inner_to, None),
            Judging::Sliding => {
                let friction = self.friction(inner_from, inner_to);
                let slips = self.stick_slip(friction.as_deref(), inner_from, inner_to);
                if let Some((slips, rate_hz)) = slips {
                    judged.require(What::SlipRate, rate_hz, slower_slips(), || {
                        Reason::StickSlip { slips, rate_hz }
                    })?;
                }
                let parts = self.sliding(from, to);
                let count = parts.len();
                let slides = Limit::at_least(1.0);
                judged.require(What::SlidingParts, count as f64, slides, || {
                    Reason::NoSliding
                })?;
                if count > 1 {
                    let one = Limit::at_most(1.0);
                    judged.require(What::SlidingParts, count as f64, one, || {
                        let unclear = self.unclear(from, to, CLEARLY_ABOVE_FLOOR);
                        unclear.unwrap_or(Reason::Interrupted { parts: count })
                    })?;
                }
                let (slide_from, slide_to) = (from + parts[0].0, from + parts[0].1);
                let (start, end) = (inner_from.max(slide_from), inner_to.min(slide_to));
                long_enough(judged, start, end)?;
                let turns = f64::from(u8::from(self.turns_back(start, end)));
                judged.require(What::Turns, turns, none, || Reason::Reversed)?;
                (start, end, friction)
            }
        };
        let steady = self.samples(start, end);
        let fraction = self.limits.clipped(steady);
        judged.require(What::ClippedShare, fraction, none, || Reason::Clipped {
            fraction,
        })?;
        let stroke = Stroke {
            steady,
            contact: self.samples(from, to),
            cut_by: CutBy::Rule,
            criteria: Vec::new(),
        };
        Ok((stroke, friction.map(|ratio| quantile(&ratio, 0.5))))
    }

    /// That the vibration in the frames `from`…`to` of a contact is less than `clear` times that without contact, so that it does not show
    /// where the finger slides; `None` where it is more, or was not measured.
    fn unclear(&self, from: usize, to: usize, clear: f64) -> Option<Reason> {
        let (vibration, floors) = (self.signals.vibration?, self.floors?);
        let (level, floor) = floors.level_in(self.frames, vibration, (from, to));
        let (ratio, needed) = (loudness(&level) / floor, ABOVE_FLOOR);
        (ratio < clear).then_some(Reason::SlidingUnclear { ratio, needed })
    }

    fn stick_slip(&self, friction: Option<&[f64]>, from: usize, to: usize) -> Option<(usize, f64)> {
        match (friction, self.signals.vibration) {
            (Some(friction), _) => {
                let noise = self
                    .noise
                    .of_friction(friction, part(self.level_n, from, to));
                stick_slip_in_friction(self.frames, friction, noise)
            }
            (None, Some(vibration)) => {
                let level = vibration_level(self.frames, vibration, from, to);
                stick_slip_in_vibration(self.frames, &level)
            }
            (None, None) => None,
        }
    }

    /// Where the finger slides within the contact: by its vibration where one was measured and there is a lift
    /// to compare it with, else by the friction; else all of it.
    fn sliding(&self, from: usize, to: usize) -> Vec<(usize, usize)> {
        if let (Some(vibration), Some(floors)) = (self.signals.vibration, self.floors) {
            let (level, floor) = floors.level_in(self.frames, vibration, (from, to));
            return sliding_parts(self.frames, &level, floor);
        }
        match self.friction(from, to) {
            Some(friction) => sliding_by_friction(self.frames, &friction, self.usual_friction),
            None => vec![(0, to - from)],
        }
    }

    /// Tangential over normal force in the frames `from`…`to`; `None` without tangential forces.
    fn friction(&self, from: usize, to: usize) -> Option<Vec<f64>> {
        let axes = self
            .tangential
            .iter()
            .map(|axis| (axis.samples, &axis.zero));
        friction(self.frames, axes, part(self.level_n, from, to), from)
    }

    /// Whether the friction points both ways within the frames `from`…`to`, each for a tenth of the time.
    fn turns_back(&self, from: usize, to: usize) -> bool {
        self.tangential.iter().any(|axis| {
            let values = self.frames.means_of(axis.samples, from, to);
            // Hum points both ways, and a finger that turns takes longer.
            let mut values = smoothed(&values, self.frames.in_time(HUM_SMOOTHING_S));
            axis.zero.take_from(&mut values, from);
            let half = 0.5 * quantile(&values.iter().map(|v| v.abs()).collect::<Vec<_>>(), 0.5);
            // A force axis across the stroke fluctuates around zero.
            let slides = half > 0.1 * quantile(part(self.level_n, from, to), 0.5);
            let share = |sign: f64| values.iter().filter(|v| sign * **v > half).count();
            slides && 10 * share(1.0).min(share(-1.0)) > values.len()
        })
    }

    /// Rejects parts that vibrate far less than the other strokes: a resting finger in a noisy environment.
    fn reject_quiet(&self, strokes: &mut Vec<Stroke>, rejected: &mut Vec<Rejected>) {
        let (Judging::Sliding, Some(vibration)) = (self.rule.judging, self.signals.vibration)
        else {
            return;
        };
        let level = |stroke: &Stroke| {
            let (from, to) = (stroke.steady.start, stroke.steady.end);
            let (from, to) = (from / self.frames.size, to / self.frames.size);
            mean(&vibration_level(self.frames, vibration, from, to))
        };
        let levels: Vec<f64> = strokes.iter().map(level).collect();
        let least = QUIET * quantile(&levels, 0.5);
        let mut levels = levels.into_iter();
        let what = StrokeCriterion::VibrationShare;
        strokes.retain_mut(|stroke| {
            let level = levels.next().unwrap_or(least);
            let kept = level >= least;
            let (share, limit) = (level / least * QUIET, Limit::at_least(QUIET));
            if kept {
                stroke.criteria.push(Criterion {
                    outcome: Outcome::Met,
                    ..Criterion::new(what, what.unit(), share, None, limit)
                });
            } else {
                let why = (stroke.contact, Reason::NoSliding);
                rejected.push(JudgedPart::of(stroke).not_met(what, share, limit, why));
            }
            kept
        });
    }

    /// Touches that are longer than a tap but too light for a contact.
    fn light_touches(&self, contacts: &[Contact]) -> Vec<Rejected> {
        let (on_n, needed_s) = (self.rule.on_n.0, self.rule.shortest_s.0);
        let level_n = self.level_n.iter().copied();
        events(level_n, LIGHT * on_n, LIGHT * on_n)
            .into_iter()
            .filter(|(from, to)| self.frames.seconds(to - from) >= needed_s)
            .filter(|(from, to)| !contacts.iter().any(|c| c.from < *to && *from < c.to))
            .map(|(from, to)| {
                let level_n = part(self.level_n, from, to).iter().copied();
                let peak_n = level_n.fold(0.0, f64::max);
                let reason = Reason::TooLight {
                    peak_n,
                    needed_n: on_n,
                };
                JudgedPart::default().not_met(
                    StrokeCriterion::LargestForce,
                    peak_n,
                    Limit::at_least(on_n),
                    (self.samples(from, to), reason),
                )
            })
            .collect()
    }

    fn mean_force_n(&self, stroke: &Stroke) -> f64 {
        let size = self.frames.size;
        mean(part(
            self.level_n,
            stroke.steady.start / size,
            stroke.steady.end / size,
        ))
    }

    fn warnings(&self, friction: &[f64]) -> Vec<Warning> {
        let mut warnings = Vec::new();
        let unseen = self.floors.is_none() && self.tangential.is_empty();
        if unseen || self.rule.judging == Judging::ContactOnly {
            warnings.push(Warning::from(RecordingWarning::ChannelMissing {
                what: MissingChannel::Sliding,
            }));
        }
        let coefficient = quantile(friction, 0.5);
        if coefficient > HIGH_FRICTION {
            warnings.push(Warning::from(ForceWarning::Doubtful {
                fault: ForceFault::HighFriction { coefficient },
            }));
        }
        warnings
    }
}

/// Tangential over normal force in the frames from `from` on that `level_n` holds, from the tangential forces and
/// their zeros; 0 where nothing touches, `None` without tangential forces.
pub(super) fn friction<'a>(
    frames: Frames,
    axes: impl Iterator<Item = (&'a [f64], &'a Polyline)>,
    level_n: &[f64],
    from: usize,
) -> Option<Vec<f64>> {
    let mut squares: Option<Vec<f64>> = None;
    for (samples, zero) in axes {
        let mut means = frames.means_of(samples, from, from + level_n.len());
        zero.take_from(&mut means, from);
        let squares = squares.get_or_insert_with(|| vec![0.0; level_n.len()]);
        for (square, off) in squares.iter_mut().zip(means) {
            *square += off * off;
        }
    }
    let mut ratio = squares?;
    for (square, level) in ratio.iter_mut().zip(level_n) {
        *square = if *level > 0.01 {
            square.sqrt() / level
        } else {
            0.0
        };
    }
    Some(ratio)
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
        None => {
            let parts: Vec<Interval> = strokes.iter().map(|s| s.steady).collect();
            let vibration = cutter.signals.vibration;
            usual_force_n(
                cutter.frames,
                vibration,
                &parts,
                &forces,
                cutter.rule.tolerance_share,
            )
        }
    };
    let reach_n = cutter.rule.tolerance_share * target_n;
    let mut forces = forces.into_iter();
    let what = StrokeCriterion::ForceDeviation;
    strokes.retain_mut(|stroke| {
        let mean_n = forces.next().unwrap_or(target_n);
        let kept = (mean_n - target_n).abs() <= reach_n;
        let (off_n, limit) = (mean_n - target_n, Limit::Within { reach: reach_n });
        if kept {
            stroke.criteria.push(Criterion {
                outcome: Outcome::Met,
                ..Criterion::new(what, what.unit(), off_n, None, limit)
            });
        } else {
            let reason = Reason::ForceOutsideTolerance {
                mean_n,
                target_n,
                low_n: target_n - reach_n,
                high_n: target_n + reach_n,
            };
            let why = (stroke.contact, reason);
            rejected.push(JudgedPart::of(stroke).not_met(what, off_n, limit, why));
        }
        kept
    });
    rejected.sort_by_key(|r| r.interval.start);
}
