//! The transfer function between two channels of a recording, whatever their units.

use crate::transfer::Swapped;
use serde::Serialize;

use super::related::repeats_itself;
use super::{
    Bias, Change, CrossSpectra, Estimate, Estimator, Excitation, Found, ImpactConfig, ImpactTraces,
    Known, Limits, OneClock, TransferError, TransferFunction, TransferReport, TransferWarning,
    Transient, estimate_with_findings, prepared, transient,
};
#[cfg(feature = "modal")]
use super::{ImpactEstimate, impact::impacts};
use crate::device::{DriveSetup, drive_of_potential};
use crate::document::Content;
use crate::integrity::{Broken, Pair, never_changes, warnings_beside};
use crate::page::{Page, Shown};
use crate::quantity::{Potential, Uncalibrated, Unit, Volts};
use crate::recording::{Channel, Losses, Recording, RecordingWarning, ReversedSign};
use crate::roles::Roles;
use crate::series::Series;
use crate::spectrum::WelchConfig;
use crate::warning::Warning;

/// Which channels, and how.
#[derive(Clone, Debug)]
pub struct BetweenConfig<'a> {
    /// The name of the channel that drives.
    pub drive: &'a str,
    /// The name of the channel that answers.
    pub response: &'a str,
    /// The segments of a drive that lasts.
    pub welch: WelchConfig,
    /// What the drive is taken for.
    pub excitation: Excitation,
    /// How an impact test is evaluated.
    pub impact: ImpactConfig,
    pub estimator: Estimator,
    /// Whether the drive is known without noise: the channel holds the signal that was sent, not a measurement of it.
    pub known_input: bool,
    /// How many volts full scale is; where it is stated a drive in V becomes one of full scale.
    pub volts_per_full_scale: Option<Volts>,
    /// The device that played; absent for a plant without one.
    pub setup: Option<DriveSetup>,
    /// From when to when samples are known to be lost, s.
    pub lost_s: Vec<[f64; 2]>,
}

/// A transfer function with the units of its two channels.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct BetweenChannels {
    /// The transfer function, with what the recording gives a warning for.
    #[serde(flatten)]
    pub function: TransferFunction<Uncalibrated, Uncalibrated>,
    /// What the confidence limits hold.
    pub limits: Limits,
    /// How far H2 lies above H1 from 20 Hz on; absent where no line lies there.
    pub bias: Option<Bias>,
    /// The unit of the drive.
    pub drive_unit: Unit,
    /// The unit of the response.
    pub response_unit: Unit,
    /// The channels of the drive and of the response.
    #[serde(skip)]
    pub channels: [String; 2],
    /// What a report draws of an impact test; absent for other drives.
    #[serde(skip)]
    pub traces: Option<ImpactTraces>,
    /// The spectra it was estimated from; absent for an impact test.
    #[serde(skip)]
    pub spectra: Option<CrossSpectra<Uncalibrated, Uncalibrated>>,
}

impl Content for BetweenChannels {
    const SCHEMA: &'static str = "transfer";
}

impl Shown for BetweenChannels {
    fn page(&self) -> Page {
        let title = format!("Transfer function: {}", self.channels.join(" → "));
        let units = [&self.drive_unit, &self.response_unit];
        TransferReport {
            traces: self.traces.as_ref(),
            spectra: self.spectra.as_ref(),
            ..TransferReport::of(title, &self.function, units)
        }
        .page()
    }
}

