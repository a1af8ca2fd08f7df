//! Strokes: the parts of a recording in which a finger slides steadily on a surface.
//!
//! Active touch is segmented by the normal force, passive touch by the speed of the surface; rejected parts and the reasons
//! are part of the result. Positions are samples from the start of the recording.

mod agreement;
mod contact;
mod criteria;
mod cuts;
mod force;
mod force_warning;
pub(crate) mod frames;
mod played;
mod sliding;
mod speed;
mod warning;
mod way;

use crate::integrity::{ChannelFault, SignalWarning};
use serde::{Deserialize, Serialize};
pub use warning::{StrokeWarning, Unusual};

use crate::criterion::Criterion;
use crate::quantity::{Newtons, SampleRate, Seconds, Unit};
use crate::recording::{MissingChannel, Recording, RecordingError, RecordingWarning, Touch};
use crate::roles::{Motion, Roles};
use crate::warning::{Counts, Warning};

pub use criteria::StrokeCriterion;
pub use cuts::{Cut, Cuts};
pub use force::{ForceRule, Judging, segment_by_force};
pub use force_warning::{ForceFault, ForceWarning};
pub use played::played_part;
pub(crate) use speed::stroke_speed_m_s;
pub use speed::{SpeedRule, segment_by_speed};
pub(crate) use way::{Way, ways};

/// The signals used for segmentation: slices of equal length at one rate.
#[derive(Clone, Debug)]
pub struct Signals<'a> {
    pub rate: SampleRate,
    /// The vibration channels, in any unit.
    pub vibration: Option<&'a [f64]>,
    /// The normal force, N.
    pub normal_force_n: Option<&'a [f64]>,
    /// The tangential forces, N.
    pub tangential_force_n: Vec<&'a [f64]>,
    /// Speed in m/s or position in m.
    pub motion: Option<(&'a [f64], MotionKind)>,
    /// The sign of the normal force in contact, where it is known; else it is found.
    pub contact_sign: Option<f64>,
}

/// What a motion channel holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MotionKind {
    /// Speed, m/s.
    Speed,
    /// Position, m.
    Position,
}

impl<'a> Signals<'a> {
    /// The channels of `recording` that `roles` names.
    ///
    /// # Errors
    /// [`SegmentError::Channel`] when a named channel is not there, [`SegmentError::Unit`] when a force is not
    /// in N or a motion neither in m nor in m/s.
    pub fn of(recording: &'a Recording, roles: &Roles) -> Result<Self, SegmentError> {
        let channel = |name: &str| {
            recording
                .pick(Some(name), &Unit::Newton)
                .map_err(SegmentError::Channel)
        };
        let in_unit = |name: &str, unit: Unit| {
            let channel = channel(name)?;
            if channel.unit == unit {
                Ok(channel.samples.as_slice())
            } else {
                Err(SegmentError::Unit {
                    channel: name.into(),
                    expected: unit,
                    found: channel.unit.clone(),
                })
            }
        };
        let motion = match &roles.motion {
            None => None,
            Some(Motion::Speed(name)) => {
                Some((in_unit(name, Unit::MetrePerSecond)?, MotionKind::Speed))
            }
            Some(Motion::Position(name)) => {
                Some((in_unit(name, Unit::Metre)?, MotionKind::Position))
            }
        };
        Ok(Self {
            rate: roles.rate_in(recording)?,
            vibration: match roles.vibration.first() {
                Some(name) => Some(channel(name)?.samples.as_slice()),
                None => None,
            },
            normal_force_n: match &roles.normal_force {
                Some(name) => Some(in_unit(name, Unit::Newton)?),
                None => None,
            },
            tangential_force_n: roles
                .tangential_force
                .iter()
                .map(|name| in_unit(name, Unit::Newton))
                .collect::<Result<_, _>>()?,
            motion,
            contact_sign: None,
        })
    }

    fn len(&self) -> usize {
        [
            self.normal_force_n,
            self.vibration,
            self.motion.map(|(samples, _)| samples),
        ]
        .into_iter()
        .flatten()
        .map(<[f64]>::len)
        .next()
        .unwrap_or(0)
    }
}

