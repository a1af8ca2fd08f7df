//! A system, a sensor or a clock that changes while a transfer function is measured.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use std::f64::consts::{PI, TAU};

use piezotact::quantity::{Band, Hertz, SampleRate, Unit};
use piezotact::recording::{
    Channel, Clocks, Condition, LostBy, Provenance, Recording, RecordingWarning,
};
use piezotact::spectrum::WelchConfig;
use piezotact::statistics::random::Random;
use piezotact::transfer::{
    BetweenChannels, BetweenConfig, Estimator, Excitation, ImpactConfig, between_channels,
};
use piezotact::warning::{Scatter, ScatterWarning};

const RATE_HZ: f64 = 5_000.0;
const SECONDS: f64 = 30.0;

/// A resonator of the given frequency and quality, by the bilinear transform: what a mass on a spring makes of its base.
#[derive(Clone)]
struct Resonator {
    b: [f64; 3],
    a: [f64; 2],
    x: [f64; 2],
    y: [f64; 2],
}

impl Resonator {
    fn of(hz: f64, quality: f64) -> Self {
        let w = TAU * hz / RATE_HZ;
        let (cos, alpha) = (w.cos(), w.sin() / (2.0 * quality));
        let norm = 1.0 + alpha;
        let b = [0.5 * (1.0 - cos), 1.0 - cos, 0.5 * (1.0 - cos)].map(|v| v / norm);
        Self {
            b,
            a: [-2.0 * cos / norm, (1.0 - alpha) / norm],
            x: [0.0; 2],
            y: [0.0; 2],
        }
    }

    fn next(&mut self, x: f64) -> f64 {
        let y = self.b[0] * x + self.b[1] * self.x[0] + self.b[2] * self.x[1]
            - self.a[0] * self.y[0]
            - self.a[1] * self.y[1];
        self.x = [x, self.x[0]];
        self.y = [y, self.y[0]];
        y
    }
}

/// Noise of 20 to 1000 Hz, rms 0.2.
fn driven(random: &mut Random, count: usize) -> Vec<f64> {
    let white: Vec<f64> = (0..count + 400).map(|_| random.normal()).collect();
    let low = |hz: f64, k: i64| match k {
        0 => 2.0 * hz / RATE_HZ,
        k => (TAU * hz / RATE_HZ * k as f64).sin() / (PI * k as f64),
    };
    let taps: Vec<f64> = (-200..=200)
        .map(|k: i64| {
            let window = 0.5 + 0.5 * (PI * k as f64 / 201.0).cos();
            window * (low(1000.0, k) - low(20.0, k))
        })
        .collect();
    let samples = (0..count).map(|i| {
        taps.iter()
            .zip(&white[i..])
            .map(|(a, b)| a * b)
            .sum::<f64>()
    });
    samples.map(|v| 0.2 * v / 0.626).collect()
}

/// The acceleration of a fingertip on the device, m/s², with noise of −40 dB.
fn finger(drive: &[f64], random: &mut Random) -> Vec<f64> {
    let mut modes = [Resonator::of(180.0, 1.5), Resonator::of(700.0, 3.0)];
    let clean: Vec<f64> = drive
        .iter()
        .map(|x| 20.0 * modes[0].next(*x) + 6.0 * modes[1].next(*x))
        .collect();
    let rms = (clean.iter().map(|v| v * v).sum::<f64>() / clean.len() as f64).sqrt();
    clean
        .iter()
        .map(|v| v + 0.01 * rms * random.normal())
        .collect()
}

fn recording(channels: Vec<(&str, Unit, Vec<f64>)>) -> Recording {
    let channels = channels.into_iter().map(|(name, unit, samples)| Channel {
        name: name.into(),
        unit,
        samples,
    });
    Recording::new(
        channels.collect(),
        SampleRate::new(RATE_HZ).unwrap(),
        Condition::default(),
        Provenance::default(),
    )
    .unwrap()
}

fn transfer(
    drive: &[f64],
    response: &[f64],
    force: Option<Vec<f64>>,
    segment: usize,
) -> BetweenChannels {
    let mut channels = vec![
        ("drive", Unit::FullScale, drive.to_vec()),
        ("nail", Unit::MetrePerSecondSquared, response.to_vec()),
    ];
    channels.extend(force.map(|force| ("force", Unit::Newton, force)));
    let config = BetweenConfig {
        drive: "drive",
        response: "nail",
        welch: WelchConfig::hann(segment),
        excitation: Excitation::Lasting,
        impact: ImpactConfig::usual(),
        estimator: Estimator::H1,
        known_input: true,
        volts_per_full_scale: None,
        setup: None,
        lost_s: Vec::new(),
    };
    between_channels(&recording(channels), &config).unwrap()
}

