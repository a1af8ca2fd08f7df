//! The course of a closed loop: its iterations, and the drive that is kept.

use piezotact::Warning;
use piezotact::clipping::{ClippedAt, ClippingWarning};
use piezotact::correct::{Correction, LoopWarning};
use piezotact::criterion::Outcome;
use piezotact::lineage::Mode;
use piezotact::quantity::{Acceleration, Band, Decibels, Drive};
use piezotact::recording::{RecordingWarning, ReversedSign};
use piezotact::render::{Coverage, PartLost, RenderWarning};
use piezotact::series::Series;
use piezotact::spectrum::{Spectrum, WelchConfig};
use piezotact::verify::{Measured, Verification, VerifyConfig, VerifyWarning, verify};

use super::impossible;
use super::measured::{Broken, MeasuredResponse, ResponseMeter};
use super::outcome::{Gain, GainCriterion, LoopEnd, LoopErrors, LoopFailure, SelectedDrive};
use super::result::Iteration;
use crate::error::ProcedureError;

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

/// Plays drives, and judges their measured responses against the target.
pub(super) struct Evaluation<'a> {
    pub(super) meter: ResponseMeter<'a>,
    /// The target at the rate of the loop.
    pub(super) target: &'a Series<Acceleration>,
    /// How spectra are estimated.
    pub(super) welch: WelchConfig,
    /// What the inverse reaches: the same for every drive of a loop.
    pub(super) reached: Vec<Band>,
}

/// A response that was measured once more, and its verification.
pub(super) type Again = Result<(Verification, MeasuredResponse), Broken>;

/// The drive that is kept, and why.
pub(super) struct Selected {
    pub(super) best: Best,
    pub(super) again: Again,
    pub(super) gain: Option<Gain>,
    pub(super) kept: SelectedDrive,
}

