//! What broke a signal on its way is found and measured, and sound signals raise nothing: seeded signals of known defects.
#![allow(
    clippy::print_stdout,
    clippy::unwrap_used,
    reason = "a test stops where something is missing, and prints what it measured"
)]

use std::f64::consts::TAU;

use piezotact::Warning;
use piezotact::clipping::limited;
use piezotact::integrity::{
    ChannelFault, Defects, Pair, SignalWarning, inspect, mains_hum, transfer_warnings, warnings_of,
};
use piezotact::quantity::{Acceleration, Drive, SampleRate, Unit};
use piezotact::recording::{Channel, Condition, Provenance, Recording};
use piezotact::series::Series;
use piezotact::spectrum::WelchConfig;
use piezotact::statistics::rms;
use piezotact::transfer::{Estimator, estimate};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

const RATE_HZ: f64 = 5_000.0;

fn rate() -> SampleRate {
    SampleRate::new(RATE_HZ).unwrap()
}

pub(crate) struct Noise(ChaCha8Rng);

impl Noise {
    pub(crate) fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    fn uniform(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 * 2f64.powi(-53)
    }

    pub(crate) fn next(&mut self) -> f64 {
        let radius = (-2.0 * (1.0 - self.uniform()).ln()).sqrt();
        radius * (TAU * self.uniform()).cos()
    }

    pub(crate) fn white(&mut self, n: usize) -> Vec<f64> {
        (0..n).map(|_| self.next()).collect()
    }

    /// A vibration of about `hertz` and half an octave, of 1 rms: two resonators one after the other.
    fn vibration(&mut self, n: usize, hertz: f64) -> Vec<f64> {
        let mut x = self.white(n + 500);
        for _ in 0..2 {
            let (w, r) = (TAU * hertz / RATE_HZ, 1.0 - 0.15 * TAU * hertz / RATE_HZ);
            let (mut a, mut b) = (0.0, 0.0);
            for v in &mut x {
                let y = *v + 2.0 * r * w.cos() * a - r * r * b;
                (b, a) = (a, y);
                *v = y;
            }
        }
        let x = x.split_off(500);
        let level = rms(&x);
        x.into_iter().map(|v| v / level).collect()
    }
}

fn inspected(samples: Vec<f64>) -> Defects {
    inspect(&Series::<Acceleration>::new(samples, rate()).unwrap())
}

fn limit_of(x: &[f64], share: f64) -> f64 {
    let mut sorted: Vec<f64> = x.iter().map(|v| v.abs()).collect();
    sorted.sort_by(f64::total_cmp);
    sorted[((1.0 - share) * x.len() as f64) as usize]
}

/// Shares of 0.5–60 %, of noise whose samples clip alone, of a vibration, of a high tone and of several: exact limits within 1 %,
/// one-sided ones and those under a little noise within 20 %. Runs of three alone read 6 % of 45 %.
#[test]
fn the_share_at_a_limit_is_measured() {
    let n = 30_000;
    let mut noise = Noise::new(11);
    let tone = |cycles: f64, i: usize| (TAU * cycles * i as f64).sin();
    let high: Vec<f64> = (0..n).map(|i| tone(0.271_828, i)).collect();
    let several = (0..n)
        .map(|i| tone(0.0131, i) + 0.7 * tone(0.0273, i) + 0.5 * tone(0.0417, i))
        .collect();
    let signals = [
        ("white noise", noise.white(n)),
        ("vibration", noise.vibration(n, 200.0)),
        ("high tone", high),
        ("three tones", several),
    ];
    for (name, x) in &signals {
        for share in [0.005, 0.02, 0.1, 0.3, 0.45, 0.6] {
            let limit = limit_of(x, share);
            let clipped: Vec<f64> = x.iter().map(|v| v.clamp(-limit, limit)).collect();
            let truth =
                clipped.iter().filter(|v| v.abs() >= limit - 1e-9).count() as f64 / n as f64;
            let exact = limited(&clipped).share();
            assert!(
                (exact / truth - 1.0).abs() < 0.01,
                "{name}, {share}: {exact}"
            );
            let one: Vec<f64> = x.iter().map(|v| v.min(limit)).collect();
            let truth = one.iter().filter(|v| **v >= limit - 1e-9).count() as f64 / n as f64;
            let found = limited(&one);
            assert!(
                found.low == 0.0 && (found.high / truth - 1.0).abs() < 0.01,
                "{name}, {share}: {found:?}, truth {truth}"
            );
            if *name == "high tone" || share < 0.02 {
                continue;
            }
            for spread in [1e-4, 3e-3] {
                let noisy: Vec<f64> = clipped
                    .iter()
                    .map(|v| v + spread * limit * noise.next())
                    .collect();
                let found = limited(&noisy).share();
                println!("{name}, {share}, noise {spread}: {:.2}", found / share);
                assert!(
                    (found / share - 1.0).abs() < 0.2,
                    "{name}, {share}: {found}"
                );
            }
        }
    }
}

