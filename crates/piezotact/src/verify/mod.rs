//! How close the re-measured vibration came to its target: in spectrum, in level, and in waveform.
//!
//! A spectrum cannot see a wrong phase. A drive made with the conjugate of the transfer function has the
//! right PSD and no resemblance to the target, so the waveform is always looked at too.

mod align;
mod beside;
mod changed;
mod clipping;
mod straight;
mod tones;

pub(crate) use align::align;
pub use beside::{Beside, beside};
pub use changed::{Changed, changed};
pub use clipping::{Clipping, clipping, flat_top_fraction};
use serde::{Deserialize, Serialize};
pub use straight::{PredictedStraight, predicted_straight};
pub use tones::{Tones, tones};

use crate::doubt::Doubt;
use crate::quantity::{Band, Decibels, Hertz, Quantity, QuantityError};
use crate::render::Mode;
use crate::resample::ResampleError;
use crate::series::{Series, SeriesError, rms};
use crate::spectrum::{EstimateError, WelchConfig, WelchPlan, frequency_axis};

/// How a measurement is compared with its target.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct VerifyConfig {
    /// The band over which they are compared.
    pub band: Band,
    /// The parts of it that the inverse declared achievable; empty when nothing was declared.
    pub achievable: Vec<Band>,
    /// How the spectra are estimated.
    pub welch: WelchConfig,
    /// The level at which the target was rendered on purpose, dB; the comparison is made at that level.
    pub level: Decibels,
    /// Whether the waveform counts, or its spectrum alone.
    pub mode: Mode,
    /// What counts as passed.
    pub limits: Limits,
}

/// What counts as passed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Limits {
    /// The largest spectrum error, dB rms over the band.
    pub error_db_rms: f64,
    /// The lowest waveform correlation, where the waveform counts.
    pub waveform_correlation: f64,
    /// The largest share of samples at a limit, 0–1.
    pub clipped_fraction: f64,
}

impl Limits {
    /// 1 dB rms, which is below the 1.58 dB (a fifth in amplitude) that can just be told apart; a correlation
    /// of 0.95; one sample in a thousand at a limit.
    #[must_use]
    pub fn individual_transfer_function() -> Self {
        Self {
            error_db_rms: 1.0,
            waveform_correlation: 0.95,
            clipped_fraction: 1e-3,
        }
    }
}

impl VerifyConfig {
    /// Over `band`, Hann segments of about 5 Hz at `rate_hz`, the limits for an individual transfer function.
    #[must_use]
    pub fn over(band: Band, rate_hz: f64) -> Self {
        let segment = 2f64.powf((rate_hz / 5.0).log2().round()).max(16.0) as usize;
        Self {
            band,
            achievable: Vec::new(),
            welch: WelchConfig::hann(segment),
            level: Decibels(0.0),
            mode: Mode::Replicate,
            limits: Limits::individual_transfer_function(),
        }
    }
}

/// What was measured while a drive was played.
#[derive(Clone, Debug)]
pub struct Measured<'a, Q: Quantity> {
    /// The response, in the unit of the target, at its rate.
    pub response: &'a Series<Q>,
    /// What is known of clipping on the way; see [`clipping`].
    pub clipping: Clipping,
}

impl<'a, Q: Quantity> Measured<'a, Q> {
    /// A response with nothing known of the way it came, but for flat tops of its own.
    #[must_use]
    pub fn alone(response: &'a Series<Q>) -> Self {
        Self {
            response,
            clipping: clipping(response, None, None),
        }
    }
}

/// What a verification concludes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "is", rename_all = "snake_case")]
pub enum Verdict {
    /// Every criterion is met, over all of the target.
    Passed,
    /// Every criterion is met over the part that could be judged, which is not all of the target.
    PassedInPart {
        /// The share of the target's power that was judged, 0–1.
        power_share: f64,
    },
    /// At least one criterion is not met.
    NotPassed,
    /// No criterion is known not to be met, and at least one is not known to be met.
    NotDecided,
}

