//! `transfer` on the hits of a hammer, and on everything that is none.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use std::f64::consts::{PI, TAU};
use std::fmt::Write as _;

use piezotact::quantity::{Band, Hertz, SampleRate, Seconds};
use piezotact::transfer::transient;
use piezotact_bench::{Excitation, ExcitationConfig, excitation};

use crate::support::{Folder, noise, shared, wav};

const RATE_HZ: f64 = 12_800.0;
/// One resonance: Hz, damping ratio, 1/mass in 1/kg.
const MODE: (f64, f64, f64) = (180.0, 0.03, 2.5);

/// Force and acceleration of a mass on a spring under half-sine hits (onset in s, peak in N), with a little noise: the exact
/// motion for a force that is linear between samples is not needed here, so it is integrated finely.
fn hits(onsets: &[(f64, f64)], seconds: f64) -> Vec<(f64, f64)> {
    const FINE: usize = 32;
    let (hz, damping_ratio, constant) = MODE;
    let (omega, step) = (TAU * hz, 1.0 / (RATE_HZ * FINE as f64));
    let force = |t: f64| -> f64 {
        let within = onsets
            .iter()
            .filter(|(at, _)| (0.0..0.0012).contains(&(t - at)));
        within
            .map(|(at, peak)| peak * (PI * (t - at) / 0.0012).sin())
            .sum()
    };
    let count = (seconds * RATE_HZ) as usize;
    let (mut x, mut v) = (0.0, 0.0);
    let mut signals = Vec::with_capacity(count);
    for ((i, a), b) in (0..count).zip(noise(count)).zip(noise(count).skip(1)) {
        let mut acceleration = 0.0;
        for k in 0..FINE {
            let t = (i * FINE + k) as f64 * step;
            let now = force(t) - 2.0 * damping_ratio * omega * v - omega * omega * x;
            if k == 0 {
                acceleration = now;
            }
            v += now * step;
            x += v * step;
        }
        signals.push((
            force(t_of(i)) + 0.01 * a,
            constant * acceleration + 0.02 * b,
        ));
    }
    signals
}

fn t_of(i: usize) -> f64 {
    i as f64 / RATE_HZ
}

fn table(signals: &[(f64, f64)]) -> String {
    let mut text = String::from("time [s],force [N],nail [m/s2]\n");
    for (i, (force, nail)) in signals.iter().enumerate() {
        writeln!(text, "{:.7},{force:.6},{nail:.6}", t_of(i)).unwrap();
    }
    text
}

const USUAL: [(f64, f64); 4] = [(0.1, 40.0), (0.6, 55.0), (1.1, 35.0), (1.6, 47.0)];

/// A table of `force` and `nail` under four hits.
pub(crate) fn four_hits() -> String {
    table(&hits(&USUAL, 2.1))
}

fn transfer<'a>(file: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    let mut call = vec![
        "transfer",
        file,
        "--drive",
        "force",
        "--response",
        "nail",
        "--out",
        "tf.json",
    ];
    call.extend(more);
    call
}

/// The first line of a written file from a frequency on, Hz, and |H| there.
fn line_from(document: &serde_json::Value, hz: f64) -> (f64, f64) {
    let column = |name: &str| document[name].as_array().unwrap();
    let axis = column("frequency_hz");
    let line = axis.iter().position(|f| f.as_f64().unwrap() >= hz).unwrap();
    let value = |name: &str| column(name)[line].as_f64().unwrap();
    let magnitude = value("real").hypot(value("imaginary"));
    (value("frequency_hz"), magnitude)
}

/// |H| there.
fn magnitude(document: &serde_json::Value, hz: f64) -> f64 {
    line_from(document, hz).1
}

fn written(folder: &Folder, name: &str) -> serde_json::Value {
    serde_json::from_slice(&std::fs::read(folder.path(name)).unwrap()).unwrap()
}

