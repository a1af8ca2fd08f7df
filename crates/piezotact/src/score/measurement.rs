//! A measurement held against its target, with what both files say.

use super::with_perceptible_difference;
use crate::clipping::{ClippingWarning, clipping};
use crate::quantity::{Acceleration, Band, Decibels, Drive};
use crate::recording::Recording;
use crate::render::Rendering;
use crate::resample::{CommonRate, ResampleError, to_common_rate};
use crate::series::Series;
use crate::verify::{Measured, Verification, VerifyConfig, VerifyError, VerifyWarning, verify};
use crate::warning::{Warning, Warnings};

/// The texture that was to be felt.
#[derive(Clone, Copy, Debug)]
pub struct Target<'a> {
    /// The name of its file.
    pub name: &'a str,
    pub recording: &'a Recording,
    /// The texture, m/s².
    pub texture: &'a Series<Acceleration>,
}

/// What was measured while a drive was played.
#[derive(Clone, Debug)]
pub struct Measurement<'a> {
    pub recording: &'a Recording,
    /// The acceleration, m/s².
    pub response: Series<Acceleration>,
    /// The drive that was recorded beside it, and the level at which the device clips, of full scale; absent where none was.
    pub drive: Option<(&'a Series<Drive>, f64)>,
    /// How the drive was made; absent where nothing says it.
    pub rendering: Option<&'a Rendering>,
}

/// A measurement with how close it came.
#[derive(Clone, Debug)]
pub struct JudgedMeasurement {
    /// What was found, with the felt difference and the warnings about both files.
    pub verification: Verification,
    /// How it was compared.
    pub config: VerifyConfig,
    /// The target at the rate of the comparison, m/s².
    pub texture: Series<Acceleration>,
}

/// A measurement that cannot be compared.
#[derive(Debug, thiserror::Error)]
pub enum MeasurementError {
    /// It cannot be brought to a common rate with its target.
    #[error("{0}")]
    Rate(#[from] ResampleError),
    /// It cannot be compared.
    #[error("{0}")]
    Verify(#[from] VerifyError),
}

/// How close `measured` came to `target` over `band`, with the warnings about both and `more_warnings`, each once.
///
/// Formula: that of [`verify`] and [`with_perceptible_difference`], at the lower rate of the two, for the bands and the level that its
/// rendering states.
///
/// Source: as [`verify`].
///
/// # Errors
/// [`MeasurementError`] for rates without a common one, and for what [`verify`] refuses.
pub fn judged_measurement(
    target: Target<'_>,
    measured: Measurement<'_>,
    band: Band,
    more_warnings: &[Warning],
) -> Result<JudgedMeasurement, MeasurementError> {
    let mut warnings = warnings_before(target, &measured, more_warnings);
    // Clipping is looked for at the rate it was acquired with.
    let clipped = measured.rendering.map(|r| r.headroom.clipped_fraction);
    let clipping = clipping(&measured.response, measured.drive, clipped);
    let CommonRate {
        first: texture,
        second: response,
        warning,
    } = to_common_rate(
        ("the target", target.texture.clone()),
        ("the measurement", measured.response),
    )?;
    warnings.extend(warning);
    let mut config = VerifyConfig::over(band, texture.rate().hz());
    if let Some(rendering) = measured.rendering {
        config.reached.clone_from(&rendering.achievable_band_hz);
        config.level = Decibels(rendering.level_db);
        config = config.rendered_as(&rendering.config, rendering.mode());
    }
    let compared = Measured {
        response: &response,
        clipping,
    };
    let mut verification = with_perceptible_difference(verify(&texture, compared, &config)?);
    let known = [
        &measured.recording.about.warnings,
        &target.recording.about.warnings,
    ];
    verification = verification.with_known_losses(known[0], known[1]);
    // What clipped is said by the verification, with what was measured of it.
    warnings.retain(|warning| match warning.kind() {
        Some(ClippingWarning::Clipped { .. }) => {
            let of = |one: &Warning| (one.code.clone(), one.fields.get("signal").cloned());
            let same = |other: &Warning| of(other) == of(warning);
            !verification.warnings.iter().any(same)
        }
        of_the_drive => of_the_drive.is_none(),
    });
    warnings.retain(|warning| !verification.warnings.say(warning));
    verification.warnings.put_first(warnings);
    Ok(JudgedMeasurement {
        verification,
        config,
        texture,
    })
}

/// What gives a warning before anything is compared: of both recordings, of the rendering, and whether they belong together.
fn warnings_before(target: Target<'_>, measured: &Measurement<'_>, more: &[Warning]) -> Warnings {
    let mut warnings: Warnings = target.recording.about.warnings.iter().cloned().collect();
    warnings.extend(measured.recording.about.warnings.iter().cloned());
    warnings.extend(more.iter().cloned());
    let Some(rendering) = measured.rendering else {
        return warnings;
    };
    let condition = &measured.recording.about.condition;
    warnings.extend(rendering.about.condition.warnings_when_measured(condition));
    if !rendering.target.is_empty() && rendering.target != target.name {
        warnings.push(VerifyWarning::OtherTarget {
            rendered: rendering.target.clone(),
            compared: target.name.to_owned(),
        });
    }
    warnings.extend(rendering.about.warnings.iter().cloned());
    warnings
}
