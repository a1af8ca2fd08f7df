//! The mapping of amplitudes and frequencies of a clip to Core Haptics on an iPhone.

use super::{AmplitudePoint, Emphasis, FrequencyPoint};

/// How much of the continuous intensity gives way where a transient is played.
const DUCKING: f64 = 0.2;

/// The intensity of the continuous event at a breakpoint, 0–1.
///
/// Formula: √amplitude, and 0.8·√amplitude where the breakpoint is emphasised, so that its transient stands out.
///
/// Source: Lofelt `NiceVibrations`, `core/datamodel/src/ios/v1.rs` (MIT).
///
/// ```
/// use piezotact_haptic::envelope::{AmplitudePoint, continuous_intensity};
/// let point = AmplitudePoint { time_s: 0.0, amplitude: 0.25, emphasis: None };
/// assert_eq!(continuous_intensity(&point), 0.5);
/// ```
#[must_use]
pub fn continuous_intensity(point: &AmplitudePoint) -> f64 {
    let intensity = point.amplitude.sqrt();
    if point.emphasis.is_some() {
        intensity * (1.0 - DUCKING)
    } else {
        intensity
    }
}

/// The intensity of the transient of an emphasis, 0–1: √amplitude. Its sharpness is the frequency as it is.
///
/// Source: Lofelt `NiceVibrations`, `core/datamodel/src/ios/v1.rs` (MIT).
#[must_use]
pub fn transient_intensity(emphasis: &Emphasis) -> f64 {
    emphasis.amplitude.sqrt()
}

/// The control of sharpness at a breakpoint of frequency, 0–1: √frequency, both 0–1.
///
/// Source: Lofelt `NiceVibrations`, `core/datamodel/src/ios/v1.rs` (MIT).
#[must_use]
pub fn sharpness_control(point: &FrequencyPoint) -> f64 {
    point.frequency.sqrt()
}
