//! The change of a texture by a manipulation: its level and the shape of its spectrum before and after.

use serde::Serialize;

use super::{VerifyConfig, VerifyError, errors_in_band, rms_of};
use crate::quantity::{Band, Decibels, Quantity};
use crate::series::Series;
use crate::spectrum::{WelchPlan, frequency_axis};
use crate::statistics::standard_deviation;

/// The difference between two textures in level and spectral shape.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Changed {
    /// The band over which the shapes are compared, Hz.
    pub band_hz: Band,
    /// The level before, rms about the mean at all frequencies, in the unit of the textures.
    pub rms_before: f64,
    /// The level after, likewise.
    pub rms_after: f64,
    /// Their ratio, dB.
    pub level_db: f64,
    /// The rms difference of the spectra over the lines of the band after removing their mean difference, dB; 0 when
    /// only the level was changed.
    pub shape_error_db_rms: f64,
    /// The lines of the spectra, Hz.
    #[serde(skip)]
    pub frequency_hz: Vec<f64>,
    /// The PSD before, unit²/Hz.
    #[serde(skip)]
    pub psd_before: Vec<f64>,
    /// The PSD after, unit²/Hz.
    #[serde(skip)]
    pub psd_after: Vec<f64>,
}

/// How `after` differs from `before`, two textures at one rate, in level and in the shape of their PSDs by Welch's method.
///
/// Source: the thesis' section 4.4 and figure 62, where levels are exchanged and shapes stay.
///
/// # Errors
/// [`VerifyError::Rate`] when the rates differ, [`VerifyError::BandAboveNyquist`], [`VerifyError::Silent`] when the texture
/// before holds nothing in the band, [`VerifyError::Estimate`] when either is shorter than a segment.
pub fn changed<Q: Quantity>(
    before: &Series<Q>,
    after: &Series<Q>,
    config: &VerifyConfig,
) -> Result<Changed, VerifyError> {
    let (rate, band) = (before.rate(), config.band);
    if (after.rate().hz() - rate.hz()).abs() > 1e-9 * rate.hz() {
        return Err(VerifyError::Rate {
            target_hz: rate.hz(),
            measured_hz: after.rate().hz(),
        });
    }
    if band.high().0 > rate.nyquist().0 {
        let highest = rate.nyquist();
        return Err(VerifyError::BandAboveNyquist { band, highest });
    }
    let mut plan = WelchPlan::new(&config.welch, rate)?;
    let psd_before = plan.estimate::<Q>(&[before.samples()])?;
    let psd_after = plan.estimate::<Q>(&[after.samples()])?;
    let resolution_hz = psd_before.resolution_hz;
    let lines = errors_in_band(&psd_before.values, &psd_after.values, resolution_hz, band);
    let lines = lines.map_err(|error| match error {
        VerifyError::Silent { band, .. } => VerifyError::Silent {
            what: "the texture before",
            band,
        },
        other => other,
    })?;
    let differences = || lines.compared.iter().map(|(_, error_db)| *error_db);
    let mean_db = differences().sum::<f64>() / lines.compared.len() as f64;
    let (rms_before, rms_after) = (
        standard_deviation(before.samples()),
        standard_deviation(after.samples()),
    );
    Ok(Changed {
        band_hz: band,
        rms_before,
        rms_after,
        level_db: Decibels::from_amplitude_ratio(rms_after / rms_before).0,
        shape_error_db_rms: rms_of(differences().map(|error| error - mean_db)),
        frequency_hz: frequency_axis(resolution_hz, psd_before.values.len()),
        psd_before: psd_before.values,
        psd_after: psd_after.values,
    })
}
