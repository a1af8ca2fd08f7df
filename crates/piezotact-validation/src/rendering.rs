//! Render, play, verify: the device as the thesis uses it.

use piezotact::feature::vibrations;
use piezotact::filter::HighPass;
use piezotact::quantity::{Acceleration, Band, Decibels, Drive, Hertz, SampleRate};
use piezotact::recording::Recording;
use piezotact::render::{
    RenderConfig, RenderError, RenderedDrive, at_fitting_level, render, uncompensated,
};
use piezotact::run::Discard;
use piezotact::series::Series;
use piezotact::transfer::TransferFunction;
use piezotact::verify::{Measured, Verification, VerifyConfig, verify};

use super::ReplayError;
use piezotact_bench::procedure::{ACCELERATION_CHANNEL, play_and_record};
use piezotact_bench::{Bench, RunPlan};
use piezotact_volunteers::Taken;

/// The rate of the drive, Hz.
const DRIVE_RATE_HZ: f64 = 48_000.0;

/// A texture as it is rendered: the first stroke of a recording, freed of the gesture.
pub(super) fn target(
    taken: &Taken,
    recording: &Recording,
) -> Result<Series<Acceleration>, ReplayError> {
    let what = recording.about.condition.to_string();
    let freed = vibrations(recording, &taken.segmentation, Some(HighPass::gesture()));
    let freed = freed.map_err(|error| format!("{what}: {error}"))?;
    let stroke = taken.segmentation.strokes.first();
    let samples = match (stroke, freed.channels.first()) {
        (Some(stroke), Some(channel)) => stroke.steady.of(channel).to_vec(),
        _ => Vec::new(),
    };
    Ok(Series::new(samples, recording.rate())?)
}

/// The drive for `target`, as loud as fits the device, and the level that takes.
pub(super) fn rendered(
    target: &Series<Acceleration>,
    function: &TransferFunction<Drive, Acceleration>,
) -> Result<(RenderedDrive, Decibels), ReplayError> {
    let band = Band::new(Hertz(20.0), Hertz(1000.0))?;
    let config = RenderConfig::over(band, SampleRate::new(DRIVE_RATE_HZ)?);
    let (level, drive) = at_fitting_level(
        |level| render(&target.clone().amplified(level), function, &config),
        RenderError::fits_at,
    );
    Ok((drive?, level))
}

/// Plays a drive and records what the finger does.
pub(super) fn played(
    bench: &mut Bench,
    drive: &Series<Drive>,
    run: &RunPlan,
) -> Result<Recording, ReplayError> {
    Ok(play_and_record(
        bench,
        drive,
        None,
        run,
        &mut Discard,
        None,
    )?)
}

/// A texture sent directly as the drive, 1 m/s² as full scale.
pub(super) struct SentStraight {
    pub(super) drive: Series<Drive>,
    /// Turned down until nothing clips, to 1 dB below the first limit.
    pub(super) softer: Series<Drive>,
    /// By how much, dB; 0 where it fits as it stands.
    pub(super) level: Decibels,
    /// Whether it exceeds a limit as it stands.
    pub(super) clips: bool,
}

/// The samples of `target` as the drive.
pub(super) fn sent_uncompensated(
    bench: &mut Bench,
    target: &Series<Acceleration>,
) -> Result<SentStraight, ReplayError> {
    let limit = bench
        .player
        .calibrate()?
        .map_or(1.0, |setup| setup.drive_limit());
    let rate = bench.player.describe().rate;
    let room = Decibels::from_amplitude_ratio(limit / target.peak().max(f64::MIN_POSITIVE));
    // Turned down before it is a drive: as it stands it is cut off at the full scale of a file.
    let level = Decibels((room.0 - 1.0).min(0.0));
    Ok(SentStraight {
        drive: uncompensated(target, rate)?,
        softer: uncompensated(&target.clone().amplified(level), rate)?,
        level,
        clips: room.0 < 0.0,
    })
}

/// How close a measurement came to its target over 30–500 Hz.
pub(super) fn compared(
    target: &Series<Acceleration>,
    measured: &Recording,
    level: Decibels,
) -> Result<Verification, ReplayError> {
    let response = measured.series::<Acceleration>(Some(ACCELERATION_CHANNEL));
    let response = response.map_err(piezotact_bench::ProcedureError::from)?;
    let config = VerifyConfig {
        level,
        ..judged_as(target)?
    };
    Ok(verify(target, Measured::alone(&response), &config)?)
}

/// How a measurement is compared with `target`: over 30–500 Hz.
pub(super) fn judged_as(target: &Series<Acceleration>) -> Result<VerifyConfig, ReplayError> {
    let band = Band::new(Hertz(30.0), Hertz(500.0))?;
    Ok(VerifyConfig::over(band, target.rate().hz()))
}
