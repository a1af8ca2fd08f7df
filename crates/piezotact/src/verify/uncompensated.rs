//! Predicted response to a texture sent directly as the drive, without inversion: the negative control, computed instead of
//! measured.

use num_complex::Complex;
use serde::Serialize;

use super::{Measured, Verification, VerifyConfig, VerifyError, rms_of, verify};
use crate::fourier::{RealTransform, fast_length};
use crate::quantity::{Band, Decibels, Drive, Hertz, Quantity};
use crate::series::Series;
use crate::statistics::mean;
use crate::transfer::TransferFunction;

/// The predicted response of the device to a texture sent directly as the drive, from its transfer function: linear, without
/// noise and without clipping.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct UncompensatedPrediction {
    /// The band of the comparison: the part of the requested band that the transfer function covers, Hz.
    pub band_hz: Band,
    /// The rms error of the judged lines after their mean error is taken away, dB.
    pub error_db_rms_level_matched: f64,
    /// That mean error: the level of the response re the texture when one unit of texture is a drive of 1, dB.
    pub level_difference_db: f64,
    /// Pearson's correlation of the band-limited waveforms after aligning the delay.
    pub waveform_correlation: f64,
    /// The unit of the PSDs.
    pub psd_unit: String,
    /// The lines of the spectra, Hz.
    #[serde(skip)]
    pub frequency_hz: Vec<f64>,
    /// The PSD of the texture, unit²/Hz.
    #[serde(skip)]
    pub target_psd: Vec<f64>,
    /// The PSD of the response, matched in level to the texture, unit²/Hz.
    #[serde(skip)]
    pub answer_psd: Vec<f64>,
}

/// What the texture itself as a drive would give, or why that is not computed.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(untagged)]
pub enum UncompensatedOutcome {
    /// What it would give.
    Predicted(UncompensatedPrediction),
    /// It cannot be computed.
    NotComputed {
        /// Why not.
        not_computed: String,
    },
}

impl From<Result<UncompensatedPrediction, VerifyError>> for UncompensatedOutcome {
    fn from(predicted: Result<UncompensatedPrediction, VerifyError>) -> Self {
        match predicted {
            Ok(predicted) => Self::Predicted(predicted),
            Err(error) => Self::NotComputed {
                not_computed: error.to_string(),
            },
        }
    }
}

impl UncompensatedPrediction {
    /// The judged band as text: the part of the judged band of `verification` that the transfer function covers.
    #[must_use]
    pub fn judged_band(&self, verification: &Verification) -> String {
        if self.band_hz == verification.band_hz {
            verification.judged_band()
        } else {
            format!("{} within {}", verification.judged_band(), self.band_hz)
        }
    }
}

/// The response to `target` itself as the drive, compared with `target` as in [`verify`] and matched in
/// level, since the units of texture and drive have no common scale. The judged lines are those of [`verify`]: the
/// achievable ones when they are stated.
///
/// Formula: `irfft(H · rfft(target))` with zero padding as long as the impulse response, H interpolated linearly.
///
/// Source: the thesis' figures 41 and 42.
///
/// # Errors
/// [`VerifyError::OutOfReach`] when the transfer function says nothing in the band; those of [`verify`].
pub fn predict_uncompensated<Q: Quantity>(
    target: &Series<Q>,
    function: &TransferFunction<Drive, Q>,
    config: &VerifyConfig,
) -> Result<UncompensatedPrediction, VerifyError> {
    let whole = Band::new(Hertz(0.0), Hertz(function.highest_hz()))?;
    let band = function
        .excited
        .and_then(|excited| excited.common(whole))
        .unwrap_or(whole)
        .common(config.band)
        .ok_or(VerifyError::OutOfReach { band: config.band })?;
    let config = VerifyConfig {
        band,
        level: Decibels(0.0),
        ..config.clone()
    };
    let response = Series::<Q>::new(answer(target, function), target.rate())?;
    let compared = verify(target, Measured::alone(&response), &config)?;
    let lines = || {
        let judged = |hz: f64| config.reached.iter().any(|band| band.contains(hz));
        let (known, all) = (compared.error_db_rms_achievable.is_some(), &compared);
        let pairs = all.error_frequency_hz.iter().zip(&all.error_db);
        pairs
            .filter(move |(hz, _)| !known || judged(**hz))
            .map(|(_, error_db)| *error_db)
    };
    let level_difference_db = lines().sum::<f64>() / lines().count() as f64;
    let matched = 10f64.powf(-level_difference_db / 10.0);
    Ok(UncompensatedPrediction {
        band_hz: band,
        error_db_rms_level_matched: rms_of(lines().map(|error| error - level_difference_db)),
        level_difference_db,
        waveform_correlation: compared.waveform_correlation,
        psd_unit: compared.psd_unit,
        frequency_hz: compared.frequency_hz,
        target_psd: compared.target_psd,
        answer_psd: compared.measured_psd.iter().map(|p| p * matched).collect(),
    })
}

/// The response to `drive` in samples of `Q` per unit of drive; it begins one length of the impulse response before the drive
/// and ends one after it.
fn answer<Q: Quantity>(drive: &Series<Q>, function: &TransferFunction<Drive, Q>) -> Vec<f64> {
    let (samples, rate_hz) = (drive.samples(), drive.rate().hz());
    let memory = (rate_hz / function.resolution_hz()).ceil() as usize;
    let length = samples.len() + 2 * memory;
    let mut padded = vec![0.0; fast_length(length)];
    let mean = mean(samples);
    for (place, sample) in padded[memory..].iter_mut().zip(samples) {
        *place = sample - mean;
    }
    let mut transform = RealTransform::new(padded.len());
    let mut bins = transform.forward(&padded);
    for (k, bin) in bins.iter_mut().enumerate() {
        let frequency_hz = k as f64 * rate_hz / padded.len() as f64;
        *bin *= if frequency_hz <= function.highest_hz() {
            function.at(frequency_hz)
        } else {
            Complex::default()
        };
    }
    let mut response = transform.inverse(bins);
    response.truncate(length);
    response
}
