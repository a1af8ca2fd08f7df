//! The recording of another system on the clock of a drive: when it began, how its clock runs, and how certain both are.
//!
//! A drive is played here and its answer is recorded elsewhere. Both hold the same signal, so the recording is cut into blocks, each block is
//! found in the drive, and a line through the places gives offset and drift. Bursts before and after a drive ([`with_bursts`]) do the same for a
//! drive that repeats.

mod anchored;
mod burst;
mod error;
mod found;
mod line;
mod matched;
mod page;
mod place;
mod recordings;
mod search;
mod tracked;
mod warning;

use serde::{Deserialize, Serialize};

use crate::quantity::{Band, Hertz, SampleRate, Seconds};
use crate::resample::Resampler;
use crate::warning::Warning;

pub use burst::{
    BurstConfig, BurstDocument, Bursts, DRIVE_BETWEEN, FIRST_BURST, LAST_BURST, Span, Which,
    WithBursts, with_bursts,
};
pub use error::AlignError;
pub use recordings::{AlignedRecording, Compared, FIRST_SAMPLE, Named, SignalOf, align_recordings};
pub use tracked::{ClockTracker, ClocksCompared};
pub use warning::{AlignFault, AlignWarning};

/// The share of the lower Nyquist frequency up to which signals are compared.
const PASSBAND: f64 = 0.9;
/// No clock is so wrong, ppm.
const MOST_DRIFT_PPM: f64 = 10_000.0;
/// The longest block, s.
const MOST_BLOCK_S: f64 = 3600.0;
/// The lower end of the usual band, Hz, and its upper one as far as rates allow.
const USUAL_HZ: [f64; 2] = [20.0, 1000.0];
/// The least width of a usual band, Hz.
const LEAST_WIDTH_HZ: f64 = 50.0;

/// How a recording is found in a drive. There is no default: it is stated, and goes into the result.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct AlignConfig {
    /// The band in which they are compared.
    pub band: Band,
    /// The length of a block, s.
    pub block_s: Seconds,
    /// The largest drift that is looked for, ppm.
    pub most_drift_ppm: f64,
}

impl AlignConfig {
    /// The band from 20 Hz to 1000 Hz, or to 0.9 of half the lower of two rates, blocks of 1 s, and drifts up to 300 ppm.
    ///
    /// # Errors
    /// [`AlignError::Rate`] for a rate that leaves less than 50 Hz of that band.
    pub fn usual(drive: SampleRate, recorded: SampleRate) -> Result<Self, AlignError> {
        let found_hz = drive.hz().min(recorded.hz());
        let [low, high] = USUAL_HZ;
        let high = high.min(PASSBAND * 0.5 * found_hz);
        let band = Band::new(Hertz(low), Hertz(high)).ok();
        let band = band.filter(|_| high - low >= LEAST_WIDTH_HZ);
        Ok(Self {
            band: band.ok_or(AlignError::Rate {
                found_hz,
                least_hz: (2.0 * (low + LEAST_WIDTH_HZ) / PASSBAND).ceil(),
                from_hz: low,
            })?,
            block_s: Seconds(1.0),
            most_drift_ppm: 300.0,
        })
    }
}

/// By what a recording was placed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum AlignedBy {
    /// By blocks of it.
    Blocks,
    /// By the bursts before and after the drive.
    Bursts,
}

/// Where one block of the recording was found.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct BlockPlace {
    /// The middle of the block, on the clock of the recording, s.
    pub recorded_s: Seconds,
    /// The same moment on the clock of the drive, s.
    pub drive_s: Seconds,
    /// The correlation of their envelopes, 0–1.
    pub correlation: f64,
    /// Whether the line was drawn with it.
    pub used: bool,
}

/// Where a burst was found.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct BurstPlace {
    /// Which one.
    pub which: Which,
    /// Its middle, on the clock of the recording, s.
    pub recorded_s: Seconds,
    /// The same moment on the clock of the drive, s.
    pub drive_s: Seconds,
    /// The correlation of their envelopes, 0–1.
    pub correlation: f64,
    /// The standard error of its time, s.
    pub error_s: Seconds,
}