/// A part of a recording, from sample `start` up to, not including, sample `end`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Interval {
    /// The first sample.
    pub start: usize,
    /// One past the last sample.
    pub end: usize,
}

impl Interval {
    /// The number of samples.
    #[must_use]
    pub fn len(self) -> usize {
        self.end.saturating_sub(self.start)
    }

    /// Whether it holds no sample.
    #[must_use]
    pub fn is_empty(self) -> bool {
        self.len() == 0
    }

    /// Whether both have a sample in common.
    #[must_use]
    pub fn meets(self, other: Self) -> bool {
        self.start < other.end && other.start < self.end
    }

    /// Its samples of a channel; what lies beyond the channel is left out.
    #[must_use]
    pub fn of<T>(self, samples: &[T]) -> &[T] {
        let end = self.end.min(samples.len());
        &samples[self.start.min(end)..end]
    }
}

/// A stroke: its steady part, and the contact to which it belongs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Stroke {
    /// The part that is analysed, without landing and take-off.
    pub steady: Interval,
    /// From the first touch to the last in active touch; in passive touch the motion that it lies in.
    pub contact: Interval,
    /// Who cut it.
    pub cut_by: CutBy,
    /// The criteria judged for it; empty for a manual stroke.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub criteria: Vec<Criterion<StrokeCriterion>>,
}

/// Who decided on a cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum CutBy {
    /// The rule of the segmentation.
    Rule,
    /// A person, in a file of cuts.
    Person,
}

/// A rejected part: a candidate that is not a stroke.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Rejected {
    /// The contact or motion.
    pub interval: Interval,
    /// Why.
    pub reason: Reason,
    /// The criteria judged for it, in order, up to the one that is not met.
    pub criteria: Vec<Criterion<StrokeCriterion>>,
}

/// Why a part of a recording is no stroke.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(tag = "reason", rename_all = "snake_case")]
pub enum Reason {
    /// Too little of it is steady.
    TooShort {
        /// The steady part, s.
        found_s: f64,
        /// What is needed, s.
        needed_s: f64,
    },
    /// The mean normal force differs from the target.
    ForceOutsideTolerance {
        /// The mean, N.
        mean_n: f64,
        /// The target force, or the usual one of the recording, N.
        target_n: f64,
        /// The lowest allowed, N.
        low_n: f64,
        /// The highest allowed, N.
        high_n: f64,
    },
    /// The finger hardly touches.
    TooLight {
        /// The largest force, N.
        peak_n: f64,
        /// What a contact needs, N.
        needed_n: f64,
    },
    /// The finger sticks and slips.
    StickSlip {
        /// Sudden slips.
        slips: usize,
        /// Their rate, Hz.
        rate_hz: f64,
    },
    /// A channel is clipped.
    Clipped {
        /// The share of samples at the limit, 0–1.
        fraction: f64,
    },
    /// The finger leaves the surface for moments.
    DiscontinuousContact {
        /// How often.
        gaps: usize,
    },
    /// The finger stops on its way: a hesitation, or two strokes without a lift between them.
    Interrupted {
        /// How many parts slide.
        parts: usize,
    },
    /// The speed varies too much for a plateau, although the surface does not stop.
    UnsteadySpeed {
        /// The standard deviation of the speed, as a share of the plateau's.
        deviation_share: f64,
        /// How far from the plateau's speed it may be, as a share of it.
        tolerance_share: f64,
        /// The share of the time in which it is farther, 0–1.
        outside: f64,
    },
    /// The finger reverses its direction without a lift.
    Reversed,
    /// The finger touches and does not slide.
    NoSliding,
    /// The vibration in contact does not stand clearly above that without contact, so that it does not show where the finger slides.
    SlidingUnclear {
        /// The vibration in contact, as a multiple of that without contact.
        ratio: f64,
        /// The multiple that sliding needs.
        needed: f64,
    },
    /// The surface moves and nothing touches it.
    NoContact,
    /// The contact begins before the recording or outlasts it.
    CutByRecording,
    /// A person excluded it.
    ByPerson {
        /// The person's note.
        note: String,
    },
}

