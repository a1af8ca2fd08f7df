//! A bench made from a measured transfer function: it answers as that does, and says what it is.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]
#![allow(clippy::print_stdout, reason = "what was found stands in the log")]

use std::f64::consts::TAU;

use num_complex::Complex;
use piezotact::correct::CorrectConfig;
use piezotact::device::{DeviceAtGain, DeviceDescription, DriveSetup, GainName};
use piezotact::lineage::Mode;
use piezotact::quantity::{
    Acceleration, Band, Decibels, Degrees, Drive, Hertz, Newtons, SampleRate, Seconds, Volts,
};
use piezotact::recording::{BenchKind, Recording, RecordingWarning, Simulated};
use piezotact::render::RenderConfig;
use piezotact::run::Discard;
use piezotact::spectrum::WelchConfig;
use piezotact::statistics::{mean, peak, rms};
use piezotact::transfer::{Estimator, TransferFunction};
use piezotact::{Series, Warning};
use piezotact_bench::measured::{MeasuredBench, SensorNoise};
use piezotact_bench::procedure::{
    ACCELERATION_CHANNEL, CharacteriseConfig, LoopConfig, characterise, closed_loop,
    faults_of_prepared, play_and_record, start_document,
};
use piezotact_bench::{
    Bench, DeviceError, Excitation, ExcitationConfig, GateConfig, Placement, Playback,
    ProcedureError, RunPlan, StopHandle, Until,
};

type Hand = TransferFunction<Drive, Acceleration>;

/// A resonance at 180 Hz and one at 420 Hz, 0.6 ms late, on 1 025 lines to half of `rate_hz`.
fn set_to(gain: &str) -> DeviceAtGain {
    DeviceDescription::drv2667()
        .at(&GainName::new(gain))
        .unwrap()
}

fn answer(frequency_hz: f64) -> Complex<f64> {
    let of = |resonance_hz: f64, damping: f64, height: f64| {
        let r = frequency_hz / resonance_hz;
        let s = Complex::new(1.0 - r * r, 2.0 * damping * r);
        -height * r * r / s
    };
    let late = Complex::from_polar(1.0, -TAU * frequency_hz * 0.6e-3);
    (of(180.0, 0.3, 12.0) + of(420.0, 0.2, 5.0)) * late
}

fn hand_to(highest_hz: f64, lines: usize) -> Hand {
    let resolution_hz = highest_hz / (lines - 1) as f64;
    let response = (0..lines)
        .map(|k| answer(k as f64 * resolution_hz))
        .collect();
    let rate = SampleRate::new(2.0 * highest_hz).unwrap();
    let coherence = vec![1.0; lines];
    let mut hand =
        Hand::from_lines(response, coherence, resolution_hz, rate, Estimator::H1, 100).unwrap();
    hand.about.condition.participant = Some("P01".into());
    hand.about.condition.load_n = Some(Newtons(0.4));
    hand.about.condition.angle_deg = Some(Degrees(30.0));
    hand
}

fn hand() -> Hand {
    hand_to(2_500.0, 1_025)
}

fn noise(rms_m_s2: f64, seed: u64) -> SensorNoise {
    SensorNoise { rms_m_s2, seed }
}

fn bench(hand: Hand, noise: SensorNoise) -> Bench {
    MeasuredBench::new(hand, "hand.json", noise)
        .unwrap()
        .into_bench()
}

fn run(label: &str) -> RunPlan {
    RunPlan {
        label: label.into(),
        load: Some(Newtons(0.4)),
        angle: Degrees(30.0),
        placement: Placement::New,
        until: Until::PlaybackEnded,
    }
}

fn output() -> SampleRate {
    SampleRate::new(48_000.0).unwrap()
}

fn silence(seconds: usize) -> Series<Drive> {
    Series::new(vec![0.0; seconds * 48_000], output()).unwrap()
}

fn tone(amplitude: f64, frequency_hz: f64) -> Series<Drive> {
    let samples = (0..96_000)
        .map(|i| amplitude * (TAU * frequency_hz * f64::from(i) / 48_000.0).sin())
        .collect();
    Series::new(samples, output()).unwrap()
}

fn recorded(bench: &mut Bench, drive: &Series<Drive>, label: &str) -> Recording {
    play_and_record(bench, drive, None, &run(label), &mut Discard, None).unwrap()
}

fn acceleration(recording: &Recording) -> Vec<f64> {
    let series = recording.series::<Acceleration>(Some(ACCELERATION_CHANNEL));
    series.unwrap().samples().to_vec()
}

