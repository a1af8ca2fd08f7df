//! The whole loop on the twin: characterise, render, play, verify.
#![allow(
    clippy::print_stderr,
    clippy::unwrap_used,
    reason = "a test prints what it measured, and fails where it cannot"
)]

use piezotact::device::{DeviceDescription, GainName};
use piezotact::quantity::{
    Acceleration, Band, Decibels, Degrees, Drive, Hertz, Newtons, SampleRate, Seconds,
};
use piezotact::render::{RenderConfig, RenderError, render};
use piezotact::run::Discard;
use piezotact::series::Series;
use piezotact::spectrum::WelchConfig;
use piezotact::transfer::{Estimator, TransferFunction};
use piezotact::verify::{Measured, Verification, VerifyConfig, verify};
use piezotact_bench::procedure::{CharacteriseConfig, characterise, play_and_record};
use piezotact_bench::{Bench, Excitation, ExcitationConfig, Placement, RunPlan, Until};
use piezotact_twin::{Participant, TwinBench, TwinParameters, record_texture};

fn band(low_hz: f64, high_hz: f64) -> Band {
    Band::new(Hertz(low_hz), Hertz(high_hz)).unwrap()
}

fn run(label: &str) -> RunPlan {
    RunPlan {
        label: label.into(),
        load: Some(Newtons(0.2)),
        angle: Degrees(20.0),
        placement: Placement::New,
        until: Until::PlaybackEnded,
    }
}

fn characterised(
    bench: &mut Bench,
    seconds: f64,
    seed: u64,
) -> TransferFunction<Drive, Acceleration> {
    let config = CharacteriseConfig {
        excitation: ExcitationConfig {
            kind: Excitation::Random,
            band: band(2.0, 1200.0),
            duration: Seconds(seconds),
            peak: 0.8,
            seed,
        },
        welch: WelchConfig::hann(2048),
        estimator: Estimator::H1,
        run: run("characterise"),
    };
    characterise(bench, &config, &mut Discard).unwrap().function
}

fn texture(participant: u64, seed: u64) -> Series<Acceleration> {
    let twin = TwinParameters::built_in();
    let participant = Participant::of(participant, seed, &twin);
    let s8 = twin.sample("S8").unwrap();
    record_texture(&twin, &participant, s8, 0.03, Seconds(6.0))
        .unwrap()
        .0
}

fn bench_of(participant: u64, seed: u64, gain: &str) -> TwinBench {
    let twin = TwinParameters::built_in();
    let set = DeviceDescription::drv2667()
        .at(&GainName::new(gain))
        .unwrap();
    TwinBench::new(&twin, Participant::of(participant, seed, &twin), &set)
}

fn felt(
    bench: &mut Bench,
    target: &Series<Acceleration>,
    function: &TransferFunction<Drive, Acceleration>,
) -> Verification {
    let config = RenderConfig::over(band(20.0, 1000.0), SampleRate::new(48_000.0).unwrap());
    let drive = render(target, function, &config).unwrap();
    let measured = play_and_record(
        bench,
        &drive.drive,
        drive.setup.as_ref(),
        &run("play"),
        &mut Discard,
        None,
    )
    .unwrap();
    let response = measured.series::<Acceleration>(None).unwrap();
    let config = VerifyConfig::over(band(30.0, 500.0), 5000.0);
    verify(target, Measured::alone(&response), &config).unwrap()
}

fn conjugated(
    function: &TransferFunction<Drive, Acceleration>,
) -> TransferFunction<Drive, Acceleration> {
    let mut wrong = TransferFunction::from_lines(
        function.response().iter().map(|h| h.conj()).collect(),
        function.coherence().to_vec(),
        function.resolution_hz(),
        function.rate,
        function.estimator,
        function.averages,
    )
    .unwrap();
    wrong.drive.clone_from(&function.drive);
    wrong
}

/// The individual transfer function renders within 1 dB rms and 0.95 for every one of the seeded people; and
/// with its conjugate (the thesis' eq. 7) the spectrum still overlaps, the waveform is lost, and it fails.
#[test]
fn individual_transfer_functions_render_and_their_conjugates_fail() {
    individual_transfer_functions_render_of(6);
}

#[test]
#[ignore = "many repetitions: ./x soak runs it"]
fn soak_individual_transfer_functions_render_and_their_conjugates_fail() {
    individual_transfer_functions_render_of(20);
}

