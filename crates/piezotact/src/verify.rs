//! How close the re-measured vibration came to its target: in spectrum, in level, and in waveform.
//!
//! A spectrum cannot see a wrong phase. A drive made with the conjugate of the transfer function has the
//! right PSD and no resemblance to the target, so the waveform is always looked at too.

use std::f64::consts::TAU;

use num_complex::Complex;
use serde::{Deserialize, Serialize};

use crate::doubt::Doubt;
use crate::fourier;
use crate::quantity::{Band, Decibels, Drive, Hertz, Quantity, Seconds};
use crate::render::Headroom;
use crate::series::{Series, mean, rms};
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
    /// What counts as passed.
    pub limits: Limits,
}

/// What counts as passed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Limits {
    /// The largest spectrum error, dB rms over the band.
    pub error_db_rms: f64,
    /// The lowest waveform correlation.
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

/// How much of a measurement stood at a limit.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Clipping {
    /// The largest of the shares found, 0–1.
    pub fraction: f64,
    /// One for each place where something clipped.
    pub doubts: Vec<Doubt>,
}

/// What clipped while `response` was measured, at the rate it was acquired with: the sensor (flat tops), the
/// drive that was played beside it (beyond the limit, full scale = 1), and the drive as it was rendered.
///
/// Source: [`flat_top_fraction`]; [`crate::render::headroom`].
#[must_use]
pub fn clipping<Q: Quantity>(
    response: &Series<Q>,
    drive: Option<(&Series<Drive>, f64)>,
    rendered: Option<&Headroom>,
) -> Clipping {
    let played = drive.map_or(0.0, |(drive, limit)| {
        let beyond = drive
            .samples()
            .iter()
            .filter(|sample| sample.abs() > limit)
            .count();
        beyond as f64 / drive.samples().len() as f64
    });
    let device = rendered
        .map_or(0.0, |headroom| headroom.clipped_fraction)
        .max(played);
    let sensor = flat_top_fraction(response.samples());
    let found = [
        (sensor, format!("the measured {}", Q::NAME)),
        (device, "the drive that was played".into()),
    ];
    Clipping {
        fraction: sensor.max(device),
        doubts: found
            .into_iter()
            .filter(|(fraction, _)| *fraction > 0.0)
            .map(|(fraction, what)| Doubt::Clipped { what, fraction })
            .collect(),
    }
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
    /// The target at its level, in its unit.
    #[serde(skip)]
    pub target: Vec<f64>,
    /// The measurement at the target's times, in its unit.
    #[serde(skip)]
    pub aligned: Vec<f64>,
    /// Whether it is within the limits.
    pub passed: bool,
    /// The limits.
    pub limits: Limits,
    /// What a person should know before relying on it.
    pub doubts: Vec<Doubt>,
}

impl Verification {
    /// One line that says whether it passed and why.
    #[must_use]
    pub fn verdict(&self) -> String {
        let clipped = if self.clipped_fraction > self.limits.clipped_fraction {
            format!(
                ", {:.1} % of samples at a limit (limit {} %)",
                self.clipped_fraction * 100.0,
                self.limits.clipped_fraction * 100.0
            )
        } else {
            String::new()
        };
        let level = if self.level_db == 0.0 {
            String::new()
        } else {
            format!(", rendered at {:+.1} dB", self.level_db)
        };
        format!(
            "{}: spectrum error {:.2} dB rms over {} (limit {} dB), waveform correlation {:.3} (limit {}){clipped}{level}",
            if self.passed { "passed" } else { "failed" },
            self.judged_error_db(),
            self.judged_band(),
            self.limits.error_db_rms,
            self.waveform_correlation,
            self.limits.waveform_correlation,
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

    fn judged_error_db(&self) -> f64 {
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

/// Lines this far below the band's strongest hold next to no target, dB: below them lies the noise of sensors.
const NO_POWER_DB: f64 = -50.0;

/// How close `measured` came to `target`, two series of one quantity at one rate.
///
/// Both are limited to the band. The delay is found by cross-correlation, to a fraction of a sample, and
/// taken away; then the PSDs are compared line by line and the waveforms correlated.
///
/// Formulas: `error = 10·log10(S_measured/S_target)`; level = 20·log10 of the rms ratio in the band;
/// correlation = Σtm/√(Σt²·Σm²).
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
    let aligned = align(target, response, config)?;
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

    let mut doubts = target_psd.doubts.clone();
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
    if compared.len() + 1 < target.samples().len() {
        doubts.push(Doubt::Cut {
            compared_s: rate.duration_of(compared.len()).0,
            target_s: target.duration().0,
        });
    }
    doubts.extend(measured.clipping.doubts);
    if waveform_correlation < 0.0 {
        doubts.push(Doubt::Inverted {
            correlation: waveform_correlation,
        });
    }
    let error_db_rms_achievable = (!reached.is_empty()).then(|| rms_of(reached.iter().copied()));
    let passed = error_db_rms_achievable.unwrap_or(error_db_rms) <= config.limits.error_db_rms
        && waveform_correlation >= config.limits.waveform_correlation
        && measured.clipping.fraction <= config.limits.clipped_fraction;
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
        delay_s: aligned.delay.0,
        clipped_fraction: measured.clipping.fraction,
        level_db: config.level.0,
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
        target: target.samples().to_vec(),
        aligned: aligned.measured,
        passed,
        limits: config.limits.clone(),
        doubts,
    })
}

fn rms_of(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0usize), |(sum, count), value| {
        (sum + value * value, count + 1)
    });
    (sum / count.max(1) as f64).sqrt()
}

