//! Warnings about sound devices.

use crate::number::{counted, digits, digits_signed, rounded};
use serde::{Deserialize, Serialize};

/// Warnings about sound devices: their calibration, their timing, and what they cannot record.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "code", rename_all = "snake_case")]
pub enum SoundWarning {
    /// The calibration is old, or of a day to come.
    #[error("{}", calibration_age(what, made_on, *days, *most_days))]
    #[serde(rename = "sound_calibration_old")]
    CalibrationOld {
        what: String,
        made_on: String,
        days: f64,
        most_days: f64,
    },
    /// The device was not calibrated: levels are relative to full scale.
    #[error(
        "{what} was not calibrated: its levels are relative to full scale; check its unit and scale"
    )]
    #[serde(rename = "sound_not_calibrated")]
    NotCalibrated { what: String },
    /// No channel records what is played: timing and level are not checked.
    #[error(
        "no input records what is played: delay, level, lost samples and silent parts of the playback are not checked"
    )]
    #[serde(rename = "sound_no_loopback")]
    NoLoopback,
    /// A sound input does not pass 0 Hz: a steady force is not recorded.
    #[error(
        "`{channel}` is recorded by a sound input, which does not pass 0 Hz: a steady force is not in it; measure the force together with the \
            acceleration"
    )]
    #[serde(rename = "sound_input_ac_coupled")]
    AcCoupled { channel: String },
    /// The input reached its full scale.
    #[error("the input of `{channel}` reached its full scale in {}: record again", counted(*samples as usize, "sample"))]
    #[serde(rename = "sound_input_clipped")]
    InputClipped { channel: String, samples: u64 },
    /// The drive exceeded full scale and was limited.
    #[error("the drive exceeded full scale in {}, which were limited: lower the level", counted(*samples as usize, "sample"))]
    #[serde(rename = "sound_drive_limited")]
    DriveLimited { samples: u64 },
    /// The engine left parts of the signal silent.
    #[error(
        "the loopback holds {} of silence, {samples} samples in all, where the drive has none: close other programs; play again",
        counted(*parts, "part")
    )]
    #[serde(rename = "sound_silent_parts")]
    SilentParts { parts: usize, samples: usize },
    /// Callbacks of the sound system came late.
    #[error(
        "the sound system paused {}, at the longest for {} ms: close other programs; play again",
        counted(*times, "time"),
        digits(1e3 * longest_s)
    )]
    #[serde(rename = "sound_stalled")]
    Stalled { times: usize, longest_s: f64 },
    /// Few restarts.
    #[error("{}: percentiles of the latency need at least {few} restarts", counted(*restarts, "restart"))]
    #[serde(rename = "sound_few_restarts")]
    FewRestarts { restarts: usize, few: usize },
    /// Restarts without a latency, or with samples lost.
    #[error("of {}, {silent} had no signal in the loopback and {dropped} lost samples: close other programs", counted(*restarts, "restart"))]
    #[serde(rename = "sound_restarts_failed")]
    RestartsFailed {
        silent: usize,
        dropped: usize,
        restarts: usize,
    },
    /// The clocks of output and input differ.
    #[error(
        "the clock of the input runs {} ppm {} than that of the output (±{} ppm, 95 %): what was recorded shares one clock, and verifications are \
            corrected for it; every other comparison with the drive that was played is off by more and more; align the channels",
        digits(ppm.abs()),
        if *ppm >= 0.0 { "faster" } else { "slower" },
        digits(*uncertainty_ppm)
    )]
    #[serde(rename = "sound_clocks_apart")]
    ClocksApart { ppm: f64, uncertainty_ppm: f64 },
    /// The latency is not what it was when it was measured.
    #[error(
        "the latency is {} ms now and was {} ms when it was measured on {measured_on}: cables, buffers or driver changed; it is left out; measure \
            again",
        digits(1e3 * found_s),
        digits(1e3 * stored_s)
    )]
    #[serde(rename = "sound_latency_changed")]
    LatencyChanged {
        measured_on: String,
        stored_s: f64,
        found_s: f64,
    },
    /// Two ways of finding a level lead to different values.
    #[error(
        "{what}: {found_by} gives {} dB re {other_by}; one of them is wrong: check readings, units and set-up; check its unit and scale",
        digits_signed(*by_db)
    )]
    #[serde(rename = "sound_ways_disagree")]
    WaysDisagree {
        what: String,
        found_by: String,
        other_by: String,
        by_db: f64,
    },
    /// The pulse of an output arrived on no input alone.
    #[error("{what}")]
    #[serde(rename = "sound_wire_not_found")]
    WireNotFound { what: String },
    /// The delay of the loopback stepped, and no loss was reported.
    #[error(
        "at {at_s:.2} s the delay from output to input stepped by {} ms: samples were lost or repeated, and the sound system did not report it; \
            close other programs; record again",
        digits_signed(1e3 * by_s)
    )]
    #[serde(rename = "sound_delay_stepped")]
    DelayStepped { at_s: f64, by_s: f64 },
}

/// How old a calibration is, and what to do.
fn calibration_age(what: &str, made_on: &str, days: f64, most_days: f64) -> String {
    if days < 0.0 {
        return format!(
            "the calibration of {what} is dated {made_on}, a day to come: check the clock of this computer"
        );
    }
    format!(
        "{what} of the sound device was calibrated on {made_on}, {} days ago: a calibration is old after {} days; check its unit and \
            scale",
        rounded(days),
        rounded(most_days)
    )
}
