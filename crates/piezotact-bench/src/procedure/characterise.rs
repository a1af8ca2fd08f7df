//! Characterisation of a device with a finger on it: plays a drive and estimates the transfer function.

use crate::DeviceError;
use piezotact::device::DriveSetup;
use piezotact::quantity::{Acceleration, Band, Decibels, Drive, Hertz, SampleRate};
use piezotact::recording::{Losses, Recording};
use piezotact::render::headroom;
use piezotact::spectrum::WelchConfig;
use piezotact::transfer::{
    Distortion, Estimator, Known, OneClock, SEGMENTS_OF_A_PERIOD, TransferFunction, best_linear,
    estimate_sweeps, estimate_without, pair_warnings, prepared,
};
use piezotact::{Series, Warning};

use super::run::excite_and_record;
use super::{ACCELERATION_CHANNEL, DRIVE_CHANNEL, RunKeeper};
use crate::error::ProcedureError;
use crate::excitation::{Excitation, ExcitationConfig, excitation};
use crate::gate::LOWEST_JUDGED;
use crate::plan::RunPlan;
use crate::traits::Bench;

/// A warning is raised for coherence below this in the excited band.
const LEAST_COHERENCE: f64 = 0.8;

/// The settings of a characterisation.
#[derive(Clone, Debug, PartialEq)]
pub struct CharacteriseConfig {
    /// The drive, with its peak re the limit of the device.
    pub excitation: ExcitationConfig,
    /// How the spectra are estimated.
    pub welch: WelchConfig,
    /// Which ratio estimates the transfer function.
    pub estimator: Estimator,
    pub run: RunPlan,
}

/// The result of a characterisation of a device with a finger on it.
#[derive(Clone, Debug)]
pub struct Characterisation {
    pub recording: Recording,
    /// From the digital drive to the nail's acceleration.
    pub function: TransferFunction<Drive, Acceleration>,
    /// Noise and distortion, separated; only for multisines.
    pub distortion: Option<Distortion>,
}

/// The duration of a segment that is usual: 2048 samples at 5 kHz, lines 2.44 Hz apart.
const USUAL_SEGMENT_S: f64 = 0.4096;

/// The usual samples of a segment at `rate`: 0.41 s, an even number without prime factors above 5, which transforms quickly.
#[must_use]
pub fn usual_segment(rate: SampleRate) -> usize {
    let least = (USUAL_SEGMENT_S * rate.hz()).round().max(2.0) as usize;
    let quick = |count: &usize| {
        let mut left = *count;
        for prime in [2_usize, 3, 5] {
            while left.is_multiple_of(prime) {
                left /= prime;
            }
        }
        count.is_multiple_of(2) && left == 1
    };
    (least..2 * least).find(quick).unwrap_or(least)
}

/// The drive that characterises the device on `bench`, and the set-up it goes through, where one is described.
///
/// # Errors
/// Those of [`excitation`]; [`DeviceError::Impossible`] when the band reaches beyond half the rate of
/// the acquisition, the recording would hold no segment, or the band no line of its spectrum.
pub fn excite(
    bench: &mut Bench,
    config: &CharacteriseConfig,
) -> Result<(Series<Drive>, Option<DriveSetup>), ProcedureError> {
    let setup = bench.player.calibrate()?;
    let acquisition = bench.acquirer.describe().rate;
    let wrong = |expected: String, found: String, todo: &str| {
        ProcedureError::Device(DeviceError::Impossible {
            expected,
            found,
            todo: todo.into(),
        })
    };
    if config.excitation.band.high().0 >= acquisition.nyquist().0 {
        return Err(wrong(
            format!("a band below half of the acquisition's {acquisition}"),
            config.excitation.band.to_string(),
            "lower its end",
        ));
    }
    // Checked as requested, then scaled to the limit of the device.
    let drive = excitation(&config.excitation, bench.player.describe().rate)?;
    let blocks = config.excitation.blocks(acquisition)?;
    let holds = match blocks {
        None => acquisition.samples_in(config.excitation.duration),
        Some(blocks) if blocks.in_a_row == 1 => blocks.length,
        Some(blocks) => blocks.length / SEGMENTS_OF_A_PERIOD,
    };
    if config.welch.hop().is_err() || config.welch.segment > holds {
        return Err(wrong(
            format!("a segment from 2 to {holds} samples"),
            config.welch.segment.to_string(),
            &format!("{} is usual", usual_segment(acquisition)),
        ));
    }
    let spacing_hz = acquisition.hz() / config.welch.segment as f64;
    let band = config.excitation.band;
    let first_hz = (band.low().0 / spacing_hz).ceil().max(1.0) * spacing_hz;
    if first_hz > band.high().0 {
        return Err(wrong(
            format!(
                "a band that holds a line of the spectrum, {spacing_hz:.2} Hz apart with --segment {}",
                config.welch.segment
            ),
            band.to_string(),
            "give a longer --segment, or widen the band",
        ));
    }

    // Within the slew limit of the amplifier with the actuator: above it the signal would be distorted.
    let playable = setup.as_ref().map_or(1.0, |setup| {
        let asked = headroom(drive.samples(), drive.rate(), Some(setup));
        let followed = setup.slew_limit_v_per_s().zip(asked.slope_v_per_s);
        let followed = followed.map_or(1.0, |(limit, slope)| limit / slope);
        let carried = setup.rms_limit().map_or(1.0, |limit| limit / asked.rms);
        setup.drive_limit().min(followed).min(carried)
    });
    Ok((
        drive.amplified(Decibels::from_amplitude_ratio(playable)),
        setup,
    ))
}