/// Signals that stand at their crests by nature, each as it is, quantised, and under noise.
#[test]
fn sound_signals_have_no_limit() {
    let n = 10_000;
    let mut found = Vec::new();
    for seed in 1..=4 {
        let mut noise = Noise::new(seed);
        let cycles = 0.002 + 0.1 * noise.uniform();
        let period = (20.0 + 180.0 * noise.uniform()).round();
        let sine = |cycles: f64| -> Vec<f64> {
            (0..n)
                .map(|i| (TAU * cycles * i as f64 + 0.3).sin())
                .collect()
        };
        let tones: Vec<[f64; 3]> = (0..4)
            .map(|_| {
                [
                    0.002 + 0.1 * noise.uniform(),
                    noise.uniform(),
                    0.2 + noise.uniform(),
                ]
            })
            .collect();
        let sum = (0..n)
            .map(|i| {
                let tone = |[f, phase, a]: &[f64; 3]| a * (TAU * (f * i as f64 + phase)).sin();
                tones.iter().map(tone).sum()
            })
            .collect();
        let place = |i: usize| (i as f64 % period) / period;
        let triangle = (0..n).map(|i| 1.0 - 4.0 * (place(i) - 0.5).abs()).collect();
        let square = (0..n)
            .map(|i| ((0.25 - (place(i) - 0.5).abs()) * period / 2.0).clamp(-1.0, 1.0))
            .collect();
        let taps = (0..n)
            .map(|i| {
                let t = (i % 500) as f64;
                (-t / 40.0).exp() * (TAU * 0.03 * t).sin()
            })
            .collect();
        let sweep = (0..n)
            .map(|i| {
                let t = i as f64 / n as f64;
                (TAU * (0.002_013 + 0.050_171 * t) * t * n as f64).sin()
            })
            .collect();
        let signals: [(&str, Vec<f64>); 9] = [
            ("white noise", noise.white(n)),
            ("vibration", noise.vibration(n, 150.0)),
            ("sine", sine(cycles)),
            ("sine of whole samples", sine(1.0 / period)),
            ("tones", sum),
            ("triangle", triangle),
            ("square", square),
            ("taps", taps),
            ("sweep", sweep),
        ];
        for (name, x) in &signals {
            let peak = x.iter().fold(0.0_f64, |peak, v| peak.max(v.abs()));
            let steps =
                |steps: f64| -> Vec<f64> { x.iter().map(|v| (v / peak * steps).round()).collect() };
            let mut looked_at = vec![
                ("", x.clone()),
                (", 5 steps", steps(5.0)),
                (", 100 steps", steps(100.0)),
                (", 16 bits", steps(32_767.0)),
            ];
            let silent: Vec<f64> = [vec![0.0; 3000], x.clone(), vec![0.0; 3000]].concat();
            looked_at.push((", in silence", silent));
            let noisy = x.iter().map(|v| v + 0.003 * peak * noise.next()).collect();
            looked_at.push((", noisy", noisy));
            for (how, x) in looked_at {
                let share = limited(&x).share();
                if share > 0.0 {
                    found.push(format!("seed {seed}, {name}{how}: {share:.3}"));
                }
            }
        }
    }
    assert!(found.is_empty(), "{found:#?}");
}