/// Hits are found by themselves, evaluated hit by hit, stated with the function and drawn; the random estimator refuses them with
/// the advice.
#[test]
fn hits_are_found_evaluated_and_reported() {
    let folder = Folder::new();
    folder.write("hits.csv", table(&hits(&USUAL, 2.1)));
    let done = folder.run(&transfer("hits.csv", &["--report", "report.html"]));
    done.expect_success();
    assert!(done.out().contains("from 4 of 4 hits"), "{}", done.out());
    assert!(
        done.err().contains("it is evaluated as an impact test"),
        "{}",
        done.err()
    );
    let tf = written(&folder, "tf.json");
    let (hz, damping_ratio, constant) = MODE;
    for at in [60.0, 120.0, 300.0, 600.0] {
        let (at, found) = line_from(&tf, at);
        let r: f64 = at / hz;
        let expected = constant * r * r / (1.0 - r * r).hypot(2.0 * damping_ratio * r);
        assert!(
            (found / expected - 1.0).abs() < 0.1,
            "{at} Hz: {found} {expected}"
        );
    }
    assert_eq!(tf["impact"]["hits"].as_array().unwrap().len(), 4);
    assert_eq!(tf["impact"]["added_damping_per_s"], 0.0);
    let report = std::fs::read_to_string(folder.path("report.html")).unwrap();
    for part in [
        "Hits",
        "force window",
        "peak force, N",
        "σ = 0",
        "4 of 4 hits",
        "was excited",
    ] {
        assert!(report.contains(part), "{part}");
    }
    let refused = folder.run(&transfer("hits.csv", &["--excitation", "random"]));
    refused.expect_failure(
        1,
        &[
            "hits.csv",
            "short pulses (4 in",
            "impact test",
            "--excitation impact",
        ],
    );
    let stated = folder.run(&transfer("hits.csv", &["--excitation", "impact", "--json"]));
    stated.expect_success();
    assert!(
        !stated.err().contains("evaluated as an impact"),
        "{}",
        stated.err()
    );
    let document = stated.json();
    assert_eq!(document["impact"]["hits"].as_array().unwrap().len(), 4);
    let info = folder.run(&["info", "tf.json"]);
    assert!(info.out().contains("4 of 4 hits used"), "{}", info.out());
    folder
        .run(&transfer(
            "hits.csv",
            &["--excitation", "random", "--exponential", "10"],
        ))
        .expect_failure(2, &["--exponential", "--excitation impact"]);
    folder
        .run(&transfer("hits.csv", &["--exponential", "0"]))
        .expect_failure(2, &["--exponential"]);
    folder
        .run(&transfer(
            "hits.csv",
            &["--excitation", "impact", "--segment", "8"],
        ))
        .expect_failure(2, &["expected a segment of"]);
}

/// An exponential window: σ in the text, the file, the report, and after a way through a MATLAB file.
#[test]
fn the_added_damping_stays_with_the_function() {
    let folder = Folder::new();
    folder.write("hits.csv", table(&hits(&USUAL, 2.1)));
    let done = folder.run(&transfer(
        "hits.csv",
        &["--exponential", "25", "--report", "report.html"],
    ));
    done.expect_success();
    assert!(
        done.out()
            .contains("25.0 1/s   damping σ added by the exponential window"),
        "{}",
        done.out()
    );
    assert!(
        done.err().contains("σ = 25.0 1/s") && done.err().contains("7.96 Hz wider"),
        "{}",
        done.err()
    );
    assert_eq!(
        written(&folder, "tf.json")["impact"]["added_damping_per_s"],
        25.0
    );
    let report = std::fs::read_to_string(folder.path("report.html")).unwrap();
    assert!(report.contains("exponential window") && report.contains("σ = 25.0 1/s"));
    let mut call = transfer("hits.csv", &["--exponential", "25"]);
    let out = call.iter().position(|part| *part == "tf.json").unwrap();
    call[out] = "tf.mat";
    folder.run(&call).expect_success();
    let info = folder.run(&["info", "tf.mat", "--json"]).json();
    assert_eq!(info["impact"]["added_damping_per_s"], 25.0, "{info}");
}

/// One hit, from a WAV file and from a table: no coherence anywhere, and the same after every way through a file.
#[test]
fn one_hit_has_no_coherence() {
    let folder = Folder::new();
    folder.write("one.csv", table(&hits(&[(0.1, 50.0)], 0.9)));
    let done = folder.run(&transfer("one.csv", &["--report", "report.html"]));
    done.expect_success();
    assert!(
        done.err().contains(
            "only 1 hit, 3 or more are recommended: neither noise nor a second force would show"
        ),
        "{}",
        done.err()
    );
    let tf = written(&folder, "tf.json");
    assert!(tf.get("coherence").is_none() && tf.get("confidence").is_none());
    let report = std::fs::read_to_string(folder.path("report.html")).unwrap();
    assert!(report.contains("one average has none") && !report.contains("median coherence"));
    for name in ["tf.mat", "tf.uff"] {
        let mut call = transfer("one.csv", &[]);
        let out = call.iter().position(|part| *part == "tf.json").unwrap();
        call[out] = name;
        folder.run(&call).expect_success();
        let info = folder.run(&["info", name, "--json"]).json();
        if name == "tf.mat" {
            assert!(info["coherence"].is_null(), "{info}");
            assert_eq!(info["impact"]["hits"].as_array().unwrap().len(), 1);
        }
    }
    let info = folder.run(&["info", "tf.json", "--json"]).json();
    assert!(info["coherence"].is_null(), "{info}");
}

