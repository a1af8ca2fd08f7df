//! Whether the vibration agrees with the force about what is contact, and the limits of both.

use super::criteria::{JudgedPart, StrokeCriterion};
use super::force_warning::{ForceFault, ForceWarning};
use super::frames::{Frames, quantile};
use super::sliding::vibration_level;
use super::{ForceRule, Interval, Reason, Rejected, Signals, Stroke};
use crate::clipping::Rails;
use crate::criterion::Limit;
use crate::warning::Warning;

/// Rejected parts that vibrate so many times as much as the strokes contradict the force.
const LOUDER: f64 = 1.25;
/// A pass without contact has less than this share of the force and of the vibration of one in contact.
const WITHOUT_CONTACT: f64 = 0.5;

/// The vibration and the forces, with the limits that the whole recording shows of each.
pub(super) struct Limits<'a>(Vec<(&'a [f64], Rails)>);

impl<'a> Limits<'a> {
    pub(super) fn of(signals: &Signals<'a>) -> Self {
        let normal_n = signals.normal_force_n.iter();
        let forces = normal_n.chain(&signals.tangential_force_n);
        let channels = signals.vibration.iter().chain(forces);
        Self(channels.map(|one| (*one, Rails::of(one))).collect())
    }

    /// The largest share of samples at a limit, 0–1.
    pub(super) fn clipped(&self, steady: Interval) -> f64 {
        let shares = self.0.iter();
        let shares = shares.map(|(channel, rails)| rails.share(steady.of(channel)));
        shares.fold(0.0, f64::max)
    }
}

/// The median of the short-time level of the vibration in a part.
fn level(frames: Frames, vibration: &[f64], part: Interval) -> f64 {
    let (from, to) = (part.start / frames.size, part.end / frames.size);
    quantile(&vibration_level(frames, vibration, from, to), 0.5)
}

/// The warning that parts which are rejected for a reason that is `of_force` vibrate more than the strokes.
pub(super) fn contradiction(
    frames: Frames,
    vibration: Option<&[f64]>,
    (strokes, rejected): (&[Stroke], &[Rejected]),
    of_force: impl Fn(&Reason) -> bool,
) -> Option<Warning> {
    let vibration = vibration?;
    let kept = strokes.iter().map(|s| level(frames, vibration, s.steady));
    let kept: Vec<f64> = kept.collect();
    let rejected = rejected.iter().filter(|r| of_force(&r.reason));
    let rejected = rejected.map(|r| level(frames, vibration, r.interval));
    let rejected: Vec<f64> = rejected.collect();
    let ratio = quantile(&rejected, 0.5) / quantile(&kept, 0.5);
    (ratio.is_finite() && ratio > LOUDER).then(|| {
        let fault = ForceFault::VibrationContradicts {
            count: rejected.len(),
            ratio,
        };
        Warning::from(ForceWarning::Doubtful { fault })
    })
}

/// Whether a part is rejected for its force alone, and should not vibrate more than strokes. A force above the load that is stated vibrates more.
pub(super) fn is_of_force(reason: &Reason, rule: &ForceRule) -> bool {
    match reason {
        Reason::NoContact | Reason::TooLight { .. } => true,
        Reason::ForceOutsideTolerance {
            mean_n, target_n, ..
        } => rule.load_n.is_none() || mean_n < target_n,
        _ => false,
    }
}

/// The usual force of candidate strokes, N: the median of `forces_n`, or, where those that are heavier by more than `tolerance_share` vibrate
/// twice as much as the others, their median: a finger in the air presses too where a cell has cross-talk.
pub(super) fn usual_force_n(
    frames: Frames,
    vibration: Option<&[f64]>,
    parts: &[Interval],
    forces_n: &[f64],
    tolerance_share: f64,
) -> f64 {
    let usual_n = quantile(forces_n, 0.5);
    let Some(vibration) = vibration else {
        return usual_n;
    };
    let all = parts.iter().zip(forces_n);
    let (heavy, others): (Vec<_>, Vec<_>) =
        all.partition(|(_, force_n)| **force_n > (1.0 + tolerance_share) * usual_n);
    let level = |of: &[(&Interval, &f64)]| {
        let levels = of.iter().map(|(part, _)| level(frames, vibration, **part));
        quantile(&levels.collect::<Vec<_>>(), 0.5)
    };
    match level(&others) < WITHOUT_CONTACT * level(&heavy) {
        true => quantile(&heavy.iter().map(|(_, n)| **n).collect::<Vec<_>>(), 0.5),
        false => usual_n,
    }
}

/// What a stroke is a pass of: whether the motion is positive, and the mean normal force, N.
pub(super) struct Pass {
    pub(super) is_forward: bool,
    pub(super) force_n: f64,
}

/// Rejects the strokes of one direction of motion where all of them together press and vibrate less than half as much as those of the other:
/// the finger is lifted on the way back, and the cell does not show zero. `passes` are those of the strokes.
pub(super) fn reject_ways_back(
    frames: Frames,
    vibration: Option<&[f64]>,
    passes: &[Pass],
    strokes: &mut Vec<Stroke>,
    rejected: &mut Vec<Rejected>,
) {
    let Some(vibration) = vibration else {
        return;
    };
    let levels: Vec<f64> = strokes
        .iter()
        .map(|stroke| level(frames, vibration, stroke.steady))
        .collect();
    // The medians of the force and of the vibration in one direction; none where no stroke has it.
    let medians = |is_forward: bool| -> Option<[f64; 2]> {
        let these = passes.iter().zip(&levels);
        let these = these.filter(|(pass, _)| pass.is_forward == is_forward);
        let (forces, levels): (Vec<f64>, Vec<f64>) =
            these.map(|(pass, level)| (pass.force_n, *level)).unzip();
        (!forces.is_empty()).then(|| [quantile(&forces, 0.5), quantile(&levels, 0.5)])
    };
    let (Some(forward), Some(backward)) = (medians(true), medians(false)) else {
        return;
    };
    let less = |a: [f64; 2], b: [f64; 2]| (0..2).all(|i| a[i] < WITHOUT_CONTACT * b[i]);
    let (lifted_is_forward, touching_level) = if less(forward, backward) {
        (true, backward[1])
    } else if less(backward, forward) {
        (false, forward[1])
    } else {
        return;
    };
    let mut each = passes.iter().zip(&levels);
    strokes.retain(|stroke| {
        let lifted = (each.next()).filter(|(pass, _)| pass.is_forward == lifted_is_forward);
        let Some((_, level)) = lifted else {
            return true;
        };
        rejected.push(JudgedPart::of(stroke).not_met(
            StrokeCriterion::VibrationShare,
            level / touching_level,
            Limit::at_least(WITHOUT_CONTACT),
            (stroke.contact, Reason::NoContact),
        ));
        false
    });
    rejected.sort_by_key(|one| one.interval.start);
}
