//! Rendering in a closed loop: play, measure, correct, and judge each drive by a measurement of its own.

mod measured;

use std::fmt;

use piezotact::Doubt;
use piezotact::correct::{CorrectConfig, Correction, Mode, Step};
use piezotact::device::DriveSetup;
use piezotact::quantity::{Acceleration, Band, Drive};
use piezotact::recording::Recording;
use piezotact::render::{
    Clipping, Inverse, RenderConfig, RenderError, RenderedDrive, achievable, headroom, render,
};
use piezotact::resample::resample;
use piezotact::series::Series;
use piezotact::transfer::TransferFunction;
use piezotact::verify::{Measured, Verification, VerifyConfig, verify};

use crate::traits::{Bench, BenchError, RunPlan};
use measured::{Broken, Felt, Listener};

/// How a texture is rendered in a closed loop.
#[derive(Clone, Debug, PartialEq)]
pub struct LoopConfig {
    /// How the first drive is made, and the band.
    pub render: RenderConfig,
    /// How it is corrected.
    pub correct: CorrectConfig,
    /// The band over which it is judged.
    pub judged: Band,
    /// How often it is corrected at most.
    pub iterations: usize,
    /// The mean force of every ten seconds may depart from its target by this share; that of a shorter drive by more, with
    /// the root of the time, up to three times as much.
    pub force_share: f64,
    /// Who touches how.
    pub run: RunPlan,
}

/// One drive of the loop, judged by a measurement that did not make it.
#[derive(Clone, Debug)]
pub struct Iteration {
    /// Its number; 0 is the open loop.
    pub number: usize,
    /// What was found.
    pub verification: Verification,
    /// What the loop makes small, dB: for a texture the rms error of the spectrum over what the inverse reaches, for a
    /// waveform the power of its difference over that of the target (NMSE).
    pub aim_db: f64,
    /// The share of its samples that stood at the device's limit, 0–1.
    pub held: f64,
    /// What the step that followed changed; none after the last.
    pub step: Option<Step>,
}

/// Why a loop ended.
#[derive(Clone, Debug, PartialEq)]
pub enum LoopEnd {
    /// It was corrected as often as asked.
    Done,
    /// It got no better twice in a row.
    NoBetter,
    /// It got clearly worse.
    Worse,
    /// A measurement could not be believed.
    Broken(String),
}

impl fmt::Display for LoopEnd {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Done => f.write_str("corrected as often as asked"),
            Self::NoBetter => f.write_str("it got no better twice in a row"),
            Self::Worse => f.write_str("it got clearly worse"),
            Self::Broken(why) => write!(f, "a measurement could not be believed: {why}"),
        }
    }
}

/// A texture rendered in a closed loop.
#[derive(Clone, Debug)]
pub struct Looped {
    /// Every drive that was judged.
    pub iterations: Vec<Iteration>,
    /// The number of the best.
    pub best: usize,
    /// Why it ended.
    pub end: LoopEnd,
    /// The best drive.
    pub rendered: RenderedDrive,
    /// What was found when the best drive was measured once more, by a measurement that did not choose it.
    pub confirmed: Verification,
    /// What was recorded then.
    pub recording: Recording,
}

/// A spectrum has to get better by so much to be no luck, and is clearly worse by so much, dB.
const SPECTRUM_DB: (f64, f64) = (0.005, 1.0);
/// The same of a waveform, which differs by more each time.
const WAVEFORM_DB: (f64, f64) = (0.2, 3.0);
/// Waveforms so close to the best are as good, and their spectra decide, dB.
const ALIKE_DB: f64 = 0.5;
/// So often in a row it may get no better.
const PATIENCE: usize = 2;
/// Below this correlation with what was asked for, pressing crests is worth a doubt.
const UNLIKE: f64 = 0.98;