impl Evaluation<'_> {
    /// Plays `drive` and corrects it, until nothing improves.
    pub(super) fn iterate(
        &mut self,
        correction: &mut Correction<Acceleration>,
        mut drive: Series<Drive>,
        noise: &Spectrum<Acceleration>,
        judged_one: &mut dyn FnMut(&Iteration),
    ) -> Result<Course, ProcedureError> {
        let config = self.meter.config;
        let mut course = Course::default();
        for number in 0..=config.iterations {
            let fit = Fit::of(correction);
            let (first, second, [unjudged, verification]) =
                match self.both(number, &drive, &fit.coverage) {
                    Ok(both) => both,
                    // A stopped loop can be resumed: its runs are stored.
                    Err(Broken::Bench(error @ ProcedureError::Stopped { .. })) => {
                        return Err(error);
                    }
                    Err(broken) if course.open.is_some() => {
                        course.failed = broken.of_the_bench();
                        course.end = LoopEnd::Broken(broken.into());
                        break;
                    }
                    Err(Broken::Bench(error)) => return Err(error),
                    Err(Broken::Unbelievable(why)) => {
                        return Err(ProcedureError::Broken(why.to_string()));
                    }
                };
            let responses = [first.response, second.response.clone()];
            let measured = [&unjudged, &verification].map(|v| self.closeness(v));
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
            course.judge(iteration, config.correct.mode, &self.reached, best);
            if course.end == LoopEnd::Done && number < config.iterations {
                let step = correction
                    .learn(&[&responses[0], &responses[1]], noise)
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
        Ok(course)
    }

    /// Two measurements of `drive`, with their verifications.
    fn both(
        &mut self,
        number: usize,
        drive: &Series<Drive>,
        coverage: &Coverage,
    ) -> Result<(MeasuredResponse, MeasuredResponse, [Verification; 2]), Broken> {
        let first = self
            .meter
            .measure(drive, &format!("iteration {number}, first"))?;
        let unjudged = self.judged(&first, coverage)?;
        let second = self
            .meter
            .measure(drive, &format!("iteration {number}, second"))?;
        let verification = self.judged(&second, coverage)?;
        Ok((first, second, [unjudged, verification]))
    }

    fn once_more(&mut self, drive: &Best) -> Again {
        let label = format!("iteration {}, once more", drive.number);
        let response = self.meter.measure(&drive.drive, &label)?;
        Ok((self.judged(&response, &drive.fit.coverage)?, response))
    }

    /// The best drive or that of the open loop. The best drive is measured once more: the smallest of several measured errors is
    /// biased by chance.
    pub(super) fn select(
        &mut self,
        iterations: &[Iteration],
        open: Best,
        best: Option<Best>,
    ) -> Selected {
        let Some(best) = best else {
            return Selected {
                again: self.once_more(&open),
                best: open,
                gain: None,
                kept: match iterations.len() {
                    1 => SelectedDrive::NothingCorrected,
                    _ => SelectedDrive::NoneCloser,
                },
            };
        };
        let mode = self.meter.config.correct.mode;
        let again = self.once_more(&best);
        let pairs: Vec<[LoopErrors; 2]> = iterations.iter().map(|i| i.measured).collect();
        let mut closed = vec![pairs[best.number][0]];
        if let Ok((verification, _)) = &again {
            closed.push(self.closeness(verification));
        }
        let gain = Gain::of(best.number, &pairs, &closed);
        let keeps = gain
            .as_ref()
            .is_some_and(|gain| gain.keeps(mode, EQUAL_WAVEFORM_DB));
        if keeps {
            return Selected {
                best,
                again,
                gain,
                kept: SelectedDrive::Corrected,
            };
        }
        let further = |gain: &Gain| {
            [GainCriterion::Aim, GainCriterion::Spectrum]
                .map(|what| gain.outcome(what))
                .contains(&Outcome::NotMet)
        };
        let kept = match gain.as_ref().is_some_and(further) {
            true => SelectedDrive::FurtherOff,
            false => SelectedDrive::WithinSpread,
        };
        Selected {
            again: self.once_more(&open),
            best: open,
            gain,
            kept,
        }
    }

    /// How close one measurement came, over what the inverse reaches.
    fn closeness(&self, verification: &Verification) -> LoopErrors {
        let spectrum_db = verification.error_db_rms_over(&self.reached);
        LoopErrors {
            aim_db: match self.meter.config.correct.mode {
                Mode::Texture => spectrum_db,
                Mode::Replicate => verification.waveform_nmse_db,
            },
            spectrum_db,
        }
    }

    /// The verification of a measured response against the target, over the `coverage` of its drive.
    fn judged(
        &self,
        response: &MeasuredResponse,
        coverage: &Coverage,
    ) -> Result<Verification, Broken> {
        let config = self.meter.config;
        let verify_config = VerifyConfig {
            reached: coverage.reached.clone(),
            welch: self.welch.clone(),
            ..VerifyConfig::over(config.judged, self.target.rate().hz())
        }
        .rendered_as(&config.render, config.correct.mode);
        let measured = Measured {
            response: &response.response,
            clipping: response.clipping.clone(),
        };
        let verification = verify(self.target, measured, &verify_config)
            .map_err(|error| impossible("a measurement that can be compared", &error))?;
        match wrong(&verification) {
            Some(warning) => Err(Broken::Unbelievable(LoopFailure::Response {
                warning: Box::new(warning),
            })),
            None => Ok(verification),
        }
    }
}

/// The state of the loop.
#[derive(Default)]
pub(super) struct Course {
    pub(super) iterations: Vec<Iteration>,
    /// The open loop's drive.
    pub(super) open: Option<Best>,
    /// The best corrected drive, if one was judged better than the open loop.
    pub(super) best: Option<Best>,
    since_best: usize,
    pub(super) end: LoopEnd,
    /// What the bench said when it failed.
    pub(super) failed: Option<String>,
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
pub(super) struct Best {
    pub(super) number: usize,
    pub(super) drive: Series<Drive>,
    pub(super) response: MeasuredResponse,
    pub(super) fit: Fit,
}

/// How a drive was made to fit.
pub(super) struct Fit {
    pub(super) coverage: Coverage,
    /// The attenuated bands, and their share of the lines.
    pub(super) turned_down: Option<(Vec<Band>, f64)>,
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
    pub(super) fn warnings(&self, fits_at: Option<Decibels>) -> Vec<Warning> {
        let turned_down = self.turned_down.clone().zip(fits_at);
        let turned_down = turned_down.map(|((bands, share), fits_at)| {
            Warning::from(RenderWarning::BandPartLost {
                bands,
                share,
                why: PartLost::TurnedDown {
                    fits_at_db: fits_at.0,
                    beyond_limit: None,
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