/// The transfer function between two channels of `recording`, in the unit of the response per unit of the drive, with the warnings
/// about all its channels: a fault of the pair is one warning about both channels.
///
/// Formula: that of [`super::estimate_without`], after [`prepared`] brought both on one clock.
///
/// Source: as [`super::estimate_without`].
///
/// # Errors
/// [`TransferError`] for channels that are missing, the same, constant, on two clocks or not in V where volts are stated, and for
/// what cannot be estimated.
pub fn between_channels(
    recording: &Recording,
    config: &BetweenConfig<'_>,
) -> Result<BetweenChannels, TransferError> {
    if config.drive == config.response {
        return Err(TransferError::SameChannel {
            channel: config.drive.to_owned(),
        });
    }
    recording.require_one_clock([config.drive, config.response])?;
    let (drive, drive_unit) = excited(recording, config)?;
    let (response_channel, response) = recording.raw(Some(config.response))?;
    let response_unit = response_channel.unit.clone();
    for (name, series) in [(config.drive, &drive), (config.response, &response)] {
        if never_changes(series.samples()) {
            return Err(TransferError::Constant {
                channel: name.to_owned(),
                value: series.samples()[0],
            });
        }
    }
    let known = Known {
        lost_s: &config.lost_s,
        driven: recording.about.provenance.excited_hz,
    };
    let Estimated {
        mut function,
        found,
        traces,
        spectra,
    } = estimated(&drive, response.clone(), config, known)?;
    require_lines(&function, response.samples().len(), config)?;
    // What a drive that repeats itself distorts repeats too: it is no scatter.
    function.known_input =
        config.known_input && !repeats_itself(drive.samples(), config.welch.segment);
    let units = [&drive_unit, &response_unit];
    let limit = config.setup.as_ref().map_or(1.0, DriveSetup::drive_limit);
    let pair = Pair {
        drive: drive.samples(),
        response: response.samples(),
        rate: response.rate(),
        drive_name: config.drive,
        response_name: config.response,
        drive_limit: (drive_unit == Unit::FullScale).then_some(limit),
        lasts: function.impact.is_none(),
    };
    let broken = Broken::of(&pair);
    function.about.warnings.extend(broken.warnings(&pair));
    warning(&mut function, &found, units);
    let change = function.change.take();
    let mut function = function.with_change(change.map(|change| beside_force(change, recording)));
    describe(&mut function, recording, config);
    let beside = warnings_beside(recording, limit, (&pair, &broken));
    function.about.add_warnings(beside);
    Ok(BetweenChannels::of(
        function,
        (drive_unit, response_unit),
        config,
        (traces, spectra),
    ))
}

impl BetweenChannels {
    /// `function` with its limits and bias, between channels of these units.
    pub(super) fn of(
        function: TransferFunction<Uncalibrated, Uncalibrated>,
        (drive_unit, response_unit): (Unit, Unit),
        config: &BetweenConfig<'_>,
        (traces, spectra): (
            Option<ImpactTraces>,
            Option<CrossSpectra<Uncalibrated, Uncalibrated>>,
        ),
    ) -> Self {
        Self {
            limits: function.limits(),
            bias: function.bias(function.tactile_band()),
            function,
            drive_unit,
            response_unit,
            channels: [config.drive, config.response].map(str::to_owned),
            traces,
            spectra,
        }
    }
}

/// Refuses segments so short that no line lies in the tactile band.
pub(super) fn require_lines(
    function: &TransferFunction<Uncalibrated, Uncalibrated>,
    samples: usize,
    config: &BetweenConfig<'_>,
) -> Result<(), TransferError> {
    let band = function.tactile_band();
    if function.impact.is_some() || function.lines_in(band).next().is_some() {
        return Ok(());
    }
    Err(TransferError::Segment {
        least: (function.rate.hz() / band.high().0).ceil() as usize,
        samples,
        found: config.welch.segment,
    })
}

/// A transfer function, what its lines show, and what a report draws of it.
struct Estimated {
    function: TransferFunction<Uncalibrated, Uncalibrated>,
    found: Found,
    traces: Option<ImpactTraces>,
    spectra: Option<CrossSpectra<Uncalibrated, Uncalibrated>>,
}

/// The estimate for what the drive is taken for.
fn estimated(
    drive: &Series<Uncalibrated>,
    response: Series<Uncalibrated>,
    config: &BetweenConfig<'_>,
    known: Known<'_>,
) -> Result<Estimated, TransferError> {
    #[cfg(feature = "modal")]
    if let Some(estimated) = of_impacts(drive, &response, config, known)? {
        return Ok(estimated);
    }
    let OneClock {
        response,
        missing_s,
        warnings: clocks,
        change,
    } = prepared(drive, response, &config.welch, known.lost_s.to_vec());
    let known = Known {
        lost_s: &missing_s,
        ..known
    };
    let Estimate {
        mut function,
        found,
        spectra,
    } = estimate_with_findings(drive, &response, &config.welch, config.estimator, known)?;
    function.about.warnings.extend(clocks);
    function.change = change;
    if config.excitation == Excitation::Found {
        let pulses = transient(response.samples(), response.rate());
        (function.about.warnings).extend(pulses.map(|Transient { hits, .. }| {
            Warning::from(TransferWarning::Swapped {
                by: Swapped::Pulses { hits },
            })
        }));
    }
    Ok(Estimated {
        function,
        found,
        traces: None,
        spectra: Some(spectra),
    })
}

