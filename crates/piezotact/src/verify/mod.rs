//! Verification of a rendering: how close the re-measured vibration is to its target in spectrum, level and waveform.
//!
//! A power spectrum does not show a wrong phase. A drive computed with the conjugate of the transfer function has the
//! right PSD and a waveform unrelated to the target, so the waveform is always compared too.

mod align;
mod alike;
mod beside;
mod changed;
mod clock;
mod close;
mod config;
mod document;
mod error;
mod events;
mod intended;
mod judge;
mod lines;
mod page;
mod tones;
mod uncompensated;
mod verdict;
mod warning;

use crate::recording::{RecordingWarning, ReversedSign};
#[cfg(test)]
use align::in_band;
pub(crate) use align::{align, in_band_with_edges};
pub use beside::{Beside, DriveBeside, DriveSource, beside, drive_beside};
pub use changed::{Changed, changed};
pub use clock::{Clock, Lost};
pub use close::CLOSE_DB;
pub use config::{Limits, Measured, RenderedBand, VerifyConfig};
pub use document::{
    DemoDocument, FurtherVerification, JudgedVerification, TextureBefore, VerifyDocument,
};
pub use error::VerifyError;
pub(crate) use lines::{errors_in_band, rms_of};
pub use page::{Compared, ShownDrive, open_and_closed};
use serde::Serialize;
pub use tones::{Tones, tones};
pub use uncompensated::{UncompensatedOutcome, UncompensatedPrediction, predict_uncompensated};
pub use verdict::{Verdict, VerifyCriterion};
pub use warning::VerifyWarning;

use crate::criterion::Criterion;
use crate::integrity::{Span, inspect};
use crate::lineage::Mode;
use crate::quantity::{Band, Decibels, Quantity, SampleRate};
use crate::series::Series;
use crate::spectrum::{WelchConfig, WelchPlan, frequency_axis};
use crate::statistics::rms;
use crate::warning::{Warning, Warnings};
use intended::Synchronised;
use judge::{Evidence, Judgement};
use lines::Pair;

/// How close a measurement came to its target.
///
/// The verdict follows from [`criteria`](Self::criteria). They refer to the judged bands and are corrected for the sensor's
/// noise and the scatter of the estimates. The other numbers are uncorrected and refer to all of [`band_hz`](Self::band_hz),
/// except [`error_db_rms_achievable`](Self::error_db_rms_achievable), which refers to the judged bands: the two sets of numbers
/// differ.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Verification {
    /// The band over which they were compared, Hz.
    pub band_hz: Band,
    /// Root mean square over all of the band's lines of the spectrum error as measured, dB; the criterion is [`VerifyCriterion::SpectrumError`].
    pub error_db_rms: f64,
    /// The largest absolute error of a line in the band, dB.
    pub error_db_max: f64,
    /// The frequency of the largest error, Hz.
    pub error_max_at_hz: f64,
    /// The same rms after removing the mean error of the lines: the error of the spectral shape alone, dB.
    pub error_db_rms_level_matched: f64,
    /// The parts of the band that the inverse declared achievable.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub achievable_band_hz: Vec<Band>,
    /// The rms error over the achievable parts, as measured, dB.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error_db_rms_achievable: Option<f64>,
    /// 20·log10 of the measured over the target rms in all of the band, with the sensor's noise, dB; the criterion is [`VerifyCriterion::Level`].
    pub level_error_db: f64,
    /// Pearson's correlation of the waveforms in all of the band, with the sensor's noise, after aligning the delay; the criterion is
    /// [`VerifyCriterion::WaveformCorrelation`].
    pub waveform_correlation: f64,
    /// The power of the difference of those waveforms re that of the target (NMSE), dB; silence would give 0 dB. Over all of the
    /// band, with the sensor's noise; the criterion is [`VerifyCriterion::WaveformError`].
    pub waveform_nmse_db: f64,
    /// How much later the measurement is than the target, s.
    pub delay_s: f64,
    /// The silence on either side of a target that is shorter than two segments, s, which belongs to what is compared.
    #[serde(skip_serializing_if = "is_none")]
    pub silence_s: f64,
    /// The share of samples at a limit, of the sensor or of the device, 0–1.
    pub clipped_fraction: f64,
    /// The level re the target at which it was intentionally rendered, dB.
    pub level_db: f64,
    /// The unit of the PSDs.
    pub psd_unit: String,
    /// The rate at which they were compared, Hz.
    pub rate_hz: f64,
    /// The power of the measurement on lines of the band without target, over the target's in the band.
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
    /// The range of these samples that was compared: the part of the target that the measurement covers.
    #[serde(skip)]
    pub compared: std::ops::Range<usize>,
    /// How the clock of the measurement differs from that of the target, and what was corrected for it.
    pub clock: Clock,
    /// The criteria, each with the value found, its limit and its outcome; the verdict follows from them.
    pub criteria: Vec<Criterion<VerifyCriterion>>,
    /// What is concluded.
    pub verdict: Verdict,
    /// The share of the lines of the band that could not be evaluated: without target, or hidden by the sensor's noise, 0–1.
    #[serde(skip)]
    pub left_out: f64,
    /// The share of the power of the whole texture (about its mean, in the band or not) on the lines that are evaluated, 0–1.
    #[serde(skip)]
    pub texture_share: f64,
    /// The difference that a finger could feel between the whole texture and the measurement, at all frequencies that are felt, JND; absent where nearly all of
    /// the texture is in the band, and where it could not be computed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub whole_texture_jnd: Option<f64>,
    /// The PSD of the texture before the band of its rendering, on the lines of [`Self::target_psd`], unit²/Hz.
    #[serde(skip)]
    pub texture_psd: Vec<f64>,
    /// Whether the waveform is judged, or the spectrum alone.
    pub mode: Mode,
    /// The limits.
    pub limits: Limits,
    /// Whether the drive was played through the transfer function that it was made with: no evidence.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub is_rehearsal: bool,
    /// The levels of target and measurement re the detection threshold, dB; absent where the perceptible difference was not
    /// computed.
    #[serde(skip)]
    pub sensation_db: Option<[f64; 2]>,
    /// What a person should know before relying on it.
    pub warnings: Warnings,
}