/// A force that rests at its zero between sixty contacts, with the sensor's noise, has no limit; a cell that saturates in contact has.
#[test]
fn a_force_at_rest_between_contacts_is_no_limit() {
    let mut noise = Noise::new(7);
    let force: Vec<f64> = (0..60 * 1500)
        .map(|i| {
            let t = f64::from(i % 1500) / 1500.0;
            let pressed = ((0.33 - (t - 0.5).abs()) * 20.0).clamp(0.0, 1.0);
            let hand = 1.0 + 0.15 * (TAU * f64::from(i) / 613.0).sin();
            -0.02 + 0.2 * pressed * hand + 0.003 * noise.next()
        })
        .collect();
    let drawn: Vec<f64> = force.iter().map(|v| -v).collect();
    for force in [&force, &drawn] {
        let found = limited(force);
        assert_eq!(found.share(), 0.0, "{found:?}");
    }
    let saturated: Vec<f64> = force.iter().map(|v| v.min(0.16)).collect();
    assert!(limited(&saturated).high > 0.2, "{:?}", limited(&saturated));
}

/// Drop-outs of 20 ms to 0.9 s, to zero and to the sensor's noise, and a sensor that holds its last value.
#[test]
fn drop_outs_and_frozen_parts_are_found() {
    for seed in 1..=3 {
        let mut noise = Noise::new(seed);
        let whole = noise.vibration(20_000, 180.0);
        for length in [100, 500, 2_500, 4_500] {
            let (from, to) = (6_000, 6_000 + length);
            let within = |spans: &[piezotact::integrity::Span]| {
                spans.len() == 1
                    && spans[0].from.abs_diff(from) < 40
                    && spans[0].to.abs_diff(to) < 40
            };
            let mut zero = whole.clone();
            zero[from..to].fill(0.0);
            let defects = inspected(zero);
            assert!(within(&defects.gaps), "seed {seed}, {length}: {defects:?}");
            assert!(defects.frozen.is_empty(), "{defects:?}");
            let mut floor = whole.clone();
            floor[from..to].fill(0.0);
            let floor = floor.iter().map(|v| v + 0.003 * noise.next()).collect();
            let defects = inspected(floor);
            // The level next to one of two edges is by chance low in 1 of 8.
            if !within(&defects.gaps) {
                println!("seed {seed}, {length} at the floor: {:?}", defects.gaps);
                assert!(defects.gaps.is_empty());
            }
            let mut held = whole.clone();
            let at = (from..).find(|i| whole[*i].abs() > 0.3).unwrap();
            let last = held[at];
            held[at..at + length].fill(last);
            let defects = inspected(held);
            assert!(
                defects.frozen.len() == 1 && defects.frozen[0].len().abs_diff(length) < 3,
                "seed {seed}, {length}: {defects:?}"
            );
            let text = defects.warnings("nail")[0].to_string();
            assert!(text.contains("`nail` stays at one value once"), "{text}");
        }
    }
}

