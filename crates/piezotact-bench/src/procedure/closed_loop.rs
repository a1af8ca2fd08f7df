//! Rendering in a closed loop: play, measure, correct, and judge each drive by a measurement of its own.

use std::fmt;

use piezotact::Doubt;
use piezotact::correct::{CorrectConfig, Correction, Step};
use piezotact::quantity::{Acceleration, Band, Drive, Force, Seconds};
use piezotact::recording::Recording;
use piezotact::render::{RenderConfig, RenderedDrive, headroom, render};
use piezotact::resample::to_common_rate;
use piezotact::series::{Series, mean, rms};
use piezotact::spectrum::WelchPlan;
use piezotact::transfer::TransferFunction;
use piezotact::verify::{
    Measured, Verification, VerifyConfig, clipping, flat_top_fraction, verify,
};

use super::{ACCELERATION_CHANNEL, FORCE_CHANNEL, Keep, play_and_record};
use crate::traits::{Bench, BenchError, Lying, RunPlan};

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
    /// The mean force of ten seconds may depart from its target by this share; that of a shorter drive by more, with the
    /// root of the time.
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
    /// It got worse by more than a decibel.
    Worse,
    /// A measurement could not be believed.
    Broken(String),
}

impl fmt::Display for LoopEnd {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Done => f.write_str("corrected as often as asked"),
            Self::NoBetter => f.write_str("it got no better twice in a row"),
            Self::Worse => f.write_str("it got worse by more than 1 dB"),
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
    /// What was recorded when the best drive was judged.
    pub recording: Recording,
}

/// How long the noise is listened to before anything is played, s.
const SILENCE_S: f64 = 4.0;
/// The time over which the mean force keeps to its share, s.
const WINDOW_S: f64 = 10.0;
/// A response that is no more than this times its noise is none.
const SILENT_RATIO: f64 = 2.0;

/// Renders `target` on `bench` and corrects the drive by what is measured of it. Every drive is played twice: the first
/// measurement corrects, the second judges. The best drive so far is kept, and the loop ends when it gets no better; it
/// never plays what the device cannot.
///
/// # Errors
/// [`BenchError::Render`] when the first drive does not fit the device (with the level that does) or the target cannot be
/// rendered; [`BenchError::Broken`] when the first measurement already cannot be believed; whatever the bench returns.
pub fn closed_loop(
    bench: &mut Bench,
    target: &Series<Acceleration>,
    function: &TransferFunction<Drive, Acceleration>,
    config: &LoopConfig,
    told: &mut dyn FnMut(&Iteration),
) -> Result<Looped, BenchError> {
    let first = render(target, function, &config.render)?;
    let mut correction = Correction::new(target, function, &config.render, &config.correct)?;
    let noise = listen(bench, target, &correction, config)?;
    let mut iterations: Vec<Iteration> = Vec::new();
    let mut best: Option<Best> = None;
    let mut since_best = 0;
    let mut end = LoopEnd::Done;
    for number in 0..=config.iterations {
        let drive = correction.drive()?;
        let reached = correction.reached();
        let learned = measured(
            bench,
            &drive,
            function,
            config,
            (number, "corrects"),
            &noise,
        );
        let judging = learned.and_then(|learned| {
            let judged = measured(bench, &drive, function, config, (number, "judges"), &noise)?;
            Ok((learned, judged))
        });
        let ((_, response), (recording, judged)) = match judging {
            Ok(both) => both,
            Err(Broken::Bench(error)) => return Err(error),
            Err(Broken::Unbelievable(why)) => {
                if iterations.is_empty() {
                    return Err(BenchError::Broken(why));
                }
                end = LoopEnd::Broken(why);
                break;
            }
        };
        let judge =
            |response: &Series<Acceleration>| compared(target, response, &reached[0], config);
        let verification = judge(&judged)?;
        let error_db = error_of(&verification);
        let best_db = best.as_ref().map_or(f64::INFINITY, |best| {
            error_of(&iterations[best.number].verification)
        });
        iterations.push(Iteration {
            number,
            verification,
            held: correction.held(),
            step: None,
        });
        if error_db < best_db - 0.005 {
            best = Some(Best {
                number,
                drive,
                recording,
                reached: reached.clone(),
            });
            since_best = 0;
        } else {
            since_best += 1;
        }
        let worse = error_db > best_db + 1.0;
        if worse || since_best >= 2 {
            end = if worse {
                LoopEnd::Worse
            } else {
                LoopEnd::NoBetter
            };
        }
        if end == LoopEnd::Done && number < config.iterations {
            let aligned = judge(&response)?;
            let step = correction.learn(&aligned.aligned, &noise);
            iterations[number].step =
                Some(step.map_err(|error| impossible("a measurement with a spectrum", &error))?);
        }
        told(&iterations[number]);
        if end != LoopEnd::Done {
            break;
        }
    }
    let Some(best) = best else {
        return Err(BenchError::Broken("no drive could be judged".into()));
    };
    let step = format!("corrected on the {}", bench.player.describe().name);
    let first = RenderedDrive {
        provenance: first.provenance.clone().then(step),
        ..first
    };
    let mut rendered = finished(
        first,
        best.drive,
        config,
        (&iterations[best.number], &end),
        best.reached,
    );
    rendered.doubts.extend(bench.acquirer.doubts(&config.run));
    Ok(Looped {
        iterations,
        best: best.number,
        end,
        rendered,
        recording: best.recording,
    })
}