impl Reason {
    /// The reason as documents have it: `too_short`.
    #[must_use]
    pub fn code(&self) -> &'static str {
        match self {
            Self::TooShort { .. } => "too_short",
            Self::ForceOutsideTolerance { .. } => "force_outside_tolerance",
            Self::TooLight { .. } => "too_light",
            Self::StickSlip { .. } => "stick_slip",
            Self::Clipped { .. } => "clipped",
            Self::DiscontinuousContact { .. } => "discontinuous_contact",
            Self::Interrupted { .. } => "interrupted",
            Self::UnsteadySpeed { .. } => "unsteady_speed",
            Self::Reversed => "reversed",
            Self::NoSliding => "no_sliding",
            Self::SlidingUnclear { .. } => "sliding_unclear",
            Self::NoContact => "no_contact",
            Self::CutByRecording => "cut_by_recording",
            Self::ByPerson { .. } => "by_person",
        }
    }

    /// The reason in two words, for tables.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::TooShort { .. } => "too short",
            Self::ForceOutsideTolerance { .. } => "force outside tolerance",
            Self::TooLight { .. } => "force too low",
            Self::StickSlip { .. } => "stick-slip",
            Self::Clipped { .. } => "clipped",
            Self::DiscontinuousContact { .. } => "discontinuous contact",
            Self::Interrupted { .. } => "interrupted sliding",
            Self::UnsteadySpeed { .. } => "unsteady speed",
            Self::Reversed => "reversed direction",
            Self::NoSliding => "no sliding",
            Self::SlidingUnclear { .. } => "sliding unclear",
            Self::NoContact => "no contact",
            Self::CutByRecording => "not recorded whole",
            Self::ByPerson { .. } => "excluded by hand",
        }
    }
}

impl std::fmt::Display for Reason {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())?;
        match self {
            Self::TooShort { found_s, needed_s } => {
                write!(f, " ({found_s:.3} s steady, {needed_s} s needed)")
            }
            Self::ForceOutsideTolerance {
                mean_n,
                low_n,
                high_n,
                ..
            } => write!(f, " (mean {mean_n:.3} N, {low_n:.3}–{high_n:.3} N allowed)"),
            Self::TooLight { peak_n, needed_n } => {
                write!(f, " ({peak_n:.3} N at most, {needed_n} N needed)")
            }
            Self::StickSlip { slips, rate_hz } => {
                write!(f, " ({slips} slips, {rate_hz:.1} a second)")
            }
            Self::Clipped { fraction } => {
                write!(
                    f,
                    " ({:.1} % of the samples at the limit)",
                    fraction * 100.0
                )
            }
            Self::DiscontinuousContact { gaps } => write!(f, " ({gaps} losses of contact)"),
            Self::Interrupted { parts } => write!(f, " ({parts} sliding parts in one contact)"),
            Self::UnsteadySpeed {
                deviation_share,
                tolerance_share,
                outside,
            } => write!(
                f,
                " (standard deviation {:.1} %; outside of ±{:.0} % for {:.0} % of the time, {:.0} % allowed)",
                deviation_share * 100.0,
                tolerance_share * 100.0,
                outside * 100.0,
                speed::MOST_OUTSIDE * 100.0
            ),
            Self::SlidingUnclear { ratio, needed } => write!(
                f,
                " (the vibration is {ratio:.1} times that without contact, and {needed} times is needed)"
            ),
            Self::ByPerson { note } if !note.is_empty() => write!(f, ": {note}"),
            Self::Reversed
            | Self::NoSliding
            | Self::NoContact
            | Self::CutByRecording
            | Self::ByPerson { .. } => Ok(()),
        }
    }
}

/// How a recording was cut.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(tag = "rule", rename_all = "snake_case")]
pub enum Rule {
    /// By the normal force.
    Force(ForceRule),
    /// By the speed of the surface.
    Speed(SpeedRule),
    /// The whole recording is one stroke.
    Whole,
    /// What was felt while a drive played is one stroke: the finger rests.
    Played,
}

/// The strokes of a recording.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Segmentation {
    /// The strokes, in their order.
    pub strokes: Vec<Stroke>,
    /// The rejected parts, in their order.
    pub rejected: Vec<Rejected>,
    /// How it was done.
    pub rule: Rule,
    /// Which channels play which part.
    pub roles: Roles,
    /// The zeros of the forces; absent where they were not found.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub force_zeros: Option<ForceZeros>,
    /// The file of manual cuts that were applied.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cuts: Option<String>,
    /// The largest force and the least of a contact, N, where nothing touches; absent elsewhere.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub untouched: Option<[f64; 2]>,
    /// What a person should know before relying on it, beside [`Self::own_warnings`].
    #[serde(alias = "doubts")]
    pub warnings: Vec<Warning>,
}