fn characterised(hand: Hand, noise: SensorNoise, to_hz: f64) -> Hand {
    let config = CharacteriseConfig {
        excitation: ExcitationConfig {
            kind: Excitation::Random,
            band: Band::new(Hertz(2.0), Hertz(to_hz)).unwrap(),
            duration: Seconds(30.0),
            peak: 0.8,
            seed: 1,
        },
        welch: WelchConfig::hann(2 * (hand.response().len() - 1)),
        estimator: Estimator::H1,
        run: run("characterise"),
    };
    let mut bench = bench(hand, noise);
    let done = characterise(&mut bench, &config, &mut Discard).unwrap();
    done.function
}

/// What `characterise` finds is what the file holds, from 30 Hz up at every line whose coherence is above 0.9, at rates below and above
/// that of the output alike: within 0.25 dB and 1.5° at the worst line and 0.05 dB rms over all. That is what lines of
/// different strength in one Hann window leave into each other, worst where the answer is weakest, in 30 s of random drive.
#[test]
fn what_is_characterised_is_what_was_measured() {
    for (highest_hz, lines, to_hz) in [
        (2_500.0, 1_025, 1_200.0),
        (2_500.0, 1_001, 1_200.0),
        (1_000.0, 401, 800.0),
        (22_050.0, 4_411, 1_200.0),
        (32_000.0, 8_193, 1_200.0),
    ] {
        let truth = hand_to(highest_hz, lines);
        let found = characterised(truth.clone(), noise(0.003, 7), to_hz);
        let judged = Band::new(Hertz(30.0), Hertz(0.98 * to_hz)).unwrap();
        let (mut levels_db, mut worst_db, mut degrees, mut at_hz) = (Vec::new(), 0.0, 0.0f64, 0.0);
        for (line, frequency_hz) in found.lines_in(judged) {
            if found.coherence()[line] > 0.9 {
                let ratio = found.response()[line] / truth.at(frequency_hz);
                let level_db = 20.0 * ratio.norm().log10();
                if level_db.abs() > worst_db {
                    (worst_db, at_hz) = (level_db.abs(), frequency_hz);
                }
                levels_db.push(level_db);
                degrees = degrees.max(ratio.arg().to_degrees().abs());
            }
        }
        let all = found.lines_in(judged).count();
        let seen = levels_db.len();
        println!(
            "to {highest_hz} Hz: {:.4} dB rms, {worst_db:.4} dB at {at_hz:.1} Hz, {degrees:.3}° over {seen} of {all} lines",
            rms(&levels_db)
        );
        assert!(seen as f64 > 0.99 * all as f64, "{seen} of {all}");
        assert!(rms(&levels_db) < 0.05 && worst_db < 0.25 && degrees < 1.5);
    }
}

/// The converter clips at full scale: a drive of 2 answers as its clipped shape does, and the loop-back shows what was sent.
#[test]
fn a_drive_beyond_full_scale_clips() {
    let played = |drive: &Series<Drive>| {
        let mut bench = bench(hand(), noise(0.0, 1));
        let stop = StopHandle::new();
        bench.acquirer.ready(&run("tone"), &stop).unwrap();
        let playback = Playback::Whole(drive.clone());
        bench.player.ready(playback, &run("tone"), &stop).unwrap();
        bench.acquirer.start().unwrap();
        bench.player.start().unwrap();
        let mut channels = [Vec::new(), Vec::new()];
        while let Some(chunk) = bench.acquirer.next_chunk().unwrap() {
            assert!(chunk.channels[0].len() <= 5_000);
            for (all, new) in channels.iter_mut().zip(chunk.channels) {
                all.extend(new);
            }
        }
        channels
    };
    let (half, one, double) = (
        played(&tone(0.5, 150.0)),
        played(&tone(1.0, 150.0)),
        played(&tone(2.0, 150.0)),
    );
    // Up to full scale it is linear, to rounding.
    assert!((rms(&one[1]) / rms(&half[1]) - 2.0).abs() < 1e-9);
    let clipped: Vec<f64> = tone(2.0, 150.0)
        .samples()
        .iter()
        .map(|v| v.clamp(-1.0, 1.0))
        .collect();
    let clipped = played(&Series::new(clipped, output()).unwrap());
    assert_eq!(double[1], clipped[1]);
    // A sine of 2 that is cut at 1 has a fundamental of 1.218 and harmonics; never that of 2.
    let louder = rms(&double[1]) / rms(&one[1]);
    println!("clipped, a drive of 2 is {louder:.3} times one of 1");
    assert!((1.15..1.35).contains(&louder), "{louder}");
    // The resampler may overshoot by what it takes away.
    assert!((peak(&double[0]) - 2.0).abs() < 1e-3);
    // The procedures refuse such a drive before it is played.
    let mut refusing = bench(hand(), noise(0.0, 1));
    let drive = tone(2.0, 150.0);
    let refused = play_and_record(&mut refusing, &drive, None, &run("x"), &mut Discard, None);
    assert!(matches!(
        refused,
        Err(ProcedureError::Device(DeviceError::Impossible { .. }))
    ));
}

