use std::f64::consts::TAU;

use piezotact::quantity::{Band, Hertz};
use piezotact::recording::{EventValue, Recording};
use piezotact::statistics::mean;

use super::head::Mixture;
use super::protocol::REST;
use super::*;
use crate::{Participant, TwinParameters};

/// Everything but the background is off.
fn still() -> TwinParameters {
    let mut parameters = TwinParameters::built_in();
    let eeg = &mut parameters.eeg;
    (eeg.alpha.mu_v, eeg.alpha.occipital_v) = (0.0, 0.0);
    (eeg.eyes.blinks_per_min, eeg.eyes.movement_v) = (0.0, 0.0);
    (
        eeg.evoked.amplitude_v,
        eeg.muscle.rms_v,
        eeg.line.amplitude_v,
    ) = (0.0, 0.0, 0.0);
    parameters
}

fn names(channels: &[&str]) -> Vec<String> {
    channels.iter().map(|name| (*name).to_owned()).collect()
}

fn protocol(parameters: &TwinParameters, task: Task, channels: &[&str]) -> EegProtocol {
    EegProtocol {
        channels: names(channels),
        ..EegProtocol::usual(parameters, task).unwrap()
    }
}

fn recorded(parameters: &TwinParameters, number: u64, protocol: &EegProtocol) -> Recording {
    let participant = Participant::of(number, 1, parameters);
    record(parameters, &participant, protocol, "test").unwrap()
}

fn samples<'a>(recording: &'a Recording, name: &str) -> &'a [f64] {
    let mut channels = recording.channels().iter();
    &channels
        .find(|channel| channel.name == name)
        .unwrap()
        .samples
}

/// The power of whole numbers of Hz in `from` to `to`, V², in the segments of a second of `signal`, under a Hann window: by its definition.
fn powers(signal: &[f64], rate: usize, [from, to]: [usize; 2]) -> Vec<f64> {
    let window: Vec<f64> = (0..rate)
        .map(|i| 0.5 - 0.5 * (TAU * i as f64 / rate as f64).cos())
        .collect();
    let energy: f64 = window.iter().map(|w| w * w).sum();
    let mut sums = vec![0.0; to - from + 1];
    for segment in signal.chunks_exact(rate) {
        for (sum, hz) in sums.iter_mut().zip(from..) {
            let (mut re, mut im) = (0.0, 0.0);
            for (i, (value, w)) in segment.iter().zip(&window).enumerate() {
                let (sin, cos) = (TAU * (hz * i % rate) as f64 / rate as f64).sin_cos();
                re += w * value * cos;
                im += w * value * sin;
            }
            *sum += 2.0 * (re * re + im * im) / energy / rate as f64;
        }
    }
    let segments = (signal.len() / rate) as f64;
    sums.iter().map(|sum| sum / segments).collect()
}

fn rms(signal: &[f64]) -> f64 {
    mean(&signal.iter().map(|v| v * v).collect::<Vec<_>>()).sqrt()
}

/// The slope of ln PSD over ln f from 3 to 40 Hz. Below, a window of one second leaks; 38 lines of 250 segments have a standard error of
/// 0.015.
#[test]
fn the_background_falls_as_stated() {
    let parameters = still();
    let recording = recorded(
        &parameters,
        0,
        &protocol(&parameters, Task::Control, &["C3"]),
    );
    let psd = powers(samples(&recording, "C3"), 512, [3, 40]);
    let points = psd
        .iter()
        .zip(3..)
        .map(|(p, hz)| (f64::from(hz).ln(), p.ln()));
    let points: Vec<(f64, f64)> = points.collect();
    let x = mean(&points.iter().map(|p| p.0).collect::<Vec<_>>());
    let slope = points.iter().map(|p| (p.0 - x) * p.1).sum::<f64>()
        / points.iter().map(|p| (p.0 - x).powi(2)).sum::<f64>();
    assert!((slope + 1.3).abs() < 0.06, "{slope}");
    let all_v = rms(samples(&recording, "C3"));
    // Flat below 0.5 Hz at 0.5^-1.3 of 3.27, and f^-1.3 from 100 to 256 Hz: 8.0·√(1 + 0.377 + 0.061) = 9.6 µV.
    assert!((all_v / 9.6e-6 - 1.0).abs() < 0.1, "{all_v}");
}

