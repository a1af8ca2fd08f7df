//! `piezotact-validation rendering`: rendering errors on the twin by method and level, for many people.

#![allow(clippy::print_stdout, reason = "it prints a table")]

use anyhow::{Result, ensure};
use piezotact::clipping::clipping;
use piezotact::correct::CorrectConfig;
use piezotact::device::DeviceDescription;
use piezotact::lineage::Mode;
use piezotact::quantity::{
    Acceleration, Band, Decibels, Degrees, Drive, Hertz, Newtons, SampleRate, Seconds,
};
use piezotact::render::{Inverse, Overload, RenderConfig, RenderError, headroom, render};
use piezotact::run::Discard;
use piezotact::series::Series;
use piezotact::spectrum::WelchConfig;
use piezotact::statistics::mean;
use piezotact::transfer::{Estimator, TransferFunction};
use piezotact::verify::{Measured, VerifyConfig, verify};
use piezotact_bench::procedure::{
    ACCELERATION_CHANNEL, CharacteriseConfig, LoopConfig, characterise, closed_loop,
    play_and_record,
};
use piezotact_bench::{
    Bench, Excitation, ExcitationConfig, Placement, ProcedureError, RunPlan, Until,
};
use piezotact_twin::{Participant, TwinBench, TwinParameters, record_texture};

const PEOPLE: u64 = 20;
const SEED: u64 = 11;
/// Textures from the faintest to the loudest, and how much louder than they are.
const TEXTURES: [(&str, f64); 6] = [
    ("S13", 0.0),
    ("S9", 0.0),
    ("S6", 0.0),
    ("S2", 0.0),
    ("S1", 6.0),
    ("S1", 12.0),
];
const SECONDS: f64 = 3.0;
/// What is asked of a closed loop at a level that fits, dB rms and at most.
const ASKED: (f64, f64) = (1.0, 3.0);

/// How a drive is made.
#[derive(Clone, Copy)]
enum Method {
    Open(Inverse),
    Closed(Mode),
}

const METHODS: [(&str, Method); 6] = [
    ("plain division", Method::Open(Inverse::Plain)),
    ("constant", Method::Open(Inverse::Constant)),
    ("coherence", Method::Open(Inverse::Coherence)),
    ("drive-limited", Method::Open(Inverse::DriveLimited)),
    ("closed, replicate", Method::Closed(Mode::Replicate)),
    ("closed, texture", Method::Closed(Mode::Texture)),
];

/// The result of one method for one texture on one finger.
struct Felt {
    rms_db: f64,
    max_db: f64,
    correlation: f64,
    clipped: f64,
    /// The share of the band that is reached, over which the errors are: 0–1.
    reached: f64,
}

/// Measures and prints the table.
pub(crate) fn run() -> Result<()> {
    println!(
        "\nR1 rendering on the twin: {PEOPLE} people, textures of {SECONDS} s over 20–1000 Hz; dB rms (largest over people) / dB at most / waveform correlation / clipped / share of the band that is reached, over which the errors are"
    );
    let parameters = TwinParameters::built_in();
    let people: Vec<(Participant, TransferFunction<Drive, Acceleration>)> = (1..=PEOPLE)
        .map(|number| {
            let person = Participant::of(number, SEED, &parameters);
            let function = function_of(&parameters, &person)?;
            Ok((person, function))
        })
        .collect::<Result<_>>()?;
    let mut short = Vec::new();
    for (name, louder_db) in TEXTURES {
        let sample = parameters.sample(name)?;
        let reference = Participant::of(0, SEED, &parameters);
        let texture = record_texture(&parameters, &reference, sample, 0.03, Seconds(SECONDS))?.0;
        let texture = texture.amplified(Decibels(louder_db));
        let level = piezotact::statistics::rms(texture.samples());
        println!("  {name} {louder_db:+.0} dB, {level:.2} m/s² rms");
        for (label, method) in METHODS {
            let mut felt = Vec::new();
            let mut offered = Vec::new();
            for (person, function) in &people {
                match feel(&parameters, person, function, &texture, method)? {
                    Outcome::Felt(one) => felt.push(one),
                    Outcome::Refused(fits_at) => offered.push((person, function, fits_at)),
                }
            }
            told(label, &felt);
            let mut closed = felt;
            if !offered.is_empty() {
                let levels: Vec<f64> = offered.iter().map(|(.., fits_at)| fits_at.0).collect();
                println!(
                    "    {label:<18} refused before playing for {} of {PEOPLE}, who are offered {:.1} dB on average; at that level:",
                    offered.len(),
                    mean(&levels)
                );
                let mut fitting = Vec::new();
                for (person, function, fits_at) in offered {
                    let softer = texture.clone().amplified(fits_at);
                    match feel(&parameters, person, function, &softer, method)? {
                        Outcome::Felt(one) => fitting.push(one),
                        Outcome::Refused(still) => short.push(format!(
                            "{name} {louder_db:+.0} dB, {label}, {}: {still} still does not fit",
                            person.pseudonym()
                        )),
                    }
                }
                told("", &fitting);
                closed.extend(fitting);
            }
            if matches!(method, Method::Closed(_)) {
                let (rms_db, max_db) = (most(&closed, |f| f.rms_db), most(&closed, |f| f.max_db));
                if rms_db > ASKED.0 || max_db > ASKED.1 {
                    short.push(format!(
                        "{name} {louder_db:+.0} dB, {label}: {rms_db:.2} dB rms, {max_db:.1} dB at most"
                    ));
                }
            }
        }
    }
    ensure!(
        short.is_empty(),
        "closed loops asked for {} dB rms and {} dB at most: {}",
        ASKED.0,
        ASKED.1,
        short.join("; ")
    );
    println!(
        "  every closed loop at a level that fits: at most {} dB rms and {} dB",
        ASKED.0, ASKED.1
    );
    Ok(())
}

