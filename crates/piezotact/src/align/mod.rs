//! The recording of another system on the clock of a drive: when it began, how its clock runs, and how certain both are.
//!
//! A drive is played here and its answer is recorded elsewhere. Both hold the same signal, so the recording is cut into blocks, each block is
//! found in the drive, and a line through the places gives offset and drift.

mod doubt;
mod place;
mod search;

use serde::{Deserialize, Serialize};

use crate::doubt::Doubt;
use crate::quantity::{Band, Hertz, SampleRate, Seconds};
use crate::resample::{ResampleError, Resampler};
use crate::statistics::{mean, median, t_quantile};
use search::{Blocks, Found};

pub use doubt::AlignDoubt;

/// With fewer blocks there is no line with an uncertainty.
const FEWEST_BLOCKS: usize = 4;
/// The share of the lower Nyquist frequency up to which signals are compared.
const PASSBAND: f64 = 0.9;
/// Residuals of more than so many robust standard deviations are left out.
const FAR: f64 = 5.0;
/// The median of absolute residuals of a normal distribution is its standard deviation over this.
const NORMAL: f64 = 1.4826;
/// No clock is so wrong, ppm.
const MOST_DRIFT_PPM: f64 = 10_000.0;
/// Less certain times are doubted, s.
const CERTAIN_S: f64 = 1e-4;

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

/// How the clock of a recording relates to that of a drive.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Alignment {
    /// How it was found.
    pub config: AlignConfig,
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
    /// The standard deviation of single blocks about the line, s.
    pub spread_s: Seconds,
    /// The first and the last time of the drive that was recorded, s.
    pub covered_s: [Seconds; 2],
    /// The length of the drive, s.
    pub drive_length_s: Seconds,
    /// The blocks in the order of time.
    pub blocks: Vec<BlockPlace>,
    /// What to know before relying on it.
    pub doubts: Vec<Doubt>,
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
        place::placed(self, samples, rate)
    }
}