/// Over ten seconds at 5 kHz: four standard errors of an rms from 52 500 independent numbers are 1.2 %.
#[test]
fn noise_is_what_was_asked_for_and_belongs_to_seed_and_label() {
    for rms_m_s2 in [0.0, SensorNoise::USUAL_RMS_M_S2, 0.5] {
        let mut bench = bench(hand(), noise(rms_m_s2, 3));
        let quiet = acceleration(&recorded(&mut bench, &silence(10), "silence"));
        assert!((rms(&quiet) - rms_m_s2).abs() <= 0.0124 * rms_m_s2);
        assert!(mean(&quiet).abs() <= 4.0 * rms_m_s2 / (quiet.len() as f64).sqrt());
        let at_rest = bench.acquirer.calibrate().unwrap().noise_rms[1];
        assert!((at_rest - rms_m_s2).abs() <= 0.04 * rms_m_s2);
    }
    let of = |seed: u64, label: &str| {
        let mut bench = bench(hand(), noise(0.5, seed));
        acceleration(&recorded(&mut bench, &tone(0.1, 100.0), label))
    };
    assert_eq!(of(3, "one"), of(3, "one"));
    for other in [of(3, "two"), of(4, "one")] {
        let apart: Vec<f64> = other.iter().zip(of(3, "one")).map(|(a, b)| a - b).collect();
        // Independent noises of 0.5 each.
        let expected = 0.5 * 2f64.sqrt();
        assert!((rms(&apart) / expected - 1.0).abs() < 0.03);
    }
    // The same bench again, with the same label: nothing of the last run is left.
    let mut bench = bench(hand(), noise(0.5, 3));
    let [first, again] = [(); 2].map(|()| recorded(&mut bench, &tone(0.1, 100.0), "one"));
    assert_eq!(first, again);
}

/// A texture: noise from 40 to 600 Hz that no two lines of share a phase.
fn texture() -> Series<Acceleration> {
    let samples = (0..20_000)
        .map(|i| {
            let t = f64::from(i) / 5_000.0;
            (1..=140)
                .map(|k| {
                    let k = f64::from(k);
                    (TAU * (40.0 + 4.0 * k) * t + k * k * 0.7).sin() * 0.12
                })
                .sum()
        })
        .collect();
    Series::new(samples, SampleRate::new(5_000.0).unwrap()).unwrap()
}

/// Rendered with another day's transfer function, 3 dB off in slopes, the loop finds back what the finger needs.
#[test]
fn a_closed_loop_learns_what_another_day_s_transfer_function_did_not_know() {
    let band = Band::new(Hertz(30.0), Hertz(700.0)).unwrap();
    let truth = hand();
    let lines = truth.frequencies_hz();
    let other_day = truth
        .response()
        .iter()
        .zip(&lines)
        .map(|(h, f)| h * 10f64.powf(3.0 * (TAU * f / 400.0).sin() / 20.0))
        .collect();
    let mut stale = Hand::from_lines(
        other_day,
        vec![1.0; lines.len()],
        truth.resolution_hz(),
        truth.rate,
        Estimator::H1,
        100,
    )
    .unwrap();
    stale.about.condition = truth.about.condition.clone();
    let target = texture().amplified(Decibels(-6.0));
    for mode in [Mode::Replicate, Mode::Texture] {
        let config = LoopConfig {
            render: RenderConfig::over(band, output()),
            correct: CorrectConfig::usual(mode),
            judged: band,
            iterations: 3,
            force_share: GateConfig::usual().force_share,
            run: run("render"),
        };
        for (function, least_db) in [(&stale, 1.0), (&truth, 0.0)] {
            let mut bench = bench(truth.clone(), noise(0.003, 7));
            let looped = closed_loop(
                &mut bench,
                &target,
                function,
                &config,
                &mut Discard,
                &mut |_| {},
            )
            .unwrap();
            let error = |i: usize| {
                let v = &looped.iterations[i].verification;
                v.error_db_rms_achievable.unwrap_or(v.error_db_rms)
            };
            // By a measurement that chose nothing.
            let best = looped.confirmed.as_ref().unwrap().judged_error_db();
            let open = error(0);
            println!("{mode:?}: {open:.2} dB open, {best:.2} dB in the loop");
            assert!(
                best <= open + 0.05 && open - best >= least_db - 0.05,
                "{open} {best}"
            );
            assert!(best < 0.5, "{best}");
            let rendered = &looped.rendered;
            assert!(rendered.about.warnings.iter().any(|d| matches!(
                d.kind(),
                Some(RecordingWarning::Simulated {
                    by: Simulated::Transfer { .. }
                })
            )));
            assert!(
                rendered
                    .about
                    .provenance
                    .steps
                    .iter()
                    .any(|s| s.contains("no finger was involved"))
            );
        }
    }
}

