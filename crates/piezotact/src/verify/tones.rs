//! The amplitude spectra of target and measurement, in which a line of a periodic texture has the height of its amplitude.

use super::{Verification, VerifyError};
use crate::quantity::{Drive, SampleRate};
use crate::spectrum::{WelchConfig, WelchPlan};

/// The longest segment, s.
const LONGEST_S: f64 = 2.0;

/// The amplitude spectra of a target and of its measurement.
#[derive(Clone, Debug, PartialEq)]
pub struct Tones {
    /// How they were estimated.
    pub welch: WelchConfig,
    /// The number of segments averaged.
    pub averages: usize,
    pub frequency_hz: Vec<f64>,
    /// The amplitude of every line of the target, in its unit.
    pub target: Vec<f64>,
    /// The amplitude of every line of the measurement, in the unit of the target.
    pub measured: Vec<f64>,
}

/// The single-sided amplitude spectra of what `verification` compared, within its band: a sine stands at its peak amplitude
/// within 0.1 %, wherever it falls between lines.
///
/// Formula: √(2·P), P the mean power of the segments under a flat-top window, |FFT|²/(Σw)². Segments are the largest power of
/// two of samples within 2 s and within what is compared, 75 % overlapped.
///
/// Source: [`crate::spectrum::Spectrum::amplitudes`]; the thesis' figures 47 and 48, which show one transform of all samples.
///
/// # Errors
/// [`VerifyError::Estimate`] when what is compared is empty.
pub fn tones(verification: &Verification) -> Result<Tones, VerifyError> {
    let rate = SampleRate::new(verification.rate_hz)?;
    let compared = verification.compared.clone();
    let most = rate
        .samples_in(crate::quantity::Seconds(LONGEST_S))
        .min(compared.len());
    let segment = 1usize << most.max(1).ilog2();
    let welch = WelchConfig::tones(segment);
    let mut plan = WelchPlan::new(&welch, rate)?;
    // The unit plays no part in it.
    let target = plan.estimate::<Drive>(&[&verification.target[compared.clone()]])?;
    let measured = plan.estimate::<Drive>(&[&verification.aligned[compared]])?;
    Ok(Tones {
        averages: target.averages,
        frequency_hz: target.frequencies_hz(),
        target: target.amplitudes(),
        measured: measured.amplitudes(),
        welch,
    })
}
