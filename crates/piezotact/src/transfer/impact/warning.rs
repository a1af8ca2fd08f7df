//! Warnings about an impact test.

use std::f64::consts::PI;
use std::fmt;

use super::fault::HitFault;
use crate::number::digits;
use crate::warning::words::percent;
use crate::warning::{Advice, Subject, Warning, WarningKind, warnings};

warnings! {
    /// Warnings about an impact test.
    pub enum ImpactWarning {
        /// Nothing states that the drive is an impact: it was found to consist of short pulses.
        TakenAsImpact("taken_as_impact") {
            /// The number of hits.
            hits: usize,
            /// The share of the recording that they take, 0–1.
            share: f64,
        },
        /// Coherence and scatter cannot be told from one hit.
        OneHit("one_hit"),
        /// Few hits: coherence and scatter are uncertain.
        FewHits("few_hits") {
            /// How many were used.
            hits: usize,
            /// How many are recommended.
            recommended: usize,
        },
        /// An exponential window added damping to every resonance.
        AddedDamping("added_damping") {
            /// The added damping σ, 1/s.
            damping_per_s: f64,
            /// The level of the response at the end of the segment without the window, re its largest, 0–1.
            left: f64,
        },
        /// The response has not decayed at the end of the segment, and no window brings it down.
        NotDecayed("response_not_decayed") {
            /// Its level there re its largest, 0–1.
            left: f64,
            /// In which octave, the one that has decayed least, Hz; absent where it is over all frequencies.
            octave_hz: Option<[f64; 2]>,
            /// The length of a segment, s.
            segment_s: f64,
        },
        /// The pulses of the force are negative.
        NegativeForce("negative_force") {
            /// The peak of the largest, in the unit of the force.
            peak: f64,
        },
        /// A double hit, which was left out.
        DoubleHit("double_hit") {
            /// When, s.
            at_s: f64,
            /// How much later the second pulse begins, s.
            after_s: f64,
            /// Its peak re that of the larger one, 0–1.
            share: f64,
        },
        /// A hit whose force is overloaded, which was left out.
        ForceOverload("force_overload") {
            /// When, s.
            at_s: f64,
            /// The samples at the limit.
            samples: usize,
        },
        /// A hit whose response is overloaded, which was left out.
        ResponseOverload("response_overload") {
            /// When, s.
            at_s: f64,
            /// The samples at the limit.
            samples: usize,
        },
        /// A hit that is followed too soon by the next, which was left out.
        NextHitTooClose("next_hit_too_close") {
            /// When, s.
            at_s: f64,
            /// How long after it the next comes, s.
            after_s: f64,
            /// How long a hit has to last, s.
            needed_s: f64,
        },
        /// A hit at the end of the recording, which was left out.
        HitAtTheEnd("hit_at_the_end") {
            /// When, s.
            at_s: f64,
            /// How much of the recording is left after it, s.
            left_s: f64,
            /// How long a hit has to last, s.
            needed_s: f64,
        },
        /// A hit at the beginning of the recording, which was left out.
        HitAtTheBeginning("hit_at_the_beginning") {
            /// When, s.
            at_s: f64,
        },
        /// A hit on a response that had not come to rest, which was left out.
        StillMoving("response_still_moving") {
            /// When, s.
            at_s: f64,
            /// The level of the response before it re its largest after it, 0–1.
            share: f64,
        },
        /// A hit that comes after its response, which was left out.
        ResponseBeforeHit("response_before_hit") {
            /// When, s.
            at_s: f64,
            /// How much before the response begins, s.
            lead_s: f64,
        },
        /// A hit of the other sign, which was left out.
        OppositeHit("opposite_hit") {
            /// When, s.
            at_s: f64,
        },
        /// A hit without a response, which was left out.
        NoResponse("no_response_to_hit") {
            /// When, s.
            at_s: f64,
        },
        /// A hit whose response drops out, which was left out.
        ResponseStops("response_drops_out") {
            /// When, s.
            at_s: f64,
            /// How long after the hit, s.
            after_s: f64,
            /// For how long, s.
            lasts_s: f64,
        },
        /// Some hits have another response than the others.
        OtherResponse("hits_differ") {
            /// When, s.
            at_s: Vec<f64>,
            /// The largest part of the energy of their response that the others do not predict, re all of it.
            share: f64,
            /// The same of the hit at the median.
            usual: f64,
        },
        /// The response to the hit before has not come to rest, and the hits are used.
        EarlierResponse("earlier_response") {
            /// The number of hits.
            hits: usize,
            /// The largest level before a hit re the largest after it, 0–1.
            share: f64,
        },
        /// The response consists of short pulses, and the drive does not.
        PulsesInResponse("pulses_in_response") {
            /// How many.
            hits: usize,
        },
        /// The baseline of the response drifts, and was subtracted.
        ResponseDrifts("response_drifts") {
            /// By how much it departs from its median at most, re the largest response.
            share: f64,
        },
        /// A drive that is averaged by segments contains short pulses.
        PulsesInDrive("pulses_in_drive") {
            /// How many.
            hits: usize,
            /// Their share of the energy of the drive, 0–1.
            energy: f64,
        },
        /// The baseline of the force drifts, and was subtracted.
        ForceDrifts("force_drifts") {
            /// By how much it departs from its median at most, re the largest hit.
            share: f64,
        },
        /// A hit with lost samples, which was left out.
        SamplesLost("hit_lost_samples") {
            /// When, s.
            at_s: f64,
        },
    }
}

