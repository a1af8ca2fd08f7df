//! Rendering in a closed loop: play, measure, correct, and judge each drive by a separate measurement.

mod measured;
mod outcome;
mod result;

use crate::DeviceError;
use piezotact::clipping::{ClippedAt, ClippingWarning};
use piezotact::resample::ResampleWarning;
use std::fmt;

use piezotact::Warning;
use piezotact::correct::{CorrectConfig, Correction, LoopStop, LoopWarning};
use piezotact::criterion::Outcome;
use piezotact::device::DriveSetup;
use piezotact::lineage::Mode;
use piezotact::quantity::{Acceleration, Band, Decibels, Drive};
use piezotact::recording::{About, RecordingWarning, ReversedSign, played_through_its_own};
use piezotact::render::{
    Coverage, Inverse, Overload, PartLost, RenderConfig, RenderError, RenderFindings,
    RenderWarning, RenderedDrive, headroom, power_outside, render_with_findings,
};
use piezotact::series::Series;
use piezotact::spectrum::WelchConfig;
use piezotact::transfer::TransferFunction;
use piezotact::verify::{Measured, Verification, VerifyConfig, VerifyWarning, verify};
use piezotact::warning::Warnings;

use super::RunKeeper;
use crate::error::ProcedureError;
use crate::plan::RunPlan;
use crate::traits::Bench;
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