/// How a sensor is loose over the run.
#[derive(Clone, Copy, Debug)]
enum Loose {
    FromOneMoment,
    NowAndThen,
    MoreAndMore,
}

/// `firm` through a sensor whose mount becomes a spring: +8 dB at 583 Hz.
fn loosened(firm: &[f64], how: Loose, random: &mut Random) -> Vec<f64> {
    let mut mount = Resonator::of(583.0, 2.5);
    let (mut is_loose, mut next) = (false, 0.0);
    let from = 0.3 + 0.4 * random.uniform();
    let count = firm.len() as f64;
    firm.iter()
        .enumerate()
        .map(|(i, x)| {
            let loose = mount.next(*x);
            match how {
                Loose::FromOneMoment if i as f64 > from * count => loose,
                Loose::FromOneMoment => *x,
                Loose::NowAndThen => {
                    if i as f64 >= next {
                        is_loose = !is_loose;
                        next += RATE_HZ * (0.2 + 3.0 * random.uniform());
                    }
                    if is_loose { loose } else { *x }
                }
                Loose::MoreAndMore => {
                    let part = i as f64 / count;
                    (1.0 - part) * x + part * loose
                }
            }
        })
        .collect()
}

/// The recording of one seed.
struct Firm {
    drive: Vec<f64>,
    response: Vec<f64>,
    random: Random,
}

impl Firm {
    fn of(seed: u64) -> Self {
        Self::lasting(seed, SECONDS)
    }

    fn lasting(seed: u64, seconds: f64) -> Self {
        let mut random = Random::stream(seed, 0, "over time");
        let drive = driven(&mut random, (seconds * RATE_HZ) as usize);
        let response = finger(&drive, &mut random);
        Self {
            drive,
            response,
            random,
        }
    }
}

/// The largest difference of the levels over 30 to 900 Hz, dB.
fn apart_db(a: &BetweenChannels, b: &BetweenChannels) -> f64 {
    let band = Band::new(Hertz(30.0), Hertz(900.0)).unwrap();
    let db = |k: usize| {
        20.0 * (a.function.response()[k] / b.function.response()[k])
            .norm()
            .log10()
    };
    let lines = a.function.lines_in(band);
    lines.map(|(k, _)| db(k).abs()).fold(0.0, f64::max)
}

/// The clocks that were corrected, ppm, and how many samples were moved back at how many places.
fn clocks(found: &BetweenChannels) -> (Vec<f64>, (f64, usize)) {
    let (mut ppm, mut lost) = (Vec::new(), (0.0, 0));
    for warning in &found.function.about.warnings {
        match warning.kind() {
            Some(RecordingWarning::ClocksDiffer {
                of: Clocks::Response { ppm: by, .. },
            }) => ppm.push(by),
            Some(RecordingWarning::SamplesLost {
                by: LostBy::Unreported { count, .. },
            }) => lost = (lost.0 + count, lost.1 + 1),
            _ => {}
        }
    }
    (ppm, lost)
}

/// Whether a warning says that the response changed.
fn says_changed(found: &BetweenChannels) -> bool {
    let mut warnings = found.function.about.warnings.iter();
    warnings.any(|warning| {
        matches!(
            warning.kind(),
            Some(ScatterWarning::Scatter {
                of: Scatter::Response { .. }
            })
        )
    })
}

fn unchanged(found: &BetweenChannels) -> bool {
    found.function.change.is_none() && !says_changed(found) && clocks(found) == (vec![], (0.0, 0))
}

/// A firm finger in little and much noise, for 4 and 30 s, with short and long segments: nothing is said.
#[test]
fn a_response_that_stays_the_same_gives_no_warning() {
    for seed in 0..8 {
        let Firm {
            drive,
            response,
            mut random,
        } = Firm::of(seed);
        for (level, seconds, segment) in [
            (0.0, SECONDS, 2048),
            (3.0, SECONDS, 1024),
            (20.0, SECONDS, 2048),
            (0.0, 4.0, 512),
        ] {
            let count = (seconds * RATE_HZ) as usize;
            let noise = response[..count]
                .iter()
                .map(|v| v + level * random.normal());
            let noise: Vec<f64> = noise.collect();
            let found = transfer(&drive[..count], &noise, None, segment);
            assert!(
                unchanged(&found),
                "seed {seed}, noise {level}, {seconds} s: {:?} {:?}",
                found.function.change,
                clocks(&found)
            );
        }
    }
}