struct LineErrors {
    /// Frequency in Hz and error in dB of every line with target power.
    compared: Vec<(f64, f64)>,
    without_target: usize,
}

fn errors_in_band(
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
        compared,
    })
}

/// A measurement brought onto its target's time.
struct Aligned {
    /// How much later the measurement is.
    delay: Seconds,
    /// The measurement at the target's times, one sample for each of the target's.
    measured: Vec<f64>,
    measured_in_band: Vec<f64>,
    target_in_band: Vec<f64>,
    /// The part of the target that the measurement covers.
    from: usize,
    to: usize,
}

/// The widest edge of the band-pass that the waveforms go through before they are compared.
const EDGE_RATIO: f64 = 0.1;

fn align<Q: Quantity>(
    target: &Series<Q>,
    measured: &Series<Q>,
    config: &VerifyConfig,
) -> Result<Aligned, VerifyError> {
    let (t, m) = (target.samples(), measured.samples());
    let n = fourier::fast_length(t.len() + m.len());
    let mut transform = fourier::RealTransform::new(n);
    let rate_hz = target.rate().hz();
    let weights: Vec<f64> = (0..=n / 2)
        .map(|k| {
            config
                .band
                .weight(k as f64 * rate_hz / n as f64, EDGE_RATIO)
        })
        .collect();
    // A mean would be a step at both ends of the padding, and a step is in every band.
    let about_mean = |samples: &[f64]| -> Vec<f64> {
        let mean = mean(samples);
        samples.iter().map(|sample| sample - mean).collect()
    };
    let (target_bins, measured_bins) = (
        transform.forward(&about_mean(t)),
        transform.forward(&about_mean(m)),
    );
    for (what, bins) in [
        ("the target", &target_bins),
        ("the measurement", &measured_bins),
    ] {
        let power: f64 = bins
            .iter()
            .zip(&weights)
            .map(|(bin, w)| bin.norm_sqr() * w)
            .sum();
        if power <= 0.0 {
            return Err(VerifyError::Silent {
                what,
                band: config.band,
            });
        }
    }
    let cross: Vec<Complex<f64>> = target_bins
        .iter()
        .zip(&measured_bins)
        .zip(&weights)
        .map(|((t, m), w)| t.conj() * m * w * w)
        .collect();
    // Four times finer than the samples: the crest of a tone between two samples must not lose against the
    // trough beside it.
    let fine = 4 * n;
    let correlation = fourier::RealTransform::new(fine).inverse(cross.clone());
    let highest = (0..fine)
        .max_by(|&a, &b| correlation[a].total_cmp(&correlation[b]))
        .unwrap_or(0);
    let deepest = (0..fine)
        .min_by(|&a, &b| correlation[a].total_cmp(&correlation[b]))
        .unwrap_or(0);
    // A tone has a trough as deep as its crest half a period away: only a clearly deeper one is an inversion.
    let inverted = -correlation[deepest] > 1.05 * correlation[highest];
    let strongest = if inverted { deepest } else { highest };
    let place = strongest as f64 / 4.0;
    let whole = if place > m.len() as f64 {
        place - n as f64
    } else {
        place
    };
    // The correlation between samples is a sum of cosines; its extreme is within a quarter of a sample.
    let sign = if inverted { -1.0 } else { 1.0 };
    let at = |lag: f64| {
        cross
            .iter()
            .enumerate()
            .filter(|(_, bin)| bin.norm_sqr() > 0.0)
            .map(|(k, bin)| (bin * Complex::from_polar(1.0, TAU * k as f64 * lag / n as f64)).re)
            .sum::<f64>()
            * sign
    };
    let lag = golden_section_maximum(at, whole - 0.25, whole + 0.25);
    let mut shifted = |in_band: bool| {
        let bins = measured_bins
            .iter()
            .zip(&weights)
            .enumerate()
            .map(|(k, (bin, w))| {
                let turned = bin * Complex::from_polar(1.0, TAU * k as f64 * lag / n as f64);
                if in_band { turned * w } else { turned }
            });
        let mut samples = transform.inverse(bins.collect());
        samples.truncate(t.len());
        samples
    };
    let (measured, measured_in_band) = (shifted(false), shifted(true));
    let mut target_in_band = transform.inverse(
        target_bins
            .iter()
            .zip(&weights)
            .map(|(bin, w)| bin * w)
            .collect(),
    );
    target_in_band.truncate(t.len());
    let from = (-lag).ceil().max(0.0) as usize;
    let to = (m.len() as f64 - lag).floor().clamp(0.0, t.len() as f64) as usize;
    Ok(Aligned {
        delay: Seconds(lag / rate_hz),
        measured,
        measured_in_band,
        target_in_band,
        from: from.min(to),
        to,
    })
}

