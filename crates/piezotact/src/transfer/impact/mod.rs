//! Impact tests: the transfer function from the force of a hammer to a response. Every hit is one segment, transformed whole.
//!
//! A window of an average by segments is near zero at the ends of the segment: a hit that lies there is weighted away while
//! the response to it is not, and the estimate is wrong by any amount. A segment that begins just before the hit and ends
//! when the response has decayed needs no window.
//!
//! The estimate is there with the feature `modal`. Hits are found in any build: no average by segments takes them for a drive that lasts.

#[cfg(feature = "modal")]
mod decay;
#[cfg(feature = "modal")]
mod estimate;
mod fault;
#[cfg(feature = "modal")]
mod overload;
mod pulses;
mod record;
#[cfg(feature = "modal")]
mod segments;
mod warning;

#[cfg(feature = "modal")]
pub(super) use estimate::impacts;
#[cfg(feature = "modal")]
pub use estimate::{ImpactEstimate, estimate_impacts};
pub use fault::HitFault;
pub(crate) use pulses::short_pulses;
pub use pulses::{Transient, transient};
pub use record::{Hit, ImpactTest, ImpactTraces};
pub use warning::{ImpactWarning, NotDecayed};

/// What the drive is taken for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Excitation {
    /// An impact where the drive consists of short pulses, else a drive that lasts.
    #[default]
    Found,
    /// A drive that lasts over the whole recording, such as noise: averages over segments.
    Lasting,
    /// Hits of a hammer: one segment a hit.
    #[cfg(feature = "modal")]
    Impact,
}

/// The length of the segments of an impact test.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ImpactSegment {
    /// Twice as long as the response takes to decay, as far as the hits and the recording allow.
    #[default]
    Fitted,
    /// As many samples.
    Samples(usize),
}

/// The window of the force.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ForceWindow {
    /// 1 until the pulse has ended, then a taper to 0: the noise after the pulse is left out.
    #[default]
    OverPulse,
    /// None.
    None,
}

/// The exponential window of force and response.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum ExponentialWindow {
    /// None.
    #[default]
    None,
    /// Where the response has not decayed at the end of the segment: as much as brings it to 1 % there.
    WhereNeeded,
    /// With this damping σ, 1/s.
    Damping(f64),
}

/// How an impact test is evaluated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImpactConfig {
    /// The length of a segment.
    pub segment: ImpactSegment,
    /// The window of the force.
    pub force_window: ForceWindow,
    pub exponential: ExponentialWindow,
    /// Lines whose force lies by more than this below its highest level are not excited, dB.
    pub excited_within_db: f64,
}

impl ImpactConfig {
    /// The usual evaluation: segments fitted to the hits, a force window, no exponential window, and a excited band in which the
    /// force spectrum lies within 10 dB of its highest level.
    ///
    /// Source: ISO 7626-5 and D. J. Ewins, *Modal Testing*, 2nd ed., section 3.9, for the windows; docs/decisions/transfer-functions.md.
    #[must_use]
    pub fn usual() -> Self {
        Self {
            segment: ImpactSegment::default(),
            force_window: ForceWindow::default(),
            exponential: ExponentialWindow::default(),
            excited_within_db: 10.0,
        }
    }
}
