//! A texture and the drive rendered from it, aligned in time and normalised by their rms, so that their shapes can be compared.

use super::align::in_band;
use super::{Verification, VerifyError};
use crate::quantity::{Drive, SampleRate, Seconds};
use crate::render::Rendering;
use crate::resample::resample;
use crate::series::Series;
use crate::spectrum::WelchPlan;
use crate::statistics::rms;

/// A texture and its drive, aligned in time, both limited to the band of the comparison and normalised by their rms.
#[derive(Clone, Debug, PartialEq)]
pub struct Beside {
    /// The rms of the texture in the band, in its unit.
    pub target_rms: f64,
    /// The rms of the drive in the band, full scale = 1.
    pub drive_rms: f64,
    /// The lines of the spectra, Hz.
    pub frequency_hz: Vec<f64>,
    /// The PSD of the texture over its mean square, 1/Hz.
    pub target_psd: Vec<f64>,
    /// The PSD of the drive over its mean square, 1/Hz.
    pub drive_psd: Vec<f64>,
    /// The texture at the rate of the comparison, in multiples of its rms.
    pub target: Vec<f64>,
    /// The drive at the texture's times, in multiples of its rms.
    pub drive: Vec<f64>,
}

/// The texture of `verification` and its `drive`, both in multiples of their rms. The drive begins `lead` before the texture
/// and is shifted back by that, to the nearest sample; the PSDs by Welch's method as in the verification.
///
/// Source: the thesis' figure 45.
///
/// # Errors
/// [`VerifyError::Series`] when the drive cannot be brought to the rate, [`VerifyError::TooShort`] when they do not overlap
/// by a segment, [`VerifyError::Silent`] when the drive holds nothing in the band.
pub fn beside(
    verification: &Verification,
    drive: &Series<Drive>,
    lead: Seconds,
) -> Result<Beside, VerifyError> {
    let rate = SampleRate::new(verification.rate_hz)?;
    let drive = resample(drive, rate)?;
    let limited = in_band(drive.samples(), rate, verification.band_hz);
    let later = ((lead.0 - verification.silence_s) * rate.hz()).round() as i64;
    let count = verification.target.len();
    let moved: Vec<f64> = (0..count as i64)
        .map(|i| {
            let place = usize::try_from(i + later).ok();
            place.and_then(|i| limited.get(i)).copied().unwrap_or(0.0)
        })
        .collect();
    let within = |place: i64| place.clamp(0, count as i64) as usize;
    let (from, to) = (within(-later), within(limited.len() as i64 - later));
    if to < from + verification.welch.segment {
        return Err(VerifyError::TooShort {
            expected: verification.welch.segment,
            found: to.saturating_sub(from),
        });
    }
    let (target, played) = (&verification.target[from..to], &moved[from..to]);
    let (target_rms, drive_rms) = (rms(target), rms(played));
    for (what, rms) in [("the target", target_rms), ("the drive", drive_rms)] {
        if rms <= 0.0 {
            let band = verification.band_hz;
            return Err(VerifyError::Silent { what, band });
        }
    }
    let mut plan = WelchPlan::new(&verification.welch, rate)?;
    let of_target = plan.estimate::<Drive>(&[target])?;
    let of_drive = plan.estimate::<Drive>(&[played])?;
    let over = |values: &[f64], rms: f64| values.iter().map(|p| p / (rms * rms)).collect();
    Ok(Beside {
        target_rms,
        drive_rms,
        frequency_hz: of_target.frequencies_hz(),
        target_psd: over(&of_target.values, target_rms),
        drive_psd: over(&of_drive.values, drive_rms),
        target: verification.target.iter().map(|v| v / target_rms).collect(),
        drive: moved.iter().map(|v| v / drive_rms).collect(),
    })
}
/// Where a drive comes from, which says on whose clock it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DriveSource {
    /// Recorded beside the measurement.
    Recorded,
    /// As it was rendered.
    Rendered,
}

/// A texture beside its drive, with the time by which the drive begins earlier.
#[derive(Clone, Debug)]
pub struct DriveBeside {
    /// Where the drive comes from.
    pub source: DriveSource,
    /// How long the drive begins before the texture.
    pub lead: Seconds,
    /// What that time follows from: the rendering, or the delay of the measurement.
    pub lead_from: DriveSource,
    /// The two on one time, or why they cannot be compared.
    pub found: Result<Beside, VerifyError>,
}

/// The texture of `verification` beside a drive from `source`, which was made as `rendering` says.
///
/// Formula: [`beside`], with the modelling delay of the rendering as the lead of a drive as it was rendered, else with the delay of
/// the measurement, s.
///
/// Source: as [`beside`].
#[must_use]
pub fn drive_beside(
    verification: &Verification,
    (drive, source): (&Series<Drive>, DriveSource),
    rendering: Option<&Rendering>,
) -> DriveBeside {
    let (lead, lead_from) = match (source, rendering) {
        (DriveSource::Rendered, Some(made)) => (made.config.modelling_delay, source),
        _ => (Seconds(verification.delay_s), DriveSource::Recorded),
    };
    DriveBeside {
        source,
        lead,
        lead_from,
        found: beside(verification, drive, lead),
    }
}