/// A finger that is away for 6 of 30 s lowers the mean by 1.4 dB and more: it is said when, and with what force.
#[test]
fn a_finger_that_lifts_is_reported() {
    for seed in 0..3 {
        let Firm {
            drive,
            response,
            mut random,
        } = Firm::of(seed);
        let from_s = 3.0 + 20.0 * random.uniform();
        let away = |i: usize| (from_s..from_s + 6.0).contains(&(i as f64 / RATE_HZ));
        let lifted = response.iter().enumerate();
        let lifted: Vec<f64> = lifted
            .map(|(i, v)| if away(i) { 0.02 * v } else { *v })
            .collect();
        let force = (0..lifted.len()).map(|i| {
            let noise = 0.02 * random.normal();
            if away(i) { noise } else { 0.5 + noise }
        });
        let force: Vec<f64> = force.collect();
        let truth = transfer(&drive, &response, None, 2048);
        let found = transfer(&drive, &lifted, Some(force), 2048);
        assert!(apart_db(&found, &truth) > 1.4);
        let change = found.function.change.as_ref().unwrap();
        assert!((change.from_s - from_s).abs() < 1.6, "{change:?}");
        assert!((change.to_s - from_s - 6.0).abs() < 1.6, "{change:?}");
        assert!((0.15..0.32).contains(&change.share), "{change:?}");
        assert!(change.by_db < -6.0, "{change:?}");
        let [then_n, rest_n] = change.force_n.unwrap();
        assert!(then_n < 0.15 && rest_n > 0.4, "{change:?}");
        assert!(says_changed(&found));
        assert_eq!(clocks(&found), (vec![], (0.0, 0)), "seed {seed}");
    }
}

/// A mount that becomes a spring changes level and phase: that is no clock and no lost samples.
#[test]
fn a_loose_sensor_is_no_clock() {
    for seed in 0..3 {
        let Firm {
            drive,
            response,
            mut random,
        } = Firm::of(seed);
        for how in [Loose::FromOneMoment, Loose::NowAndThen, Loose::MoreAndMore] {
            let loose = loosened(&response, how, &mut random);
            let found = transfer(&drive, &loose, None, 2048);
            let change = found.function.change.as_ref();
            let change = change.unwrap_or_else(|| panic!("seed {seed} {how:?}"));
            assert!(says_changed(&found));
            assert!(change.by_db.abs() > 2.3, "{how:?} {change:?}");
            assert_eq!(clocks(&found), (vec![], (0.0, 0)), "seed {seed} {how:?}");
        }
    }
}

/// A gain that rises by 14 dB over the run is a change, and no clock.
#[test]
fn a_gain_that_drifts_is_reported() {
    for seed in 0..3 {
        let Firm {
            drive, response, ..
        } = Firm::of(seed);
        let count = response.len() as f64;
        let drifting = response.iter().enumerate();
        let drifting: Vec<f64> = drifting
            .map(|(i, v)| v * 10f64.powf(0.7 * (i as f64 / count - 0.5)))
            .collect();
        let found = transfer(&drive, &drifting, None, 2048);
        let change = found.function.change.as_ref().unwrap();
        assert!(change.by_db.abs() > 5.0, "{change:?}");
        assert_eq!(clocks(&found), (vec![], (0.0, 0)), "seed {seed}");
    }
}

/// Ten samples lost at one place and at ten places, and up to 123 at one place, are moved back.
#[test]
fn lost_samples_are_moved_back() {
    lost_samples_are_moved_back_of(0..2);
}

#[test]
#[ignore = "many repetitions: ./x soak runs it"]
fn soak_lost_samples_are_moved_back() {
    lost_samples_are_moved_back_of(0..4);
}

fn lost_samples_are_moved_back_of(seeds: std::ops::Range<u64>) {
    let spread: Vec<(f64, usize)> = (0..10).map(|k| (1.5 + 2.9 * f64::from(k), 1)).collect();
    for seed in seeds {
        let Firm {
            drive, response, ..
        } = Firm::of(seed);
        let truth = transfer(&drive, &response, None, 2048);
        for (places, found_at) in [
            (vec![(7.3, 10)], 1),
            (vec![(0.9, 10)], 1),
            (vec![(29.0, 10)], 1),
            (vec![(14.1, 90)], 1),
            (vec![(14.1, 123)], 1),
            (spread.clone(), 10),
        ] {
            let mut lost = response.clone();
            for (at, many) in places.iter().rev() {
                let at = (at * RATE_HZ) as usize;
                lost.drain(at..at + many);
            }
            let found = transfer(&drive[..lost.len()], &lost, None, 2048);
            let count: usize = places.iter().map(|(_, many)| many).sum();
            let (ppm, (moved, at)) = clocks(&found);
            assert!(ppm.is_empty(), "seed {seed} {places:?}: {ppm:?} ppm");
            assert_eq!(
                (moved, at),
                (count as f64, found_at),
                "seed {seed} {places:?}"
            );
            assert!(
                found.function.change.is_none(),
                "seed {seed} {places:?}: {:?}",
                found.function.change
            );
            let apart = apart_db(&found, &truth);
            assert!(apart < 0.5, "seed {seed} {places:?}: {apart} dB");
        }
    }
}