impl ImpactWarning {
    /// The warning about the hit at `at_s` that was left out for `fault`.
    #[cfg(feature = "modal")]
    pub(super) fn of_hit(at_s: f64, fault: HitFault) -> Warning {
        Warning::from(match fault {
            HitFault::Double { after_s, share } => Self::DoubleHit {
                at_s,
                after_s,
                share,
            },
            HitFault::ForceOverload { samples } => Self::ForceOverload { at_s, samples },
            HitFault::ResponseOverload { samples } => Self::ResponseOverload { at_s, samples },
            HitFault::NextTooClose { after_s, needed_s } => Self::NextHitTooClose {
                at_s,
                after_s,
                needed_s,
            },
            HitFault::AtTheEnd { left_s, needed_s } => Self::HitAtTheEnd {
                at_s,
                left_s,
                needed_s,
            },
            HitFault::AtTheBeginning => Self::HitAtTheBeginning { at_s },
            HitFault::StillMoving { share } => Self::StillMoving { at_s, share },
            HitFault::ResponseFirst { lead_s } => Self::ResponseBeforeHit { at_s, lead_s },
            HitFault::Opposite => Self::OppositeHit { at_s },
            HitFault::NoResponse => Self::NoResponse { at_s },
            HitFault::LostSamples => Self::SamplesLost { at_s },
            HitFault::ResponseStops { after_s, lasts_s } => Self::ResponseStops {
                at_s,
                after_s,
                lasts_s,
            },
        })
    }

    /// The time and the fault of a hit that was left out.
    fn fault(&self) -> Option<(f64, HitFault)> {
        Some(match *self {
            Self::DoubleHit {
                at_s,
                after_s,
                share,
            } => (at_s, HitFault::Double { after_s, share }),
            Self::ForceOverload { at_s, samples } => (at_s, HitFault::ForceOverload { samples }),
            Self::ResponseOverload { at_s, samples } => {
                (at_s, HitFault::ResponseOverload { samples })
            }
            Self::NextHitTooClose {
                at_s,
                after_s,
                needed_s,
            } => (at_s, HitFault::NextTooClose { after_s, needed_s }),
            Self::HitAtTheEnd {
                at_s,
                left_s,
                needed_s,
            } => (at_s, HitFault::AtTheEnd { left_s, needed_s }),
            Self::HitAtTheBeginning { at_s } => (at_s, HitFault::AtTheBeginning),
            Self::StillMoving { at_s, share } => (at_s, HitFault::StillMoving { share }),
            Self::ResponseBeforeHit { at_s, lead_s } => (at_s, HitFault::ResponseFirst { lead_s }),
            Self::OppositeHit { at_s } => (at_s, HitFault::Opposite),
            Self::NoResponse { at_s } => (at_s, HitFault::NoResponse),
            Self::SamplesLost { at_s } => (at_s, HitFault::LostSamples),
            Self::ResponseStops {
                at_s,
                after_s,
                lasts_s,
            } => (at_s, HitFault::ResponseStops { after_s, lasts_s }),
            _ => return None,
        })
    }
}

impl WarningKind for ImpactWarning {
    fn of(warning: &Warning) -> Option<Self> {
        Self::of_warning(warning)
    }