/// The result of one method for one person.
enum Outcome {
    Felt(Felt),
    /// It was refused before anything played; the level that is offered.
    Refused(Decibels),
}

fn most(felt: &[Felt], of: fn(&Felt) -> f64) -> f64 {
    felt.iter().map(of).fold(f64::NEG_INFINITY, f64::max)
}

fn told(label: &str, felt: &[Felt]) {
    if felt.is_empty() {
        return;
    }
    let average = |of: fn(&Felt) -> f64| mean(&felt.iter().map(of).collect::<Vec<f64>>());
    println!(
        "    {label:<18} {:>5.2} ({:>5.2}) dB rms  {:>5.1} dB at most  r {:.3}  {:>5.2} % clipped  {:>3.0} % of the band",
        average(|f| f.rms_db),
        most(felt, |f| f.rms_db),
        most(felt, |f| f.max_db),
        average(|f| f.correlation),
        100.0 * average(|f| f.clipped),
        100.0 * average(|f| f.reached),
    );
}

fn bench_of(parameters: &TwinParameters, person: &Participant) -> Bench {
    TwinBench::new(
        parameters,
        person.clone(),
        &DeviceDescription::drv2667().at_usual_gain(),
    )
    .into_bench()
}

fn run_plan(label: &str) -> RunPlan {
    RunPlan {
        label: label.into(),
        load: Some(Newtons(0.2)),
        angle: Degrees(20.0),
        placement: Placement::New,
        until: Until::PlaybackEnded,
    }
}

fn function_of(
    parameters: &TwinParameters,
    person: &Participant,
) -> Result<TransferFunction<Drive, Acceleration>> {
    let config = CharacteriseConfig {
        excitation: ExcitationConfig {
            kind: Excitation::Random,
            band: Band::new(Hertz(2.0), Hertz(1_200.0))?,
            duration: Seconds(30.0),
            peak: 0.8,
            seed: SEED,
        },
        welch: WelchConfig::hann(2_048),
        estimator: Estimator::H1,
        run: run_plan("characterise"),
    };
    Ok(characterise(&mut bench_of(parameters, person), &config, &mut Discard)?.function)
}

fn rendering() -> Result<RenderConfig> {
    Ok(RenderConfig::over(
        Band::new(Hertz(20.0), Hertz(1_000.0))?,
        SampleRate::new(48_000.0)?,
    ))
}

fn feel(
    parameters: &TwinParameters,
    person: &Participant,
    function: &TransferFunction<Drive, Acceleration>,
    texture: &Series<Acceleration>,
    method: Method,
) -> Result<Outcome> {
    let mut config = rendering()?;
    let mut bench = bench_of(parameters, person);
    let verification = match method {
        Method::Open(inverse) => {
            config.inverse.inverse = inverse;
            config.clipping = Overload::Allow;
            let rendered = render(texture, function, &config)?;
            let recording = play_and_record(
                &mut bench,
                &rendered.drive,
                None,
                &run_plan("play"),
                &mut Discard,
                None,
            )?;
            let response = recording.series::<Acceleration>(Some(ACCELERATION_CHANNEL))?;
            let asked = headroom(
                rendered.drive.samples(),
                rendered.drive.rate(),
                rendered.setup.as_ref(),
            );
            let measured = Measured {
                response: &response,
                clipping: clipping(&response, None, Some(asked.clipped_fraction)),
            };
            let judged = VerifyConfig {
                reached: rendered.coverage.reached.clone(),
                ..VerifyConfig::over(config.inverse.band, texture.rate().hz())
            };
            verify(texture, measured, &judged)?
        }
        Method::Closed(mode) => {
            let loop_config = LoopConfig {
                judged: config.inverse.band,
                render: config,
                correct: CorrectConfig::usual(mode),
                iterations: 4,
                force_share: 0.1,
                run: run_plan("loop"),
            };
            let looped = closed_loop(
                &mut bench,
                texture,
                function,
                &loop_config,
                &mut Discard,
                &mut |_| {},
            );
            match looped {
                Ok(looped) => looped.best_verification().clone(),
                Err(ProcedureError::Render(RenderError::ExceedsFullScale { fits_at, .. })) => {
                    return Ok(Outcome::Refused(fits_at));
                }
                Err(error) => anyhow::bail!("{}: {error}", person.pseudonym()),
            }
        }
    };
    let width = |bands: &[Band]| bands.iter().map(|b| b.high().0 - b.low().0).sum::<f64>();
    let reached = width(&verification.achievable_band_hz);
    Ok(Outcome::Felt(Felt {
        rms_db: verification.judged_error_db(),
        max_db: verification.error_db_max_achievable(),
        correlation: verification.waveform_correlation,
        clipped: verification.clipped_fraction,
        reached: reached / width(&[verification.band_hz]),
    }))
}