/// Ten samples lost within a second are a step, or said to be a change.
#[test]
fn losses_near_each_other_are_reported() {
    for seed in 8..10 {
        let Firm {
            drive,
            mut response,
            ..
        } = Firm::of(seed);
        for k in (0..10).rev() {
            response.remove(60_000 + 500 * k);
        }
        let found = transfer(&drive[..response.len()], &response, None, 2048);
        let (ppm, (moved, _)) = clocks(&found);
        assert!(ppm.is_empty(), "seed {seed}: {ppm:?} ppm");
        assert!(
            moved == 10.0 || says_changed(&found),
            "seed {seed}: {moved}"
        );
    }
}

/// More losses than can be told apart are said to be a change.
#[test]
fn losses_without_number_are_a_change() {
    for seed in 0..3 {
        let Firm {
            drive,
            mut response,
            mut random,
        } = Firm::of(seed);
        for _ in 0..123 {
            let at = (random.uniform() * response.len() as f64) as usize;
            response.remove(at);
        }
        let found = transfer(&drive[..response.len()], &response, None, 2048);
        assert!(says_changed(&found), "seed {seed}");
    }
}

/// A response sampled by a clock that is faster by `ppm`, by a windowed sinc.
fn late(response: &[f64], ppm: f64) -> Vec<f64> {
    let at = |i: usize| {
        let place = i as f64 / (1.0 + ppm * 1e-6);
        let first = place.floor() as i64;
        let tap = |k: i64| {
            let sample = usize::try_from(k).ok().and_then(|k| response.get(k));
            let x = place - k as f64;
            let sinc = match x.abs() < 1e-9 {
                true => 1.0,
                false => (PI * x).sin() / (PI * x),
            };
            sample.unwrap_or(&0.0) * sinc * (0.5 + 0.5 * (PI * x / 33.0).cos())
        };
        (first - 31..=first + 32).map(tap).sum()
    };
    (0..response.len()).map(at).collect()
}

/// 20 ppm over 30 s and 1.7 ppm over two minutes are corrected, where they cost more than 0.1 dB.
#[test]
fn a_clock_that_drifts_is_corrected() {
    a_clock_is_corrected_of(&[(1, -20.0, SECONDS), (3, 1.7, 120.0)]);
}

#[test]
#[ignore = "many repetitions: ./x soak runs it"]
fn soak_a_clock_that_drifts_is_corrected() {
    a_clock_is_corrected_of(&[
        (0, 20.0, SECONDS),
        (1, -20.0, SECONDS),
        (2, 20.0, SECONDS),
        (3, 1.7, 120.0),
        (4, -1.7, 120.0),
        (5, 1.7, 120.0),
    ]);
}

fn a_clock_is_corrected_of(cases: &[(u64, f64, f64)]) {
    for &(seed, ppm, seconds) in cases {
        let Firm {
            drive, response, ..
        } = Firm::lasting(seed, seconds);
        let truth = transfer(&drive, &response, None, 2048);
        let found = transfer(&drive, &late(&response, ppm), None, 2048);
        let (found_ppm, lost) = clocks(&found);
        assert!(
            found_ppm.len() == 1 && (found_ppm[0] - ppm).abs() < 0.1,
            "{ppm}: {found_ppm:?}"
        );
        assert_eq!(lost, (0.0, 0));
        assert!(
            found.function.change.is_none(),
            "{:?}",
            found.function.change
        );
        let apart = apart_db(&found, &truth);
        assert!(apart < 0.1, "{ppm}: {apart} dB");
    }
}

/// Three exponential sweeps of a firm finger: a drive that is elsewhere at every moment is no change.
#[test]
fn a_sweep_gives_no_warning() {
    for seed in 0..3 {
        let mut random = Random::stream(seed, 0, "sweeps");
        let count = (10.0 * RATE_HZ) as usize;
        let growth = 50f64.ln();
        let sweep = (0..count).map(|i| {
            let part = i as f64 / count as f64;
            0.5 * (TAU * 20.0 * 10.0 / growth * ((growth * part).exp() - 1.0)).sin()
        });
        let sweep: Vec<f64> = sweep.collect();
        let drive = [&sweep[..]; 3].concat();
        let response = finger(&drive, &mut random);
        for segment in [512, 2048] {
            let found = transfer(&drive, &response, None, segment);
            assert!(
                unchanged(&found),
                "seed {seed}, {segment}: {:?} {:?}",
                found.function.change,
                clocks(&found)
            );
        }
    }
}
