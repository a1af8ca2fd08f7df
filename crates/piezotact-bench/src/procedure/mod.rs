//! Procedures that run on any bench: play a drive and record the response, characterise a device, closed loops.

mod characterise;
mod closed_loop;
mod keeper;
mod repeats;
mod run;

pub use characterise::{
    Characterisation, CharacteriseConfig, characterise, excite, transfer_of, usual_segment,
};
pub use closed_loop::{
    ClosedLoopResult, Gain, GainCriterion, Iteration, LoopCloseness, LoopConfig, LoopEnd,
    LoopErrors, LoopFailure, SelectedDrive, closed_loop,
};
pub use keeper::RunKeeper;
pub use repeats::{GatePolicy, Refused, RepeatConfig, RepeatedCharacterisation, repeated};
pub use run::{acquire, play_and_record, record, start_document};

use piezotact::Series;
use piezotact::device::DriveSetup;
use piezotact::quantity::Drive;

use crate::error::{DeviceError, ProcedureError};
use crate::traits::{Bench, PlayDescription};

/// The drive as it was sent, looped back.
pub const DRIVE_CHANNEL: &str = "drive";
/// The acceleration of the fingernail.
pub const ACCELERATION_CHANNEL: &str = "acceleration";
/// The normal force of the finger, where it is measured.
pub const FORCE_CHANNEL: &str = "normal_force";
/// The tolerance of the voltage at full scale re the one for which a drive was made, as a share: 0.4 dB.
const OUTPUT_TOLERANCE: f64 = 0.05;

/// Refuses a drive that does not match the present state of the bench: another gain or other limits, another voltage
/// at full scale, another rate, a described device while that of the bench is not described, or samples beyond full scale.
///
/// # Errors
/// [`ProcedureError::Gain`], [`ProcedureError::Described`], [`ProcedureError::OutputLevel`], [`DeviceError::Rate`], [`DeviceError::Impossible`].
pub fn require_device(
    bench: &mut Bench,
    drive: &Series<Drive>,
    rendered_for: Option<&DriveSetup>,
) -> Result<(), ProcedureError> {
    let mut faults = signal_faults(bench, drive);
    if let Some(setup) = rendered_for {
        let found = bench.player.calibrate()?;
        faults.extend(device_faults(bench, setup, found.as_ref()));
    }
    faults.into_iter().next().map_or(Ok(()), Err)
}

/// Everything for which a drive that was prepared for this bench may not be played on it as it is now: the errors of
/// [`require_device`], and a drive that does not state the device it is for while that of the bench is described. Nothing is played.
///
/// # Errors
/// [`DeviceError`] when the output cannot be read.
pub fn faults_of_prepared(
    bench: &mut Bench,
    drive: &Series<Drive>,
    rendered_for: Option<&DriveSetup>,
) -> Result<Vec<ProcedureError>, DeviceError> {
    let found = bench.player.calibrate()?;
    let mut faults = signal_faults(bench, drive);
    match (rendered_for, &found) {
        (Some(setup), found) => faults.extend(device_faults(bench, setup, found.as_ref())),
        (None, Some(found)) => faults.push(ProcedureError::Device(DeviceError::Impossible {
            expected: format!(
                "a drive that states the device and the gain it was rendered for, as the {} is described ({})",
                bench.player.describe().name,
                found.amplification()
            ),
            found: "one that states none".into(),
            todo: "render it with a transfer function that was measured on this bench".into(),
        })),
        (None, None) => {}
    }
    Ok(faults)
}

/// Why the output does not take the samples of `drive`.
fn signal_faults(bench: &Bench, drive: &Series<Drive>) -> Vec<ProcedureError> {
    let PlayDescription { name, rate, .. } = bench.player.describe();
    let mut faults = Vec::new();
    if drive.rate() != rate {
        let error = DeviceError::Rate {
            drive: drive.rate(),
            output: rate,
            name,
        };
        faults.push(error.into());
    }
    if drive.peak() > 1.0 {
        faults.push(ProcedureError::Device(DeviceError::Impossible {
            expected: "a drive within ±1 (full scale)".into(),
            found: format!("a peak of {:.3}", drive.peak()),
            todo: "render it again at a lower level".into(),
        }));
    }
    faults
}

/// What differs between the device that a drive is for (`setup`) and that of the bench, as it was `found`.
fn device_faults(
    bench: &Bench,
    setup: &DriveSetup,
    found: Option<&DriveSetup>,
) -> Vec<ProcedureError> {
    let PlayDescription { name, gain, .. } = bench.player.describe();
    let (Some(gain), Some(found)) = (gain, found) else {
        return vec![ProcedureError::Device(DeviceError::Impossible {
            expected: format!(
                "a drive for a device without a description, like that of the {name}"
            ),
            found: format!("one for gain {}", setup.gain),
            todo: "render it with the transfer function that this bench uses, and leave --gain out"
                .into(),
        })];
    };
    let mut faults = Vec::new();
    if setup.device().name() == found.device().name() && setup.gain.name != gain {
        faults.push(ProcedureError::Gain {
            drive: setup.gain.name.clone(),
            bench: gain,
            name: name.clone(),
        });
    } else if !setup.amplifies_like(found) {
        faults.push(ProcedureError::Described {
            drive: setup.amplification(),
            bench: found.amplification(),
            name: name.clone(),
        });
    }
    let found = found.volts_per_full_scale;
    if (found / setup.volts_per_full_scale - 1.0).abs() > OUTPUT_TOLERANCE {
        faults.push(ProcedureError::OutputLevel {
            drive: setup.volts_per_full_scale,
            bench: found,
            name,
        });
    }
    faults
}