/// Strokes with pauses between them, taps, a texture that swells, each with and without the noise of a sensor, quantised and
/// between silence; and a held force.
#[test]
fn pauses_are_no_drop_outs() {
    let n = 30_000;
    for seed in 1..=3 {
        let mut noise = Noise::new(seed);
        let x = noise.vibration(n, 160.0);
        let strokes = |i: usize| {
            let place = (i % 6_000) as f64 / RATE_HZ;
            (place.min(0.8 - place) / 0.08).clamp(0.0, 1.0)
        };
        let swell = |i: usize| 1.0 + 0.95 * (TAU * 3.0 * i as f64 / RATE_HZ).sin();
        let shaped = |shape: &dyn Fn(usize) -> f64| -> Vec<f64> {
            (0..n).map(|i| x[i] * shape(i)).collect()
        };
        let taps: Vec<f64> = (0..n)
            .map(|i| {
                let t = (i % 2_000) as f64 / RATE_HZ;
                (-t / 0.01).exp() * (TAU * 150.0 * t).sin()
            })
            .collect();
        let force: Vec<f64> = (0..n).map(|i| 0.5 * strokes(i)).collect();
        for (name, x) in [
            ("strokes", shaped(&strokes)),
            ("swelling", shaped(&swell)),
            ("taps", taps),
            ("force", force),
        ] {
            let noisy: Vec<f64> = x.iter().map(|v| v + 0.002 * noise.next()).collect();
            let rounded: Vec<f64> = x.iter().map(|v| (v * 200.0).round() / 200.0).collect();
            let silent = [vec![0.0; 2_000], x.clone(), vec![0.0; 2_000]].concat();
            for x in [x, noisy, rounded, silent] {
                let defects = inspected(x);
                assert!(
                    defects.gaps.is_empty() && defects.frozen.is_empty(),
                    "seed {seed}, {name}: {:?} {:?}",
                    defects.gaps,
                    defects.frozen
                );
            }
        }
    }
}

/// 50 and 60 Hz with harmonics are found; lines of a texture that wander with its speed, a comb of 25 Hz and tones are not.
#[test]
fn hum_is_told_from_a_texture() {
    let n = 30_000;
    for seed in 1..=4 {
        let mut noise = Noise::new(seed);
        let x = noise.vibration(n, 200.0);
        let line = |hertz: f64, i: usize| (TAU * hertz * i as f64 / RATE_HZ).sin();
        for mains_hz in [49.96, 50.0, 60.05] {
            let hum = |i: usize| {
                line(mains_hz, i) + 0.4 * line(2.0 * mains_hz, i) + 0.6 * line(3.0 * mains_hz, i)
            };
            let y: Vec<f64> = (0..n).map(|i| x[i] + 1.5 * hum(i)).collect();
            let found = mains_hum(&y, rate()).unwrap();
            let share = 1.71 / 2.71;
            assert!(
                (found.mains_hz - mains_hz).abs() < 0.05
                    && found.harmonics == [1, 2, 3]
                    && (found.share / share - 1.0).abs() < 0.3,
                "seed {seed}, {mains_hz}: {found:?}"
            );
        }
        assert_eq!(mains_hum(&x, rate()), None);
        let comb: Vec<f64> = (0..n)
            .map(|i| x[i] + (1..8).map(|k| line(25.0 * f64::from(k), i)).sum::<f64>())
            .collect();
        assert_eq!(mains_hum(&comb, rate()), None);
        // A period of 1 mm at 50 mm/s, which varies by 0.5 %.
        let (mut phase, mut wander) = (0.0, 0.0);
        let texture: Vec<f64> = x
            .iter()
            .map(|v| {
                wander += -wander / 2_000.0 + noise.next() * 0.005 * (2.0_f64 / 2_000.0).sqrt();
                phase += 50.0 * (1.0 + wander) / RATE_HZ;
                0.3 * v
                    + (1..4)
                        .map(|k| (TAU * f64::from(k) * phase).sin())
                        .sum::<f64>()
            })
            .collect();
        assert_eq!(mains_hum(&texture, rate()), None, "seed {seed}");
        let tones: Vec<f64> = (0..n).map(|i| line(50.0, i) + line(180.0, i)).collect();
        assert_eq!(mains_hum(&tones, rate()), None);
    }
}

fn pair<'a>(drive: &'a [f64], response: &'a [f64]) -> Pair<'a> {
    Pair {
        drive,
        response,
        rate: rate(),
        drive_name: "out",
        response_name: "nail",
        lasts: true,
        drive_limit: Some(1.0),
    }
}

