//! `xtask bench R1`: how well textures are rendered on the twin, by method and level, for many people.

#![allow(clippy::print_stdout, reason = "it prints a table")]

use anyhow::{Result, ensure};
use piezotact::correct::{CorrectConfig, Mode};
use piezotact::device::AmplifierGain;
use piezotact::quantity::{
    Acceleration, Band, Decibels, Degrees, Drive, Hertz, Newtons, SampleRate, Seconds,
};
use piezotact::render::{Clipping, Inverse, RenderConfig, RenderError, headroom, render};
use piezotact::series::{Series, mean};
use piezotact::spectrum::WelchConfig;
use piezotact::transfer::{Estimator, TransferFunction};
use piezotact::verify::{Measured, Verification, VerifyConfig, clipping, verify};
use piezotact_bench::procedure::{
    ACCELERATION_CHANNEL, CharacteriseConfig, LoopConfig, characterise, closed_loop,
    play_and_record,
};
use piezotact_bench::twin::{Participant, TwinBench, TwinParameters, record_texture};
use piezotact_bench::{Bench, BenchError, Excitation, ExcitationConfig, Lying, RunPlan};

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

/// What one method did with one texture on one finger.
struct Felt {
    rms_db: f64,
    max_db: f64,
    correlation: f64,
    clipped: f64,
}

/// Measures and prints the table.
pub(crate) fn run() -> Result<()> {
    println!(
        "\nR1 rendering on the twin: {PEOPLE} people, textures of {SECONDS} s over 20–1000 Hz; dB rms (largest over people) / dB at most / waveform correlation / clipped"
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
        let level = piezotact::series::rms(texture.samples());
        let fits: Vec<f64> = people
            .iter()
            .filter_map(|(_, function)| does_not_fit(&texture, function))
            .collect();
        let told = match fits.len() {
            0 => "fits everybody".to_owned(),
            n => format!(
                "does not fit {n} of {PEOPLE}, who are offered {:.1} dB on average",
                mean(&fits)
            ),
        };
        println!("  {name} {louder_db:+.0} dB, {level:.2} m/s² rms: {told}");
        for (label, method) in METHODS {
            let mut felt = Vec::new();
            let mut refused = 0;
            for (person, function) in &people {
                let fits = does_not_fit(&texture, function).is_none();
                if !fits && matches!(method, Method::Closed(_)) {
                    refused += 1;
                    continue;
                }
                felt.push(feel(&parameters, person, function, &texture, method)?);
            }
            if felt.is_empty() {
                println!("    {label:<18} refused before playing for all {refused}");
                continue;
            }
            let of =
                |value: &dyn Fn(&Felt) -> f64| -> Vec<f64> { felt.iter().map(value).collect() };
            let most = |values: &[f64]| values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let (rms_db, max_db) = (of(&|f| f.rms_db), of(&|f| f.max_db));
            println!(
                "    {label:<18} {:>5.2} ({:>5.2}) dB rms  {:>5.1} dB at most  r {:.3}  {:>5.2} % clipped{}",
                mean(&rms_db),
                most(&rms_db),
                most(&max_db),
                mean(&of(&|f| f.correlation)),
                100.0 * mean(&of(&|f| f.clipped)),
                if refused > 0 {
                    format!("; refused before playing for {refused}")
                } else {
                    String::new()
                }
            );
            if matches!(method, Method::Closed(_))
                && (most(&rms_db) > ASKED.0 || most(&max_db) > ASKED.1)
            {
                short.push(format!(
                    "{name} {louder_db:+.0} dB, {label}: {:.2} dB rms, {:.1} dB at most",
                    most(&rms_db),
                    most(&max_db)
                ));
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

fn bench_of(parameters: &TwinParameters, person: &Participant) -> Bench {
    TwinBench::new(parameters, person.clone(), AmplifierGain::B3).into_bench()
}

fn run_plan(label: &str) -> RunPlan {
    RunPlan {
        label: label.into(),
        load: Some(Newtons(0.2)),
        angle: Degrees(20.0),
        lying: Lying::Anew,
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
    Ok(characterise(&mut bench_of(parameters, person), &config, &mut |_| Ok(()))?.function)
}

fn rendering() -> Result<RenderConfig> {
    Ok(RenderConfig::over(
        Band::new(Hertz(20.0), Hertz(1_000.0))?,
        SampleRate::new(48_000.0)?,
    ))
}

/// The level at which a texture that does not fit a device would, dB.
fn does_not_fit(
    texture: &Series<Acceleration>,
    function: &TransferFunction<Drive, Acceleration>,
) -> Option<f64> {
    match render(texture, function, &rendering().ok()?) {
        Err(RenderError::ExceedsFullScale { fits_at, .. }) => Some(fits_at.0),
        _ => None,
    }
}

fn feel(
    parameters: &TwinParameters,
    person: &Participant,
    function: &TransferFunction<Drive, Acceleration>,
    texture: &Series<Acceleration>,
    method: Method,
) -> Result<Felt> {
    let mut config = rendering()?;
    let mut bench = bench_of(parameters, person);
    let verification = match method {
        Method::Open(inverse) => {
            config.inverse.inverse = inverse;
            config.clipping = Clipping::Allow;
            let rendered = render(texture, function, &config)?;
            let recording = play_and_record(
                &mut bench,
                &rendered.drive,
                None,
                &run_plan("play"),
                &mut |_| Ok(()),
            )?;
            let response = recording.series::<Acceleration>(Some(ACCELERATION_CHANNEL))?;
            let asked = headroom(
                rendered.drive.samples(),
                rendered.drive.rate(),
                rendered.setup.as_ref(),
            );
            let measured = Measured {
                response: &response,
                clipping: clipping(&response, None, Some(&asked)),
            };
            let judged = VerifyConfig {
                achievable: rendered.achievable.clone(),
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
            let looped = closed_loop(&mut bench, texture, function, &loop_config, &mut |_| {});
            let mut looped = looped
                .map_err(|error: BenchError| anyhow::anyhow!("{}: {error}", person.pseudonym()))?;
            looped.iterations.swap_remove(looped.best).verification
        }
    };
    Ok(Felt {
        rms_db: verification
            .error_db_rms_achievable
            .unwrap_or(verification.error_db_rms),
        max_db: largest(&verification),
        correlation: verification.waveform_correlation,
        clipped: verification.clipped_fraction,
    })
}

/// The largest error within the achievable band, dB.
fn largest(verification: &Verification) -> f64 {
    let reached = |hz: f64| {
        let bands = &verification.achievable_band_hz;
        bands.is_empty() || bands.iter().any(|band| band.contains(hz))
    };
    let errors = verification
        .error_frequency_hz
        .iter()
        .zip(&verification.error_db);
    errors
        .filter(|(hz, _)| reached(**hz))
        .fold(0.0, |most: f64, (_, e)| most.max(e.abs()))
}