/// How close a measurement came to its target.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Verification {
    /// The band over which they were compared, Hz.
    pub band_hz: Band,
    /// Root mean square over the band's lines of the spectrum error, dB.
    pub error_db_rms: f64,
    /// The largest absolute error of a line in the band, dB.
    pub error_db_max: f64,
    /// The frequency of the largest error, Hz.
    pub error_max_at_hz: f64,
    /// The same rms after the mean error of the lines is taken away: the error in shape alone, dB.
    pub error_db_rms_level_matched: f64,
    /// The parts of the band that the inverse declared achievable.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub achievable_band_hz: Vec<Band>,
    /// The rms error over those alone, dB.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub error_db_rms_achievable: Option<f64>,
    /// 20·log10 of the measured over the target rms in the band, dB.
    pub level_error_db: f64,
    /// Pearson's correlation of the band-limited waveforms after aligning the delay.
    pub waveform_correlation: f64,
    /// The power of the difference of those waveforms over that of the target (NMSE), dB; 0 dB is no better than silence.
    #[serde(default)]
    pub waveform_nmse_db: f64,
    /// How much later the measurement is than the target, s.
    pub delay_s: f64,
    /// The share of samples at a limit, of the sensor or of the device, 0–1.
    pub clipped_fraction: f64,
    /// The level at which the target was rendered on purpose, dB.
    pub level_db: f64,
    /// The unit of the PSDs.
    pub psd_unit: String,
    /// The rate at which they were compared, Hz.
    pub rate_hz: f64,
    /// The power of the measurement on lines of the band without target, over the target's in the band.
    #[serde(default)]
    pub added_power: f64,
    /// How the spectra were estimated.
    pub welch: WelchConfig,
    /// The number of segments averaged.
    pub averages: usize,
    /// The lines of the spectra, Hz.
    pub frequency_hz: Vec<f64>,
    /// The PSD of the target, unit²/Hz.
    pub target_psd: Vec<f64>,
    /// The PSD of the measurement, unit²/Hz.
    pub measured_psd: Vec<f64>,
    /// The lines that are judged, Hz: those of the band that hold target power.
    pub error_frequency_hz: Vec<f64>,
    /// Their errors, 10·log10(measured/target) of the band-limited signals, dB.
    pub error_db: Vec<f64>,
    /// The target at its level, limited to the band, in its unit.
    #[serde(skip)]
    pub target: Vec<f64>,
    /// The measurement at the target's times, limited to the band, in its unit.
    #[serde(skip)]
    pub aligned: Vec<f64>,
    /// Those of their samples that were compared: what the measurement covers.
    #[serde(skip)]
    pub compared: std::ops::Range<usize>,
    /// What is concluded.
    pub verdict: Verdict,
    /// Whether the waveform counts, or its spectrum alone.
    pub mode: Mode,
    /// The limits.
    pub limits: Limits,
    /// What a person should know before relying on it.
    pub doubts: Vec<Doubt>,
}

impl Verification {
    /// Whether every criterion is met over all of the target.
    #[must_use]
    pub fn passed(&self) -> bool {
        self.verdict == Verdict::Passed
    }

