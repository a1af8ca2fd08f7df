//! Rendering: from a texture to the drive that reproduces it on a resting finger.
//!
//! The target's spectrum is divided by the transfer function of the device with the finger on it, within a
//! band and only where the device responds; the result states which parts of the band were given up, and the
//! headroom of the drive below the limits of the device.

mod coverage;
mod error;
mod findings;
mod frame;
mod inverse;
mod level;
mod limits;
mod rendering;
mod warning;

pub(crate) use coverage::runs;
pub use coverage::{Coverage, coverage};
pub use error::RenderError;
pub use findings::{FadeLoss, RenderFindings, TurnedDown};
pub(crate) use frame::{Frame, fade_ends, offset};
pub use inverse::{Inverse, InverseConfig, InversePlan, Limiting, PhaseForm, invert};
pub use level::at_fitting_level;
pub(crate) use limits::cut;
use limits::{DriveLimits, FULL_SCALE, excursion_within_limit};
pub use limits::{GainFit, Headroom, fitting, gains_for, headroom, share_of_least_error};
pub use rendering::{Rendering, warnings_of_played};
pub use warning::{PartLost, RenderWarning};

use serde::{Deserialize, Serialize};

use crate::device::{DeviceDescription, DriveSetup, GainName};
use crate::lineage::Mode;
use crate::quantity::{Band, Decibels, Drive, Quantity, SampleRate, Seconds};
use crate::recording::About;
use crate::series::Series;
use crate::transfer::TransferFunction;

/// What to do with a drive that the device cannot play.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Overload {
    /// Refuse, and say at which level it would fit.
    Refuse,
    /// Clip it at the device's limit, leave its slope as it is, and report both. The rms current and the excursion of an actuator are
    /// limits all the same.
    Allow,
}

/// How a target is rendered.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct RenderConfig {
    /// How the transfer function is inverted.
    pub inverse: InverseConfig,
    /// Silence before the texture, into which the inverse's early part falls.
    pub modelling_delay: Seconds,
    /// Silence after the texture, for the inverse's late part.
    pub tail: Seconds,
    /// The raised-cosine fade at both ends of the texture, 0 where they are left as they are.
    pub fade: Seconds,
    /// The rate of the drive.
    pub output_rate: SampleRate,
    /// A line is reached when regularisation attenuates it by no more than this.
    pub largest_loss: Decibels,
    /// A line is reached when its coherence is at least this.
    pub lowest_coherence: f64,
    /// What to do with a drive beyond the limits of the device, in amplitude or in slope.
    pub clipping: Overload,
}

impl RenderConfig {
    /// For the PIEZOTACT and similar devices: 0.25 s of silence before and after, no fade, 48 kHz; a line is
    /// reached within 0.5 dB and with a coherence of 0.8 or more; a drive beyond a limit of the device is refused.
    #[must_use]
    pub fn over(band: Band, output_rate: SampleRate) -> Self {
        Self {
            inverse: InverseConfig::over(band),
            modelling_delay: Seconds(0.25),
            tail: Seconds(0.25),
            fade: Seconds(0.0),
            output_rate,
            largest_loss: Decibels(0.5),
            lowest_coherence: 0.8,
            clipping: Overload::Refuse,
        }
    }
}

/// A drive ready to be played, with its origin, settings and warnings.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderedDrive {
    /// The drive, full scale = 1, at the output rate.
    pub drive: Series<Drive>,
    /// The device it is for; absent when the transfer function did not say.
    pub setup: Option<DriveSetup>,
    /// The condition it is for (participant, load, angle), its provenance, and its warnings.
    pub about: About,
    /// How it was made.
    pub config: RenderConfig,
    /// The aim of the closed loop that corrected it; none for an open loop.
    pub aim: Option<Mode>,
    /// Its peak, rms and slope re the limits of the device.
    pub headroom: Headroom,
    /// The parts of the band that the drive reaches, and those that it gives up.
    pub coverage: Coverage,
}

/// What [`render`] takes in memory at most beside its target, in bytes for each sample of it.
///
/// Source: measured by `tests/memory.rs`; docs/decisions/verification.md.
pub const MEMORY_BYTES_A_SAMPLE: usize = 220;