/// The ratio of two transfer functions from one drive, dB over 40–400 Hz.
fn off_db(drive: &[f64], whole: &[f64], broken: &[f64]) -> f64 {
    let function = |response: &[f64]| {
        let drive = Series::<Drive>::new(drive.to_vec(), rate()).unwrap();
        let response = Series::<Acceleration>::new(response.to_vec(), rate()).unwrap();
        estimate(&drive, &response, &WelchConfig::hann(1024), Estimator::H1).unwrap()
    };
    let (whole, broken) = (function(whole), function(broken));
    let lines = 8..80;
    let level = |f: &piezotact::transfer::TransferFunction<Drive, Acceleration>| {
        f.response()[lines.clone()]
            .iter()
            .map(|h| h.norm().ln())
            .sum::<f64>()
    };
    20.0 / std::f64::consts::LN_10 * (level(&broken) - level(&whole)) / 72.0
}

/// Each says how far H is off, and that is how far it is off.
#[test]
fn a_broken_pair_says_how_far_its_transfer_function_is_off() {
    let mut noise = Noise::new(5);
    let n = 100_000;
    let drive: Vec<f64> = noise.white(n).iter().map(|v| 0.2 * v).collect();
    let whole: Vec<f64> = (0..n)
        .map(|i| {
            let at = |k: usize| if i >= k { drive[i - k] } else { 0.0 };
            5.0 * at(3) + 3.0 * at(4) - 2.0 * at(6) + 0.01 * noise.next()
        })
        .collect();
    let warnings = transfer_warnings(&pair(&drive, &whole));
    assert!(warnings.is_empty(), "{warnings:?}");

    // Dead for a quarter of the time, to the sensor's noise.
    let mut dead = whole.clone();
    for v in &mut dead[40_000..65_000] {
        *v = 0.01 * noise.next();
    }
    let warnings = transfer_warnings(&pair(&drive, &dead));
    let Some(SignalWarning::Channel {
        fault:
            ChannelFault::DeadWhileDriven {
                share,
                low_db,
                count: 1,
                ..
            },
        ..
    }) = warnings.first().and_then(Warning::kind)
    else {
        panic!("{warnings:?}");
    };
    let truth = -off_db(&drive, &whole, &dead);
    println!(
        "dead: said {low_db:.2} dB, is {truth:.2} dB; {}",
        warnings[0]
    );
    assert!((share - 0.25).abs() < 0.01 && (low_db - truth).abs() < 0.2);
    assert!(
        warnings[0].to_string().contains("about 2.5 dB too low"),
        "{}",
        warnings[0]
    );

    // Single samples clipped, 45 % of them.
    let limit = limit_of(&whole, 0.45);
    let clipped: Vec<f64> = whole.iter().map(|v| v.clamp(-limit, limit)).collect();
    let warnings = transfer_warnings(&pair(&drive, &clipped));
    let Some(SignalWarning::Channel {
        fault:
            ChannelFault::Clipped {
                fraction,
                off_db: Some(said),
                ..
            },
        ..
    }) = warnings.first().and_then(Warning::kind)
    else {
        panic!("{warnings:?}");
    };
    let truth = off_db(&drive, &whole, &clipped);
    println!(
        "clipped: said {said:.2} dB, is {truth:.2} dB; {}",
        warnings[0]
    );
    assert!((fraction - 0.45).abs() < 0.005 && (said - truth).abs() < 0.3);

    // A drive of 8.7 times full scale, of which full scale was played.
    let peak = drive.iter().fold(0.0_f64, |peak, v| peak.max(v.abs()));
    let loud: Vec<f64> = drive.iter().map(|v| v * 8.7 / peak).collect();
    let warnings = transfer_warnings(&pair(&loud, &whole));
    let Some(SignalWarning::Channel {
        fault: ChannelFault::BeyondLimit { peak, lost_db, .. },
        ..
    }) = warnings.first().and_then(Warning::kind)
    else {
        panic!("{warnings:?}");
    };
    println!("{lost_db:.1} dB: {}", warnings[0]);
    assert!((peak - 8.7).abs() < 0.01);

    // A copy, and hum 20 dB above the response.
    let copy: Vec<f64> = drive.iter().map(|v| 2.0 * v).collect();
    let warnings = transfer_warnings(&pair(&drive, &copy));
    assert!(
        warnings[0]
            .to_string()
            .starts_with("`nail` is `out` times 2.000:"),
        "{warnings:?}"
    );
    let hum: Vec<f64> = whole
        .iter()
        .enumerate()
        .map(|(i, v)| {
            v + 10.0 * rms(&whole) * 2f64.sqrt() * (TAU * 50.0 * i as f64 / RATE_HZ).sin()
        })
        .collect();
    let warnings = transfer_warnings(&pair(&drive, &hum));
    assert!(
        warnings.iter().any(
            |d| matches!(d.kind(), Some(SignalWarning::Channel { fault: ChannelFault::MainsHum { share, .. }, .. }) if share > 0.9)
        ),
        "{warnings:?}"
    );
}