fn individual_transfer_functions_render_of(people: u64) {
    let mut errors = Vec::new();
    for seed in 0..people {
        let mut bench = bench_of(1 + seed % 5, seed, "B3").into_bench();
        let function = characterised(&mut bench, 30.0, seed);
        // 6 dB down, so that it fits the device of every one of them.
        let target = texture(1, seed).amplified(Decibels(-6.0));
        let right = felt(&mut bench, &target, &function);
        let wrong = felt(&mut bench, &target, &conjugated(&function));
        eprintln!(
            "seed {seed}: {:.2} dB rms, r {:.3}, level {:+.2} dB; conjugate {:.2} dB rms, r {:.3}",
            right.error_db_rms,
            right.waveform_correlation,
            right.level_error_db,
            wrong.error_db_rms,
            wrong.waveform_correlation
        );
        assert!(right.passed(), "seed {seed}: {}", right.sentence());
        assert!(
            !wrong.passed(),
            "seed {seed}: the conjugate {}",
            wrong.sentence()
        );
        // The spectrum alone would have passed.
        assert!(
            wrong.error_db_rms <= 1.0,
            "seed {seed}: {}",
            wrong.sentence()
        );
        // Near-constant parts of the phase pass for a delay or a polarity, so some resemblance remains.
        assert!(
            wrong.waveform_correlation < 0.9,
            "seed {seed}: {}",
            wrong.sentence()
        );
        errors.push(right.error_db_rms);
    }
    let mean = errors.iter().sum::<f64>() / errors.len() as f64;
    // Not an inverse crime: the finger lies otherwise each time, so something between 0.1 and 1 dB remains.
    assert!((0.1..1.0).contains(&mean), "{mean}");
}

#[test]
fn coherence_is_near_one_except_at_very_low_frequencies() {
    let mut bench = bench_of(1, 3, "B3").into_bench();
    let function = characterised(&mut bench, 60.0, 3);
    let at = |frequency_hz: f64| {
        function.coherence()[(frequency_hz / function.resolution_hz()).round() as usize]
    };
    let lowest = function
        .lines_in(band(25.0, 950.0))
        .map(|(k, _)| function.coherence()[k])
        .fold(1.0, f64::min);
    eprintln!(
        "lowest 25–950 Hz {lowest:.4}, at 10 Hz {:.3}, at 5 Hz {:.3}",
        at(10.0),
        at(5.0)
    );
    assert!(lowest > 0.95 && at(5.0) < 0.9, "{lowest} {}", at(5.0));
}

#[test]
fn the_same_seed_gives_the_same_bytes() {
    let drive = Series::new(vec![0.1; 4800], SampleRate::new(48_000.0).unwrap()).unwrap();
    let record = |label: &str| {
        let mut bench = bench_of(2, 9, "B3").into_bench();
        play_and_record(&mut bench, &drive, None, &run(label), &mut Discard, None).unwrap()
    };
    assert_eq!(record("play"), record("play"));
    assert_ne!(record("play").channels()[1], record("again").channels()[1]);
}

#[test]
fn a_drive_that_does_not_fit_is_refused_with_the_level_that_does() {
    let mut bench = bench_of(1, 4, "B3").into_bench();
    let function = characterised(&mut bench, 10.0, 4);
    let config = RenderConfig::over(band(20.0, 1000.0), SampleRate::new(48_000.0).unwrap());
    let loud = texture(1, 4).amplified(Decibels(30.0));
    let RenderError::ExceedsFullScale { fits_at, .. } =
        render(&loud, &function, &config).unwrap_err()
    else {
        panic!("expected a refusal");
    };
    assert!(render(&loud.amplified(fits_at), &function, &config).is_ok());
}

#[test]
fn a_drive_for_another_gain_is_refused() {
    let mut bench = bench_of(1, 4, "B2").into_bench();
    let drive = Series::new(vec![0.1; 4800], SampleRate::new(48_000.0).unwrap()).unwrap();
    let setup = bench_of(1, 4, "B3")
        .into_bench()
        .player
        .calibrate()
        .unwrap();
    let refused = play_and_record(
        &mut bench,
        &drive,
        setup.as_ref(),
        &run("play"),
        &mut Discard,
        None,
    )
    .unwrap_err()
    .to_string();
    assert!(
        refused.contains("B3") && refused.contains("B2"),
        "{refused}"
    );
}