/// The drive (full scale = 1) to which the device responds with `target`, in the SI unit of `O`.
///
/// The target, its mean taken away, is faded at both ends, put between `modelling_delay` and `tail` of silence, divided by the
/// transfer function inside the band, and brought to the output rate.
///
/// Source: thesis sections 4.1 and 2.5; see [`invert`] for the formula.
///
/// # Errors
/// Those of [`invert`]; [`RenderError::Signal`] when the band does not fit the output rate;
/// [`RenderError::ExceedsFullScale`] when the drive does not fit the device and that is refused,
/// [`RenderError::ExceedsSlew`] when it is steeper than the amplifier follows and that is refused; [`RenderError::ExceedsCurrent`] and
/// [`RenderError::ExceedsExcursion`] beyond what the actuator bears.
pub fn render<O: Quantity>(
    target: &Series<O>,
    function: &TransferFunction<Drive, O>,
    config: &RenderConfig,
) -> Result<RenderedDrive, RenderError> {
    let (mut rendered, findings) = render_with_findings(target, function, config)?;
    rendered.about.warnings = findings.warnings(config.inverse.band, &rendered.headroom);
    Ok(rendered)
}

/// As [`render`], with what gives warnings beside a drive that has none yet: for whoever settles a part of it.
///
/// Source: as [`render`].
///
/// # Errors
/// Those of [`render`].
pub fn render_with_findings<O: Quantity>(
    target: &Series<O>,
    function: &TransferFunction<Drive, O>,
    config: &RenderConfig,
) -> Result<(RenderedDrive, RenderFindings), RenderError> {
    let (rate, band) = (target.rate(), config.inverse.band);
    let frame = Frame::of(target, config)?;
    let texture = frame.faded(target)?;
    let padded = frame.padded(&texture);
    let mut plan = InversePlan::new(padded.len());
    let mut drive_of = |limiting: Option<&Limiting>| -> Result<Vec<f64>, RenderError> {
        let drive = plan.invert_limited(&padded, rate, function, &config.inverse, limiting)?;
        Ok(frame.played(drive))
    };
    let mut samples = drive_of(None)?;
    let inverse = coverage::known(function, config)?;
    let mut turned_down = None;
    let room = DriveLimits::of(function.drive.as_ref(), config.output_rate);
    if config.inverse.inverse == Inverse::DriveLimited && !room.holds(&samples) {
        let mut costs = Limiting::of(target.samples(), rate, function, band)?;
        if room.is_steeper_than_loud(&samples) {
            costs = costs.by_slope(band);
        }
        if let Some((fitting, limiting)) = fitted(&costs, &room, &mut drive_of)? {
            let kept = coverage::limited(function, config, Some(&limiting))?;
            let found = TurnedDown {
                share: kept.given_up_share - inverse.given_up_share,
                bands: coverage::without(&kept.bands.given_up, &inverse.bands.given_up),
                fits_at_db: room.fits_at(&samples).0,
                beyond_limit: room.beyond(&samples),
            };
            samples = fitting;
            turned_down = Some((found, kept.bands));
        }
    }

    let mut findings = RenderFindings::of(function, config);
    if !inverse.bands.given_up.is_empty() {
        findings.given_up = Some((inverse.bands.given_up.clone(), inverse.given_up_share));
    }
    let coverage = match turned_down {
        Some((found, coverage)) => {
            findings.turned_down = Some(found);
            coverage
        }
        None => inverse.bands,
    };
    findings.power_outside = plan.outside(&padded);
    findings.faded = frame.fade_loss(target, &texture);
    let setup = function.drive.as_ref();
    let headroom = headroom(&samples, config.output_rate, setup);
    findings.too_steep = headroom.too_steep(setup);
    if let Some(refused) = room.refused(&samples, setup, config.clipping) {
        return Err(refused);
    }
    let excursion = excursion_within_limit::<O>(&padded, (rate, band), setup)?;
    let headroom = headroom.with_excursion(excursion);
    findings.clipped_at = (headroom.peak > headroom.limit)
        .then(|| setup.map_or(FULL_SCALE, DriveSetup::limited_by).into());
    cut(&mut samples, headroom.limit);
    let mut provenance = function.about.provenance.clone();
    // A transfer function measured by playing through another one stands for that one.
    let known = std::iter::once(function.checksum()).chain(provenance.answered_with.take());
    provenance.made_with = known.collect();
    let rendered = RenderedDrive {
        drive: Series::new(samples, config.output_rate)?,
        setup: function.drive.clone(),
        about: About {
            condition: function.about.condition.clone(),
            provenance: provenance.then(format!(
                "rendered over {band}, inverse {}, phase {}, regularisation {:.1e} of the band's largest |H|², modelling delay {}",
                config.inverse.inverse.name(),
                config.inverse.phase.name(),
                config.inverse.regularisation,
                config.modelling_delay
            )),
            warnings: Vec::new(),
        },
        config: config.clone(),
        aim: None,
        headroom,
        coverage,
    };
    Ok((rendered, findings))
}