    fn advice(&self) -> Vec<Advice> {
        if let Some((_, fault)) = self.fault() {
            return fault.advice();
        }
        match self {
            Self::TakenAsImpact { .. } => vec![Advice::StateExcitation],
            Self::OneHit => vec![Advice::HitMore { count: 3 }],
            Self::FewHits { recommended, .. } => vec![Advice::HitMore {
                count: *recommended,
            }],
            Self::AddedDamping { .. } => vec![Advice::SubtractDamping, Advice::RecordLonger],
            Self::NotDecayed { .. } => vec![Advice::RecordLonger, Advice::ExponentialWindow],
            Self::NegativeForce { .. } => vec![Advice::Check(Subject::Polarity)],
            Self::OtherResponse { .. } => vec![Advice::Check(Subject::PointOfHits)],
            Self::EarlierResponse { .. } => vec![Advice::HitLater],
            Self::PulsesInDrive { .. } => vec![Advice::EvaluateAsImpacts, Advice::LeaveOut],
            Self::PulsesInResponse { .. } => vec![Advice::ExchangeDriveAndResponse],
            Self::ResponseDrifts { .. } => vec![Advice::Check(Subject::ChannelsAndSensor)],
            Self::ForceDrifts { .. } => vec![Advice::Check(Subject::ForceChannel)],
            _ => Vec::new(),
        }
    }
}

impl fmt::Display for ImpactWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some((at_s, fault)) = self.fault() {
            return write!(f, "the hit at {at_s:.3} s is not used: {fault}");
        }
        match self {
            Self::TakenAsImpact { hits, share } => write!(
                f,
                "the drive is {hits} short pulse{} in {} of the recording: it is evaluated as an impact test",
                if *hits == 1 { "" } else { "s" },
                percent(*share)
            ),
            Self::OneHit => f.write_str(
                "one hit has no coherence, so that neither noise nor a second force would show: the uncertainty is not known",
            ),
            Self::FewHits { hits, recommended } => write!(
                f,
                "only {hits} hits were used, {recommended} or more are recommended: coherence and limits are uncertain"
            ),
            Self::AddedDamping {
                damping_per_s,
                left,
            } => write!(
                f,
                "an exponential window adds a damping of σ = {} 1/s to every resonance, whose half-power bandwidth is {} Hz wider \
                    and whose height is lower: without it {} of the response would remain at the end of the segment",
                digits(*damping_per_s),
                digits(damping_per_s / PI),
                percent(*left)
            ),
            Self::NotDecayed {
                left,
                octave_hz,
                segment_s,
            } => {
                let octave = octave_hz.map_or_else(String::new, |[low, high]| {
                    format!(" between {low:.0} and {high:.0} Hz")
                });
                write!(
                    f,
                    "{} of the response{octave} is left at the end of the segment of {segment_s:.3} s: what lasts there is \
                        underestimated at its resonances, and leaks into neighbouring lines",
                    percent(*left)
                )
            }
            Self::NegativeForce { peak } => write!(
                f,
                "the force is negative in the hits (peak {}), although a hammer pushes: either it hit against the direction of the \
                    sensor, or the sign of the force is reversed and the phase is off by 180°",
                digits(*peak)
            ),
            Self::OtherResponse { at_s, share, usual } => {
                let times: Vec<String> = at_s.iter().map(|at_s| format!("{at_s:.3} s")).collect();
                write!(
                    f,
                    "the response to the hit{} at {} is not that to the others: up to {} of its energy differs from what they predict \
                        ({} for the median hit); it is used all the same",
                    if times.len() == 1 { "" } else { "s" },
                    times.join(", "),
                    percent(*share),
                    percent(*usual)
                )
            }
            Self::EarlierResponse { hits, share } => write!(
                f,
                "up to {} of the response to the hit before is left when {hits} of the hits come: the function scatters by as much from \
                    hit to hit",
                percent(*share)
            ),
            Self::PulsesInDrive { hits, energy } => write!(
                f,
                "the drive contains {hits} short pulse{} with {} of its energy: if {} of a hammer, an average by segments weights \
                    each by where it lies and is wrong by any amount; if not, it is a disturbance",
                if *hits == 1 { "" } else { "s" },
                percent(*energy),
                if *hits == 1 { "it is a hit" } else { "they are hits" }
            ),
            Self::PulsesInResponse { hits } => write!(
                f,
                "the response consists of {hits} short pulse{}, which the drive does not: they look like the force of a hammer",
                if *hits == 1 { "" } else { "s" }
            ),
            Self::ResponseDrifts { share } => write!(
                f,
                "the baseline of the response drifts by up to {} of its largest value; it was subtracted, and the lowest lines are \
                    uncertain",
                percent(*share)
            ),
            Self::ForceDrifts { share } => write!(
                f,
                "the baseline of the force drifts by up to {} of the largest hit; it was subtracted",
                percent(*share)
            ),
            _ => Ok(()),
        }
    }
}