/// The drifting zeros of a force cell, measured without contact.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct ForceZeros {
    /// What the normal force is multiplied by to be positive in contact: 1 or −1.
    pub sign: f64,
    /// Sample, and the zero of every axis there in N: the normal one (after the sign), then the tangential ones.
    pub zeros: Vec<(usize, Vec<f64>)>,
}

impl ForceZeros {
    /// The zero of axis `axis` (0 is the normal one) at sample `at`, N: on the line between the lifts around it.
    #[must_use]
    pub fn at(&self, axis: usize, at: usize) -> f64 {
        let value = |(_, axes): &(usize, Vec<f64>)| axes.get(axis).copied().unwrap_or(0.0);
        let next = self.zeros.partition_point(|(sample, _)| *sample <= at);
        match (
            next.checked_sub(1).and_then(|i| self.zeros.get(i)),
            self.zeros.get(next),
        ) {
            (Some(a), Some(b)) => {
                let share = (at - a.0) as f64 / (b.0 - a.0).max(1) as f64;
                value(a) + share * (value(b) - value(a))
            }
            (Some(only), None) | (None, Some(only)) => value(only),
            (None, None) => 0.0,
        }
    }
}

impl Segmentation {
    /// The warnings that follow from its parts, of a recording at `rate`: nothing was cut, strokes are long, parts were rejected. What
    /// a person cut is long on purpose.
    ///
    /// Source: house rule.
    #[must_use]
    pub fn own_warnings(&self, rate: SampleRate) -> Vec<Warning> {
        let of_rule = match &self.rule {
            _ if self.cuts.is_some() => Vec::new(),
            Rule::Whole => vec![
                RecordingWarning::ChannelMissing {
                    what: MissingChannel::Cutting,
                }
                .into(),
            ],
            Rule::Force(_) => force::long_strokes(&self.strokes, rate),
            Rule::Speed(_) | Rule::Played => Vec::new(),
        };
        of_rule
            .into_iter()
            .chain(self.rejection_warning())
            .collect()
    }

    /// The warning that nothing touches; `None` where something does, or no force was looked at.
    pub(crate) fn untouched_warning(&self) -> Option<Warning> {
        let [largest_n, threshold_n] = self.untouched?;
        let untouched = StrokeWarning::NoContact {
            largest_n,
            threshold_n,
        };
        Some(untouched.into())
    }

    /// The warning about rejected parts, with the count of every reason; `None` if nothing was rejected. Motions without contact
    /// are not counted when there are no more of them than strokes: the surface moves back.
    pub(crate) fn rejection_warning(&self) -> Option<Warning> {
        let mut reasons = Counts::default();
        let untouched = |r: &&Rejected| r.reason == Reason::NoContact;
        let ways_back = self.rejected.iter().filter(untouched).count() <= self.strokes.len();
        let failed = self
            .rejected
            .iter()
            .filter(|r| !(ways_back && untouched(r)));
        for rejected in failed.clone() {
            *reasons.0.entry(rejected.reason.code().into()).or_default() += 1;
        }
        (!reasons.0.is_empty()).then(|| {
            Warning::from(StrokeWarning::Rejected {
                count: failed.clone().count(),
                of: failed.count() + self.strokes.len(),
                reasons,
            })
        })
    }
}

/// The expected load, speed and sliding criterion for a recording whose rule is not stated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Expected {
    /// The normal force that was asked for; none when it is not known.
    pub load_n: Option<Newtons>,
    /// The speed that was asked for, m/s.
    pub speed_m_s: Option<f64>,
    /// Whether contacts are judged by how the finger slides.
    pub judging: Judging,
}