/// The reference at rest: mu of 6 µV at its centre, of which exp(−d²/2s²) is left at C3; background as good as off.
#[test]
fn mu_at_c3_has_its_amplitude() {
    let mut parameters = still();
    (parameters.eeg.alpha.mu_v, parameters.eeg.alpha.sma_share) = (6e-6, 0.0);
    parameters.eeg.background.rms_v = 1e-7;
    parameters.eeg.desynchronisation.control = 0.0;
    let recording = recorded(
        &parameters,
        0,
        &protocol(&parameters, Task::Control, &["C3", "C4"]),
    );
    // Half the angle of 21.4° between C3 and CP3 on a head of 95 mm: 17.7 mm, and exp(−½·(17.7/40)²) = 0.907.
    let found_v = rms(samples(&recording, "C3"));
    // 250 s of noise of a bandwidth of 1.5 Hz: a standard error of 1.5 %.
    assert!((found_v / (0.907 * 6e-6) - 1.0).abs() < 0.06, "{found_v}");
    assert!(rms(samples(&recording, "C4")) < 0.05 * found_v);
}

/// Mu at C3 on the plateau of long trials, relative to rest, as the truth says with the background; for each task.
#[test]
fn power_falls_on_the_plateau_as_the_truth_says() {
    let parameters = TwinParameters::built_in();
    for (task, about) in [
        (Task::Natural, -0.18),
        (Task::Control, -0.5),
        (Task::Imagery, -0.35),
    ] {
        let long = EegProtocol {
            surfaces: names(&["M8"]),
            trials_per_surface: 100,
            rest_s: 6.0,
            touch_s: 6.0,
            ..protocol(&parameters, task, &["C3"])
        };
        let reference = Participant::of(0, 1, &parameters);
        let recording = record(&parameters, &reference, &long, "test").unwrap();
        let windows = TruthWindows {
            band: Band::new(Hertz(7.5), Hertz(12.5)).unwrap(),
            baseline_s: [-4.0, -1.0],
            window_s: [1.0, 5.0],
        };
        let known = truth(&parameters, &reference, &long, ("M8", &windows)).unwrap();
        let [rest, touched] =
            [[-4.0, -1.0], [1.0, 5.0]].map(|window| power_around(&recording, "C3", task, window));
        let found = touched / rest - 1.0;
        assert!((known.source - about).abs() < 1e-12);
        assert!((known.channels[0].window - known.channels[0].plateau).abs() < 1e-3);
        assert!(known.channels[0].plateau > about && known.channels[0].plateau < 0.7 * about);
        // 400 and 300 s of a bandwidth of 1.5 Hz: standard errors of 3 and 3.4 % of each power.
        assert!(
            (found - known.channels[0].plateau).abs() < 0.12,
            "{task}: {found} {known:?}"
        );
        assert!(
            (rest / known.channels[0].rest_v2 - 1.0).abs() < 0.12,
            "{rest} {known:?}"
        );
    }
}

/// The mean power of 8 to 12 Hz in `window_s`, whole seconds from each trial's onset, V².
fn power_around(recording: &Recording, name: &str, task: Task, [from_s, to_s]: [f64; 2]) -> f64 {
    let rate_hz = recording.rate().hz();
    let signal = samples(recording, name);
    let trials = recording.annotations.events.iter();
    let each = trials
        .filter(|event| event.kind == task.event_kind())
        .map(|event| {
            let at = |time_s: f64| ((event.onset_s.0 + time_s) * rate_hz).round() as usize;
            let window = &signal[at(from_s)..at(to_s)];
            powers(window, rate_hz as usize, [8, 12])
                .iter()
                .sum::<f64>()
        });
    mean(&each.collect::<Vec<_>>())
}

/// 15 blinks a minute, seen as 200 µV in VEOG: their count within four standard deviations of a renewal process.
#[test]
fn blinks_are_as_frequent_as_stated() {
    let parameters = TwinParameters::built_in();
    let recording = recorded(
        &parameters,
        2,
        &protocol(&parameters, Task::Control, &[VEOG, "Fp1", "Oz"]),
    );
    let (mut blinks, mut open) = (0, true);
    for value in samples(&recording, VEOG) {
        match open {
            true if *value > 80e-6 => (blinks, open) = (blinks + 1, false),
            false if *value < 30e-6 => open = true,
            _ => {}
        }
    }
    let expected = recording.duration().0 / 4.0;
    assert!(
        (f64::from(blinks) - expected).abs() < 4.0 * expected.sqrt(),
        "{blinks} {expected}"
    );
    let peak = |name: &str| {
        samples(&recording, name)
            .iter()
            .copied()
            .fold(0.0, f64::max)
    };
    assert!(peak("Fp1") > 80e-6 && peak("Oz") < 80e-6);
}