/// A channel of nothing, a copy and a drive beyond full scale are said of a recording, and come back from JSON as they were.
#[test]
fn a_recording_says_what_is_broken() {
    let mut noise = Noise::new(9);
    let x = noise.white(5_000);
    let channel = |name: &str, unit: Unit, samples: Vec<f64>| Channel {
        name: name.into(),
        unit,
        samples,
    };
    let acceleration = Unit::MetrePerSecondSquared;
    let recording = Recording::new(
        vec![
            channel("drive", Unit::FullScale, x.clone()),
            channel(
                "nail",
                acceleration.clone(),
                x.iter().map(|v| 3.0 * v).collect(),
            ),
            channel("tip", acceleration, vec![0.0; 5_000]),
        ],
        rate(),
        Condition::default(),
        Provenance::default(),
    )
    .unwrap();
    let warnings = warnings_of(&recording, 1.0);
    let kinds: Vec<String> = warnings
        .iter()
        .map(|warning| {
            let json = serde_json::to_string(warning).unwrap();
            assert_eq!(
                *warning,
                serde_json::from_str::<Warning>(&json).unwrap(),
                "{json}"
            );
            serde_json::to_value(warning).unwrap()["fault"]
                .as_str()
                .unwrap()
                .to_owned()
        })
        .collect();
    assert_eq!(kinds, ["beyond_limit", "dead", "copied"], "{warnings:?}");
}

/// Lines at multiples of 50 Hz that the drive plays are no hum in what is measured of it; without the drive they are, and so is hum beside it.
#[test]
fn lines_of_the_drive_are_no_hum() {
    let n = 30_000;
    let mut noise = Noise::new(21);
    let tones = |hertz: f64, i: usize| {
        let line = |k: f64| (TAU * k * hertz * i as f64 / RATE_HZ).sin();
        line(1.0) + 0.5 * line(2.0) + 0.7 * line(3.0) + 0.4 * line(4.0)
    };
    let drive: Vec<f64> = (0..n).map(|i| 0.1 * tones(50.0, i)).collect();
    let other: Vec<f64> = noise.white(n).iter().map(|v| 0.1 * v).collect();
    let mut measured = |hertz: f64| -> Vec<f64> {
        (0..n)
            .map(|i| tones(hertz, i) + 0.02 * noise.next())
            .collect()
    };
    let response = measured(50.0);
    let at_60_hz = measured(60.0);
    let has_hum = |drive: Option<&[f64]>, response: &[f64]| {
        let channel = |name: &str, unit: Unit, samples: &[f64]| Channel {
            name: name.into(),
            unit,
            samples: samples.to_vec(),
        };
        let mut channels = vec![channel("nail", Unit::MetrePerSecondSquared, response)];
        channels.extend(drive.map(|drive| channel("drive", Unit::FullScale, drive)));
        let recording = Recording::new(
            channels,
            rate(),
            Condition::default(),
            Provenance::default(),
        )
        .unwrap();
        let warnings = warnings_of(&recording, 1.0);
        let mut kinds = warnings.iter().filter_map(|warning| warning.kind());
        kinds.any(|kind| {
            matches!(
                kind,
                SignalWarning::Channel {
                    fault: ChannelFault::MainsHum { .. },
                    ..
                }
            )
        })
    };
    assert!(!has_hum(Some(&drive), &response));
    assert!(has_hum(None, &response));
    assert!(has_hum(Some(&drive), &at_60_hz));
    assert!(has_hum(Some(&other), &response));
}