/// The best drive so far.
struct Best {
    number: usize,
    drive: Series<Drive>,
    recording: Recording,
    /// The parts of the band that it reaches, and those that were given up.
    reached: [Vec<Band>; 2],
}

fn impossible(expected: &str, error: &dyn fmt::Display) -> BenchError {
    BenchError::Impossible {
        expected: expected.into(),
        found: error.to_string(),
        todo: "check rates, lengths and bands of target and bench".into(),
    }
}

fn error_of(verification: &Verification) -> f64 {
    verification
        .error_db_rms_achievable
        .unwrap_or(verification.error_db_rms)
}

/// The first rendering with the loop's drive in its place.
fn finished(
    first: RenderedDrive,
    drive: Series<Drive>,
    config: &LoopConfig,
    (best, end): (&Iteration, &LoopEnd),
    [achieved, given_up]: [Vec<Band>; 2],
) -> RenderedDrive {
    let headroom = headroom(drive.samples(), drive.rate(), first.setup.as_ref());
    let mut doubts = first.doubts;
    if best.held > 0.0 {
        doubts.push(Doubt::Clipped {
            what: "the corrected drive".into(),
            fraction: best.held,
        });
    }
    if matches!(end, LoopEnd::Worse | LoopEnd::Broken(_)) {
        doubts.push(Doubt::LoopStopped {
            best: best.number,
            why: end.to_string(),
        });
    }
    let (achievable, lost) = if given_up.is_empty() {
        (first.achievable, first.given_up)
    } else {
        (achieved, given_up)
    };
    RenderedDrive {
        drive,
        headroom,
        achievable,
        given_up: lost,
        provenance: first.provenance.then(format!(
            "closed loop, {}: iteration {} of at most {}, judged by a measurement of its own at {:.2} dB rms; {end}",
            config.correct.mode.name(),
            best.number,
            config.iterations,
            error_of(&best.verification)
        )),
        doubts,
        ..first
    }
}

/// Why a measurement does not count.
enum Broken {
    Bench(BenchError),
    Unbelievable(String),
}

impl From<BenchError> for Broken {
    fn from(error: BenchError) -> Self {
        Self::Bench(error)
    }
}

fn nobody_keeps()
-> impl FnMut(&crate::Chunk) -> Result<(), Box<dyn std::error::Error + Send + Sync>> {
    |_| Ok(())
}

fn run_of(config: &LoopConfig, label: String) -> RunPlan {
    RunPlan {
        label,
        lying: Lying::AsIn(config.run.put_down_for().into()),
        ..config.run.clone()
    }
}