/// A waveform whose correlation with its target is below this has the opposite sign.
const INVERTED: f64 = -0.5;

/// Whether `compared` of `all` samples of a target lack a part of it: aligning loses up to 1 % at the ends.
fn is_cut(compared: usize, all: usize) -> bool {
    compared * 100 < all * 99
}

impl Verification {
    /// Whether the measurement follows its target with the opposite sign.
    #[must_use]
    pub fn is_inverted(&self) -> bool {
        self.waveform_correlation < INVERTED
    }

    /// Whether more than 1 % of the target was not measured.
    #[must_use]
    pub fn is_cut(&self) -> bool {
        is_cut(self.compared.len(), self.target.len())
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
                "the reached part ({} bands) of {}",
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

/// The power of a difference re that of the target, dB; a difference of exactly zero gives the smallest value that rounding
/// allows.
pub(crate) fn nmse_db(difference_rms: f64, target_rms: f64) -> f64 {
    20.0 * (difference_rms / target_rms.max(f64::MIN_POSITIVE))
        .max(1e-16)
        .log10()
}

/// A waveform follows its target in time when the magnitude of their correlation exceeds this.
const FOLLOWS: f64 = 0.5;

/// What [`verify`] takes in memory at most beside its two recordings, in bytes for each sample of the longer one.
///
/// Source: measured by `tests/memory.rs`; docs/decisions/verification.md.
pub const MEMORY_BYTES_A_SAMPLE: usize = 260;

/// How close `measured` came to `target`, two series of one quantity at one rate, and whether that is close enough.
///
/// The target is compared as it was intended to be played: mean removed, at its level, within the band of its rendering; a fade of
/// the rendering is a loss. One that is shorter than two segments of its spectrum is compared with the silence around it. Both are limited to
/// the band. The delay is found by cross-correlation to a fraction of a sample and removed, as are clock drift and lost samples
/// where the delay shows them; then the PSDs are compared line by line and the waveforms sample by sample. The verdict follows from [`Verification::criteria`].
///
/// Formulas: `error = 10·log10(S_measured/S_target)`; level = 20·log10 of the rms ratio in the band;
/// correlation = Σtm/√(Σt²·Σm²); NMSE = 10·log10(Σ(m − t)²/Σt²). The criteria use the same with the sensor's noise, as it
/// is before and after the texture, taken away, and 95 % intervals by the jackknife over blocks of time.
///
/// Source: thesis section 4.2 for the comparison of spectra; generalised cross-correlation after Knapp and
/// Carter (1976) for the delay; B. Efron and C. Stein (1981), Ann. Stat. 9(3), for the jackknife; docs/decisions/verification.md.
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
    refuse(target.rate(), measured.response.rate(), config.band)?;
    let rate = target.rate();
    let asked = intended::Asked::of(target.clone().amplified(config.level), config)?;
    let intended = intended::intended_target(&asked, config)?;
    let synchronised = intended::synchronised(&intended, measured.response, config.band)?;
    let aligned = &synchronised.aligned;
    let compared = aligned.from..aligned.to;
    if compared.len() < config.welch.segment {
        return Err(VerifyError::TooShort {
            expected: config.welch.segment,
            found: compared.len(),
        });
    }
    let wanted = &aligned.target_in_band[compared.clone()];
    let got = &aligned.measured_in_band[compared.clone()];
    let waveforms = Waveforms::of(wanted, got);

    let mut plan = WelchPlan::new(&config.welch, rate)?;
    // PSDs of the band-limited signals: content outside the band was not rendered and must not leak in.
    let target_psd = plan.estimate::<Q>(&[wanted])?;
    let measured_psd = plan.estimate::<Q>(&[got])?;
    let lines = errors_in_band(
        &target_psd.values,
        &measured_psd.values,
        target_psd.resolution_hz,
        config.band,
    )?;
    let (error_max_at_hz, largest) = lines.largest().unwrap_or((config.band.low().0, 0.0));

    let full_target = plan.estimate::<Q>(&[&intended.samples()[compared.clone()]])?;
    let full_measured = plan.estimate::<Q>(&[&aligned.measured[compared.clone()]])?;
    let texture_psd = plan.estimate::<Q>(&[&asked.series.samples()[compared.clone()]])?;

    let in_band: f64 = target_psd.values.iter().sum();
    let added_power = lines.added / in_band.max(f64::MIN_POSITIVE);
    let mut warnings: Warnings = target_psd.warnings.iter().cloned().collect();
    warnings.extend(lines.no_target());
    warnings.extend(cut(asked.measured(&compared), target));
    warnings.extend(measured.clipping.warnings.iter().cloned());
    warnings.extend(waveforms.inverted());
    let achievable = config
        .reached
        .iter()
        .filter_map(|band| band.common(config.band));
    let achievable_band_hz: Vec<Band> = achievable.collect();
    let Judgement {
        criteria,
        more,
        left_out,
        texture_share,
    } = judgement(
        &synchronised,
        (&asked, &intended, &texture_psd.values),
        &measured,
        &achievable_band_hz,
        config,
    )?;
    warnings.extend(more);
    let (error_frequency_hz, error_db) = lines.compared.iter().copied().unzip();
    let verdict = Verdict::of(&criteria, config.limits.least_judged);
    let Synchronised { aligned, clock } = synchronised;
    Ok(Verification {
        band_hz: config.band,
        error_db_rms: rms_of(lines.compared.iter().map(|(_, error)| *error)),
        error_db_max: largest.abs(),
        error_max_at_hz,
        error_db_rms_level_matched: lines.level_matched_db(),
        achievable_band_hz,
        error_db_rms_achievable: lines.rms_db_within(&config.reached),
        level_error_db: waveforms.level_error_db,
        waveform_correlation: waveforms.correlation,
        waveform_nmse_db: waveforms.nmse_db,
        delay_s: aligned.delay.0 + rate.duration_of(asked.silence).0,
        silence_s: rate.duration_of(asked.silence).0,
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
        error_frequency_hz,
        error_db,
        target: aligned.target_in_band,
        aligned: aligned.measured_in_band,
        compared,
        clock,
        criteria,
        verdict,
        left_out,
        texture_share,
        whole_texture_jnd: None,
        texture_psd: texture_psd.values,
        mode: config.mode,
        limits: config.limits.clone(),
        is_rehearsal: false,
        sensation_db: None,
        warnings,
    })
}

/// Whether no silence was put around a target.
fn is_none(silence_s: &f64) -> bool {
    *silence_s <= 0.0
}

fn refuse(target: SampleRate, measured: SampleRate, band: Band) -> Result<(), VerifyError> {
    if (measured.hz() - target.hz()).abs() > 1e-9 * target.hz() {
        return Err(VerifyError::Rate {
            target_hz: target.hz(),
            measured_hz: measured.hz(),
        });
    }
    if band.high().0 > target.nyquist().0 {
        return Err(VerifyError::BandAboveNyquist {
            band,
            highest: target.nyquist(),
        });
    }
    Ok(())
}

/// The warning that only `compared` samples of `target` were measured.
fn cut<Q: Quantity>(compared: usize, target: &Series<Q>) -> Option<Warning> {
    is_cut(compared, target.samples().len()).then(|| {
        Warning::from(VerifyWarning::Cut {
            compared_s: target.rate().duration_of(compared).0,
            target_s: target.duration().0,
        })
    })
}

/// How the aligned waveforms of the band differ.
struct Waveforms {
    level_error_db: f64,
    correlation: f64,
    nmse_db: f64,
}

impl Waveforms {
    fn of(wanted: &[f64], got: &[f64]) -> Self {
        let (level_target, level_measured) = (rms(wanted), rms(got));
        let product: f64 = wanted.iter().zip(got).map(|(t, m)| t * m).sum();
        let missed: Vec<f64> = wanted.iter().zip(got).map(|(t, m)| m - t).collect();
        Self {
            level_error_db: Decibels::from_amplitude_ratio(level_measured / level_target).0,
            correlation: product / (wanted.len() as f64 * level_target * level_measured),
            nmse_db: nmse_db(rms(&missed), level_target),
        }
    }