/// What a recording says of where it comes from, of load and angle, of the force and of the device.
#[test]
fn it_says_what_it_is_and_what_it_cannot_tell() {
    let mut described = hand();
    described.about.provenance.bench = Some(BenchKind::Hardware);
    described.excited = Band::new(Hertz(20.0), Hertz(1_000.0)).ok();
    let setup = DriveSetup::new(set_to("B2"), Volts(1.4), Some(80e-9)).unwrap();
    described.drive = Some(setup.clone());
    let mut measured = bench(described, noise(0.003, 7));
    assert_eq!(measured.player.calibrate().unwrap(), Some(setup.clone()));
    let recording = recorded(&mut measured, &tone(0.1, 100.0), "play");
    assert_eq!(recording.about.provenance.bench, Some(BenchKind::Measured));
    assert!(
        recording
            .about
            .provenance
            .source
            .contains("no finger was involved")
    );
    assert_eq!(recording.about.condition.load_n, Some(Newtons(0.4)));
    assert_eq!(
        recording.about.condition.participant.as_deref(),
        Some("P01")
    );
    let said = |recording: &Recording| {
        let texts: Vec<String> = recording
            .about
            .warnings
            .iter()
            .map(Warning::to_string)
            .collect();
        texts.join("\n")
    };
    let text = said(&recording);
    for part in [
        "no finger was involved",
        "measured on hardware",
        "responds only over 20–1000 Hz",
        "no force was measured: it is not known whether 0.4 N was held",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
    assert!(!text.contains("amplifier gain"), "{text}");
    let other = setup.with_gain(&GainName::new("B3")).unwrap();
    let mut louder = setup;
    louder.volts_per_full_scale = 1.6;
    let faults = |measured: &mut Bench, drive: &Series<Drive>, setup: Option<&DriveSetup>| {
        let found = faults_of_prepared(measured, drive, setup).unwrap();
        let texts: Vec<String> = found.iter().map(ToString::to_string).collect();
        texts.join("\n")
    };
    let fits = measured.player.calibrate().unwrap();
    assert_eq!(faults(&mut measured, &silence(1), fits.as_ref()), "");
    // All at once, not one after the other.
    let mut both = other.clone();
    both.volts_per_full_scale = 1.6;
    let elsewhere = Series::new(vec![1.5; 10], SampleRate::new(44_100.0).unwrap()).unwrap();
    let text = faults(&mut measured, &elsewhere, Some(&both));
    for part in [
        "sampled at 44100 Hz",
        "a peak of 1.500",
        "rendered for gain B3",
        "1.600 V",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
    let text = faults(&mut measured, &silence(1), None);
    assert!(text.contains("found one that states none"), "{text}");
    for (setup, part) in [(other, "rendered for gain B3"), (louder, "1.600 V")] {
        let refused = play_and_record(
            &mut measured,
            &silence(1),
            Some(&setup),
            &run("x"),
            &mut Discard,
            None,
        );
        let text = refused.unwrap_err().to_string();
        assert!(text.contains(part), "{text}");
    }

    let mut bare = hand();
    bare.about.condition = Default::default();
    let mut bare = bench(bare, noise(0.003, 7));
    let text = said(&recorded(&mut bare, &tone(0.1, 100.0), "play"));
    for part in [
        "does not state the load and angle",
        "states neither amplifier gain",
        "does not state whether a finger was measured",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
    let condition = start_document(bare.acquirer.as_ref(), &run("x"))
        .about
        .condition;
    assert_eq!((condition.load_n, condition.angle_deg), (None, None));
    let setup = DriveSetup::new(set_to("B3"), Volts(1.4), Some(80e-9)).unwrap();
    let refused = play_and_record(
        &mut bare,
        &silence(1),
        Some(&setup),
        &run("x"),
        &mut Discard,
        None,
    );
    let text = refused.unwrap_err().to_string();
    assert!(
        text.contains("without a description") && text.contains("gain B3"),
        "{text}"
    );
}

/// Behind a described amplifier a drive clips where the amplifier does.
#[test]
fn the_amplifier_s_limit_counts() {
    let mut described = hand();
    let setup = DriveSetup::new(set_to("B3"), Volts(1.8), Some(80e-9)).unwrap();
    let limit = setup.drive_limit();
    described.drive = Some(setup);
    let level = |drive: f64| {
        let mut bench = bench(described.clone(), noise(0.0, 1));
        rms(&acceleration(&recorded(
            &mut bench,
            &tone(drive, 150.0),
            "tone",
        )))
    };
    assert!((level(0.9 * limit) / level(0.45 * limit) - 2.0).abs() < 1e-9);
    assert!(level(1.0) / level(limit) < 0.75 / limit);
}

#[test]
fn another_load_or_angle_is_refused() {
    let mut bench = bench(hand(), noise(0.003, 7));
    for (run, part) in [
        (
            RunPlan {
                load: Some(Newtons(0.2)),
                ..run("x")
            },
            "the load of 0.4 N",
        ),
        (
            RunPlan {
                angle: Degrees(20.0),
                ..run("x")
            },
            "the angle of 30 °",
        ),
        (
            RunPlan {
                load: Some(Newtons(f64::NAN)),
                ..run("x")
            },
            "the load of 0.4 N",
        ),
    ] {
        let text = bench
            .acquirer
            .ready(&run, &StopHandle::new())
            .unwrap_err()
            .to_string();
        assert!(text.contains(part) && text.contains("leave --"), "{text}");
    }
    let free = RunPlan {
        load: None,
        ..run("x")
    };
    bench.acquirer.ready(&free, &StopHandle::new()).unwrap();
}

#[test]
fn what_makes_no_bench_is_refused() {
    let of = |hand: Hand, noise: SensorNoise| {
        let refused = MeasuredBench::new(hand, "hand.json", noise);
        refused.map(|_| ()).unwrap_err().to_string()
    };
    for bad in [-0.1, f64::NAN, f64::INFINITY, 1e4] {
        assert!(of(hand(), noise(bad, 1)).contains("a noise from 0"));
    }
    let usual = noise(0.003, 1);
    for highest_hz in [50.0, 200_000.0] {
        let said = of(hand_to(highest_hz, 101), usual);
        assert!(
            said.contains("lines end from 100 to 96000 Hz") && said.contains("hand.json"),
            "{said}"
        );
    }
    let said = of(hand_to(2_500.000_123, 101), usual);
    assert!(said.contains("round frequency"), "{said}");
    // It answers outside what was excited alone.
    let lines = vec![Complex::default(); 100]
        .into_iter()
        .chain([Complex::from(1.0); 100])
        .collect();
    let rate = SampleRate::new(5_000.0).unwrap();
    let mut dead = Hand::from_lines(
        lines,
        vec![1.0; 200],
        2_500.0 / 199.0,
        rate,
        Estimator::H1,
        100,
    )
    .unwrap();
    dead.excited = Band::new(Hertz(20.0), Hertz(1_000.0)).ok();
    assert!(of(dead, usual).contains("zeros"));
}

/// A step out of order is a fault, not a panic.
#[test]
fn steps_have_an_order() {
    let mut bench = bench(hand(), noise(0.003, 7));
    assert!(bench.acquirer.start().is_err() && bench.acquirer.next_chunk().is_err());
    assert!(bench.player.start().is_err() && bench.player.progress().is_err());
    let slow = Series::<Drive>::new(vec![0.0; 100], SampleRate::new(5_000.0).unwrap()).unwrap();
    assert!(matches!(
        bench
            .player
            .ready(Playback::Whole(slow), &run("x"), &StopHandle::new()),
        Err(DeviceError::Rate { .. })
    ));
    bench.player.stop();
    bench.acquirer.stop();
}
