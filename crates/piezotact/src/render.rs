//! From a texture to the drive that makes a resting finger feel it.
//!
//! The target's spectrum is divided by the transfer function of the device with the finger on it, inside a
//! band and no further than the device answers; the drive says which part of the band it gave up, and how
//! far it stays below what the device can do.

use std::f64::consts::PI;

use num_complex::Complex;
use serde::{Deserialize, Serialize};

use crate::device::{AmplifierGain, DriveSetup};
use crate::doubt::Doubt;
use crate::fourier;
use crate::quantity::{Band, Decibels, Drive, Hertz, Quantity, SampleRate, Seconds};
use crate::recording::{Condition, Provenance};
use crate::resample::{ResampleError, Resampler};
use crate::series::{Series, SeriesError, mean, peak, rms};
use crate::transfer::{COHERENCE_ROUNDING, TransferFunction};

/// How a transfer function is inverted.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct InverseConfig {
    /// The band that is rendered.
    pub band: Band,
    /// The width of the raised-cosine edges outside the band, as a ratio of its ends.
    pub edge_ratio: f64,
    /// The regularisation ε, relative to the largest |H|² *in the band*. (Relative to all lines it would
    /// follow H1's noise above the excitation, and nothing of the target would be left.)
    pub regularisation: f64,
}

impl InverseConfig {
    /// Edges of 10 % and ε = 9e-6, that is −50 dB re the band's largest |H|: a device that answers 40 dB
    /// more weakly at one frequency than at another is still inverted there to 0.8 dB.
    #[must_use]
    pub fn over(band: Band) -> Self {
        Self {
            band,
            edge_ratio: 0.1,
            regularisation: 9e-6,
        }
    }
}

/// What to do with a drive that the device cannot play.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Clipping {
    /// Refuse, and say at which level it would fit.
    Refuse,
    /// Let it clip, and say how much of it does.
    Allow,
}

/// How a target is rendered.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RenderConfig {
    /// How the transfer function is inverted.
    pub inverse: InverseConfig,
    /// Silence before the texture, into which the inverse's early part falls.
    pub modelling_delay: Seconds,
    /// Silence after the texture, for the inverse's late part.
    pub tail: Seconds,
    /// The raised-cosine fade at both ends of the texture.
    pub fade: Seconds,
    /// The rate of the drive.
    pub output_rate: SampleRate,
    /// A line is achievable when regularisation takes no more than this from it.
    pub largest_loss: Decibels,
    /// A line is achievable when its coherence is at least this.
    pub lowest_coherence: f64,
    /// What to do with a drive that does not fit.
    pub clipping: Clipping,
}

impl RenderConfig {
    /// For the PIEZOTACT and its like: 0.25 s of silence before and after, 20 ms fades, 48 kHz; a line is
    /// achievable within 0.5 dB and with a coherence of 0.8 or more; a drive that would clip is refused.
    #[must_use]
    pub fn over(band: Band, output_rate: SampleRate) -> Self {
        Self {
            inverse: InverseConfig::over(band),
            modelling_delay: Seconds(0.25),
            tail: Seconds(0.25),
            fade: Seconds(0.02),
            output_rate,
            largest_loss: Decibels(0.5),
            lowest_coherence: 0.8,
            clipping: Clipping::Refuse,
        }
    }
}

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

/// A drive ready to be played, with what it was made from and what it leaves open.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderedDrive {
    /// The drive, full scale = 1, at the output rate.
    pub drive: Series<Drive>,
    /// The device it is for; absent when the transfer function did not say.
    pub setup: Option<DriveSetup>,
    /// Whose finger it is for.
    pub condition: Condition,
    /// How it was made.
    pub config: RenderConfig,
    /// How much of the device it uses.
    pub headroom: Headroom,
    /// The parts of the band that the inverse reaches.
    pub achievable: Vec<Band>,
    /// The parts it gives up.
    pub given_up: Vec<Band>,
    /// Where it comes from.
    pub provenance: Provenance,
    /// What a person should know before relying on it.
    pub doubts: Vec<Doubt>,
}