/// N80 of the reference is −1.7 µV at CP3, to which P100 adds a tenth; it is smaller in the other tasks, and not there before the onset.
#[test]
fn the_evoked_response_is_locked_to_the_onset() {
    let mut parameters = still();
    parameters.eeg.evoked.amplitude_v = 1.7e-6;
    parameters.eeg.background.rms_v = 1e-7;
    for (task, of_task) in [
        (Task::Control, 1.0),
        (Task::Natural, 0.7),
        (Task::Imagery, 0.85),
    ] {
        let recording = recorded(&parameters, 0, &protocol(&parameters, task, &["CP3", "C4"]));
        let at = |name: &str, time_s: f64| {
            let trials = recording.annotations.events.iter();
            let values = trials.filter(|event| event.kind != REST).map(|event| {
                let sample = (event.onset_s.0 + time_s) * 512.0;
                samples(&recording, name)[sample.round() as usize]
            });
            mean(&values.collect::<Vec<_>>())
        };
        let n80_v = at("CP3", 0.08);
        assert!(
            (n80_v / (-0.89 * 1.7e-6 * of_task) - 1.0).abs() < 0.05,
            "{n80_v}"
        );
        // 0.1 µV of background over 60 trials: 13 nV.
        assert!(at("CP3", -0.05).abs() < 60e-9 && at("C4", 0.08).abs() < 60e-9);
    }
}

#[test]
fn one_seed_gives_one_recording() {
    let parameters = TwinParameters::built_in();
    let of = |task| protocol(&parameters, task, &["C3", HEOG]);
    let (one, again) = (
        recorded(&parameters, 3, &of(Task::Imagery)),
        recorded(&parameters, 3, &of(Task::Imagery)),
    );
    assert_eq!(one, again);
    let participant = Participant::of(3, 1, &parameters);
    let label = record(&parameters, &participant, &of(Task::Imagery), "other").unwrap();
    for other in [
        label,
        recorded(&parameters, 4, &of(Task::Imagery)),
        recorded(&parameters, 3, &of(Task::Control)),
    ] {
        assert_ne!(samples(&one, "C3")[..100], samples(&other, "C3")[..100]);
    }
}

/// The reference has every mean, and people differ within what they are clamped to.
#[test]
fn the_reference_has_the_mean_brain() {
    let parameters = TwinParameters::built_in();
    let reference = Participant::of(0, 5, &parameters).brain;
    let stated = Brain {
        alpha_hz: 10.0,
        mu_v: 6e-6,
        occipital_v: 1.41e-5,
        background_v: 8e-6,
        evoked_v: 1.7e-6,
        desynchronisation: 0.0,
    };
    assert_eq!(reference, stated);
    let [one, two] = [1, 2].map(|number| Participant::of(number, 5, &parameters).brain);
    assert!(one != two && one != stated);
}

/// To the last bit: EOG, the first electrode of the mixture and the last one, in any order, alone or with all.
#[test]
fn a_channel_is_the_same_whatever_others_are_recorded() {
    let parameters = TwinParameters::built_in();
    let short = |channels: &[&str]| EegProtocol {
        surfaces: names(&["M8"]),
        trials_per_surface: 2,
        ..protocol(&parameters, Task::Natural, channels)
    };
    let every = all_channels();
    let every: Vec<&str> = every.iter().map(String::as_str).collect();
    let all = recorded(&parameters, 1, &short(&every));
    assert_eq!(all.channels().len(), 66);
    for few in [&["C3"][..], &["P10", HEOG, "Fp2"], &[VEOG, "CP3", "C3"]] {
        let recording = recorded(&parameters, 1, &short(few));
        for name in few {
            assert_eq!(samples(&recording, name), samples(&all, name), "{name}");
        }
    }
}

/// Every row of the mixture has a power of 1, and two neighbours correlate as 0.9·exp(−d/l).
#[test]
fn the_background_is_correlated_over_the_scalp() {
    let mixture = Mixture::of(&TwinParameters::built_in().eeg);
    let product = |a: &str, b: &str| -> f64 {
        let [a, b] = [a, b].map(|name| mixture.row(name).unwrap());
        a.iter().zip(b).map(|(a, b)| a * b).sum()
    };
    for name in all_channels().iter().take(64) {
        assert!((product(name, name) - 1.0).abs() < 1e-9, "{name}");
    }
    // C3 and CP3 are 2·95·sin(10.7°) = 35.2 mm apart.
    assert!((product("C3", "CP3") - 0.9 * (-0.0352_f64 / 0.06).exp()).abs() < 2e-3);
    assert!(product("C3", "C4") < 0.2);
}

/// Rests and trials alternate, do not overlap and lie in the recording; every surface has its trials, in one block.
#[test]
fn events_say_what_happens() {
    let parameters = TwinParameters::built_in();
    for task in Task::ALL {
        let recording = recorded(&parameters, 1, &protocol(&parameters, task, &["C3"]));
        let events = &recording.annotations.events;
        assert!(
            recording
                .annotations
                .outside(recording.duration())
                .is_empty()
        );
        assert_eq!(events.len(), 120);
        for pair in events.windows(2) {
            assert!(pair[0].onset_s.0 + pair[0].duration_s.0 <= pair[1].onset_s.0 + 1e-9);
        }
        let trials: Vec<&EventValue> = events
            .iter()
            .filter_map(|event| event.value.as_ref())
            .collect();
        let blocks: Vec<usize> = trials.chunk_by(|a, b| a == b).map(<[_]>::len).collect();
        assert_eq!(blocks, [20, 20, 20]);
        let rest_s = events[2].duration_s.0;
        let planning_s = if task == Task::Natural { 1.0 } else { 0.0 };
        assert!(
            (2.5 - planning_s..3.01 - planning_s).contains(&rest_s),
            "{rest_s}"
        );
    }
}