/// What is no hit stays what it was: noise, bursts of noise, sweeps and multisines as the bench drives them.
#[test]
fn other_drives_are_never_taken_for_hits() {
    let rate = SampleRate::new(12_000.0).unwrap();
    for kind in [Excitation::Random, Excitation::Sweep, Excitation::Multisine] {
        for seed in 0..6 {
            let config = ExcitationConfig {
                kind,
                band: Band::new(Hertz(2.0), Hertz(1200.0)).unwrap(),
                duration: Seconds(12.0),
                peak: 0.8,
                seed,
            };
            let drive = excitation(&config, rate).unwrap();
            assert!(
                transient(drive.samples(), rate).is_none(),
                "{kind:?} {seed}"
            );
            // The same within a long silence.
            let silent = vec![0.0; 20 * drive.samples().len()];
            let long = [silent.as_slice(), drive.samples(), &silent].concat();
            assert!(
                transient(&long, rate).is_none(),
                "{kind:?} {seed} in silence"
            );
        }
    }
    let random: Vec<f64> = noise(120_000).collect();
    for (burst, pause) in [(6_000, 6_000), (1_200, 10_800), (240, 11_760)] {
        let period = burst + pause;
        let bursts: Vec<f64> = (random.iter().enumerate())
            .map(|(i, v)| if i % period < burst { *v } else { 0.0 })
            .collect();
        assert!(
            transient(&bursts, rate).is_none(),
            "bursts of {burst} samples"
        );
    }
    // A step, a slow press and a square wave drive otherwise than a hammer.
    let step: Vec<f64> = (0..50_000)
        .map(|i| f64::from(u8::from(i > 30_000)))
        .collect();
    let square: Vec<f64> = (0..50_000).map(|i| f64::from((i / 600) % 2)).collect();
    for signal in [step, square] {
        assert!(transient(&signal, rate).is_none());
    }
}

/// A burst of noise goes through the estimator by segments, as before.
#[test]
fn bursts_of_noise_are_estimated_by_segments() {
    let folder = Folder::new();
    let plant = [0.0, 0.5, 1.0, 0.3, -0.4];
    let drive: Vec<f64> = (noise(60_000).enumerate())
        .map(|(i, v)| if i % 12_800 < 5_000 { v } else { 0.0 })
        .collect();
    let pairs: Vec<(f64, f64)> = (0..drive.len())
        .map(|i| {
            let past = plant.iter().take(i + 1).enumerate();
            (drive[i], past.map(|(k, h)| h * drive[i - k]).sum())
        })
        .collect();
    folder.write("burst.csv", table(&pairs));
    folder.run(&transfer("burst.csv", &[])).expect_success();
    let tf = written(&folder, "tf.json");
    assert!(tf.get("impact").is_none());
    for hz in [200.0, 800.0, 2_000.0] {
        let turn = |k: usize| -TAU * hz * k as f64 / RATE_HZ;
        let parts = plant.iter().enumerate();
        let (re, im) = parts.fold((0.0, 0.0), |(re, im), (k, h)| {
            (re + h * turn(k).cos(), im + h * turn(k).sin())
        });
        let found = magnitude(&tf, hz);
        assert!(
            (found / f64::hypot(re, im) - 1.0).abs() < 0.02,
            "{hz} Hz: {found}"
        );
    }
}

/// No channel of the real vibrations is taken for hits; the recording of an instrumented hammer is, with its sign.
#[test]
fn of_real_recordings_only_the_hammer_is_a_hammer() {
    let Some(data) = shared("data") else {
        return;
    };
    let mut looked_at = 0;
    for part in [
        "vibration/textsense",
        "vibration/fabricslide",
        "vibration/hapmat",
    ] {
        for entry in std::fs::read_dir(data.join(part)).unwrap() {
            let file = entry.unwrap().path();
            let options = piezotact_dataset::ReadOptions::default();
            let Ok(contents) = piezotact_dataset::read_recording(&file, &options) else {
                continue;
            };
            for (channel, clock) in contents.recording.channels_with_clocks() {
                looked_at += 1;
                let found = transient(&channel.samples, clock.rate_hz);
                assert!(
                    found.is_none(),
                    "{}, {}: {found:?}",
                    file.display(),
                    channel.name
                );
            }
        }
    }
    assert!(looked_at > 40, "{looked_at}");
    let folder = Folder::new();
    let file = data.join("frf/lvm/long_single_header_multi_ch.lvm");
    let done = folder.run(&[
        "transfer",
        file.to_str().unwrap(),
        "--drive",
        "F",
        "--response",
        "m_1",
        "--out",
        "tf.json",
    ]);
    done.expect_success();
    // Two hits, whose pulses are negative and shorter than a sample; the response to the first rings at 5 % when the second comes.
    assert!(
        done.out().contains("of 2 hits"),
        "{}{}",
        done.out(),
        done.err()
    );
    assert!(
        done.err().contains("the force is negative"),
        "{}",
        done.err()
    );
}