    fn inverted(&self) -> Option<Warning> {
        (self.correlation < INVERTED).then(|| {
            Warning::from(RecordingWarning::Sign {
                of: ReversedSign::Measurement {
                    correlation: self.correlation,
                },
            })
        })
    }
}

/// The criteria for a measurement of the `intended` target, which was `asked` for, with the PSD `asked_psd`, before the band of its rendering.
fn judgement<Q: Quantity>(
    Synchronised { aligned, clock }: &Synchronised,
    (asked, intended, asked_psd): (&intended::Asked<Q>, &Series<Q>, &[f64]),
    measured: &Measured<'_, Q>,
    achievable: &[Band],
    config: &VerifyConfig,
) -> Result<Judgement, VerifyError> {
    let (rate, response) = (intended.rate(), measured.response);
    let compared = aligned.from..aligned.to;
    let whole = [config.band];
    let judged = if config.reached.is_empty() {
        &whole
    } else {
        achievable
    };
    let floor = intended::floor(intended, response, aligned, config.band);
    let waveforms = intended::judged_waveforms(aligned, judged, rate, config.band);
    Ok(judge::judge(&Evidence {
        pair: &Pair::of(
            &aligned.target_in_band[compared.clone()],
            &aligned.measured_in_band[compared.clone()],
            &config.welch,
            rate,
        )?,
        asked_psd,
        outside: &Pair::of(
            &intended.samples()[compared.clone()],
            &aligned.measured[compared.clone()],
            &config.welch,
            rate,
        )?,
        waveforms: [
            &waveforms[0][compared.clone()],
            &waveforms[1][compared.clone()],
        ],
        floor: floor.as_ref(),
        judged,
        covered: asked.measured(&compared) as f64 / asked.target as f64,
        clipped: measured.clipping.fraction,
        clipped_drive: measured.clipping.of_the_drive,
        frozen_s: frozen(response, aligned),
        bridged_s: bridged(response, aligned),
        silence_s: rate.duration_of(asked.silence).0,
        clock,
        felt: Q::UNIT == crate::quantity::Unit::MetrePerSecondSquared,
        rate,
        config,
    }))
}

/// The longest part of what is compared in which the sensor of `response` froze, s.
fn frozen<Q: Quantity>(response: &Series<Q>, aligned: &align::Aligned) -> Option<f64> {
    let defects = inspect(response);
    let later = (aligned.delay.0 * response.rate().hz()).round().max(0.0) as usize;
    let (from, to) = (aligned.from + later, aligned.to + later);
    let within = |span: &Span| span.to.min(to).saturating_sub(span.from.max(from));
    let longest = defects.frozen.iter().map(within).max()?;
    Some(response.rate().duration_of(longest).0)
}

/// From this many samples and this duration (s) on, a straight line is not a vibration.
const STRAIGHT: (usize, f64) = (12, 0.0025);
/// The tolerance for rounding, re the peak.
const ROUNDED: f64 = 1e-11;

/// The longest straight line in the compared part of `response`, s: lost samples are replaced by straight lines. A constant
/// value does not count.
fn bridged<Q: Quantity>(response: &Series<Q>, aligned: &align::Aligned) -> f64 {
    let rate = response.rate();
    let later = (aligned.delay.0 * rate.hz()).round() as i64;
    let all = response.samples();
    let place = |at: usize| (at as i64 + later).clamp(0, all.len() as i64) as usize;
    let samples = &all[place(aligned.from)..place(aligned.to)];
    let rounded = ROUNDED * crate::statistics::peak(all);
    let (mut longest, mut run) = (0, 0);
    for three in samples.windows(3) {
        let straight = (three[2] - 2.0 * three[1] + three[0]).abs() <= rounded;
        let slopes = (three[2] - three[1]).abs() > 10.0 * rounded;
        run = if straight && slopes { run + 1 } else { 0 };
        longest = longest.max(run);
    }
    let lost_s = rate.duration_of(longest).0;
    if longest >= STRAIGHT.0 && lost_s >= STRAIGHT.1 {
        lost_s
    } else {
        0.0
    }
}

#[cfg(test)]
mod alike_tests;
#[cfg(test)]
mod drop_out_tests;
#[cfg(test)]
mod short_tests;
#[cfg(test)]
mod tests;
#[cfg(test)]
mod verdict_tests;