/// Where `f` is largest between `low` and `high`, to 1e-4 of a sample.
fn golden_section_maximum(f: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    let golden = (5f64.sqrt() - 1.0) / 2.0;
    let (mut a, mut b) = (high - golden * (high - low), low + golden * (high - low));
    let (mut fa, mut fb) = (f(a), f(b));
    while high - low > 1e-4 {
        if fa > fb {
            (high, b, fb) = (b, a, fa);
            a = high - golden * (high - low);
            fa = f(a);
        } else {
            (low, a, fa) = (a, b, fb);
            b = low + golden * (high - low);
            fb = f(b);
        }
    }
    0.5 * (low + high)
}

/// The share of samples that stand in runs of three or more at the same extreme value, as a clipping sensor
/// leaves them, 0–1. Fewer than three such runs are the crests of a slow or coarsely quantised signal: 0.
///
/// Source: three equal neighbours at the extreme do not happen again and again unless something limits.
#[must_use]
pub fn flat_top_fraction(samples: &[f64]) -> f64 {
    let (low, high) = samples.iter().fold((f64::MAX, f64::MIN), |(low, high), v| {
        (low.min(*v), high.max(*v))
    });
    if low >= high {
        return 0.0;
    }
    let (runs, at_limit) = samples
        .chunk_by(|a, b| a == b)
        .filter(|run| run.len() >= 3 && (run[0] <= low || run[0] >= high))
        .fold((0, 0), |(runs, at_limit), run| {
            (runs + 1, at_limit + run.len())
        });
    if runs < 3 {
        0.0
    } else {
        at_limit as f64 / samples.len() as f64
    }
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
    /// The spectra cannot be estimated.
    #[error(transparent)]
    Estimate(#[from] EstimateError),
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantity::{Acceleration, SampleRate};

    const RATE_HZ: f64 = 5000.0;

    fn series(samples: Vec<f64>) -> Series<Acceleration> {
        Series::new(samples, SampleRate::new(RATE_HZ).unwrap()).unwrap()
    }

    /// A sum of tones inside the band, later by `delay_s`, so that any delay is exact.
    fn tones(
        frequencies_hz: &[f64],
        samples: usize,
        delay_s: f64,
        gain: f64,
    ) -> Series<Acceleration> {
        let at = |i: usize| {
            let t_s = i as f64 / RATE_HZ - delay_s;
            frequencies_hz
                .iter()
                .enumerate()
                .map(|(j, f)| (TAU * f * t_s + j as f64).sin())
                .sum::<f64>()
                * gain
        };
        series((0..samples).map(at).collect())
    }

    fn texture(samples: usize, delay_s: f64, gain: f64) -> Series<Acceleration> {
        let frequencies_hz: Vec<f64> = (0..160).map(|j| 31.0 + 2.93 * f64::from(j)).collect();
        tones(&frequencies_hz, samples, delay_s, gain)
    }

    fn judged(target: &Series<Acceleration>, measured: &Series<Acceleration>) -> Verification {
        let config = VerifyConfig::over(Band::new(Hertz(30.0), Hertz(500.0)).unwrap(), RATE_HZ);
        verify(target, Measured::alone(measured), &config).unwrap()
    }

    #[test]
    fn delays_are_found_to_a_fraction_of_a_sample_either_way() {
        for delay_s in [0.0, 0.01234, 0.00005, -0.00777] {
            let v = judged(&texture(20_000, 0.0, 1.0), &texture(20_000, delay_s, 1.0));
            assert!(
                (v.delay_s - delay_s).abs() < 2e-6,
                "{delay_s}: {}",
                v.delay_s
            );
            // A measurement that starts or ends elsewhere lacks a part: what is shared is the same.
            assert!(
                v.passed && v.waveform_correlation > 0.999,
                "{delay_s}: {}",
                v.verdict()
            );
        }
    }

    #[test]
    fn a_level_is_a_level_and_not_a_shape() {
        let v = judged(&texture(20_000, 0.0, 1.0), &texture(20_000, 0.0, 2.0));
        let doubled_db = 20.0 * 2f64.log10();
        assert!((v.level_error_db - doubled_db).abs() < 1e-9);
        assert!((v.error_db_rms - doubled_db).abs() < 1e-9 && v.error_db_rms_level_matched < 1e-9);
        assert!(!v.passed && (v.waveform_correlation - 1.0).abs() < 1e-9);
    }

    /// Half a sample late, a tone has a trough on a sample beside its crest between two.
    #[test]
    fn a_tone_between_samples_is_not_taken_for_its_inverse() {
        for frequency_hz in [330.0, 440.0, 499.0] {
            let v = judged(
                &tones(&[frequency_hz], 20_000, 0.0, 1.0),
                &tones(&[frequency_hz], 20_000, 0.5 / RATE_HZ, 1.0),
            );
            assert!(
                v.waveform_correlation > 0.99,
                "{frequency_hz}: {}",
                v.verdict()
            );
        }
    }

    #[test]
    fn a_reversed_sign_is_said() {
        let v = judged(&texture(20_000, 0.0, 1.0), &texture(20_000, 0.004, -1.0));
        assert!(v.waveform_correlation < -0.99 && !v.passed);
        assert!(
            v.doubts
                .iter()
                .any(|doubt| matches!(doubt, Doubt::Inverted { .. }))
        );
    }

    #[test]
    fn a_measurement_that_ends_early_is_cut_and_said() {
        let v = judged(&texture(20_000, 0.0, 1.0), &texture(12_000, 0.0, 1.0));
        assert!(
            v.doubts
                .iter()
                .any(|doubt| matches!(doubt, Doubt::Cut { .. })),
            "{:?}",
            v.doubts
        );
        assert!(v.waveform_correlation > 0.99);
    }

    #[test]
    fn flat_tops_are_counted_and_crests_are_not() {
        let sine: Vec<f64> = (0..5000)
            .map(|i| (TAU * 7.3 * f64::from(i) / 5000.0).sin())
            .collect();
        assert_eq!(flat_top_fraction(&sine), 0.0);
        let clipped: Vec<f64> = sine.iter().map(|v| v.clamp(-0.8, 0.8)).collect();
        let share = clipped.iter().filter(|v| v.abs() >= 0.8).count() as f64 / 5000.0;
        assert!((flat_top_fraction(&clipped) - share).abs() < 1e-12);
        assert_eq!(flat_top_fraction(&[0.0; 10]), 0.0);
    }
}