    /// One line that says whether it passed and why.
    #[must_use]
    pub fn sentence(&self) -> String {
        let clipped = if self.clipped_fraction > self.limits.clipped_fraction {
            format!(
                ", {:.1} % of samples at a limit (limit {} %)",
                self.clipped_fraction * 100.0,
                self.limits.clipped_fraction * 100.0
            )
        } else {
            String::new()
        };
        let added = if self.added_power > MOST_ADDED {
            format!(
                ", {:.0} % of the target's power added where it has none (limit {:.0} %)",
                self.added_power * 100.0,
                MOST_ADDED * 100.0
            )
        } else {
            String::new()
        };
        let part = if self.judged_share() < LEAST_JUDGED {
            format!(
                ", {:.0} % of the band judged (limit {:.0} %)",
                self.judged_share() * 100.0,
                LEAST_JUDGED * 100.0
            )
        } else {
            String::new()
        };
        let level = if self.level_db == 0.0 {
            String::new()
        } else {
            format!(", rendered at {:+.1} dB", self.level_db)
        };
        let waveform_limit = match self.mode {
            Mode::Replicate => format!("limit {}", self.limits.waveform_correlation),
            Mode::Texture => "the spectrum alone counts".into(),
        };
        format!(
            "{}: spectrum error {:.2} dB rms over {} (limit {} dB), waveform correlation {:.3} ({waveform_limit}){clipped}{added}{part}{level}",
            if self.passed() {
                "passed"
            } else {
                "not passed"
            },
            self.judged_error_db(),
            self.judged_band(),
            self.limits.error_db_rms,
            self.waveform_correlation,
        )
    }

    /// The band that is judged, as text: all of it, or the part that the inverse declared achievable.
    #[must_use]
    pub fn judged_band(&self) -> String {
        match self.achievable_band_hz.as_slice() {
            _ if self.error_db_rms_achievable.is_none() => self.band_hz.to_string(),
            [only] if *only == self.band_hz => self.band_hz.to_string(),
            few if few.len() <= 3 => {
                let bands: Vec<String> = few.iter().map(ToString::to_string).collect();
                format!("{} of {}", bands.join(", "), self.band_hz)
            }
            many => format!(
                "the achievable part ({} bands) of {}",
                many.len(),
                self.band_hz
            ),
        }
    }

    /// The rms error over the lines within `bands`, dB; over all that are compared when none lies there.
    #[must_use]
    pub fn error_db_rms_over(&self, bands: &[Band]) -> f64 {
        let lines = self.error_frequency_hz.iter().zip(&self.error_db);
        let within: Vec<f64> = lines
            .filter(|(hz, _)| bands.iter().any(|band| band.contains(**hz)))
            .map(|(_, error)| *error)
            .collect();
        if within.is_empty() {
            self.error_db_rms
        } else {
            rms(&within)
        }
    }

    /// The share of the compared lines that are judged, 0–1.
    #[must_use]
    pub fn judged_share(&self) -> f64 {
        if self.error_db_rms_achievable.is_none() {
            return 1.0;
        }
        let reached = |hz: &&f64| {
            self.achievable_band_hz
                .iter()
                .any(|band| band.contains(**hz))
        };
        let judged = self.error_frequency_hz.iter().filter(reached).count();
        judged as f64 / self.error_frequency_hz.len().max(1) as f64
    }

    /// The largest absolute error of a line that is judged, dB: over the achievable part where one was declared.
    #[must_use]
    pub fn error_db_max_achievable(&self) -> f64 {
        let judged = |hz: f64| {
            self.error_db_rms_achievable.is_none()
                || self.achievable_band_hz.iter().any(|band| band.contains(hz))
        };
        let lines = self.error_frequency_hz.iter().zip(&self.error_db);
        lines
            .filter(|(hz, _)| judged(**hz))
            .fold(0.0, |most, (_, error)| error.abs().max(most))
    }

    /// The rms error that is judged, dB: over the achievable part where one was declared.
    #[must_use]
    pub fn judged_error_db(&self) -> f64 {
        self.error_db_rms_achievable.unwrap_or(self.error_db_rms)
    }
}

fn ratio_db(measured: f64, target: f64) -> f64 {
    if target > 0.0 {
        10.0 * (measured.max(target * 1e-12) / target).log10()
    } else {
        0.0
    }
}

/// The power of a difference over that of what it should have been, dB. What is equal to the last bit is as good as numbers
/// are.
pub(crate) fn nmse_db(difference_rms: f64, target_rms: f64) -> f64 {
    20.0 * (difference_rms / target_rms.max(f64::MIN_POSITIVE))
        .max(1e-16)
        .log10()
}