/// The least improvement of a spectrum, and the change from which it is clearly worse, dB.
const SPECTRUM_DB: (f64, f64) = (0.005, 1.0);
/// The change from which a waveform is clearly worse, dB; waveforms vary more between measurements.
const WORSE_WAVEFORM_DB: f64 = 3.0;
/// Waveforms within this of the best count as equally good, and their spectra decide, dB.
const EQUAL_WAVEFORM_DB: f64 = 0.5;
/// The number of consecutive iterations without improvement after which the loop stops.
const MAX_STALLED_ITERATIONS: usize = 2;
/// The share of samples at the limit from which a warning is raised: about one in ten thousand is due to rounding.
const WARNING_HELD_SHARE: f64 = 1e-4;
/// Below this correlation with the requested drive, limiting its crests raises a warning.
const UNLIKE: f64 = 0.98;

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
    let recorded = target;
    let (target, converted) = at_a_common_rate(target, bench, config)?;
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
    let mut correction = Correction::new(&target, &function, &config.render, &config.correct)?;
    let reached = correction.inverse_coverage().reached.clone();
    let mut drive = correction.drive()?;
    let free = config.render.inverse.inverse == Inverse::DriveLimited
        || config.render.clipping == Overload::Allow;
    if !free && !correction.fits() {
        return Err(refused(&mut correction, function.drive.as_ref()).into());
    }
    let mut meter = ResponseMeter {
        bench,
        keeper,
        config,
        setup: function.drive.clone(),
        rate: target.rate(),
        noise: None,
    };
    let correction_welch = correction.welch().clone();
    let noise = meter.measure_noise(&correction_welch)?.clone();
    let hidden = correction
        .hidden(&noise)
        .map_err(|error| impossible("a target with a spectrum", &error))?;
    first.about.warnings.extend(hidden);
    let judge = |response: &MeasuredResponse, coverage: &Coverage| {
        judged(
            &target,
            response,
            (coverage, correction_welch.clone()),
            config,
        )
    };

    let mut course = Course::default();
    for number in 0..=config.iterations {
        let fit = Fit::of(&correction);
        let mut both =
            || -> Result<(MeasuredResponse, MeasuredResponse, [Verification; 2]), Broken> {
                let first = meter.measure(&drive, &format!("iteration {number}, first"))?;
                let unjudged = judge(&first, &fit.coverage)?;
                let second = meter.measure(&drive, &format!("iteration {number}, second"))?;
                let verification = judge(&second, &fit.coverage)?;
                Ok((first, second, [unjudged, verification]))
            };
        let (first, second, [unjudged, verification]) = match both() {
            Ok(both) => both,
            // A stopped loop can be resumed: its runs are stored.
            Err(Broken::Bench(error @ ProcedureError::Stopped { .. })) => return Err(error),
            Err(broken) if course.open.is_some() => {
                course.failed = broken.of_the_bench();
                course.end = LoopEnd::Broken(broken.into());
                break;
            }
            Err(Broken::Bench(error)) => return Err(error),
            Err(Broken::Unbelievable(why)) => return Err(ProcedureError::Broken(why.to_string())),
        };
        let responses = [first.response, second.response.clone()];
        let measured =
            [&unjudged, &verification].map(|v| closeness(v, config.correct.mode, &reached));
        let iteration = Iteration {
            number,
            aim_db: measured[1].aim_db,
            verification,
            measured,
            held: correction.held(),
            step: None,
        };
        let best = || Best {
            number,
            drive: drive.clone(),
            response: second,
            fit,
        };
        course.judge(iteration, config.correct.mode, &reached, best);
        if course.end == LoopEnd::Done && number < config.iterations {
            let step = correction
                .learn(&[&responses[0], &responses[1]], &noise)
                .map_err(|error| error.to_string());
            let next = correction.drive().map_err(|error| error.to_string());
            match (step, next) {
                (Ok(step), Ok(next)) => {
                    course.iterations[number].step = Some(step);
                    drive = next;
                }
                (Err(said), _) | (_, Err(said)) => {
                    course.end = LoopEnd::Broken(LoopFailure::Correction { said });
                }
            }
        }
        judged_one(&course.iterations[number]);
        if course.end != LoopEnd::Done {
            break;
        }
    }
    let Course {
        iterations,
        open: Some(open),
        best,
        end,
        mut failed,
        ..
    } = course
    else {
        return Err(ProcedureError::Broken("no drive could be evaluated".into()));
    };
    let mut once_more = |drive: &Best| -> Result<(Verification, MeasuredResponse), Broken> {
        let label = format!("iteration {}, once more", drive.number);
        let response = meter.measure(&drive.drive, &label)?;
        Ok((judge(&response, &drive.fit.coverage)?, response))
    };
    // The best drive is measured once more: the smallest of several measured errors is biased by chance.
    let (best, again, gain, kept) = match best {
        None if iterations.len() == 1 => {
            let again = once_more(&open);
            (open, again, None, SelectedDrive::NothingCorrected)
        }
        None => {
            let again = once_more(&open);
            (open, again, None, SelectedDrive::NoneCloser)
        }
        Some(best) => {
            let again = once_more(&best);
            let pairs: Vec<[LoopErrors; 2]> = iterations.iter().map(|i| i.measured).collect();
            let mut closed = vec![pairs[best.number][0]];
            if let Ok((verification, _)) = &again {
                closed.push(closeness(verification, config.correct.mode, &reached));
            }
            let gain = Gain::of(best.number, &pairs, &closed);
            let keeps = gain
                .as_ref()
                .is_some_and(|gain| gain.keeps(config.correct.mode, EQUAL_WAVEFORM_DB));
            if keeps {
                (best, again, gain, SelectedDrive::Corrected)
            } else {
                let further = |gain: &Gain| {
                    [GainCriterion::Aim, GainCriterion::Spectrum]
                        .map(|what| gain.outcome(what))
                        .contains(&Outcome::NotMet)
                };
                let kept = match gain.as_ref().is_some_and(further) {
                    true => SelectedDrive::FurtherOff,
                    false => SelectedDrive::WithinSpread,
                };
                let again = once_more(&open);
                (open, again, gain, kept)
            }
        }
    };
    let fits_at = best.fit.turned_down.as_ref().map(|_| correction.fits_at());
    let mut rendered = finished(
        first,
        best.drive,
        config,
        best.fit.warnings(fits_at),
        (&iterations[best.number], &end, kept),
    );
    rendered.coverage = best.fit.coverage;
    let (confirmed, recording) = match again {
        Ok((verification, response)) => {
            rendered.about.provenance = rendered.about.provenance.then(format!(
                "confirmation measurement: {:.2} dB rms, NMSE {:.1} dB, on the {}",
                verification.judged_error_db(),
                verification.waveform_nmse_db,
                bench.player.describe().name
            ));
            (Some(verification), response.recording)
        }
        Err(Broken::Bench(error @ ProcedureError::Stopped { .. })) => return Err(error),
        Err(broken) => {
            failed = failed.or(broken.of_the_bench());
            rendered
                .about
                .warnings
                .push(Warning::from(LoopWarning::LoopStopped {
                    best: best.number,
                    why: LoopStop::NotConfirmed {
                        cause: LoopFailure::from(broken).warning(),
                    },
                }));
            (None, best.response.recording)
        }
    };
    let condition = recording.about.condition.clone();
    let its_own = played_through_its_own(&rendered.about.provenance, &recording.about.provenance);
    // It was corrected on what answered.
    let answered = recording.about.provenance.answered_with;
    let known = &mut rendered.about.provenance.made_with;
    known.extend(answered.filter(|one| !known.contains(one)));
    let shown = confirmed
        .as_ref()
        .unwrap_or(&iterations[best.number].verification);
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

