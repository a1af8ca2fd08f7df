//! What was done on a bench, as it is handed out.

use std::path::{Path, PathBuf};

use piezotact::Warning;
use piezotact::device::DriveSetup;
use piezotact::document::Content;
use piezotact::quantity::{Band, SampleRate, Seconds, Unit};
use piezotact::recording::{Condition, Provenance, Recording};
use piezotact::render::{GainFit, Headroom, RenderedDrive, gains_for};
use piezotact::run::{Attempt, RunStart};
use piezotact::transfer::{Bias, Distortion, Limits};
use piezotact::verify::Verification;
use piezotact::warning::{Merged, merged};
use serde::Serialize;

use crate::procedure::{
    ClosedLoopResult, Gain, LoopEnd, Refused, RepeatedCharacterisation, SelectedDrive,
};

/// A measurement that the gate refused.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct RefusedAttempt {
    /// Which repeat, from 1.
    pub repeat: usize,
    /// Which attempt at it, from 1.
    pub attempt: usize,
    /// Why.
    pub reason: String,
}

impl From<&Refused> for RefusedAttempt {
    fn from(refused: &Refused) -> Self {
        Self {
            repeat: refused.repeat,
            attempt: refused.attempt,
            reason: refused.refusal.to_string(),
        }
    }
}

/// The transfer function of a device with a finger on it.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct CharacteriseDocument<'a> {
    /// The file that holds it.
    pub out: &'a Path,
    /// What the confidence limits hold.
    pub limits: Limits,
    /// How far H2 lies above H1 from 20 Hz on; absent where no line lies there.
    pub bias: Option<Bias>,
    /// How many segments were averaged.
    pub averages: usize,
    /// As many independent ones scatter as much.
    pub effective_averages: f64,
    /// The distance of two lines, Hz.
    pub resolution_hz: f64,
    /// The band of the excitation.
    pub band_hz: Band,
    /// From the lowest to the highest line that was excited; absent when not known.
    pub excited_hz: Option<Band>,
    /// How often it was measured.
    pub repeats: usize,
    /// How far the two repeats that differ most lie apart, dB rms; absent for one.
    pub repeats_apart_db_rms: Option<f64>,
    /// What was refused.
    pub refused: Vec<RefusedAttempt>,
    /// Every attempt with what was judged of it.
    pub attempts: &'a [Attempt],
    /// Noise and distortion; absent where the excitation cannot separate them.
    pub distortion: Option<&'a Distortion>,
    /// The device.
    pub drive_setup: Option<&'a DriveSetup>,
    /// Who touched how.
    pub condition: &'a Condition,
    /// Where it comes from.
    pub provenance: &'a Provenance,
    /// What limits it.
    pub warnings: Vec<Merged>,
}

impl Content for CharacteriseDocument<'_> {
    const SCHEMA: &'static str = "characterise";
}

impl<'a> CharacteriseDocument<'a> {
    /// What was `measured` over `band_hz`, with the `distortion` of all repeats, kept in the file `out`.
    #[must_use]
    pub fn of(
        measured: &'a RepeatedCharacterisation,
        (band_hz, distortion): (Band, Option<&'a Distortion>),
        out: &'a Path,
    ) -> Self {
        let function = &measured.function;
        Self {
            out,
            limits: function.limits(),
            bias: function.bias(function.tactile_band()),
            averages: function.averages,
            effective_averages: function.effective_averages,
            resolution_hz: function.resolution_hz(),
            band_hz,
            excited_hz: function.excited,
            repeats: measured.each.len(),
            repeats_apart_db_rms: measured.apart_db,
            refused: measured.refused.iter().map(RefusedAttempt::from).collect(),
            attempts: &measured.attempts,
            distortion,
            drive_setup: function.drive.as_ref(),
            condition: &function.about.condition,
            provenance: &function.about.provenance,
            warnings: merged(&function.about.warnings),
        }
    }
}

/// A drive that was played and the response that was recorded.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct PlayDocument<'a> {
    /// The file that holds the recording.
    pub record: &'a Path,
    /// Its rate, Hz.
    pub rate_hz: SampleRate,
    /// How long it is, s.
    pub duration_s: Seconds,
    /// Where it comes from.
    pub provenance: &'a Provenance,
    /// What limits it.
    pub warnings: Vec<Merged>,
}

