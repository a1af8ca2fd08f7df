//! Rendering in a closed loop: play, measure, correct, and judge each drive by a separate measurement.

mod course;
mod measured;
mod outcome;
mod result;

use crate::DeviceError;
use piezotact::resample::ResampleWarning;
use std::fmt;

use piezotact::Warning;
use piezotact::correct::{CorrectConfig, Correction, LoopStop, LoopWarning};
use piezotact::device::DriveSetup;
use piezotact::number::signed;
use piezotact::quantity::{Acceleration, Band, Drive};
use piezotact::recording::{About, Recording, played_through_its_own};
use piezotact::render::{
    Inverse, Overload, RenderConfig, RenderError, RenderFindings, RenderedDrive, headroom,
    power_outside, render_with_findings,
};
use piezotact::series::Series;
use piezotact::transfer::TransferFunction;
use piezotact::verify::Verification;
use piezotact::warning::Warnings;

use super::RunKeeper;
use crate::error::ProcedureError;
use crate::plan::RunPlan;
use crate::traits::Bench;
use course::{Again, Course, Evaluation, Selected};
use measured::{Broken, MeasuredResponse, ResponseMeter, resampled_to};
pub use outcome::{Gain, GainCriterion, LoopEnd, LoopErrors, LoopFailure, SelectedDrive};
pub use result::{ClosedLoopResult, Iteration, LoopCloseness};

/// How a texture is rendered in a closed loop.
#[derive(Clone, Debug, PartialEq)]
pub struct LoopConfig {
    /// How the first drive is made, and the band.
    pub render: RenderConfig,
    /// How it is corrected.
    pub correct: CorrectConfig,
    /// The band over which it is judged.
    pub judged: Band,
    /// The largest number of corrections.
    pub iterations: usize,
    /// The largest departure of the mean force over ten seconds from its target, as a share; for a shorter drive it is wider by
    /// the square root of the time ratio, up to three times.
    pub force_share: f64,
    pub run: RunPlan,
}

/// Renders `target` on `bench` and corrects the drive from measured responses. Every drive is played twice: the second
/// measurement judges it, and both together give the next drive, so no drive is judged by a measurement from which it was
/// computed. The loop ends when there is no improvement, and the best drive is measured once more. It is kept if independent
/// measurements of it are closer to the target than the open loop by more than their spread; otherwise the open loop is kept.
/// The limits of the device are never exceeded. The loop works at the lower of the rates of target and bench.
///
/// # Errors
/// [`ProcedureError::Render`] when the first drive does not fit the device (with the level that does) or the target cannot be
/// rendered; [`ProcedureError::Broken`] when the first measurement already cannot be believed; whatever the bench returns before
/// there is a drive to keep.
pub fn closed_loop(
    bench: &mut Bench,
    target: &Series<Acceleration>,
    function: &TransferFunction<Drive, Acceleration>,
    config: &LoopConfig,
    keeper: &mut dyn RunKeeper,
    judged_one: &mut dyn FnMut(&Iteration),
) -> Result<ClosedLoopResult, ProcedureError> {
    let OpenLoop {
        target,
        function,
        mut first,
    } = open_loop(bench, target, function, config)?;
    let mut correction = Correction::new(&target, &function, &config.render, &config.correct)?;
    let reached = correction.inverse_coverage().reached.clone();
    let drive = correction.drive()?;
    let free = config.render.inverse.inverse == Inverse::DriveLimited
        || config.render.clipping == Overload::Allow;
    if !free && !correction.fits() {
        return Err(refused(&mut correction, function.drive.as_ref()).into());
    }
    let mut evaluation = Evaluation {
        meter: ResponseMeter {
            bench,
            keeper,
            config,
            setup: function.drive.clone(),
            rate: target.rate(),
            noise: None,
        },
        target: &target,
        welch: correction.welch().clone(),
        reached,
    };
    let noise = evaluation.meter.measure_noise(&evaluation.welch)?.clone();
    let hidden = correction
        .hidden(&noise)
        .map_err(|error| impossible("a target with a spectrum", &error))?;
    first.about.warnings.extend(hidden);
    let Course {
        iterations,
        open: Some(open),
        best,
        end,
        mut failed,
        ..
    } = evaluation.iterate(&mut correction, drive, &noise, judged_one)?
    else {
        return Err(ProcedureError::Broken("no drive could be evaluated".into()));
    };
    let Selected {
        best,
        again,
        gain,
        kept,
    } = evaluation.select(&iterations, open, best);
    let fits_at = best.fit.turned_down.as_ref().map(|_| correction.fits_at());
    let mut rendered = finished(
        first,
        best.drive,
        config,
        best.fit.warnings(fits_at),
        (&iterations[best.number], &end, kept),
    );
    rendered.coverage = best.fit.coverage;
    let Confirmation {
        confirmed,
        recording,
        broken,
    } = confirmation(again, (best.number, best.response), &mut rendered, bench)?;
    failed = failed.or(broken);
    let shown = confirmed
        .as_ref()
        .unwrap_or(&iterations[best.number].verification);
    add_response(&mut rendered, &function, &recording, shown);
    Ok(ClosedLoopResult {
        iterations,
        best: best.number,
        kept,
        gain,
        ended: end.to_string(),
        end,
        failed,
        rendered,
        confirmed,
        recording,
    })
}