/// The inversion of targets of one length, planned once.
#[derive(Clone, Debug)]
pub struct InversePlan {
    transform: fourier::RealTransform,
    lines: Vec<(usize, f64, Complex<f64>)>,
}

impl InversePlan {
    /// A plan for targets of `samples` samples.
    #[must_use]
    pub fn new(samples: usize) -> Self {
        Self {
            transform: fourier::RealTransform::new(samples),
            lines: Vec::new(),
        }
    }

    /// The drive whose response is `target`; see [`invert`].
    ///
    /// # Errors
    /// Those of [`invert`]; [`RenderError::Length`] when the target has another length than the plan.
    pub fn invert<I: Quantity, O: Quantity>(
        &mut self,
        target: &[f64],
        rate: SampleRate,
        function: &TransferFunction<I, O>,
        config: &InverseConfig,
    ) -> Result<Vec<f64>, RenderError> {
        let n = self.transform.length();
        if target.len() != n {
            return Err(RenderError::Length {
                expected: n,
                found: target.len(),
            });
        }
        require_band(config.band, rate.nyquist(), "the target's rate")?;
        require_band(
            config.band,
            Hertz(function.highest_hz()),
            "the transfer function",
        )?;
        if !(config.regularisation.is_finite() && config.regularisation >= 0.0) {
            return Err(RenderError::Regularisation {
                found: config.regularisation,
            });
        }
        let spectrum = self.transform.forward(target);
        // The lines that count: index, weight, and the transfer function there.
        self.lines.clear();
        self.lines.extend((0..spectrum.len()).filter_map(|k| {
            let frequency_hz = k as f64 * rate.hz() / n as f64;
            let weight = config.band.weight(frequency_hz, config.edge_ratio);
            (weight > 0.0).then(|| (k, weight, function.at(frequency_hz)))
        }));
        let in_band = self.lines.iter().filter(|(_, weight, _)| *weight > 0.5);
        let largest = in_band.map(|(.., h)| h.norm_sqr()).fold(0.0, f64::max);
        if largest <= 0.0 {
            return Err(RenderError::NoResponse { band: config.band });
        }
        let floor = config.regularisation * largest;
        let mut drive = vec![Complex::default(); spectrum.len()];
        for (k, weight, h) in &self.lines {
            drive[*k] = spectrum[*k] * h.conj() * (weight / (h.norm_sqr() + floor));
        }
        Ok(self.transform.inverse(drive))
    }
}

/// The drive whose response is `target`, as long as the target and circular: what leaves one end comes in at
/// the other. Samples of `O` at `rate` become samples of `I`.
///
/// Formula: `irfft(FIV · conj(H)/(|H|² + ε·max_band|H|²) · W)`, H interpolated linearly in its real and
/// imaginary part, W the band with raised-cosine edges.
///
/// Source: the thesis' eq. 16–17, regularised as in Kirkeby and Nelson (1999), JAES 47(7/8).
///
/// # Errors
/// [`RenderError::BandAboveNyquist`], [`RenderError::Regularisation`], [`RenderError::NoResponse`].
pub fn invert<I: Quantity, O: Quantity>(
    target: &[f64],
    rate: SampleRate,
    function: &TransferFunction<I, O>,
    config: &InverseConfig,
) -> Result<Vec<f64>, RenderError> {
    InversePlan::new(target.len()).invert(target, rate, function, config)
}

fn require_band(band: Band, highest: Hertz, what: &'static str) -> Result<(), RenderError> {
    if band.high().0 > highest.0 * (1.0 + 1e-9) {
        return Err(RenderError::BandAboveNyquist {
            band,
            what,
            highest,
        });
    }
    Ok(())
}

