//! Faults of a force cell detected in its normal force: a wrong unit or scale, and a zero with a large offset, drift or
//! scatter.

use super::contact::Force;
use super::frames::quantile;
use crate::clipping::flat_top_fraction;
use crate::number::{counted, rounded, signed};
use crate::statistics::mean;
use crate::warning::Warning;
use serde::{Deserialize, Serialize};

/// The largest plausible force of a sliding fingertip, N: surfaces are explored with 0.1 to 5 N; the maximal force of most
/// people at rest is 30 to 60 N.
const LARGEST_N: f64 = 20.0;
/// A change of the zero is reported from this share of the contact threshold on.
const SIZEABLE: f64 = 0.1;
/// The fewest lifts from which a trend of the zero is tested.
const LIFTS_OF_A_COURSE: usize = 4;
/// One-sided 5 % of the standard normal distribution.
const NORMAL: f64 = 1.645;

/// What a person should know of a force before relying on it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "code", rename_all = "snake_case")]
pub enum ForceWarning {
    /// A force that cannot be trusted.
    #[error("{fault}; {}", fault.advice())]
    #[serde(rename = "force_doubtful")]
    Doubtful {
        #[serde(flatten)]
        fault: ForceFault,
    },
}

/// What is wrong with a force.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "fault", rename_all = "snake_case")]
pub enum ForceFault {
    /// A normal force that no fingertip presses with.
    #[error(
        "the normal force reaches {level_n:.0} N{}, and no fingertip presses with more than {largest_n:.0} N: {}, so forces and friction are wrong",
        match at_limit_share {
        0.0 => String::new(),
        share => format!(" and stays at its limit in {:.1} % of the samples", 100.0 * share),
        },
        if *at_limit_share > 0.0 { "the cell is saturated, or its unit or scale is wrong" } else { "its unit or scale is wrong (mN, g or counts instead of N)" }
    )]
    Implausible {
        level_n: f64,
        largest_n: f64,
        at_limit_share: f64,
    },
    /// The zero of a force cell lies farther from 0 than any fingertip presses.
    #[error(
        "the zero of the normal force lies at {zero_n:.0} N, farther from 0 than the {largest_n:.0} N that a fingertip presses with: the cell was \
            not zeroed, carries a weight, or its unit is wrong"
    )]
    ZeroFar { zero_n: f64, largest_n: f64 },
    /// The zero of a force cell differs from lift to lift without a trend.
    #[error(
        "the zero of the normal force lies between {from_n:.3} and {to_n:.3} N in {lifts} lifts, without a clear drift (a contact needs \
            {threshold_n} N): forces have this uncertainty",
        threshold_n = rounded(*threshold_n)
    )]
    ZeroScatters {
        from_n: f64,
        to_n: f64,
        lifts: usize,
        threshold_n: f64,
    },
    /// The forces never leave one level: their zeros are not known.
    #[error(
        "the finger never leaves the surface, or never touches it: the zeros of the forces are assumed to be 0, and force and friction are only as \
            accurate as this assumption"
    )]
    ZeroUnknown,
    /// The zero of a force cell drifts.
    #[error(
        "the zero of the normal force drifts between {from_n} and {to_n} N (a contact needs {threshold_n} N): contacts are found above the \
            drifting zero",
        from_n = signed(*from_n, 3),
        to_n = signed(*to_n, 3),
        threshold_n = rounded(*threshold_n)
    )]
    ZeroDrifts {
        from_n: f64,
        to_n: f64,
        threshold_n: f64,
    },
    /// More friction than skin usually has.
    #[error(
        "the friction coefficient is {coefficient:.2}, more than skin usually has: an adhesive surface, or the force axes are swapped"
    )]
    HighFriction { coefficient: f64 },
    /// What is rejected for its force vibrates more than the strokes.
    #[error(
        "the vibration in {} that the normal force rejects is {ratio:.1} times that in the strokes that are kept: the finger may touch where the \
            force says that it does not",
        counted(*count, "part")
    )]
    VibrationContradicts { count: usize, ratio: f64 },
    /// The finger vibrates more where the normal force is near zero.
    #[error(
        "the vibration is {ratio:.1} times as much where the normal force is near zero as where it presses: what is near zero is taken as lifted, \
            since the forces say so"
    )]
    LiftsVibrate { ratio: f64 },
    /// The normal force fluctuates where nothing touches, as much as a light touch.
    #[error(
        "the normal force fluctuates by {noise_n:.3} N rms where it is quietest, and a contact needs {threshold_n} N: noise or hum of its cell; it \
            is smoothed over {smoothing_ms:.0} ms to find contacts",
        threshold_n = rounded(*threshold_n)
    )]
    Fluctuates {
        noise_n: f64,
        threshold_n: f64,
        smoothing_ms: f64,
    },
    /// The forces fluctuate without contact, and hide slips.
    #[error(
        "the forces fluctuate by {noise_n:.3} N rms without contact: slips by less than {:.0} % of the friction are not seen, and 20 % make stick-slip",
        100.0 * least_slip
    )]
    SlipsHidden { noise_n: f64, least_slip: f64 },
    /// The file of the force began again while it was followed.
    #[error(
        "{file} was emptied or replaced, or its time began again, {} while it was followed: the zero of the force may have changed",
        counted(*times, "time")
    )]
    BeganAgain { file: String, times: usize },
}