/// The share of the power of `target` (as recorded, with the fades of `config`) outside the band, 0–1, if it is a tenth or more: the
/// same as in [`RenderFindings::power_outside`]. A target resampled to a lower rate before would show a smaller share.
///
/// Source: docs/decisions/verification.md: a tenth is 0.4 dB of level.
///
/// # Errors
/// [`RenderError::Signal`] when what is in the band cannot be brought to the output rate, [`RenderError::Silent`] when the
/// target holds nothing but its mean.
pub fn power_outside<O: Quantity>(
    target: &Series<O>,
    config: &RenderConfig,
) -> Result<Option<f64>, RenderError> {
    let frame = Frame::of(target, config)?;
    let padded = frame.padded(&frame.faded(target)?);
    let band = config.inverse.band;
    let mut plan = InversePlan::new(padded.len());
    Ok(plan.outside_of(&padded, target.rate(), band))
}

/// Bisection steps for the strength of limiting.
const HALVINGS: usize = 20;

/// Computes the drive for an attenuation, or without one.
type DriveOf<'a> = &'a mut dyn FnMut(Option<&Limiting>) -> Result<Vec<f64>, RenderError>;

/// The least attenuated drive that stays within `room`, with its attenuation; `None` when no strength in the range
/// fits.
fn fitted(
    costs: &Limiting,
    room: &DriveLimits,
    drive_of: DriveOf<'_>,
) -> Result<Option<(Vec<f64>, Limiting)>, RenderError> {
    let (mut weak, mut strong) = (-6.0f64, 6.0f64);
    let mut best = None;
    for _ in 0..HALVINGS {
        let middle = 0.5 * (weak + strong);
        let limiting = costs.turned_down(10f64.powf(middle));
        let drive = drive_of(Some(&limiting))?;
        if room.holds(&drive) {
            strong = middle;
            best = Some((drive, limiting));
        } else {
            weak = middle;
        }
    }
    Ok(best)
}

/// The negative control: the target's samples used directly as the drive (full scale = 1), one unit of `O` as full scale,
/// clamped to the range of a file. The response is the target times the transfer function.
///
/// Source: thesis figures 41–42, "wrong rendering strategy".
///
/// # Errors
/// [`RenderError::Signal`] when the target cannot be brought to the output rate.
pub fn uncompensated<O: Quantity>(
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

/// Refuses a transfer function that was measured with another gain than the one the drive is for. A transfer function that does
/// not state its gain is accepted here; rendering then raises a warning.
///
/// Source: a transfer function holds for one amplifier gain (thesis 2.4, 2.5.3).
///
/// # Errors
/// [`RenderError::ConditionMismatch`] naming both gains.
pub fn require_gain(setup: Option<&DriveSetup>, requested: &GainName) -> Result<(), RenderError> {
    match setup {
        Some(setup) if setup.gain.name != *requested => Err(RenderError::ConditionMismatch {
            what: "gain",
            measured: setup.gain.to_string(),
            requested: requested.to_string(),
        }),
        _ => Ok(()),
    }
}

/// Refuses a transfer function that was measured with another device than the one described: its gain setting, with the
/// limits, and its input. One that does not state its device is accepted here; rendering then raises a warning.
///
/// Source: a transfer function holds for one amplifier (thesis 2.4, 2.5.3).
///
/// # Errors
/// [`RenderError::ConditionMismatch`] naming both devices.
pub fn require_device(
    setup: Option<&DriveSetup>,
    requested: &DeviceDescription,
) -> Result<(), RenderError> {
    let Some(setup) = setup else {
        return Ok(());
    };
    let same_gain = requested.gain(&setup.gain.name);
    let same = same_gain.is_ok_and(|gain| *gain == *setup.gain)
        && requested.input() == setup.device().input();
    if same {
        return Ok(());
    }
    Err(RenderError::ConditionMismatch {
        what: "device",
        measured: setup.amplification(),
        requested: format!("{} as described", requested.name()),
    })
}

/// A level rounded down to a tenth of a decibel.
#[must_use]
pub(crate) fn floored(level: Decibels) -> Decibels {
    Decibels((level.0 * 10.0).floor() / 10.0)
}

#[cfg(test)]
mod tests;