/// The bad input of the issue, as a researcher sees it.
#[test]
fn what_goes_wrong_with_a_hammer_is_named_with_what_to_do() {
    let folder = Folder::new();
    type Signals = Vec<(f64, f64)>;
    let spoiled =
        |name: &str, onsets: &[(f64, f64)], seconds: f64, change: &dyn Fn(&mut Signals)| {
            let mut signals = hits(onsets, seconds);
            change(&mut signals);
            folder.write(name, table(&signals));
            folder.run(&transfer(name, &["--excitation", "impact"]))
        };
    let as_is = |_: &mut Signals| {};
    spoiled("end.csv", &[(0.99, 50.0)], 1.0, &as_is).expect_failure(
        1,
        &[
            "end.csv",
            "found 1 and none usable",
            "the recording ends",
            "record longer",
        ],
    );
    let close = spoiled(
        "close.csv",
        &[(0.1, 50.0), (0.6, 50.0), (0.71, 50.0), (1.2, 50.0)],
        1.7,
        &as_is,
    );
    close.expect_success();
    assert!(
        close.err().contains("the next hit comes") && close.err().contains("hit again only after"),
        "{}",
        close.err()
    );
    let over = spoiled("over.csv", &USUAL, 2.1, &|signals| {
        signals.iter_mut().for_each(|(f, _)| *f = f.min(45.0))
    });
    over.expect_success();
    assert!(
        over.err().contains("force overloaded") && over.out().contains("2 of 4 hits"),
        "{}",
        over.err()
    );
    spoiled("never.csv", &[], 1.0, &as_is).expect_failure(
        1,
        &[
            "never.csv",
            "no hit was found",
            "the largest force is",
            "check",
            "--excitation",
        ],
    );
    spoiled("first.csv", &USUAL, 2.1, &|signals| {
        let late: Vec<f64> = signals.iter().map(|(force, _)| *force).collect();
        for (i, (force, _)) in signals.iter_mut().enumerate() {
            *force = if i >= 128 { late[i - 128] } else { 0.0 };
        }
    })
    .expect_failure(
        1,
        &[
            "first.csv",
            "the response begins",
            "before the hit",
            "swapped",
        ],
    );
    let negative = spoiled("negative.csv", &USUAL, 2.1, &|signals| {
        signals.iter_mut().for_each(|(f, _)| *f = -*f)
    });
    negative.expect_success();
    assert!(
        negative.err().contains("the force is negative") && negative.err().contains("polarity"),
        "{}",
        negative.err()
    );
}

/// A sound file of two channels does as well as a table.
#[test]
fn hits_in_a_sound_file_are_evaluated() {
    let folder = Folder::new();
    let signals = hits(&USUAL, 2.1);
    let mono = |of: fn(&(f64, f64)) -> f64, scale: f64| -> Vec<f64> {
        signals.iter().map(|pair| of(pair) / scale).collect()
    };
    // The helper writes one channel: force and response side by side are made of two.
    let (force, nail) = (mono(|p| p.0, 100.0), mono(|p| p.1, 500.0));
    let bytes = wav(
        force.iter().zip(&nail).flat_map(|(f, a)| [*f, *a]),
        RATE_HZ as u32,
    );
    let stereo = stereo(bytes);
    folder.write("hits.wav", stereo);
    folder.write(
        "hits.wav.json",
        r#"{"channels": ["force", "nail"], "units": {"force": "100 N", "nail": "500 m/s2"}}"#,
    );
    let said = folder.run(&["info", "hits.wav"]);
    let done = folder.run(&transfer("hits.wav", &["--excitation", "impact"]));
    assert!(
        done.out().contains("from 4 of 4 hits"),
        "{}{}{}",
        done.out(),
        done.err(),
        said.out()
    );
}

/// The header of a mono file of interleaved samples made into that of two channels.
fn stereo(mut bytes: Vec<u8>) -> Vec<u8> {
    let rate = u32::from_le_bytes(bytes[24..28].try_into().unwrap());
    let bits = u16::from_le_bytes(bytes[34..36].try_into().unwrap());
    let frame = 2 * bits / 8;
    bytes[22..24].copy_from_slice(&2u16.to_le_bytes());
    bytes[28..32].copy_from_slice(&(rate * u32::from(frame)).to_le_bytes());
    bytes[32..34].copy_from_slice(&frame.to_le_bytes());
    bytes
}