/// A verification that judges less of the band than this does not pass, and from this much less than all it is a doubt.
const LEAST_JUDGED: f64 = 0.5;
const TOLD_SHARE: f64 = 0.05;
/// More power than this where the target has none, over the target's, is a doubt; more than that does not pass.
const ADDED_TOLD: f64 = 0.01;
const MOST_ADDED: f64 = 0.1;

/// Lines this far below the band's strongest hold next to no target, dB: below them lies the noise of sensors.
const NO_POWER_DB: f64 = -50.0;

/// How close `measured` came to `target`, two series of one quantity at one rate.
///
/// Both are limited to the band. The delay is found by cross-correlation, to a fraction of a sample, and
/// taken away; then the PSDs are compared line by line and the waveforms correlated.
///
/// Formulas: `error = 10·log10(S_measured/S_target)`; level = 20·log10 of the rms ratio in the band;
/// correlation = Σtm/√(Σt²·Σm²); NMSE = 10·log10(Σ(m − t)²/Σt²).
///
/// Source: thesis section 4.2 for the comparison of spectra; generalised cross-correlation after Knapp and
/// Carter (1976) for the delay.
///
/// # Errors
/// [`VerifyError::Rate`] when the rates differ, [`VerifyError::BandAboveNyquist`],
/// [`VerifyError::TooShort`] when they do not overlap by a segment, [`VerifyError::Silent`] when either holds
/// nothing in the band.
pub fn verify<Q: Quantity>(
    target: &Series<Q>,
    measured: Measured<'_, Q>,
    config: &VerifyConfig,
) -> Result<Verification, VerifyError> {
    let target = &target.clone().amplified(config.level);
    let (rate, response) = (target.rate(), measured.response);
    if (response.rate().hz() - rate.hz()).abs() > 1e-9 * rate.hz() {
        return Err(VerifyError::Rate {
            target_hz: rate.hz(),
            measured_hz: response.rate().hz(),
        });
    }
    if config.band.high().0 > rate.nyquist().0 {
        return Err(VerifyError::BandAboveNyquist {
            band: config.band,
            highest: rate.nyquist(),
        });
    }
    let aligned = align(target, response, config.band)?;
    let compared = aligned.from..aligned.to;
    if compared.len() < config.welch.segment {
        return Err(VerifyError::TooShort {
            expected: config.welch.segment,
            found: compared.len(),
        });
    }
    let wanted = &aligned.target_in_band[compared.clone()];
    let got = &aligned.measured_in_band[compared.clone()];
    let (level_target, level_measured) = (rms(wanted), rms(got));
    let level_error_db = Decibels::from_amplitude_ratio(level_measured / level_target).0;
    let product: f64 = wanted.iter().zip(got).map(|(t, m)| t * m).sum();
    let waveform_correlation = product / (wanted.len() as f64 * level_target * level_measured);

    let missed: Vec<f64> = wanted.iter().zip(got).map(|(t, m)| m - t).collect();
    let waveform_nmse_db = nmse_db(rms(&missed), level_target);

    let mut plan = WelchPlan::new(&config.welch, rate)?;
    // Of the band-limited signals: what lies outside was not rendered and must not leak in.
    let target_psd = plan.estimate::<Q>(&[wanted])?;
    let measured_psd = plan.estimate::<Q>(&[got])?;
    let lines = errors_in_band(
        &target_psd.values,
        &measured_psd.values,
        target_psd.resolution_hz,
        config.band,
    )?;
    let (error_max_at_hz, largest) = lines
        .compared
        .iter()
        .copied()
        .max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))
        .unwrap_or((config.band.low().0, 0.0));
    let error_db_rms = rms_of(lines.compared.iter().map(|(_, error)| *error));
    let achievable = |frequency_hz: f64| {
        config
            .achievable
            .iter()
            .any(|band| band.contains(frequency_hz))
    };
    let reached: Vec<f64> = lines
        .compared
        .iter()
        .filter(|(frequency_hz, _)| achievable(*frequency_hz))
        .map(|(_, error)| *error)
        .collect();

    let full_target = plan.estimate::<Q>(&[&target.samples()[compared.clone()]])?;
    let full_measured = plan.estimate::<Q>(&[&aligned.measured[compared.clone()]])?;

    let judged_share = if reached.is_empty() {
        1.0
    } else {
        reached.len() as f64 / lines.compared.len() as f64
    };
    let in_band: f64 = target_psd.values.iter().sum();
    let added_power = lines.added / in_band.max(f64::MIN_POSITIVE);
    let mut doubts = target_psd.doubts.clone();
    if judged_share < 1.0 - TOLD_SHARE {
        doubts.push(Doubt::PartJudged {
            share: judged_share,
            judged: config.achievable.clone(),
            band: config.band,
        });
    }
    if added_power > ADDED_TOLD {
        doubts.push(Doubt::PowerAdded { ratio: added_power });
    }
    if config.level.0 != 0.0 {
        doubts.push(Doubt::LevelChanged {
            level_db: config.level.0,
        });
    }
    if lines.without_target > 0 {
        let all = lines.without_target + lines.compared.len();
        doubts.push(Doubt::NoTargetPower {
            share: lines.without_target as f64 / all as f64,
        });
    }
    // A hundredth is what aligning costs at the ends.
    if compared.len() * 100 < target.samples().len() * 99 {
        doubts.push(Doubt::Cut {
            compared_s: rate.duration_of(compared.len()).0,
            target_s: target.duration().0,
        });
    }
    doubts.extend(measured.clipping.doubts);
    if waveform_correlation < -0.5 {
        doubts.push(Doubt::Inverted {
            correlation: waveform_correlation,
        });
    }
    let error_db_rms_achievable = (!reached.is_empty()).then(|| rms_of(reached.iter().copied()));
    let passed = error_db_rms_achievable.unwrap_or(error_db_rms) <= config.limits.error_db_rms
        && (config.mode == Mode::Texture
            || waveform_correlation >= config.limits.waveform_correlation)
        && measured.clipping.fraction <= config.limits.clipped_fraction
        && judged_share >= LEAST_JUDGED
        && added_power <= MOST_ADDED
        && compared.len() * 2 >= target.samples().len();
    let mean_error_db =
        lines.compared.iter().map(|(_, error)| error).sum::<f64>() / lines.compared.len() as f64;
    Ok(Verification {
        band_hz: config.band,
        error_db_rms,
        error_db_max: largest.abs(),
        error_max_at_hz,
        error_db_rms_level_matched: rms_of(
            lines
                .compared
                .iter()
                .map(|(_, error)| error - mean_error_db),
        ),
        achievable_band_hz: config
            .achievable
            .iter()
            .filter_map(|band| band.common(config.band))
            .collect(),
        error_db_rms_achievable,
        level_error_db,
        waveform_correlation,
        waveform_nmse_db,
        delay_s: aligned.delay.0,
        clipped_fraction: measured.clipping.fraction,
        level_db: config.level.0,
        added_power,
        psd_unit: Q::UNIT.of_psd(),
        rate_hz: rate.hz(),
        welch: config.welch.clone(),
        averages: full_target.averages,
        frequency_hz: frequency_axis(full_target.resolution_hz, full_target.values.len()),
        target_psd: full_target.values,
        measured_psd: full_measured.values,
        error_frequency_hz: lines
            .compared
            .iter()
            .map(|(frequency_hz, _)| *frequency_hz)
            .collect(),
        error_db: lines.compared.iter().map(|(_, error)| *error).collect(),
        target: aligned.target_in_band,
        aligned: aligned.measured_in_band,
        compared,
        verdict: if passed {
            Verdict::Passed
        } else {
            Verdict::NotPassed
        },
        mode: config.mode,
        limits: config.limits.clone(),
        doubts,
    })
}