/// The PSD of the response to silence, on the lines of the correction's spectra.
fn listen(
    bench: &mut Bench,
    target: &Series<Acceleration>,
    correction: &Correction,
    config: &LoopConfig,
) -> Result<Vec<f64>, BenchError> {
    let rate = bench.player.describe().rate;
    let silence = Series::<Drive>::new(vec![0.0; rate.samples_in(Seconds(SILENCE_S))], rate)?;
    let keep: Keep<'_> = &mut nobody_keeps();
    let run = run_of(config, format!("{}, silence", config.run.label));
    let recording = play_and_record(bench, &silence, None, &run, keep)?;
    let response = recording.series::<Acceleration>(Some(ACCELERATION_CHANNEL))?;
    let common = to_common_rate(("the target", target.clone()), ("the noise", response))
        .map_err(|error| impossible("rates that go together", &error))?;
    let mut plan = WelchPlan::new(correction.welch(), common.second.rate())
        .map_err(|error| impossible("a spectrum of the noise", &error))?;
    let psd = plan
        .estimate::<Acceleration>(&[common.second.samples()])
        .map_err(|error| impossible("a spectrum of the noise", &error))?;
    Ok(psd.values)
}

/// Plays `drive`, and again where the force was not held; the recording and the response.
fn measured(
    bench: &mut Bench,
    drive: &Series<Drive>,
    function: &TransferFunction<Drive, Acceleration>,
    config: &LoopConfig,
    (number, what): (usize, &str),
    noise_psd: &[f64],
) -> Result<(Recording, Series<Acceleration>), Broken> {
    let mut why = String::new();
    for attempt in 1..=2 {
        let run = run_of(
            config,
            format!(
                "{}, iteration {number} {what}, attempt {attempt}",
                config.run.label
            ),
        );
        let keep: Keep<'_> = &mut nobody_keeps();
        let recording = play_and_record(bench, drive, function.drive.as_ref(), &run, keep)?;
        let response = recording
            .series::<Acceleration>(Some(ACCELERATION_CHANNEL))
            .map_err(BenchError::from)?;
        match believable(&recording, &response, config, noise_psd) {
            Ok(()) => return Ok((recording, response)),
            Err(reason) => why = reason,
        }
    }
    Err(Broken::Unbelievable(why))
}

fn believable(
    recording: &Recording,
    response: &Series<Acceleration>,
    config: &LoopConfig,
    noise_psd: &[f64],
) -> Result<(), String> {
    if let (Some(load), Ok(force)) = (
        config.run.load,
        recording.series::<Force>(Some(FORCE_CHANNEL)),
    ) {
        let mean_n = mean(force.samples());
        // A hand wanders: over less than ten seconds its mean does so more.
        let share = config.force_share * (WINDOW_S / force.duration().0).sqrt().max(1.0);
        if (mean_n / load.0 - 1.0).abs() > share {
            return Err(format!(
                "the force averaged {mean_n:.3} N, expected {} N ± {:.0} %: hold the finger so that the display shows it",
                load.0,
                share * 100.0
            ));
        }
    }
    let fraction = flat_top_fraction(response.samples());
    if fraction > 0.0 {
        return Err(format!(
            "{:.1} % of the response stands at a limit: the sensor clips; take its larger range, or render softer",
            fraction * 100.0
        ));
    }
    // Noise power over all lines: the lines are as far apart as the PSD is dense.
    let lines = noise_psd.len().max(2);
    let noise: f64 =
        noise_psd.iter().sum::<f64>() * response.rate().nyquist().0 / (lines - 1) as f64;
    if rms(response.samples()) < SILENT_RATIO * noise.sqrt() {
        return Err(
            "the response is no louder than its noise: the finger lifted, the sensor came off, or the amplifier is off".into(),
        );
    }
    Ok(())
}

fn compared(
    target: &Series<Acceleration>,
    response: &Series<Acceleration>,
    achievable: &[Band],
    config: &LoopConfig,
) -> Result<Verification, BenchError> {
    let clipped = clipping(response, None, None);
    let common = to_common_rate(
        ("the target", target.clone()),
        ("the measurement", response.clone()),
    )
    .map_err(|error| impossible("rates that go together", &error))?;
    let verify_config = VerifyConfig {
        achievable: achievable.to_vec(),
        ..VerifyConfig::over(config.judged, common.first.rate().hz())
    };
    let measured = Measured {
        response: &common.second,
        clipping: clipped,
    };
    verify(&common.first, measured, &verify_config)
        .map_err(|error| impossible("a measurement that can be compared", &error))
}