/// The estimate where the drive is taken for hits.
#[cfg(feature = "modal")]
fn of_impacts(
    drive: &Series<Uncalibrated>,
    response: &Series<Uncalibrated>,
    config: &BetweenConfig<'_>,
    known: Known<'_>,
) -> Result<Option<Estimated>, TransferError> {
    let found = match config.excitation {
        Excitation::Found => transient(drive.samples(), drive.rate()),
        Excitation::Lasting | Excitation::Impact => None,
    };
    if found.is_none() && config.excitation != Excitation::Impact {
        return Ok(None);
    }
    let ImpactEstimate {
        mut function,
        traces,
    } = impacts(drive, response, &config.impact, config.estimator, known)?;
    let guessed = found.map(|Transient { hits, share }| {
        Warning::from(super::ImpactWarning::PulsesInDrive {
            hits,
            share,
            as_impact: true,
        })
    });
    function.about.warnings.extend(guessed);
    Ok(Some(Estimated {
        function,
        found: Found::default(),
        traces: Some(traces),
        spectra: None,
    }))
}

/// The drive, as a share of full scale where volts per full scale are stated, and its unit.
pub(super) fn excited(
    recording: &Recording,
    config: &BetweenConfig<'_>,
) -> Result<(Series<Uncalibrated>, Unit), TransferError> {
    let (Channel { unit, .. }, drive) = recording.raw(Some(config.drive))?;
    match config.volts_per_full_scale {
        Some(volts) if *unit == Unit::Volt => {
            let potential = recording.series::<Potential>(Some(config.drive))?;
            let drive = drive_of_potential(&potential, volts)?;
            let rate = drive.rate();
            Ok((Series::new(drive.into_samples(), rate)?, Unit::FullScale))
        }
        Some(_) if *unit != Unit::FullScale => Err(TransferError::NotVolts {
            found: unit.clone(),
        }),
        _ => Ok((drive, unit.clone())),
    }
}

/// The change with the normal force in and outside it, where the recording holds one.
fn beside_force(change: Change, recording: &Recording) -> Change {
    let force = Roles::guess(recording).0.normal_force;
    let force = force.and_then(|name| recording.raw(Some(name.as_str())).ok());
    match force {
        Some((_, force)) => change.with_force(force.samples(), force.rate()),
        None => change,
    }
}

/// Warns of units that are no drive and response, and of a sign that is reversed.
pub(super) fn warning(
    function: &mut TransferFunction<Uncalibrated, Uncalibrated>,
    found: &Found,
    [drive_unit, response_unit]: [&Unit; 2],
) {
    let warnings = &mut function.about.warnings;
    let sends = matches!(response_unit, Unit::FullScale | Unit::Volt);
    if *drive_unit == Unit::MetrePerSecondSquared && sends {
        warnings.push(Warning::from(TransferWarning::Swapped {
            by: Swapped::Units {
                drive: drive_unit.to_string(),
                response: response_unit.to_string(),
            },
        }));
    }
    // A hammer may hit elsewhere than where the response is measured: the power it puts in there has either sign.
    let at_one_point = function.impact.is_none();
    let from_force = *drive_unit == Unit::Newton;
    if at_one_point && from_force && *response_unit == Unit::MetrePerSecondSquared {
        let inverted = found.is_inverted(function);
        let inverted = inverted.then(|| {
            RecordingWarning::Sign {
                of: ReversedSign::Power,
            }
            .into()
        });
        function.about.warnings.extend(inverted);
    }
}

/// Gives the transfer function the provenance, the condition and the warnings of its recording, and the device.
pub(super) fn describe(
    function: &mut TransferFunction<Uncalibrated, Uncalibrated>,
    recording: &Recording,
    config: &BetweenConfig<'_>,
) {
    let about = &recording.about;
    let estimated = std::mem::take(&mut function.about.provenance.steps);
    let step = format!("{} → {}", config.drive, config.response);
    function.about.provenance = about.provenance.clone().then(step);
    let began = recording.annotations.started_at.clone();
    function.about.provenance.measured_at = began;
    // The transfer function says itself which band was excited.
    function.about.provenance.excited_hz = None;
    // What was lost is left out of it.
    function.about.provenance.losses = Losses::default();
    function.about.provenance.steps.extend(estimated);
    function.about.condition = about.condition.clone();
    function.drive.clone_from(&config.setup);
    let before = about.warnings.iter().cloned();
    function.about.warnings.extend(before);
}