/// The state of the loop.
#[derive(Default)]
struct Course {
    iterations: Vec<Iteration>,
    /// The open loop's drive.
    open: Option<Best>,
    /// The best corrected drive, if one was judged better than the open loop.
    best: Option<Best>,
    since_best: usize,
    end: LoopEnd,
    /// What the bench said when it failed.
    failed: Option<String>,
}

impl Course {
    /// Takes `iteration` into account, and `best` when it is the best so far.
    fn judge(
        &mut self,
        iteration: Iteration,
        mode: Mode,
        reached: &[Band],
        best: impl FnOnce() -> Best,
    ) {
        let spectrum_db = |i: &Iteration| i.verification.error_db_rms_over(reached);
        let so_far = self
            .best
            .as_ref()
            .or(self.open.as_ref())
            .map(|best| &self.iterations[best.number]);
        let aims = self.iterations.iter().map(|i| i.aim_db);
        let least_db = aims.fold(f64::INFINITY, f64::min);
        let aim_db = iteration.aim_db;
        let (better, worse) = match (mode, so_far) {
            (_, None) => (true, false),
            (Mode::Texture, Some(so_far)) => (
                aim_db < so_far.aim_db - SPECTRUM_DB.0,
                aim_db > so_far.aim_db + SPECTRUM_DB.1,
            ),
            // The strong lines dominate a waveform; among equally good waveforms the best spectrum decides.
            (Mode::Replicate, Some(so_far)) => (
                aim_db < least_db - EQUAL_WAVEFORM_DB
                    || aim_db < least_db + EQUAL_WAVEFORM_DB
                        && spectrum_db(&iteration) < spectrum_db(so_far) - SPECTRUM_DB.0,
                aim_db > so_far.aim_db + WORSE_WAVEFORM_DB,
            ),
        };
        self.iterations.push(iteration);
        if better {
            let place = match self.open {
                None => &mut self.open,
                Some(_) => &mut self.best,
            };
            *place = Some(best());
            self.since_best = 0;
        } else {
            self.since_best += 1;
        }
        if worse {
            self.end = LoopEnd::Worse;
        } else if self.since_best >= MAX_STALLED_ITERATIONS {
            self.end = LoopEnd::NoBetter;
        }
    }
}

/// The best drive so far.
struct Best {
    number: usize,
    drive: Series<Drive>,
    response: MeasuredResponse,
    fit: Fit,
}

/// How a drive was made to fit.
struct Fit {
    coverage: Coverage,
    /// The attenuated bands, and their share of the lines.
    turned_down: Option<(Vec<Band>, f64)>,
    crest_correlation: f64,
    held: f64,
}

impl Fit {
    fn of(correction: &Correction<Acceleration>) -> Self {
        Self {
            coverage: correction.coverage(),
            turned_down: correction.turned_down(),
            crest_correlation: correction.crest_correlation(),
            held: correction.held(),
        }
    }