/// The strokes of a recording, in samples, by the rule that its channels allow: by speed if it was measured, otherwise by the
/// normal force, otherwise the whole recording, with a warning. In active touch by the normal force if it was measured, otherwise by speed.
///
/// Source: the protocols of active and passive touch; see [`segment_by_force`] and [`segment_by_speed`].
///
/// # Errors
/// Those of the rule that is taken.
pub fn segment(
    recording: &Recording,
    roles: &Roles,
    expected: Expected,
) -> Result<Segmentation, SegmentError> {
    segment_of_sign(recording, roles, expected, None)
}

/// As [`segment`], with the sign of the normal force in contact where it is known.
pub(crate) fn segment_of_sign(
    recording: &Recording,
    roles: &Roles,
    expected: Expected,
    contact_sign: Option<f64>,
) -> Result<Segmentation, SegmentError> {
    let (mut roles, mut dead) = (roles.clone(), Vec::new());
    roles.tangential_force.retain(|name| {
        let channel = recording.channels().iter().find(|c| c.name == *name);
        let changes = channel.is_none_or(|c| c.samples.windows(2).any(|pair| pair[0] != pair[1]));
        if !changes {
            dead.push(Warning::from(SignalWarning::Channel {
                channel: name.clone(),
                fault: ChannelFault::Dead,
            }));
        }
        changes
    });
    let signals = Signals {
        contact_sign,
        ..Signals::of(recording, &roles)?
    };
    // A hand has no plateau of the speed.
    let by_hand = recording.about.condition.touch == Some(Touch::Active);
    let forces = signals.normal_force_n.is_some();
    let mut segmentation = if signals.motion.is_some() && !(by_hand && forces) {
        let rule = match by_hand {
            true => SpeedRule::hand(expected),
            false => SpeedRule::trapezoid(expected),
        };
        segment_by_speed(&signals, &rule)?
    } else if forces {
        let rule = ForceRule {
            judging: expected.judging,
            ..ForceRule::active(expected.load_n)
        };
        segment_by_force(&signals, &rule)?
    } else {
        whole(&signals)?
    };
    if segmentation.strokes.is_empty()
        && let Some(played) = played_part(recording)
        && played.end <= signals.len()
    {
        segmentation = one_stroke(played, Rule::Played);
    }
    segmentation.roles = roles;
    segmentation.warnings.extend(dead);
    Ok(segmentation)
}

/// The whole recording as one stroke.
///
/// Source: for recordings that hold nothing but the sliding, or no channel to cut by.
///
/// # Errors
/// [`SegmentError::NothingToCutBy`] when there is no vibration either.
pub fn whole(signals: &Signals<'_>) -> Result<Segmentation, SegmentError> {
    let all = Interval {
        start: 0,
        end: signals.len(),
    };
    if all.is_empty() {
        return Err(SegmentError::NothingToCutBy);
    }
    Ok(one_stroke(all, Rule::Whole))
}

fn one_stroke(all: Interval, rule: Rule) -> Segmentation {
    Segmentation {
        strokes: vec![Stroke {
            steady: all,
            contact: all,
            cut_by: CutBy::Rule,
            criteria: Vec::new(),
        }],
        rejected: Vec::new(),
        rule,
        roles: Roles::default(),
        force_zeros: None,
        cuts: None,
        untouched: None,
        warnings: Vec::new(),
    }
}

/// Why a recording cannot be cut into strokes.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SegmentError {
    /// A named channel is not there.
    #[error(transparent)]
    Channel(#[from] RecordingError),
    /// A channel holds another quantity.
    #[error(
        "expected `{channel}` in {expected}, found {found}; name another channel or correct its unit"
    )]
    Unit {
        channel: String,
        expected: Unit,
        found: Unit,
    },
    /// There is nothing to cut by.
    #[error("there is no channel of force, speed or vibration to cut by: name one")]
    NothingToCutBy,
    /// The channel to cut by never changes.
    #[error("expected {what} to change, found {found} all along; check the cable and the channel")]
    Dead {
        what: &'static str,
        /// Its value with its unit.
        found: String,
    },
    /// An impossible rule.
    #[error("expected {expected}, found {found}; correct the rule")]
    Rule {
        expected: &'static str,
        found: String,
    },
    /// The recording is too short to be cut.
    #[error("expected at least {needed} to cut, found {found}; record longer")]
    TooShort { needed: Seconds, found: Seconds },
}
