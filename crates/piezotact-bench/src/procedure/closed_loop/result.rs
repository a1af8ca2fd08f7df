//! What a closed loop came to.

use piezotact::correct::{CorrectedRendering, LineChange};
use piezotact::recording::Recording;
use piezotact::render::RenderedDrive;
use piezotact::verify::Verification;
use serde::{Serialize, Serializer};

use super::{Gain, LoopEnd, LoopErrors, SelectedDrive};

/// One drive of the loop, judged by a measurement that was not used to compute it.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Iteration {
    /// Its number; 0 is the open loop.
    #[serde(rename = "iteration")]
    pub number: usize,
    /// The verification of this drive; documents have a few of its numbers.
    #[serde(flatten, serialize_with = "closeness")]
    #[cfg_attr(feature = "schemas", schemars(with = "LoopCloseness"))]
    pub verification: Verification,
    /// The objective that the loop minimises, dB: for a texture the rms error of the spectrum over the bands that the inverse
    /// reaches, for a waveform the power of its difference re that of the target (NMSE).
    #[serde(skip)]
    pub aim_db: f64,
    /// The errors of its two measurements; the drive is judged by the second.
    #[serde(skip)]
    pub measured: [LoopErrors; 2],
    /// The share of its samples clipped at the device's limit, 0–1.
    #[serde(rename = "held_at_limit")]
    pub held: f64,
    /// The change made by the following correction step; none after the last.
    #[serde(skip)]
    pub step: Option<LineChange>,
}

impl ClosedLoopResult {
    /// The verification of the drive that was kept: from the confirmation measurement, or from the loop if that failed.
    #[must_use]
    pub fn best_verification(&self) -> &Verification {
        let judged = &self.iterations[self.best].verification;
        self.confirmed.as_ref().unwrap_or(judged)
    }

    /// What it came to, called `called`, for a texture rendered at `level_db` dB as `drive`.
    #[must_use]
    pub fn summary<'a>(
        &'a self,
        called: &'a str,
        level_db: f64,
        drive: &'a RenderedDrive,
    ) -> CorrectedRendering<'a> {
        CorrectedRendering {
            called,
            level_db,
            drive,
            open: &self.iterations[0].verification,
            closed: self.best_verification(),
            is_confirmed: self.confirmed.is_some(),
            is_close: self.is_close(),
            is_open_kept: self.kept.keeps_open_loop(),
            kept: self.kept.to_string(),
            got_worse: self.got_worse(),
            gain_db: self.gain.as_ref().and_then(|gain| {
                let [aim, _] = &gain.criteria;
                aim.found.zip(aim.interval)
            }),
            best: self.best,
            held: self.iterations[self.best].held,
            ended: match self.end {
                LoopEnd::Done => "number reached",
                LoopEnd::NoBetter => "no improvement",
                LoopEnd::Worse => "worse",
                LoopEnd::Broken(_) => "invalid measurement",
            },
            bench: self.recording.about.provenance.bench,
        }
    }
}

/// A texture rendered in a closed loop.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct ClosedLoopResult {
    /// All drives that were judged.
    pub iterations: Vec<Iteration>,
    /// The number of the drive that is kept.
    pub best: usize,
    /// Why this drive was kept.
    pub kept: SelectedDrive,
    /// The comparison of the best corrected drive with the open loop; absent if none was judged better than the open loop.
    pub gain: Option<Gain>,
    /// Why the loop ended.
    pub end: LoopEnd,
    /// The same in words.
    pub ended: String,
    /// The message of the bench if it failed before the end of the loop; the drive that is kept then follows from the
    /// measurements made until then.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub failed: Option<String>,
    /// The drive that is kept.
    #[serde(skip)]
    pub rendered: RenderedDrive,
    /// The verification from the confirmation measurement of the drive that is kept, which was not used to choose it; none if
    /// that measurement was not reliable.
    #[serde(serialize_with = "closeness_of_confirmed")]
    #[cfg_attr(feature = "schemas", schemars(with = "Option<LoopCloseness>"))]
    pub confirmed: Option<Verification>,
    /// The recording of the confirmation measurement, or otherwise of the measurement by which the drive was judged.
    #[serde(skip)]
    pub recording: Recording,
}

/// How close a drive of a closed loop came to the texture: the numbers of its verification that documents have.
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

fn closeness<S: Serializer>(verification: &Verification, to: S) -> Result<S::Ok, S::Error> {
    LoopCloseness::from(verification).serialize(to)
}

fn closeness_of_confirmed<S: Serializer>(
    confirmed: &Option<Verification>,
    to: S,
) -> Result<S::Ok, S::Error> {
    confirmed.as_ref().map(LoopCloseness::from).serialize(to)
}
