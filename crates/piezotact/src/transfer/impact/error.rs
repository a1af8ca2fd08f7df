//! Why an impact test cannot be evaluated.

use super::fault::HitFault;
use crate::number::digits;
use crate::number::rounded;

/// Why an impact test cannot be evaluated.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ImpactError {
    /// The force holds no hit.
    #[error(
        "expected hits, pulses of the force above 10 times its noise, found none: its largest value is {} and its noise {}; check \
            that the force of the hammer is the drive, its cable and its range, and hit harder",
        digits(*.largest),
        digits(*.noise)
    )]
    NoHit {
        /// The largest magnitude re rest, in the unit of the force.
        largest: f64,
        /// The standard deviation of the noise, in the unit of the force.
        noise: f64,
    },
    /// The force is no series of pulses.
    #[error(
        "expected hits, short pulses of the force with rest between them, found a force that oscillates or does not rest; check \
            whether drive and response are exchanged, or evaluate it as a random drive"
    )]
    NoPulses,
    /// No hit can be used.
    #[error("expected one usable hit or more, found {} and none usable: {}", .faults.len(), listed(.faults))]
    NoneUsable {
        /// Where each hit is, s, and its first fault.
        faults: Vec<(f64, HitFault)>,
    },
    /// The segment cannot hold a hit.
    #[error(
        "expected a segment of {least} samples or more, and no longer than the recording of {samples}, found {found}; state another \
            length, or none"
    )]
    Segment {
        /// The shortest segment, samples.
        least: usize,
        /// The length of the recording, samples.
        samples: usize,
        /// The segment asked for, samples.
        found: usize,
    },
    /// An exponential window that leaves nothing of a segment.
    #[error(
        "expected an added damping of at most {most:.0} 1/s for a segment of {segment_s:.3} s, found {found}; state less, or a shorter \
            segment",
        found = rounded(*found)
    )]
    Overdamped {
        /// What was found, 1/s.
        found: f64,
        /// The most for this segment, 1/s.
        most: f64,
        segment_s: f64,
    },
    /// An added damping that is none.
    #[error(
        "expected an added damping above 0 1/s, found {found}; state the damping in 1/s, or none"
    )]
    Damping {
        /// What was found, 1/s.
        found: f64,
    },
}

/// The first faults, each with its time, and what to do.
fn listed(faults: &[(f64, HitFault)]) -> String {
    let mut said: Vec<String> = faults
        .iter()
        .take(4)
        .map(|(at_s, fault)| format!("at {at_s:.3} s {fault}"))
        .collect();
    if faults.len() > said.len() {
        said.push(format!("and {} more", faults.len() - said.len()));
    }
    let mut advice: Vec<&str> = Vec::new();
    for (_, fault) in faults {
        let one = fault.advice();
        if !advice.contains(&one) {
            advice.push(one);
        }
    }
    format!("{}; {}", said.join("; "), advice.join("; "))
}