/// Renders `target` on `bench` and corrects the drive by what is measured of it. Every drive is played twice: the second
/// measurement judges it, and both, with what they share, make the next; so no drive is judged by what made it. The best
/// so far is kept, the loop ends when it gets no better, and the best is measured once more. It never plays what the device cannot, and works at the lower rate of target and bench.
///
/// # Errors
/// [`BenchError::Render`] when the first drive does not fit the device (with the level that does) or the target cannot be
/// rendered; [`BenchError::Broken`] when the first measurement already cannot be believed; whatever the bench returns before
/// there is a drive to keep.
pub fn closed_loop(
    bench: &mut Bench,
    target: &Series<Acceleration>,
    function: &TransferFunction<Drive, Acceleration>,
    config: &LoopConfig,
    told: &mut dyn FnMut(&Iteration),
) -> Result<Looped, BenchError> {
    let (target, converted) = at_a_common_rate(target, bench)?;
    let mut first = opened(&target, function, config)?;
    first.doubts.extend(converted);
    // A transfer function that does not say its device is used on this one.
    let mut function = function.clone();
    if function.drive.is_none() {
        function.drive = bench.player.calibrate()?;
    }
    first.setup.clone_from(&function.drive);
    let (reached, ..) = achievable(&function, &config.render)?;
    let mut correction = Correction::new(&target, &function, &config.render, &config.correct)?;
    let mut drive = correction.drive()?;
    let free = config.render.inverse.inverse == Inverse::DriveLimited
        || config.render.clipping == Clipping::Allow;
    if !free && !correction.fits() {
        return Err(refused(&mut correction, function.drive.as_ref()).into());
    }
    let mut listener = Listener {
        bench,
        config,
        setup: function.drive.clone(),
        rate: target.rate(),
        noise: None,
    };
    let noise = listener.listen(correction.welch())?.clone();
    let hidden = correction
        .hidden(&noise)
        .map_err(|error| impossible("a target with a spectrum", &error))?;
    first.doubts.extend(hidden);
    let judge = |felt: &Felt| judged(&target, felt, &reached, config);

    let mut iterations: Vec<Iteration> = Vec::new();
    let mut best: Option<Best> = None;
    let mut since_best = 0;
    let mut end = LoopEnd::Done;
    for number in 0..=config.iterations {
        let mut both = || -> Result<(Series<Acceleration>, Felt, Verification), Broken> {
            let first = listener.feel(&drive, &format!("iteration {number}, first"))?;
            let felt = listener.feel(&drive, &format!("iteration {number}, second"))?;
            let verification = judge(&felt)?;
            Ok((first.response, felt, verification))
        };
        let (learned, felt, verification) = match both() {
            Ok(both) => both,
            Err(broken) if best.is_some() => {
                end = LoopEnd::Broken(broken.to_string());
                break;
            }
            Err(Broken::Bench(error)) => return Err(error),
            Err(Broken::Unbelievable(why)) => return Err(BenchError::Broken(why)),
        };
        let judging = felt.response.clone();
        let aim_db = aim_of(&verification, config.correct.mode);
        let best_db = best
            .as_ref()
            .map_or(f64::INFINITY, |best| iterations[best.number].aim_db);
        iterations.push(Iteration {
            number,
            aim_db,
            verification,
            held: correction.held(),
            step: None,
        });
        let spectrum_db = iterations[number].verification.judged_error_db();
        let best_spectrum_db = best.as_ref().map_or(f64::INFINITY, |best| {
            iterations[best.number].verification.judged_error_db()
        });
        let (better_db, worse_db) = match config.correct.mode {
            Mode::Texture => SPECTRUM_DB,
            Mode::Replicate => WAVEFORM_DB,
        };
        // The strong lines make a waveform; of two that are alike the one whose weak lines are right too is better.
        let least_db = iterations
            .iter()
            .map(|i| i.aim_db)
            .fold(f64::INFINITY, f64::min);
        let alike = config.correct.mode == Mode::Replicate
            && aim_db < least_db + ALIKE_DB
            && spectrum_db < best_spectrum_db - SPECTRUM_DB.0;
        if aim_db < best_db - better_db || alike {
            best = Some(Best {
                number,
                drive: drive.clone(),
                felt,
                fit: Fit::of(&mut correction),
            });
            since_best = 0;
        } else {
            since_best += 1;
        }
        if aim_db > best_db + worse_db {
            end = LoopEnd::Worse;
        } else if since_best >= PATIENCE {
            end = LoopEnd::NoBetter;
        }
        if end == LoopEnd::Done && number < config.iterations {
            let step = correction.learn(&[&learned, &judging], &noise);
            iterations[number].step =
                Some(step.map_err(|error| impossible("a measurement with a spectrum", &error))?);
            drive = correction.drive()?;
        }
        told(&iterations[number]);
        if end != LoopEnd::Done {
            break;
        }
    }
    let Some(best) = best else {
        return Err(BenchError::Broken("no drive could be judged".into()));
    };
    // What is told of the best is measured once more: of several measurements the smallest is partly luck.
    let again = listener.feel(
        &best.drive,
        &format!("iteration {}, once more", best.number),
    );
    let confirmed = again.and_then(|felt| Ok((judge(&felt)?, felt)));
    let (confirmed, felt, unconfirmed) = match confirmed {
        Ok((verification, felt)) => (verification, felt, None),
        Err(broken) => (
            iterations[best.number].verification.clone(),
            best.felt,
            Some(Doubt::LoopStopped {
                best: best.number,
                why: format!("the best drive could not be measured once more: {broken}"),
            }),
        ),
    };
    let mut rendered = finished(
        first,
        best.drive,
        config,
        &best.fit,
        (&iterations[best.number], &end),
    );
    rendered.provenance = rendered.provenance.then(format!(
        "measured once more at {:.2} dB rms, NMSE {:.1} dB, on the {}",
        confirmed.judged_error_db(),
        confirmed.waveform_nmse_db,
        bench.player.describe().name
    ));
    let condition = felt.recording.condition.clone();
    let others = function.condition.doubts_when_measured(&condition);
    let new = others
        .into_iter()
        .chain(unconfirmed)
        .chain(felt.recording.doubts.iter().cloned())
        .chain(confirmed.doubts.iter().cloned());
    for doubt in new {
        if !rendered.doubts.contains(&doubt) {
            rendered.doubts.push(doubt);
        }
    }
    // It was corrected on the finger that was there.
    rendered.condition = condition;
    Ok(Looped {
        iterations,
        best: best.number,
        end,
        rendered,
        confirmed,
        recording: felt.recording,
    })
}