/// Finds `recorded` in `drive`, samples at their own rates in any unit: the offset, the drift and their 95 % intervals. The delay of the device
/// between them is in the offset.
///
/// Formula: both are limited to the band at the lower of the two rates; the envelope of the cross-correlation of each block, over the energies
/// of both parts, has its maximum at the block's place; t(drive) = offset + t(recording)/(1 + drift) by least squares over blocks, without those
/// further than five robust standard deviations; intervals by Student's t.
///
/// Source: G. C. Carter (1987), Proc. IEEE 75(2), for the delay; decision 0087 of this project.
///
/// # Errors
/// [`AlignError`] for signals shorter than four blocks, a band that both rates cannot hold, a recording that does not hold the drive, and a
/// drive that repeats so that it fits at several places.
pub fn align(
    (drive, drive_rate): (&[f64], SampleRate),
    (recorded, recorded_rate): (&[f64], SampleRate),
    config: &AlignConfig,
) -> Result<Alignment, AlignError> {
    let most = 0.0..=MOST_DRIFT_PPM;
    let is_block = config.block_s.0 > 0.0 && config.block_s.0.is_finite();
    if !(is_block && config.most_drift_ppm > 0.0 && most.contains(&config.most_drift_ppm)) {
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
    let at_rate = |samples: &[f64], own: SampleRate| match own == rate {
        true => Ok(samples.to_vec()),
        false => Resampler::new(own, rate, Hertz(highest_hz)).map(|plan| plan.process(samples)),
    };
    let blocks = Blocks::of(
        &at_rate(drive, drive_rate)?,
        &at_rate(recorded, recorded_rate)?,
        rate,
        config,
    )?;
    let found = blocks.places()?;
    line(
        &found,
        config,
        drive_rate.duration_of(drive.len()).0,
        recorded_rate.duration_of(recorded.len()).0,
    )
}

/// The line through the places of blocks.
fn line(
    found: &[Found],
    config: &AlignConfig,
    drive_s: f64,
    recorded_s: f64,
) -> Result<Alignment, AlignError> {
    let mut used: Vec<bool> = vec![true; found.len()];
    let mut fit = Fit::of(found, &used).ok_or(AlignError::FewBlocks { found: found.len() })?;
    // Twice: what is far from the first line has moved it.
    for _ in 0..2 {
        let residuals: Vec<f64> = found.iter().map(|one| fit.residual(one)).collect();
        let sizes: Vec<f64> = residuals.iter().map(|residual| residual.abs()).collect();
        let usual = median(&mut sizes.clone()).unwrap_or(0.0);
        let limit = FAR * NORMAL * usual.max(1e-7);
        for (used, size) in used.iter_mut().zip(&sizes) {
            *used = *size <= limit;
        }
        let count = used.iter().filter(|used| **used).count();
        fit = Fit::of(found, &used).ok_or(AlignError::FewBlocks { found: count })?;
    }
    let drift_of = |slope: f64| 1e6 * (1.0 / slope - 1.0);
    let reach = |half: f64| [drift_of(fit.slope + half), drift_of(fit.slope - half)];
    let half = fit.t * fit.slope_error();
    let at = |recorded_s: f64| fit.t * fit.error_at(recorded_s);
    let uncertainty_s = at(0.0).max(at(recorded_s));
    let offset_s = fit.at(0.0);
    let covered_s = [offset_s.max(0.0), fit.at(recorded_s).min(drive_s)];
    let drift_ppm = drift_of(fit.slope);
    let left_out = used.iter().filter(|used| !**used).count();
    let mut doubts: Vec<Doubt> = Vec::new();
    if covered_s[0] > CERTAIN_S || covered_s[1] < drive_s - CERTAIN_S {
        doubts.push(
            AlignDoubt::PartCovered {
                from_s: covered_s[0],
                to_s: covered_s[1],
                length_s: drive_s,
            }
            .into(),
        );
    }
    if uncertainty_s > CERTAIN_S {
        doubts.push(
            AlignDoubt::Uncertain {
                uncertainty_s,
                blocks: found.len() - left_out,
            }
            .into(),
        );
    }
    if 5 * left_out > found.len() {
        doubts.push(
            AlignDoubt::ManyLeftOut {
                left_out,
                of: found.len(),
            }
            .into(),
        );
    }
    if drift_ppm.abs() > 0.8 * config.most_drift_ppm {
        doubts.push(
            AlignDoubt::DriftAtLimit {
                drift_ppm,
                most_ppm: config.most_drift_ppm,
            }
            .into(),
        );
    }
    Ok(Alignment {
        config: *config,
        offset_s: Seconds(offset_s),
        offset_interval_s: [-1.0, 1.0].map(|side| Seconds(offset_s + side * at(0.0))),
        drift_ppm,
        drift_interval_ppm: reach(half),
        uncertainty_s: Seconds(uncertainty_s),
        spread_s: Seconds(fit.spread),
        covered_s: covered_s.map(Seconds),
        drive_length_s: Seconds(drive_s),
        blocks: found
            .iter()
            .zip(used)
            .map(|(one, used)| BlockPlace {
                recorded_s: Seconds(one.recorded_s),
                drive_s: Seconds(one.drive_s),
                correlation: one.correlation,
                used,
            })
            .collect(),
        doubts,
    })
}

/// A least-squares line from the clock of the recording to that of the drive.
struct Fit {
    middle: [f64; 2],
    slope: f64,
    squares: f64,
    count: f64,
    spread: f64,
    t: f64,
}

impl Fit {
    fn of(found: &[Found], used: &[bool]) -> Option<Self> {
        let own: Vec<&Found> = found
            .iter()
            .zip(used)
            .filter_map(|(one, used)| used.then_some(one))
            .collect();
        if own.len() < FEWEST_BLOCKS {
            return None;
        }
        let x: Vec<f64> = own.iter().map(|one| one.recorded_s).collect();
        // Less the time of the recording, so that no digit is lost.
        let y: Vec<f64> = own.iter().map(|one| one.drive_s - one.recorded_s).collect();
        let middle = [mean(&x), mean(&y)];
        let squares: f64 = x.iter().map(|x| (x - middle[0]).powi(2)).sum();
        let product: f64 = x
            .iter()
            .zip(&y)
            .map(|(x, y)| (x - middle[0]) * (y - middle[1]))
            .sum();
        let slope = product / squares;
        let rest: f64 = x
            .iter()
            .zip(&y)
            .map(|(x, y)| (y - middle[1] - slope * (x - middle[0])).powi(2))
            .sum();
        let count = own.len() as f64;
        let found = Self {
            middle,
            slope: 1.0 + slope,
            squares,
            count,
            spread: (rest / (count - 2.0)).sqrt(),
            t: t_quantile(own.len() - 2)?,
        };
        found.slope.is_finite().then_some(found)
    }

    /// The time of the drive at a time of the recording.
    fn at(&self, recorded_s: f64) -> f64 {
        let along = recorded_s - self.middle[0];
        recorded_s + self.middle[1] + (self.slope - 1.0) * along
    }

    fn residual(&self, one: &Found) -> f64 {
        one.drive_s - self.at(one.recorded_s)
    }

    fn slope_error(&self) -> f64 {
        self.spread / self.squares.sqrt()
    }

    fn error_at(&self, recorded_s: f64) -> f64 {
        let along = recorded_s - self.middle[0];
        self.spread * (1.0 / self.count + along * along / self.squares).sqrt()
    }
}

/// Why a recording cannot be put on the clock of a drive.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum AlignError {
    /// Settings that are none.
    #[error(
        "expected a block above 0 s and a largest drift above 0 and up to {MOST_DRIFT_PPM} ppm, found others; 1 s and 300 ppm are usual"
    )]
    Settings,
    /// A band that the lower rate cannot hold.
    #[error(
        "expected a band up to {highest_hz} Hz, 0.9 of half the lower rate, found one up to {high_hz} Hz; state a lower one"
    )]
    Band {
        /// Its upper end, Hz.
        high_hz: f64,
        /// The highest possible, Hz.
        highest_hz: f64,
    },
    /// A sample that is no number.
    #[error("expected finite samples, found one of the {what} that is none; cut that part out")]
    NotFinite {
        /// Which signal.
        what: &'static str,
    },
    /// Fewer blocks than a line needs.
    #[error(
        "expected at least {FEWEST_BLOCKS} blocks of the recording in the drive, found {found}; record longer, or take shorter blocks"
    )]
    FewBlocks {
        /// How many.
        found: usize,
    },
    /// No block in the drive.
    #[error(
        "expected the drive in the recording, found none of it (largest correlation {correlation:.2}); check the channel, and that this drive was played"
    )]
    NotThere {
        /// The largest correlation of a block.
        correlation: f64,
    },
    /// Several places fit.
    #[error(
        "expected one place of the recording in the drive, found it at {first_s:.3} s and at {second_s:.3} s alike: the drive repeats; record its \
         beginning or its end too, or play a drive with a synchronisation burst at both ends"
    )]
    SeveralPlaces {
        /// One offset, s.
        first_s: f64,
        /// Another, s.
        second_s: f64,
    },
    /// A change of rate that cannot be.
    #[error(transparent)]
    Resample(#[from] ResampleError),
}

#[cfg(test)]
mod tests;