impl ForceFault {
    /// What a person can do.
    fn advice(&self) -> &'static str {
        match self {
            Self::Implausible { .. } => "check its unit and scale",
            Self::ZeroFar { .. } | Self::ZeroScatters { .. } | Self::BeganAgain { .. } => {
                "check the zero of the force cell, and any weight on it"
            }
            Self::ZeroUnknown => "record a part with the finger lifted",
            Self::ZeroDrifts { .. } => "let the cell warm up, or zero it between trials",
            Self::HighFriction { .. } => "check which channel is the normal force",
            Self::Fluctuates { .. } | Self::SlipsHidden { .. } => {
                "shield the cable of the cell, or filter the forces before they are sampled"
            }
            Self::VibrationContradicts { .. } | Self::LiftsVibrate { .. } => {
                "check channel, sign and zero of the normal force; cut the strokes by hand"
            }
        }
    }
}

/// The warnings about `force`, computed from the samples `normal_n` with the contact threshold `on_n`.
///
/// Formula: a drift is shown where the zeros bᵢ of n lifts follow each other more closely than at random, by J. von
/// Neumann's ratio: Σ(bᵢ₊₁ − bᵢ)²/Σ(bᵢ − b̄)² < 2 − 1.645·2·√((n − 2)/(n² − 1)).
///
/// Source: J. von Neumann (1941), Ann. Math. Stat. 12(4).
pub(super) fn warnings_of_force(normal_n: &[f64], force: &Force, on_n: f64) -> Vec<Warning> {
    let level_n = quantile(&force.level_n, 0.99);
    if level_n > LARGEST_N {
        return vec![Warning::from(ForceWarning::Doubtful {
            fault: ForceFault::Implausible {
                level_n,
                largest_n: LARGEST_N,
                at_limit_share: flat_top_fraction(normal_n),
            },
        })];
    }
    let zeros_n: Vec<f64> = force.baseline.0.iter().map(|(_, zero_n)| *zero_n).collect();
    let zero_n = quantile(&zeros_n, 0.5);
    let mut warnings = Vec::new();
    if zero_n.abs() > LARGEST_N {
        warnings.push(Warning::from(ForceWarning::Doubtful {
            fault: ForceFault::ZeroFar {
                zero_n,
                largest_n: LARGEST_N,
            },
        }));
    }
    let (from_n, to_n) = force.baseline.range();
    let threshold_n = on_n;
    if to_n - from_n <= SIZEABLE * on_n {
        return warnings;
    }
    warnings.push(if force.lifts.is_empty() {
        // The lower envelope of one contact is no zero.
        Warning::from(ForceWarning::Doubtful {
            fault: ForceFault::ZeroUnknown,
        })
    } else if has_a_course(&zeros_n) {
        Warning::from(ForceWarning::Doubtful {
            fault: ForceFault::ZeroDrifts {
                from_n,
                to_n,
                threshold_n,
            },
        })
    } else {
        Warning::from(ForceWarning::Doubtful {
            fault: ForceFault::ZeroScatters {
                from_n,
                to_n,
                lifts: zeros_n.len(),
                threshold_n,
            },
        })
    });
    warnings
}

/// Whether values follow each other more closely than at random.
fn has_a_course(values: &[f64]) -> bool {
    if values.len() < LIFTS_OF_A_COURSE {
        return false;
    }
    let middle = mean(values);
    let spread: f64 = values.iter().map(|v| (v - middle).powi(2)).sum();
    let steps: f64 = values.windows(2).map(|v| (v[1] - v[0]).powi(2)).sum();
    let n = values.len() as f64;
    steps / spread < 2.0 - NORMAL * 2.0 * ((n - 2.0) / (n * n - 1.0)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stroke::contact::above_drifting_zero;
    use crate::stroke::frames::Frames;

    const FRAMES: Frames = Frames {
        size: 10,
        rate_hz: 500.0,
    };

    /// Twelve touches of `press_n` on a zero of `zero` in newtons by the second, found with contacts from half of 0.2 N.
    fn said(press_n: f64, zero: impl Fn(f64) -> f64) -> Vec<String> {
        let force: Vec<f64> = (0..12_000)
            .map(|i| {
                let t = f64::from(i) / 500.0;
                let touches = t % 2.0 > 0.5 && t % 2.0 < 1.6;
                zero(t) + if touches { press_n } else { 0.0 }
            })
            .collect();
        let found = above_drifting_zero(FRAMES, force.clone(), 0.1);
        let warnings = warnings_of_force(&force, &found, 0.1);
        warnings.iter().map(ToString::to_string).collect()
    }

    /// 200 N is not a drift of the zero: a unit or a scale is wrong, or the cell is saturated.
    #[test]
    fn two_hundred_newtons_are_named_as_what_they_are() {
        assert_eq!(said(0.2, |_| 0.003), [""; 0]);
        let text = said(200.0, |t| 15.0 * (0.3 * t).sin());
        assert_eq!(text.len(), 1, "{text:?}");
        assert!(
            text[0].contains("reaches 2") && text[0].contains("unit or scale is wrong"),
            "{text:?}"
        );
        let far = said(0.2, |_| -200.0);
        assert!(
            far.len() == 1 && far[0].contains("lies at -200 N"),
            "{far:?}"
        );
    }

    #[test]
    fn a_drift_is_said_where_one_is_shown() {
        let drifts = said(0.2, |t| 0.004 * t);
        assert!(drifts[0].contains("drifts between"), "{drifts:?}");
        // A zero that jumps to and fro between two lifts.
        let scatters = said(0.2, |t| if t % 4.0 < 2.0 { 0.0 } else { 0.03 });
        assert!(
            scatters[0].contains("without a clear drift"),
            "{scatters:?}"
        );
    }
}