/// The drive (full scale = 1) that makes the device answer with `target`, in the SI unit of `O`.
///
/// The target, its mean taken away, is faded at both ends, put between `modelling_delay` and `tail` of silence, divided by the
/// transfer function inside the band, and brought to the output rate.
///
/// Source: thesis sections 4.1 and 2.5; see [`invert`] for the formula.
///
/// # Errors
/// Those of [`invert`]; [`RenderError::Rate`] when the band does not fit the output rate;
/// [`RenderError::ExceedsFullScale`] when the drive does not fit the device and clipping is refused.
pub fn render<O: Quantity>(
    target: &Series<O>,
    function: &TransferFunction<Drive, O>,
    config: &RenderConfig,
) -> Result<RenderedDrive, RenderError> {
    let rate = target.rate();
    let (before, after) = (
        rate.samples_in(config.modelling_delay),
        rate.samples_in(config.tail),
    );
    let mut padded = vec![0.0; fourier::fast_length(before + target.samples().len() + after)];
    let texture = &mut padded[before..before + target.samples().len()];
    // A mean (gravity, an offset of the amplifier) is no texture; faded, it would become a ramp that is one.
    let mean = mean(target.samples());
    for (place, sample) in texture.iter_mut().zip(target.samples()) {
        *place = sample - mean;
    }
    if peak(texture) <= 0.0 {
        return Err(RenderError::Silent);
    }
    fade_ends(texture, rate.samples_in(config.fade));
    let mut drive = invert(&padded, rate, function, &config.inverse)?;
    drive.truncate(before + target.samples().len() + after);
    fade_ends(
        &mut drive,
        rate.samples_in(config.fade).min(before).min(after),
    );

    let band = config.inverse.band;
    let passband =
        Hertz((band.high().0 * (1.0 + config.inverse.edge_ratio)).min(0.995 * rate.nyquist().0));
    let mut samples = if rate == config.output_rate {
        drive
    } else {
        Resampler::new(rate, config.output_rate, passband)?.process(&drive)
    };

    let mut doubts: Vec<Doubt> = function
        .low_coherence(band, config.lowest_coherence)
        .into_iter()
        .collect();
    doubts.extend(function.not_driven(band));
    // What was doubted of the transfer function is doubted of all that comes of it.
    doubts.extend(
        function
            .doubts
            .iter()
            .filter(|doubt| !matches!(doubt, Doubt::LowCoherence { .. } | Doubt::NotDriven { .. }))
            .cloned(),
    );
    if (function.rate.hz() - rate.hz()).abs() > 1e-9 {
        doubts.push(Doubt::RatesDiffer {
            target_hz: rate.hz(),
            transfer_hz: function.rate.hz(),
        });
    }
    if function.drive.is_none() {
        doubts.push(Doubt::DeviceNotDescribed);
    }
    let (achievable, given_up, share) = achievable(function, config)?;
    if !given_up.is_empty() {
        doubts.push(Doubt::GivenUp {
            bands: given_up.clone(),
            share,
        });
    }
    let headroom = headroom(&samples, config.output_rate, function.drive.as_ref());
    if headroom.peak > headroom.limit {
        match config.clipping {
            Clipping::Refuse => {
                return Err(RenderError::ExceedsFullScale {
                    peak: headroom.peak,
                    limit: headroom.limit,
                    limited_by: headroom.limited_by,
                    fits_at: Decibels((headroom.headroom_db * 10.0).floor() / 10.0),
                });
            }
            Clipping::Allow => {
                for sample in &mut samples {
                    *sample = sample.clamp(-1.0, 1.0);
                }
                doubts.push(Doubt::Clipped {
                    what: format!("the drive ({})", headroom.limited_by),
                    fraction: headroom.clipped_fraction,
                });
            }
        }
    }
    if let (Some(setup), Some(asked)) = (&function.drive, headroom.slope_v_per_s) {
        let limit = setup.slew_limit_v_per_s();
        if asked > limit {
            doubts.push(Doubt::SlewLimited {
                asked_v_per_s: asked,
                limit_v_per_s: limit,
            });
        }
    }
    Ok(RenderedDrive {
        drive: Series::new(samples, config.output_rate)?,
        setup: function.drive.clone(),
        condition: function.condition.clone(),
        config: config.clone(),
        headroom,
        achievable,
        given_up,
        provenance: function.provenance.clone().then(format!(
            "rendered over {band}, regularisation {:.1e} of the band's largest |H|², modelling delay {}",
            config.inverse.regularisation, config.modelling_delay
        )),
        doubts,
    })
}

