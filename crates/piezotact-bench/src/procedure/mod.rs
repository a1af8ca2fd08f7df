//! Procedures that run on any bench: play a drive and record the response, characterise a device, closed loops.

mod characterise;
mod closed_loop;
mod keeper;
mod repeats;
mod run;

pub use characterise::{
    Characterisation, CharacteriseConfig, LOWEST_JUDGED, characterise, excite, transfer_of,
    usual_segment,
};
pub use closed_loop::{
    Gain, GainCriterion, Iteration, Kept, LoopConfig, LoopEnd, LoopErrors, Looped, Mishap,
    closed_loop,
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
/// [`ProcedureError::Gain`], [`ProcedureError::Described`], [`ProcedureError::OutputLevel`], [`DeviceError::Rate`], [`ProcedureError::Impossible`].
pub fn require_device(
    bench: &mut Bench,
    drive: &Series<Drive>,
    rendered_for: Option<&DriveSetup>,
) -> Result<(), ProcedureError> {
    let PlayDescription {
        name, rate, gain, ..
    } = bench.player.describe();
    if drive.rate() != rate {
        return Err(DeviceError::Rate {
            drive: drive.rate(),
            output: rate,
            name,
        }
        .into());
    }
    if drive.peak() > 1.0 {
        return Err(ProcedureError::Impossible {
            expected: "a drive within ±1 (full scale)".into(),
            found: format!("a peak of {:.3}", drive.peak()),
            todo: "render it again at a lower level".into(),
        });
    }
    let Some(setup) = rendered_for else {
        return Ok(());
    };
    let (Some(gain), Some(found)) = (gain, bench.player.calibrate()?) else {
        return Err(ProcedureError::Impossible {
            expected: format!(
                "a drive for a device without a description, like that of the {name}"
            ),
            found: format!("one for gain {}", setup.gain),
            todo: "render it with the transfer function that this bench uses, and leave --gain out"
                .into(),
        });
    };
    if setup.device().name() == found.device().name() && setup.gain.name != gain {
        return Err(ProcedureError::Gain {
            drive: setup.gain.name.clone(),
            bench: gain,
            name,
        });
    }
    if !setup.amplifies_like(&found) {
        return Err(ProcedureError::Described {
            drive: setup.amplification(),
            bench: found.amplification(),
            name,
        });
    }
    let found = found.volts_per_full_scale;
    if (found / setup.volts_per_full_scale - 1.0).abs() > OUTPUT_TOLERANCE {
        return Err(ProcedureError::OutputLevel {
            drive: setup.volts_per_full_scale,
            bench: found,
            name,
        });
    }
    Ok(())
}