    /// The warnings about it; `fits_at` is the level at which no attenuation is needed.
    fn warnings(&self, fits_at: Option<Decibels>) -> Vec<Warning> {
        let turned_down = self.turned_down.clone().zip(fits_at);
        let turned_down = turned_down.map(|((bands, share), fits_at)| {
            Warning::from(RenderWarning::BandPartLost {
                bands,
                share,
                why: PartLost::TurnedDown {
                    fits_at_db: fits_at.0,
                },
            })
        });
        let pressed = (self.crest_correlation < UNLIKE).then_some(Warning::from(
            LoopWarning::CrestsPressed {
                correlation: self.crest_correlation,
            },
        ));
        let held = (self.held > WARNING_HELD_SHARE).then(|| {
            Warning::from(ClippingWarning::Clipped {
                signal: "the corrected drive".into(),
                at: ClippedAt::Recorded {
                    fraction: self.held,
                },
            })
        });
        turned_down.into_iter().chain(pressed).chain(held).collect()
    }
}

fn impossible(expected: &str, error: &dyn fmt::Display) -> ProcedureError {
    ProcedureError::Device(DeviceError::Impossible {
        expected: expected.into(),
        found: error.to_string(),
        todo: "check rates, lengths and bands of target and bench".into(),
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
    open.steep = Overload::Allow;
    if open.inverse.inverse == Inverse::DriveLimited {
        open.inverse.inverse = Inverse::Constant;
    }
    let (mut first, mut findings) = render_with_findings(target, function, &open)?;
    first.config = config.render.clone();
    findings.is_clipped = false;
    findings.too_steep = None;
    Ok((first, findings))
}

/// Why a drive that does not fit is not played, with the level at which it does.
fn refused(correction: &mut Correction<Acceleration>, setup: Option<&DriveSetup>) -> RenderError {
    let loud = correction.asked() > setup.map_or(1.0, DriveSetup::drive_limit);
    if let (false, Some(setup), Some(steep)) = (loud, setup, correction.too_steep()) {
        return RenderError::ExceedsSlew {
            asked_v_per_s: steep * setup.actuator_v_per_full_scale(),
            limit_v_per_s: setup.slew_limit_v_per_s(),
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

/// How close one measurement came, over what the inverse `reached`: the same for every drive of a loop.
fn closeness(verification: &Verification, mode: Mode, reached: &[Band]) -> LoopErrors {
    let spectrum_db = verification.error_db_rms_over(reached);
    LoopErrors {
        aim_db: match mode {
            Mode::Texture => spectrum_db,
            Mode::Replicate => verification.waveform_nmse_db,
        },
        spectrum_db,
    }
}

/// The verification of a measured response against `target`, over the `coverage` of its drive.
fn judged(
    target: &Series<Acceleration>,
    response: &MeasuredResponse,
    (coverage, welch): (&Coverage, WelchConfig),
    config: &LoopConfig,
) -> Result<Verification, Broken> {
    let verify_config = VerifyConfig {
        reached: coverage.reached.clone(),
        welch,
        ..VerifyConfig::over(config.judged, target.rate().hz())
    }
    .rendered_as(&config.render, config.correct.mode);
    let measured = Measured {
        response: &response.response,
        clipping: response.clipping.clone(),
    };
    let verification = verify(target, measured, &verify_config)
        .map_err(|error| impossible("a measurement that can be compared", &error))?;
    match wrong(&verification) {
        Some(warning) => Err(Broken::Unbelievable(LoopFailure::Response {
            warning: Box::new(warning.into()),
        })),
        None => Ok(verification),
    }
}

/// Why a measured response cannot be that of the drive: it ends too early, or is inverted.
fn wrong(verification: &Verification) -> Option<Warning> {
    let seconds = |samples: usize| samples as f64 / verification.rate_hz;
    if verification.is_cut() {
        let cut = VerifyWarning::Cut {
            compared_s: seconds(verification.compared.len()),
            target_s: seconds(verification.target.len()),
        };
        return Some(cut.into());
    }
    let correlation = verification.waveform_correlation;
    let inverted = RecordingWarning::Sign {
        of: ReversedSign::Measurement { correlation },
    };
    (verification.is_inverted()).then(|| inverted.into())
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