/// How the clock of a recording relates to that of a drive.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Alignment {
    /// How it was found.
    pub config: AlignConfig,
    /// By what.
    pub by: AlignedBy,
    /// The time of the first sample of the recording on the clock of the drive, s: negative where it began before the drive.
    pub offset_s: Seconds,
    /// Its 95 % interval.
    pub offset_interval_s: [Seconds; 2],
    /// How much faster the clock of the recording runs than that of the drive, ppm.
    pub drift_ppm: f64,
    /// Its 95 % interval.
    pub drift_interval_ppm: [f64; 2],
    /// Half the 95 % interval of the time of a sample, where it is largest in the recording, s.
    pub uncertainty_s: Seconds,
    /// Half the 95 % interval of the time of a sample at times of the recording, s.
    pub intervals_s: Vec<(Seconds, Seconds)>,
    /// The standard deviation of single blocks about the line, s; absent where it was drawn by bursts.
    pub spread_s: Option<Seconds>,
    /// The first and the last time of the drive that was recorded, s.
    pub covered_s: [Seconds; 2],
    /// The length of the drive, s.
    pub drive_length_s: Seconds,
    /// The blocks in the order of time.
    pub blocks: Vec<BlockPlace>,
    /// The bursts in the order of time.
    pub bursts: Vec<BurstPlace>,
    /// What to know before relying on it.
    #[serde(alias = "doubts")]
    pub warnings: Vec<Warning>,
}

impl Alignment {
    /// A time of the recording on the clock of the drive, s.
    #[must_use]
    pub fn on_drive(&self, recorded_s: Seconds) -> Seconds {
        Seconds(self.offset_s.0 + recorded_s.0 / (1.0 + 1e-6 * self.drift_ppm))
    }

    /// A time of the drive on the clock of the recording, s.
    #[must_use]
    pub fn on_recording(&self, drive_s: Seconds) -> Seconds {
        Seconds((drive_s.0 - self.offset_s.0) * (1.0 + 1e-6 * self.drift_ppm))
    }

    /// A signal of the recording, sampled at `rate` by its clock, on the clock of the drive: the first sample given out is at the first
    /// whole sample of that clock that lies within the recording, whose time is given too; in the unit of `samples`.
    ///
    /// Formula: band-limited interpolation by a sinc of 64 samples in a Kaiser window.
    ///
    /// Source: J. O. Smith, *Digital Audio Resampling*; J. F. Kaiser (1974).
    #[must_use]
    pub fn placed(&self, samples: &[f64], rate: SampleRate) -> (Vec<f64>, Seconds) {
        place::placed(self, samples, rate, Seconds(0.0))
    }
}

/// Drive and recording in the band at the lower of their rates.
struct Prepared {
    config: AlignConfig,
    rate: SampleRate,
    drive: Vec<f64>,
    recorded: Vec<f64>,
    /// The mean power of the drive.
    usual: f64,
    drive_length_s: f64,
    recorded_length_s: f64,
}

/// Finds `recorded` in `drive`, samples at their own rates in any unit: the offset, the drift and their 95 % intervals. The delay of the device
/// between them is in the offset.
///
/// Formula: both are limited to the band at the lower of the two rates; the envelope of the cross-correlation of each block, over the energies
/// of both parts, has its maximum at the block's place; t(drive) = offset + t(recording)/(1 + drift) by least squares over blocks, without those
/// further than five robust standard deviations; intervals by Student's t. It is repeated by a clock that is corrected for the drift until
/// none is left: a sweep is found too early or too late by one that is not.
///
/// Source: G. C. Carter (1987), Proc. IEEE 75(2), for the delay; docs/decisions/sound.md.
///
/// # Errors
/// [`AlignError`] for signals shorter than four blocks, a band that both rates cannot hold, a recording that does not hold the drive, and a
/// drive that repeats so that it fits at several places.
pub fn align(
    drive: (&[f64], SampleRate),
    recorded: (&[f64], SampleRate),
    config: &AlignConfig,
) -> Result<Alignment, AlignError> {
    found::by_blocks(&Prepared::of(drive, recorded, config)?)
}