/// The best drive so far.
struct Best {
    number: usize,
    drive: Series<Drive>,
    felt: Felt,
    fit: Fit,
}

/// How a drive was made to fit.
struct Fit {
    achieved: Vec<Band>,
    given_up: Vec<Band>,
    doubts: Vec<Doubt>,
}

impl Fit {
    fn of(correction: &mut Correction<Acceleration>) -> Self {
        let mut doubts = Vec::new();
        let turned_down = correction.turned_down();
        if let Some((bands, share)) = turned_down {
            doubts.push(Doubt::TurnedDown {
                bands,
                share,
                fits_at_db: correction.fits_at().0,
            });
        }
        if correction.likeness() < UNLIKE {
            doubts.push(Doubt::CrestsPressed {
                correlation: correction.likeness(),
            });
        }
        if correction.held() > 0.0 {
            doubts.push(Doubt::Clipped {
                what: "the corrected drive".into(),
                fraction: correction.held(),
            });
        }
        let (achieved, given_up) = correction.reached();
        Self {
            achieved,
            given_up,
            doubts,
        }
    }
}

fn impossible(expected: &str, error: &dyn fmt::Display) -> BenchError {
    BenchError::Impossible {
        expected: expected.into(),
        found: error.to_string(),
        todo: "check rates, lengths and bands of target and bench".into(),
    }
}

