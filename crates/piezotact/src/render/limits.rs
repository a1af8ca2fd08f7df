//! What a drive asks of the device, before it plays.

use serde::{Deserialize, Serialize};

use crate::device::DriveSetup;
use crate::quantity::{Decibels, Drive, SampleRate};
use crate::series::{Series, peak, rms};

/// How much of what the device can do a drive uses.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Headroom {
    /// The largest sample of the drive as computed, full scale = 1.
    pub peak: f64,
    /// Its root mean square, the silence before and after the texture included.
    pub rms: f64,
    /// The drive at which the first limit is reached, full scale = 1.
    pub limit: f64,
    /// What that limit is.
    pub limited_by: String,
    /// How far the peak stays below the limit; negative when it does not fit.
    pub headroom_db: f64,
    /// The share of samples beyond the limit, 0–1.
    pub clipped_fraction: f64,
    /// The steepest slope at the actuator, V/s; absent when the device is not described.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub slope_v_per_s: Option<f64>,
}

/// A drive turned down until it stays 1 dB below the first limit of the device; unchanged when it does already.
///
/// Source: [`DriveSetup::drive_limit`].
#[must_use]
pub fn fitting(drive: &Series<Drive>, setup: &DriveSetup) -> Series<Drive> {
    let room =
        Decibels::from_amplitude_ratio(setup.drive_limit() / drive.peak().max(f64::MIN_POSITIVE));
    drive.clone().amplified(Decibels((room.0 - 1.0).min(0.0)))
}

/// How much of what a device can do `drive` (full scale = 1) at `rate` uses; without a description of the
/// device only the digital full scale counts.
///
/// Formula: headroom = 20·log10(limit/peak); slope = max|Δ|·rate·gain·volts per full scale.
///
/// Source: DRV2667 data sheet SLOS751E for the limits, see [`DriveSetup`].
#[must_use]
pub fn headroom(drive: &[f64], rate: SampleRate, setup: Option<&DriveSetup>) -> Headroom {
    let limit = setup.map_or(1.0, DriveSetup::drive_limit);
    let peak = peak(drive);
    let beyond = drive.iter().filter(|sample| sample.abs() > limit).count();
    let steepest = drive
        .windows(2)
        .map(|pair| (pair[1] - pair[0]).abs())
        .fold(0.0, f64::max);
    Headroom {
        peak,
        rms: rms(drive),
        limit,
        limited_by: setup
            .map_or("the digital full scale", DriveSetup::limited_by)
            .into(),
        // A drive of −240 dB is silence.
        headroom_db: Decibels::from_amplitude_ratio(limit / peak.max(1e-12)).0,
        clipped_fraction: beyond as f64 / drive.len().max(1) as f64,
        slope_v_per_s: setup.map(|setup| {
            steepest * rate.hz() * setup.gain.voltage_ratio() * setup.volts_per_full_scale
        }),
    }
}