fn impossible(expected: &str, error: &dyn fmt::Display) -> ProcedureError {
    ProcedureError::Device(DeviceError::Impossible {
        expected: expected.into(),
        found: error.to_string(),
        todo: "check rates, lengths and bands of target and bench".into(),
    })
}

/// What a loop begins with.
struct OpenLoop {
    /// The target at the rate of the loop.
    target: Series<Acceleration>,
    /// The transfer function, of the bench's device where it does not say its own.
    function: TransferFunction<Drive, Acceleration>,
    /// The open loop's drive.
    first: RenderedDrive,
}

fn open_loop(
    bench: &mut Bench,
    recorded: &Series<Acceleration>,
    function: &TransferFunction<Drive, Acceleration>,
    config: &LoopConfig,
) -> Result<OpenLoop, ProcedureError> {
    let (target, converted) = at_a_common_rate(recorded, bench, config)?;
    let (mut first, mut findings) = opened(&target, function, config)?;
    if converted.is_some() {
        // Content removed by a lower rate still belongs to the texture.
        findings.power_outside = power_outside(recorded, &config.render)?;
    }
    // A transfer function that does not say its device is used on this one.
    let mut function = function.clone();
    if function.drive.is_none() {
        function.drive = bench.player.calibrate()?;
        findings.is_device_unknown = function.drive.is_none();
    }
    first.setup.clone_from(&function.drive);
    first.about.warnings = findings.warnings(config.render.inverse.band, &first.headroom);
    first.about.warnings.extend(converted);
    Ok(OpenLoop {
        target,
        function,
        first,
    })
}

/// `target` at no higher rate than the bench acquires with.
fn at_a_common_rate(
    target: &Series<Acceleration>,
    bench: &Bench,
    config: &LoopConfig,
) -> Result<(Series<Acceleration>, Option<Warning>), ProcedureError> {
    let (from, to) = (target.rate(), bench.acquirer.describe().rate);
    if from.hz() <= to.hz() {
        return Ok((target.clone(), None));
    }
    let lower = resampled_to(target, to, config)?;
    let warning = Warning::from(ResampleWarning::RateConverted {
        signal: "the target".into(),
        from_hz: from.hz(),
        to_hz: to.hz(),
    });
    Ok((lower, Some(warning)))
}

/// The open loop's drive with what gives warnings, but not whether it fits, which the loop decides.
fn opened(
    target: &Series<Acceleration>,
    function: &TransferFunction<Drive, Acceleration>,
    config: &LoopConfig,
) -> Result<(RenderedDrive, RenderFindings), RenderError> {
    let mut open = config.render.clone();
    open.clipping = Overload::Allow;
    if open.inverse.inverse == Inverse::DriveLimited {
        open.inverse.inverse = Inverse::Constant;
    }
    let (mut first, mut findings) = render_with_findings(target, function, &open)?;
    first.config = config.render.clone();
    findings.clipped_at = None;
    findings.too_steep = None;
    Ok((first, findings))
}

/// Why a drive that does not fit is not played, with the level at which it does.
fn refused(correction: &mut Correction<Acceleration>, setup: Option<&DriveSetup>) -> RenderError {
    let loud = correction.asked() > setup.map_or(1.0, DriveSetup::drive_limit);
    if let (false, Some(setup), Some(steep)) = (loud, setup, correction.too_steep()) {
        return RenderError::ExceedsSlew {
            asked_v_per_s: steep * setup.actuator_v_per_full_scale(),
            limit_v_per_s: setup.slew_limit_v_per_s().unwrap_or(f64::INFINITY),
            fits_at: correction.fits_at(),
        };
    }
    RenderError::ExceedsFullScale {
        peak: correction.asked(),
        limit: setup.map_or(1.0, DriveSetup::drive_limit),
        limited_by: setup
            .map_or("the digital full scale", DriveSetup::limited_by)
            .into(),
        fits_at: correction.fits_at(),
    }
}