pub(crate) fn rms_of(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0usize), |(sum, count), value| {
        (sum + value * value, count + 1)
    });
    (sum / count.max(1) as f64).sqrt()
}

/// The errors of the lines of a band.
pub(crate) struct LineErrors {
    /// Frequency in Hz and error in dB of every line with target power.
    pub(crate) compared: Vec<(f64, f64)>,
    /// How many lines hold none.
    pub(crate) without_target: usize,
    /// The sum of the measured values on those.
    pub(crate) added: f64,
}

pub(crate) fn errors_in_band(
    target: &[f64],
    measured: &[f64],
    resolution_hz: f64,
    band: Band,
) -> Result<LineErrors, VerifyError> {
    let lines: Vec<(f64, f64, f64)> = target
        .iter()
        .zip(measured)
        .enumerate()
        .map(|(k, (t, m))| (k as f64 * resolution_hz, *t, *m))
        .filter(|(frequency_hz, ..)| band.contains(*frequency_hz))
        .collect();
    if lines.is_empty() {
        return Err(VerifyError::NoLine {
            band,
            resolution_hz,
        });
    }
    let strongest = lines
        .iter()
        .fold(0.0, |strongest: f64, (_, t, _)| strongest.max(*t));
    if strongest <= 0.0 {
        return Err(VerifyError::Silent {
            what: "the target",
            band,
        });
    }
    let least = strongest * 10f64.powf(NO_POWER_DB / 10.0);
    let compared: Vec<(f64, f64)> = lines
        .iter()
        .filter(|(_, t, _)| *t >= least)
        .map(|(f, t, m)| (*f, ratio_db(*m, *t)))
        .collect();
    Ok(LineErrors {
        without_target: lines.len() - compared.len(),
        added: lines
            .iter()
            .filter(|(_, t, _)| *t < least)
            .map(|(.., m)| m)
            .sum(),
        compared,
    })
}