/// `target` at no higher rate than the bench acquires with.
fn at_a_common_rate(
    target: &Series<Acceleration>,
    bench: &Bench,
) -> Result<(Series<Acceleration>, Option<Doubt>), BenchError> {
    let (from, to) = (target.rate(), bench.acquirer.describe().rate);
    if from.hz() <= to.hz() {
        return Ok((target.clone(), None));
    }
    let lower =
        resample(target, to).map_err(|error| impossible("rates that go together", &error))?;
    let doubt = Doubt::RateConverted {
        what: "the target".into(),
        from_hz: from.hz(),
        to_hz: to.hz(),
    };
    Ok((lower, Some(doubt)))
}

/// The open loop's drive with what is known of it, but for how it fits, which the loop decides.
fn opened(
    target: &Series<Acceleration>,
    function: &TransferFunction<Drive, Acceleration>,
    config: &LoopConfig,
) -> Result<RenderedDrive, RenderError> {
    let mut open = config.render.clone();
    open.clipping = Clipping::Allow;
    if open.inverse.inverse == Inverse::DriveLimited {
        open.inverse.inverse = Inverse::Constant;
    }
    let mut first = render(target, function, &open)?;
    first.config = config.render.clone();
    first
        .doubts
        .retain(|doubt| !matches!(doubt, Doubt::Clipped { .. } | Doubt::SlewLimited { .. }));
    Ok(first)
}

/// Why a drive that does not fit is not played, with the level at which it does.
fn refused(correction: &mut Correction<Acceleration>, setup: Option<&DriveSetup>) -> RenderError {
    RenderError::ExceedsFullScale {
        peak: correction.asked(),
        limit: setup.map_or(1.0, DriveSetup::drive_limit),
        limited_by: setup
            .map_or("the digital full scale", DriveSetup::limited_by)
            .into(),
        fits_at: correction.fits_at(),
    }
}

/// What the loop makes small, dB.
fn aim_of(verification: &Verification, mode: Mode) -> f64 {
    match mode {
        Mode::Texture => verification.judged_error_db(),
        Mode::Replicate => verification.waveform_nmse_db,
    }
}

/// How close what was felt came to `target`, over what the inverse `reached`: the same for every drive of a loop.
fn judged(
    target: &Series<Acceleration>,
    felt: &Felt,
    reached: &[Band],
    config: &LoopConfig,
) -> Result<Verification, Broken> {
    let verify_config = VerifyConfig {
        achievable: reached.to_vec(),
        ..VerifyConfig::over(config.judged, target.rate().hz())
    };
    let measured = Measured {
        response: &felt.response,
        clipping: felt.clipping.clone(),
    };
    let verification = verify(target, measured, &verify_config)
        .map_err(|error| impossible("a measurement that can be compared", &error))?;
    let wrong = |doubt: &&Doubt| matches!(doubt, Doubt::Inverted { .. } | Doubt::Cut { .. });
    match verification.doubts.iter().find(wrong) {
        Some(doubt) => Err(Broken::Unbelievable(doubt.to_string())),
        None => Ok(verification),
    }
}

/// The first rendering with the loop's drive in its place.
fn finished(
    first: RenderedDrive,
    drive: Series<Drive>,
    config: &LoopConfig,
    fit: &Fit,
    (best, end): (&Iteration, &LoopEnd),
) -> RenderedDrive {
    let headroom = headroom(drive.samples(), drive.rate(), first.setup.as_ref());
    let mut doubts = first.doubts;
    doubts.extend(fit.doubts.iter().cloned());
    doubts.extend(headroom.slew_doubt(first.setup.as_ref()));
    if matches!(end, LoopEnd::Worse | LoopEnd::Broken(_)) {
        doubts.push(Doubt::LoopStopped {
            best: best.number,
            why: end.to_string(),
        });
    }
    RenderedDrive {
        drive,
        headroom,
        aim: Some(config.correct.mode),
        achievable: fit.achieved.clone(),
        given_up: fit.given_up.clone(),
        provenance: first.provenance.then(format!(
            "closed loop, {}: iteration {} of at most {}, judged by a measurement of its own at {:.2} dB; {end}",
            config.correct.mode.name(),
            best.number,
            config.iterations,
            best.aim_db
        )),
        doubts,
        ..first
    }
}