/// The first rendering with the loop's drive in its place.
fn finished(
    first: RenderedDrive,
    drive: Series<Drive>,
    config: &LoopConfig,
    fit: Vec<Warning>,
    (best, end, kept): (&Iteration, &LoopEnd, SelectedDrive),
) -> RenderedDrive {
    let headroom = headroom(drive.samples(), drive.rate(), first.setup.as_ref());
    let mut warnings = first.about.warnings;
    warnings.extend(fit);
    warnings.extend(headroom.slew_warning(first.setup.as_ref()));
    let stopped = match end {
        LoopEnd::Worse => Some(LoopStop::GotWorse),
        LoopEnd::Broken(mishap) => Some(LoopStop::NotBelieved {
            cause: mishap.warning(),
        }),
        LoopEnd::Done | LoopEnd::NoBetter => None,
    };
    warnings.extend(stopped.map(|why| {
        Warning::from(LoopWarning::LoopStopped {
            best: best.number,
            why,
        })
    }));
    RenderedDrive {
        drive,
        headroom,
        aim: Some(config.correct.mode),
        about: About {
            condition: first.about.condition,
            provenance: first.about.provenance.then(format!(
                "closed loop, {}: iteration {} of at most {}, evaluated by a separate measurement: {:.2} dB; {end}; {kept}",
                config.correct.mode.name(),
                best.number,
                config.iterations,
                best.aim_db
            )),
            warnings,
        },
        ..first
    }
}

/// What the last measurement of the drive that is kept says.
struct Confirmation {
    confirmed: Option<Verification>,
    /// The confirmation measurement, or else the one before it.
    recording: Recording,
    /// What the bench said when it failed.
    broken: Option<String>,
}

fn confirmation(
    again: Again,
    (number, before): (usize, MeasuredResponse),
    rendered: &mut RenderedDrive,
    bench: &Bench,
) -> Result<Confirmation, ProcedureError> {
    match again {
        Ok((verification, response)) => {
            let provenance = std::mem::take(&mut rendered.about.provenance);
            rendered.about.provenance = provenance.then(format!(
                "confirmation measurement: {:.2} dB rms, NMSE {} dB, on the {}",
                verification.judged_error_db(),
                signed(verification.waveform_nmse_db, 1),
                bench.player.describe().name
            ));
            Ok(Confirmation {
                confirmed: Some(verification),
                recording: response.recording,
                broken: None,
            })
        }
        Err(Broken::Bench(error @ ProcedureError::Stopped { .. })) => Err(error),
        Err(broken) => {
            let said = broken.of_the_bench();
            rendered
                .about
                .warnings
                .push(Warning::from(LoopWarning::LoopStopped {
                    best: number,
                    why: LoopStop::NotConfirmed {
                        cause: LoopFailure::from(broken).warning(),
                    },
                }));
            Ok(Confirmation {
                confirmed: None,
                recording: before.recording,
                broken: said,
            })
        }
    }
}

/// Adds to `rendered` what the last `recording` of it says: the condition, what answered, and the warnings, with those of the
/// verification that is shown.
fn add_response(
    rendered: &mut RenderedDrive,
    function: &TransferFunction<Drive, Acceleration>,
    recording: &Recording,
    shown: &Verification,
) {
    let condition = recording.about.condition.clone();
    let its_own = played_through_its_own(&rendered.about.provenance, &recording.about.provenance);
    // It was corrected on what answered.
    let answered = recording.about.provenance.answered_with;
    let known = &mut rendered.about.provenance.made_with;
    known.extend(answered.filter(|one| !known.contains(one)));
    let limit_db = shown.limits.error_db_rms;
    let missed = (shown.judged_error_db() > limit_db).then(|| {
        Warning::from(LoopWarning::TargetMissed {
            error_db_rms: shown.judged_error_db(),
            limit_db,
        })
    });
    let new = function
        .about
        .condition
        .warnings_when_measured(&condition)
        .into_iter()
        .chain(missed)
        .chain(its_own)
        .chain(recording.about.warnings.iter().cloned())
        .chain(shown.warnings.iter().cloned());
    let before = std::mem::take(&mut rendered.about.warnings).into_iter();
    rendered.about.warnings = before.chain(new).collect::<Warnings>().into();
    // It was corrected on the finger that was there.
    rendered.about.condition = condition;
}