impl Content for PlayDocument<'_> {
    const SCHEMA: &'static str = "play";
}

impl<'a> PlayDocument<'a> {
    /// The recording kept in the file `record`.
    #[must_use]
    pub fn of(recording: &'a Recording, record: &'a Path) -> Self {
        Self {
            record,
            rate_hz: recording.rate(),
            duration_s: recording.duration(),
            provenance: &recording.about.provenance,
            warnings: merged(&recording.about.warnings),
        }
    }
}

/// What sensors acquired while a person touched something.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct RecordDocument<'a> {
    /// The file that holds the recording.
    pub record: &'a Path,
    /// Its rate, Hz.
    pub rate_hz: SampleRate,
    /// How long it is, s.
    pub duration_s: Seconds,
    /// Names and units of its channels.
    pub channels: &'a [(String, Unit)],
    /// Who touched what, and how.
    pub condition: &'a Condition,
    /// Where it comes from.
    pub provenance: &'a Provenance,
    /// What limits it.
    pub warnings: Vec<Merged>,
}

impl Content for RecordDocument<'_> {
    const SCHEMA: &'static str = "record";
}

impl<'a> RecordDocument<'a> {
    /// A run of `samples` samples with `warnings` that began with `start`, kept in the file `record`.
    #[must_use]
    pub fn of(start: &'a RunStart, samples: usize, record: &'a Path, warnings: &[Warning]) -> Self {
        Self {
            record,
            rate_hz: start.rate_hz,
            duration_s: start.rate_hz.duration_of(samples),
            channels: &start.channels,
            condition: &start.about.condition,
            provenance: &start.about.provenance,
            warnings: merged(warnings),
        }
    }
}

/// How close a drive of a closed loop came to the texture.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct LoopCloseness {
    /// The error of the spectrum over the band, dB rms.
    pub error_db_rms: f64,
    /// The same over what the inverse reaches; absent where it reaches nothing.
    pub error_db_rms_achievable: Option<f64>,
    /// The largest error of a line, dB.
    pub error_db_max: f64,
    /// The same over what the inverse reaches.
    pub error_db_max_achievable: f64,
    /// The error of the level, dB.
    pub level_error_db: f64,
    /// The correlation of the waveforms, −1 to 1.
    pub waveform_correlation: f64,
    /// The power of the difference of the waveforms re that of the texture, dB.
    pub waveform_nmse_db: f64,
}

impl From<&Verification> for LoopCloseness {
    fn from(v: &Verification) -> Self {
        Self {
            error_db_rms: v.error_db_rms,
            error_db_rms_achievable: v.error_db_rms_achievable,
            error_db_max: v.error_db_max,
            error_db_max_achievable: v.error_db_max_achievable(),
            level_error_db: v.level_error_db,
            waveform_correlation: v.waveform_correlation,
            waveform_nmse_db: v.waveform_nmse_db,
        }
    }
}

/// One drive of a closed loop.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct LoopIteration {
    /// Its number, 0 for the open loop.
    pub iteration: usize,
    /// The share of its samples that stood at the limit of the device, 0–1.
    pub held_at_limit: f64,
    /// How close it came.
    #[serde(flatten)]
    pub closeness: LoopCloseness,
}

/// A closed loop.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct LoopDocument {
    /// The number of the drive that is kept.
    pub best: usize,
    /// Why that one.
    pub kept: SelectedDrive,
    /// The best corrected drive against the open loop; absent where none was judged better.
    pub gain: Option<Gain>,
    /// Why it ended.
    pub end: LoopEnd,
    /// The same in words.
    pub ended: String,
    /// Every drive that was judged.
    pub iterations: Vec<LoopIteration>,
    /// What was found when the kept drive was measured once more; absent where that could not be believed.
    pub confirmed: Option<LoopCloseness>,
    /// What the bench said when it failed; absent where it did not.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub failed: Option<String>,
}