/// Why a measurement cannot be compared with its target.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum VerifyError {
    /// The rates differ.
    #[error(
        "cannot compare: the target is sampled at {target_hz} Hz, the measurement at {measured_hz} Hz; bring both to one rate"
    )]
    Rate {
        /// The target's rate.
        target_hz: f64,
        /// The measurement's rate.
        measured_hz: f64,
    },
    /// The band reaches beyond the signals.
    #[error("cannot compare over {band}: the signals end at {highest}; lower the band's end")]
    BandAboveNyquist {
        /// The band asked for.
        band: Band,
        /// Where the signals end.
        highest: Hertz,
    },
    /// The band falls between two lines.
    #[error(
        "cannot compare over {band}: it holds no line of the spectra, which have one every {resolution_hz:.2} Hz; take a wider band"
    )]
    NoLine {
        /// The band.
        band: Band,
        /// The step between lines, Hz.
        resolution_hz: f64,
    },
    /// Too little in common.
    #[error(
        "expected {expected} samples that target and measurement share, found {found}; check that they belong together"
    )]
    TooShort {
        /// A segment.
        expected: usize,
        /// What they share.
        found: usize,
    },
    /// Nothing there.
    #[error(
        "expected {what} to hold a signal in {band}, found none; check the channel and the band"
    )]
    Silent {
        /// Which of the two.
        what: &'static str,
        /// The band.
        band: Band,
    },
    /// The transfer function does not reach the band.
    #[error(
        "expected a transfer function that says something in {band}, found none; compare over another band, or measure it there"
    )]
    OutOfReach {
        /// The band asked for.
        band: Band,
    },
    /// The spectra cannot be estimated.
    #[error(transparent)]
    Estimate(#[from] EstimateError),
    /// A drive cannot be brought to the rate of the comparison.
    #[error(transparent)]
    Resample(#[from] ResampleError),
    /// What was computed is no signal.
    #[error(transparent)]
    Series(#[from] SeriesError),
    /// A rate or a band that cannot be.
    #[error(transparent)]
    Quantity(#[from] QuantityError),
}

#[cfg(test)]
mod tests;