/// As [`align`], of a drive with bursts at `bursts`: they say where the recording is in the drive. Blocks are then looked for near there; where
/// they are less certain, or the drive repeats, offset and drift are those of the line through the two bursts, with their standard
/// errors. Where the recording holds neither burst, as [`align`].
///
/// Source: docs/decisions/sound.md.
///
/// # Errors
/// Those of [`align`]; [`AlignError::BurstsApart`] for bursts of two playbacks, or with samples missing between them;
/// [`AlignError::OneBurst`] for a recording with one burst of a drive that repeats.
pub fn align_with_bursts(
    drive: (&[f64], SampleRate),
    recorded: (&[f64], SampleRate),
    bursts: &Bursts,
    config: &AlignConfig,
) -> Result<Alignment, AlignError> {
    found::by_bursts(&Prepared::of(drive, recorded, config)?, bursts)
}

impl Prepared {
    fn of(
        (drive, drive_rate): (&[f64], SampleRate),
        (recorded, recorded_rate): (&[f64], SampleRate),
        config: &AlignConfig,
    ) -> Result<Self, AlignError> {
        let is_drift = config.most_drift_ppm > 0.0 && config.most_drift_ppm <= MOST_DRIFT_PPM;
        let is_block = config.block_s.0 > 0.0 && config.block_s.0 <= MOST_BLOCK_S;
        if !(is_block && is_drift) {
            return Err(AlignError::Settings);
        }
        let rate = match drive_rate.hz() < recorded_rate.hz() {
            true => drive_rate,
            false => recorded_rate,
        };
        let highest_hz = PASSBAND * rate.nyquist().0;
        if config.band.high().0 > highest_hz {
            return Err(AlignError::Band {
                high_hz: config.band.high().0,
                highest_hz,
            });
        }
        for (what, samples) in [("drive", drive), ("recording", recorded)] {
            if samples.iter().any(|value| !value.is_finite()) {
                return Err(AlignError::NotFinite { what });
            }
        }
        let in_band = |samples: &[f64], own: SampleRate| -> Result<Vec<f64>, AlignError> {
            let samples = match own == rate {
                true => samples.to_vec(),
                false => Resampler::new(own, rate, Hertz(highest_hz))?.process(samples),
            };
            Ok(within(&samples, rate, config.band))
        };
        let own = in_band(drive, drive_rate)?;
        Ok(Self {
            config: *config,
            rate,
            usual: own.iter().map(|v| v * v).sum::<f64>() / own.len().max(1) as f64,
            drive: own,
            recorded: in_band(recorded, recorded_rate)?,
            drive_length_s: drive_rate.duration_of(drive.len()).0,
            recorded_length_s: recorded_rate.duration_of(recorded.len()).0,
        })
    }
}

/// The signal within the band, whose edges fall over a tenth of its width.
fn within(samples: &[f64], rate: SampleRate, band: Band) -> Vec<f64> {
    use crate::fourier::{RealTransform, fast_length};
    let n = fast_length(samples.len() + rate.hz() as usize);
    let mut transform = RealTransform::new(n);
    let mut bins = transform.forward(samples);
    let (low, high) = (band.low().0, band.high().0);
    let edge = 0.1 * (high - low);
    for (line, bin) in bins.iter_mut().enumerate() {
        let hz = line as f64 * rate.hz() / n as f64;
        let inside = (hz - low).min(high - hz) / edge;
        *bin *= inside.clamp(0.0, 1.0);
    }
    let mut found = transform.inverse(bins);
    found.truncate(samples.len());
    found
}

#[cfg(test)]
mod tests;