/// The negative control: the target's samples sent as the drive as they stand, one unit of `O` as full scale,
/// clamped to what a file can hold. What comes of it is the target times the transfer function.
///
/// Source: thesis figures 41–42, "wrong rendering strategy".
///
/// # Errors
/// [`RenderError::Rate`] when the target cannot be brought to the output rate.
pub fn straight<O: Quantity>(
    target: &Series<O>,
    output_rate: SampleRate,
) -> Result<Series<Drive>, RenderError> {
    let samples = crate::resample::resample(target, output_rate)?.into_samples();
    Ok(Series::new(
        samples
            .into_iter()
            .map(|sample| sample.clamp(-1.0, 1.0))
            .collect(),
        output_rate,
    )?)
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

/// Refuses a transfer function that was measured with another gain than the one the drive is for. One that does
/// not say its gain passes here; rendering doubts it.
///
/// Source: a transfer function holds for one amplifier gain (thesis 2.4, 2.5.3).
///
/// # Errors
/// [`RenderError::ConditionMismatch`] naming both gains.
pub fn require_gain(
    setup: Option<&DriveSetup>,
    requested: AmplifierGain,
) -> Result<(), RenderError> {
    match setup {
        Some(setup) if setup.gain != requested => Err(RenderError::ConditionMismatch {
            what: "gain",
            measured: setup.gain.to_string(),
            requested: requested.to_string(),
        }),
        _ => Ok(()),
    }
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

/// The parts of the band that the inverse reaches, those it gives up, and the share of lines given up.
///
/// A line is achievable when |H|²/(|H|² + ε·max|H|²) loses no more than `largest_loss` and the coherence is
/// at least `lowest_coherence`.
///
/// Source: the delivered-to-target ratio H·Z/FIV of the inverse in [`invert`].
///
/// # Errors
/// [`RenderError::NoResponse`] when the transfer function has no line in the band, or not one is achievable.
pub fn achievable<I: Quantity, O: Quantity>(
    function: &TransferFunction<I, O>,
    config: &RenderConfig,
) -> Result<(Vec<Band>, Vec<Band>, f64), RenderError> {
    let band = config.inverse.band;
    let largest = function.peak_magnitude(band);
    let floor = config.inverse.regularisation * largest * largest;
    let least = Decibels(-config.largest_loss.0).amplitude_ratio();
    // A coherence above 1 is no better than none.
    let believable = config.lowest_coherence..=1.0 + COHERENCE_ROUNDING;
    let driven = |hz: f64| function.driven.is_none_or(|driven| driven.contains(hz));
    if function.lines_in(band).next().is_none() {
        return Err(RenderError::NoLine {
            band,
            resolution_hz: function.resolution_hz(),
        });
    }
    let reached: Vec<(f64, bool)> = function
        .lines_in(band)
        .map(|(k, frequency_hz)| {
            let power = function.response()[k].norm_sqr();
            let delivered = power / (power + floor);
            (
                frequency_hz,
                delivered >= least
                    && driven(frequency_hz)
                    && believable.contains(&function.coherence()[k]),
            )
        })
        .collect();
    let lost = reached.iter().filter(|(_, reached)| !reached).count();
    if lost == reached.len() {
        return Err(RenderError::NoResponse { band });
    }
    let half = function.resolution_hz() / 2.0;
    let bands = |wanted: bool| {
        let mut bands: Vec<Band> = Vec::new();
        for run in reached
            .chunk_by(|a, b| a.1 == b.1)
            .filter(|run| run[0].1 == wanted)
        {
            // The outermost lines stand for the rest of the band up to its ends.
            let (first, last) = (run[0].0, run[run.len() - 1].0);
            let low = if first - reached[0].0 <= 0.0 {
                band.low().0
            } else {
                first - half
            };
            let high = if reached[reached.len() - 1].0 - last <= 0.0 {
                band.high().0
            } else {
                last + half
            };
            bands.extend(Band::new(Hertz(low), Hertz(high)));
        }
        bands
    };
    Ok((
        bands(true),
        bands(false),
        lost as f64 / reached.len() as f64,
    ))
}

/// Raised-cosine fades over `fade` samples at both ends, in place.
fn fade_ends(samples: &mut [f64], fade: usize) {
    let n = samples.len();
    let fade = fade.min(n / 2);
    for i in 0..fade {
        let gain = 0.5 - 0.5 * (PI * (i as f64 + 0.5) / fade as f64).cos();
        samples[i] *= gain;
        samples[n - 1 - i] *= gain;
    }
}

/// Why a target cannot be rendered.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RenderError {
    /// The band reaches beyond what is known.
    #[error(
        "cannot render over {band}: {what} ends at {highest}; lower the band's end or measure at a higher rate"
    )]
    BandAboveNyquist {
        /// The band asked for.
        band: Band,
        /// What does not reach that far.
        what: &'static str,
        /// Where it ends.
        highest: Hertz,
    },
    /// The plan is for another length.
    #[error(
        "cannot render: the plan is for {expected} samples, the target has {found}; make a plan for its length"
    )]
    Length {
        /// The plan's length.
        expected: usize,
        /// The target's length.
        found: usize,
    },
    /// The regularisation is not a number from zero up.
    #[error("expected a regularisation of 0 or more, found {found}; 9e-6 is the usual one")]
    Regularisation {
        /// What was found.
        found: f64,
    },
    /// There is nothing to render.
    #[error(
        "cannot render: expected a texture, found silence (every sample is the same); check the channel"
    )]
    Silent,
    /// The band falls between two lines.
    #[error(
        "cannot render over {band}: it holds no line of the transfer function, which has one every {resolution_hz:.2} Hz; take a wider band"
    )]
    NoLine {
        /// The band.
        band: Band,
        /// The step between lines, Hz.
        resolution_hz: f64,
    },
    /// The device does not answer.
    #[error(
        "cannot render over {band}: the device answers at none of its frequencies well enough to be inverted; measure it again, louder or longer, or take another band"
    )]
    NoResponse {
        /// The band.
        band: Band,
    },
    /// Measured one way, asked another.
    #[error(
        "cannot render: transfer function measured at {what} {measured}, drive requested at {requested}; characterise at {requested}, or set the amplifier to what was measured"
    )]
    ConditionMismatch {
        /// What differs.
        what: &'static str,
        /// How it was measured.
        measured: String,
        /// How it is asked for.
        requested: String,
    },
    /// The drive does not fit.
    #[error(
        "the target needs a drive of {peak:.3} and {limited_by} ends at {limit:.3} (full scale = 1): lower the target by {:.1} dB, or allow clipping", -fits_at.0
    )]
    ExceedsFullScale {
        /// The largest sample needed.
        peak: f64,
        /// The limit.
        limit: f64,
        /// What sets it.
        limited_by: String,
        /// The level at which it would fit.
        fits_at: Decibels,
    },
    /// The output rate does not fit.
    #[error("cannot bring the drive to the output rate: {0}")]
    Rate(#[from] ResampleError),
    /// The drive is no signal.
    #[error("the drive that comes out is no signal: {0}")]
    Drive(#[from] SeriesError),
}