/// Muscles over the temple are three times as strong while a person moves, and nowhere else.
#[test]
fn muscles_work_while_a_person_moves() {
    let mut parameters = still();
    parameters.eeg.muscle.rms_v = 1.5e-6;
    parameters.eeg.background.rms_v = 1e-7;
    let power = |task, window: f64| {
        let recording = recorded(
            &parameters,
            0,
            &EegProtocol {
                trials_per_surface: 5,
                ..protocol(&parameters, task, &["T7"])
            },
        );
        let trials = recording
            .annotations
            .events
            .iter()
            .filter(|event| event.kind != REST);
        let each = trials.map(|event| {
            let from = ((event.onset_s.0 + window) * 512.0).round() as usize;
            mean(&powers(
                &samples(&recording, "T7")[from..from + 512],
                512,
                [100, 180],
            ))
        });
        mean(&each.collect::<Vec<_>>())
    };
    let ratio = power(Task::Natural, 0.2) / power(Task::Natural, -2.3);
    // Nine times the power: 15 seconds of 81 lines, and a background that is as good as off.
    assert!((8.0..10.0).contains(&ratio), "{ratio}");
    let still = power(Task::Control, 0.2) / power(Task::Control, -2.3);
    assert!((0.8..1.25).contains(&still), "{still}");
}

#[test]
fn a_protocol_that_cannot_be_is_refused() {
    let parameters = TwinParameters::built_in();
    let good = protocol(&parameters, Task::Control, &["C3"]);
    let participant = Participant::of(1, 1, &parameters);
    for (bad, says) in [
        (
            EegProtocol {
                surfaces: names(&["M8", "S99"]),
                ..good.clone()
            },
            "found `S99`",
        ),
        (
            EegProtocol {
                surfaces: names(&["M8", "M8"]),
                ..good.clone()
            },
            "surfaces: expected each once, found M8 twice",
        ),
        (
            EegProtocol {
                surfaces: Vec::new(),
                ..good.clone()
            },
            "surfaces: expected at least one, found none",
        ),
        (
            EegProtocol {
                channels: names(&["C3", "C9"]),
                ..good.clone()
            },
            "VEOG, HEOG, found C9",
        ),
        (
            EegProtocol {
                channels: Vec::new(),
                ..good.clone()
            },
            "channels: expected at least one",
        ),
        (
            EegProtocol {
                trials_per_surface: 0,
                ..good.clone()
            },
            "trials of a surface: expected 1 to 500 trials, found 0",
        ),
        (
            EegProtocol {
                rest_s: f64::NAN,
                ..good.clone()
            },
            "rest: expected 2 to 30 s, found NaN",
        ),
        (
            EegProtocol {
                touch_s: 0.5,
                ..good.clone()
            },
            "trial: expected 0.8 to 30 s, found 0.5",
        ),
        (
            EegProtocol {
                trials_per_surface: 500,
                rate: piezotact::quantity::SampleRate::new(8192.0).unwrap(),
                channels: all_channels(),
                ..good.clone()
            },
            "at most 268435456",
        ),
    ] {
        let error = record(&parameters, &participant, &bad, "test").err();
        let error = error.map_or("recorded".into(), |error| error.to_string());
        assert!(error.contains(says), "{says}: {error}");
    }
    let windows = TruthWindows {
        band: Band::new(Hertz(8.0), Hertz(12.0)).unwrap(),
        baseline_s: [-1.5, -0.5],
        window_s: [0.0, 0.8],
    };
    let eog = EegProtocol {
        channels: names(&[VEOG]),
        ..good.clone()
    };
    for (protocol, surface, windows, says) in [
        (
            &good,
            "S1",
            windows,
            "surface: expected one of the protocol: M8, BIO, M3, found S1",
        ),
        (&eog, "M8", windows, "leave the EOG out"),
        (
            &good,
            "M8",
            TruthWindows {
                window_s: [0.8, 0.0],
                ..windows
            },
            "found 0.8 to 0 s",
        ),
    ] {
        let error = truth(&parameters, &participant, protocol, (surface, &windows))
            .unwrap_err()
            .to_string();
        assert!(error.contains(says), "{error}");
    }
}