/// Sends a drive to the device and estimates the transfer function from the drive to the nail's
/// acceleration, with the gain, the level and the condition that it holds for.
///
/// Source: thesis 2.5.3.
///
/// # Errors
/// Those of [`excite`], [`super::play_and_record`] and [`transfer_of`].
pub fn characterise(
    bench: &mut Bench,
    config: &CharacteriseConfig,
    keeper: &mut dyn RunKeeper,
) -> Result<Characterisation, ProcedureError> {
    let (drive, setup) = excite(bench, config)?;
    let excited = (&drive, Some(config.excitation.band));
    let recording = excite_and_record(bench, excited, setup.as_ref(), &config.run, keeper, None)?;
    let mut done = transfer_of(recording, setup.as_ref(), config)?;
    let low = low_coherence(&done.function, config);
    done.function.about.warnings.extend(low);
    Ok(done)
}

/// The warning about coherence that is low in the part of the excited band in which a device of this kind responds.
pub(super) fn low_coherence(
    function: &TransferFunction<Drive, Acceleration>,
    config: &CharacteriseConfig,
) -> Option<Warning> {
    function.low_coherence(judged_band(config)?, LEAST_COHERENCE)
}

/// The transfer function estimated from a recording of the drive, with the condition and device it is valid for.
///
/// # Errors
/// [`ProcedureError::Recording`] when it lacks a channel, [`ProcedureError::Transfer`] when nothing comes through.
pub fn transfer_of(
    recording: Recording,
    setup: Option<&DriveSetup>,
    config: &CharacteriseConfig,
) -> Result<Characterisation, ProcedureError> {
    let drive = recording.series::<Drive>(Some(DRIVE_CHANNEL))?;
    let response = recording.series::<Acceleration>(Some(ACCELERATION_CHANNEL))?;
    let CharacteriseConfig {
        excitation,
        welch,
        estimator,
        ..
    } = config;
    let OneClock {
        response,
        missing_s: lost,
        warnings: clocks,
        change,
    } = prepared(
        &drive,
        response,
        welch,
        recording.about.provenance.losses.stretches_s.clone(),
    );
    let known = Known {
        lost_s: &lost,
        // The onset and end of a drive have power outside its band, which does not count as excited.
        driven: Some(excitation.band),
    };
    let (mut function, distortion) = match excitation.blocks(recording.rate())? {
        None => (
            estimate_without(&drive, &response, welch, *estimator, known)?,
            None,
        ),
        Some(blocks) if blocks.in_a_row == 1 => (
            estimate_sweeps(&drive, &response, blocks, welch.segment, *estimator, known)?,
            None,
        ),
        Some(blocks) => {
            let found = best_linear(&drive, &response, blocks, welch.segment, known)?;
            (found.function, Some(found.distortion))
        }
    };
    let broken = pair_warnings(&drive, &response);
    function.about.warnings.extend(broken);
    function.about.warnings.extend(clocks);
    function = function.with_change(change);
    // The drive is the signal that was sent. What a sweep distorts repeats with every sweep and is no scatter.
    function.known_input = config.excitation.kind != Excitation::Sweep;
    let estimated = std::mem::take(&mut function.about.provenance.steps);
    function.about.provenance = recording
        .about
        .provenance
        .clone()
        .then(excitation.text(drive.peak()));
    let began = recording.annotations.started_at.clone();
    function.about.provenance.measured_at = began;
    // The excited band is stated by the transfer function itself.
    function.about.provenance.excited_hz = None;
    // What was lost is left out of it.
    function.about.provenance.losses = Losses::default();
    function.about.provenance.steps.extend(estimated);
    function.about.condition = recording.about.condition.clone();
    function.drive = setup.cloned();
    function
        .about
        .warnings
        .extend(recording.about.warnings.clone());
    let judged = judged_band(config);
    function
        .about
        .warnings
        .extend(judged.and_then(|band| function.not_excited(band)));
    Ok(Characterisation {
        recording,
        function,
        distortion,
    })
}

/// The part of the excited band in which a device of this kind responds; `None` if the excited band lies below it.
pub(super) fn judged_band(config: &CharacteriseConfig) -> Option<Band> {
    Band::new(LOWEST_JUDGED, Hertz(f64::MAX))
        .ok()
        .and_then(|band| config.excitation.band.common(band))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn segments_are_as_long_at_every_rate() {
        for (hz, samples) in [
            (5_000.0, 2_048),
            (48_000.0, 20_000),
            (44_100.0, 18_432),
            (1.0, 2),
        ] {
            assert_eq!(usual_segment(SampleRate::new(hz).unwrap()), samples, "{hz}");
        }
    }
}