impl From<&ClosedLoopResult> for LoopDocument {
    fn from(looped: &ClosedLoopResult) -> Self {
        let iterations = looped.iterations.iter().map(|i| LoopIteration {
            iteration: i.number,
            held_at_limit: i.held,
            closeness: LoopCloseness::from(&i.verification),
        });
        Self {
            best: looped.best,
            kept: looped.kept,
            gain: looped.gain.clone(),
            end: looped.end.clone(),
            ended: looped.end.to_string(),
            iterations: iterations.collect(),
            confirmed: looped.confirmed.as_ref().map(LoopCloseness::from),
            failed: looped.failed.clone(),
        }
    }
}

/// A texture that was rendered.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct RenderDocument {
    /// What it is called beside others.
    pub called: String,
    /// The file of the texture.
    pub target: PathBuf,
    /// The file of the transfer function.
    pub transfer: PathBuf,
    /// The file that holds the drive.
    pub out: PathBuf,
    /// The rate of the drive, Hz.
    pub rate_hz: u32,
    /// The level it was rendered at, relative to the texture, dB.
    pub level_db: f64,
    /// How much of the device it uses.
    pub headroom: Headroom,
    /// The parts of the band that the inverse reaches, Hz.
    pub achievable_band_hz: Vec<Band>,
    /// The parts it gives up, Hz.
    pub given_up_band_hz: Vec<Band>,
    /// The device it is for.
    pub drive_setup: Option<DriveSetup>,
    /// What it would need, and have, at every gain; absent where the device is not known.
    pub gains: Option<Vec<GainFit>>,
    /// What the closed loop found; absent for an open loop.
    #[serde(rename = "loop")]
    pub looped: Option<LoopDocument>,
    /// Whose finger it is for.
    pub condition: Condition,
    /// What limits it.
    pub warnings: Vec<Merged>,
}

impl Content for RenderDocument {
    const SCHEMA: &'static str = "render";
}

/// The names of a rendering: of the texture, of the transfer function, of the drive.
#[derive(Clone, Copy, Debug)]
pub struct RenderNames<'a> {
    /// What it is called beside others.
    pub called: &'a str,
    /// The file of the texture.
    pub target: &'a Path,
    /// The file of the transfer function.
    pub transfer: &'a Path,
    /// The file of the drive.
    pub out: &'a Path,
}

impl RenderDocument {
    /// `drive`, rendered at `level_db` dB relative to the texture and kept at `rate_hz`, with its closed loop where there was one.
    #[must_use]
    pub fn of(
        names: RenderNames<'_>,
        drive: &RenderedDrive,
        (rate_hz, level_db): (u32, f64),
        looped: Option<&ClosedLoopResult>,
    ) -> Self {
        let setup = drive.setup.as_ref();
        Self {
            called: names.called.to_owned(),
            target: names.target.to_owned(),
            transfer: names.transfer.to_owned(),
            out: names.out.to_owned(),
            rate_hz,
            level_db,
            headroom: drive.headroom.clone(),
            achievable_band_hz: drive.coverage.reached.clone(),
            given_up_band_hz: drive.coverage.given_up.clone(),
            drive_setup: drive.setup.clone(),
            gains: setup.map(|setup| gains_for(&drive.headroom, setup)),
            looped: looped.map(LoopDocument::from),
            condition: drive.about.condition.clone(),
            warnings: merged(&drive.about.warnings),
        }
    }
}

/// A texture that could not be rendered.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct RefusedRendering {
    /// What it is called.
    pub called: String,
    /// The file of the texture.
    pub target: PathBuf,
    /// The file of the transfer function.
    pub transfer: PathBuf,
    /// Why.
    pub why: String,
}

/// Several textures or fingers in one go.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct RenderBatchDocument {
    /// What was rendered.
    pub renderings: Vec<RenderDocument>,
    /// What could not be.
    pub refused: Vec<RefusedRendering>,
}

impl Content for RenderBatchDocument {
    const SCHEMA: &'static str = "render_batch";
}