/// A line at rest is found where it is 15 dB above the noise of the rest, also alone; noise has none, and a finger that rests none.
#[test]
fn a_line_at_rest_is_found_and_noise_has_none() {
    use crate::studies::Random;
    use piezotact::integrity::lines_at_rest;
    let rate = SampleRate::new(2000.0).unwrap();
    for seed in 0..60 {
        let mut random = Random::new(900 + seed);
        let rest = |random: &mut Random, level: f64, hz: f64| -> Vec<f64> {
            let at = |i: usize| (TAU * hz * i as f64 / 2000.0 + 0.4).sin();
            (0..1100)
                .map(|i| 0.01 * random.normal() + level * at(i))
                .collect()
        };
        let quiet: Vec<Vec<f64>> = (0..5).map(|_| rest(&mut random, 0.0, 50.0)).collect();
        let parts: Vec<&[f64]> = quiet.iter().map(Vec::as_slice).collect();
        assert_eq!(lines_at_rest(&parts, rate), [], "seed {seed}");
        for hz in [50.0, 60.0, 137.3] {
            let loud: Vec<Vec<f64>> = (0..5).map(|_| rest(&mut random, 0.02, hz)).collect();
            let parts: Vec<&[f64]> = loud.iter().map(Vec::as_slice).collect();
            let found = lines_at_rest(&parts, rate);
            let [line] = found.as_slice() else {
                panic!("seed {seed}, {hz} Hz: {found:?}");
            };
            assert!((line.frequency_hz - hz).abs() < 0.5, "{found:?}");
            // Half the square of the amplitude.
            assert!((line.mean_square / 2e-4 - 1.0).abs() < 0.15, "{found:?}");
        }
    }
    assert_eq!(lines_at_rest(&[&[0.0; 100][..]], rate), []);
}

/// A torque of a few steps of its converter rests on one of them, and leaves it by a whole step.
#[test]
fn a_coarsely_quantised_torque_is_no_drop_out() {
    let n = (10.0 * RATE_HZ) as usize;
    for (seed, step) in [(1, 0.05), (2, 0.1), (3, 0.2)] {
        let mut noise = Noise::new(seed);
        let (mut slow, keep) = (0.0, (-TAU * 3.0 / RATE_HZ).exp());
        let torque: Vec<f64> = (0..n)
            .map(|_| {
                slow = keep * slow + (1.0 - keep * keep).sqrt() * noise.next();
                (0.2 * slow / step).round() * step
            })
            .collect();
        let unit = Unit::Other("N·m".into());
        let found = piezotact::integrity::inspect_samples(&torque, rate(), &unit);
        assert!(
            found.gaps.is_empty() && found.frozen.is_empty(),
            "{step}: {found:?}"
        );
    }
}

/// A finger that presses for most of the time and lifts at once: neither the load nor the lifts are lost signal. A cell that holds one value is.
#[test]
fn a_steady_load_is_no_drop_out() {
    for seed in [5, 6] {
        let mut noise = Noise::new(seed);
        let n = (20.0 * RATE_HZ) as usize;
        let touches = |i: usize| (i as f64 / RATE_HZ) % 2.0 < 1.5;
        let mut force: Vec<f64> = (0..n)
            .map(|i| if touches(i) { 0.5 } else { 0.0 } + 0.002 * noise.next())
            .collect();
        let found = piezotact::integrity::inspect_samples(&force, rate(), &Unit::Newton);
        assert!(
            found.gaps.is_empty() && found.frozen.is_empty(),
            "{found:?}"
        );
        force[32_500..34_500].fill(0.0);
        let found = piezotact::integrity::inspect_samples(&force, rate(), &Unit::Newton);
        assert_eq!(found.gaps.len() + found.frozen.len(), 1, "{found:?}");
    }
}
