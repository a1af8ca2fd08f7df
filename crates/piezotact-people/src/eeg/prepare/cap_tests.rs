//! Eye movements and bad electrodes of a whole cap.

use super::tests::config;
use super::*;
use crate::eeg::{EegWarning, ElectrodesFault};
use piezotact::quantity::{Seconds, Unit};
use piezotact::recording::{Channel, Condition, Event, Provenance, Recording};

const RATE_HZ: f64 = 100.0;

/// 20 electrodes with alpha that falls off from C3, blinks that fall off from the front, and noise; VEOG and HEOG beside them. 60 s.
fn cap() -> (Recording, Vec<i64>, Montage) {
    let names = [
        "Fp1", "Fp2", "F7", "F3", "Fz", "F4", "F8", "T7", "C3", "Cz", "C4", "T8", "P7", "P3", "Pz",
        "P4", "P8", "O1", "Oz", "O2",
    ];
    let names: Vec<String> = names.map(str::to_owned).to_vec();
    let montage = Montage::ten_ten(&names).unwrap();
    let mut random = piezotact::statistics::random::Random::stream(3, 0, "cap");
    let alpha = |i: usize| 1e-5 * (0.6 * i as f64).sin() * (1.0 + 0.5 * (0.013 * i as f64).sin());
    let blink = |i: usize| 1e-4 * (-((i % 270) as f64 - 100.0).powi(2) / 60.0).exp();
    let left = montage.positions[8];
    let near = |at: &[f64; 3], of: &[f64; 3]| {
        let cosine: f64 = at.iter().zip(of).map(|(a, b)| a * b).sum();
        (3.0 * (cosine - 1.0)).exp()
    };
    let volt = |name: &str, samples: Vec<f64>| Channel {
        name: name.into(),
        unit: Unit::Volt,
        samples,
    };
    let mut noise = |size: f64| -> Vec<f64> { (0..6000).map(|_| size * random.normal()).collect() };
    let mut channels: Vec<Channel> = names
        .iter()
        .zip(&montage.positions)
        .map(|(name, at)| {
            let (a, b) = (near(at, &left), near(at, &[0.0, 1.0, 0.0]));
            let noise = noise(1e-7).into_iter().enumerate();
            let samples = noise.map(|(i, n)| a * alpha(i) + b * blink(i) + n);
            volt(name, samples.collect())
        })
        .collect();
    for (name, share) in [("VEOG", 2.0), ("HEOG", 0.0)] {
        let noise = noise(2e-6).into_iter().enumerate();
        channels.push(volt(
            name,
            noise.map(|(i, n)| share * blink(i) + n).collect(),
        ));
    }
    let rate = SampleRate::new(RATE_HZ).unwrap();
    let mut found =
        Recording::new(channels, rate, Condition::default(), Provenance::default()).unwrap();
    let at: Vec<i64> = (1..28).map(|i| 210 * i).collect();
    found.annotations.events = at
        .iter()
        .map(|at| Event {
            onset_s: Seconds(*at as f64 / RATE_HZ),
            duration_s: Seconds(0.0),
            kind: "touch".into(),
            value: None,
        })
        .collect();
    (found, at, montage)
}

fn of_cap(
    recording: &Recording,
    at: &[i64],
    config: &PrepareConfig,
) -> Result<Prepared, PrepareError> {
    let segment = Segment {
        recording,
        start_s: Seconds(0.0),
        event_samples: at,
        stated: &[],
    };
    prepare(&[segment], config)
}

/// The standard deviation: components are taken out about their mean, which stays.
fn spread(values: &[f64]) -> f64 {
    piezotact::statistics::standard_deviation(values)
}

fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64).sqrt()
}

#[test]
fn bad_electrodes_are_interpolated_from_the_others_and_said_to_be() {
    let (recording, at, _) = cap();
    let clean = config(&[("touch", "touch")]);
    let asked = PrepareConfig {
        interpolated: vec!["C3".into(), "F4".into()],
        ..clean.clone()
    };
    let expected = of_cap(&recording, &at, &clean).unwrap();
    // What the bad electrodes recorded has no part in it: not even a flat channel.
    let broken: Vec<Channel> = (recording.channels().iter().cloned())
        .map(|mut channel| {
            if channel.name == "C3" {
                channel.samples.fill(0.0);
            }
            channel
        })
        .collect();
    let mut flat = Recording::new(
        broken,
        SampleRate::new(RATE_HZ).unwrap(),
        Condition::default(),
        Provenance::default(),
    )
    .unwrap();
    flat.annotations.events = recording.annotations.events.clone();
    assert!(matches!(
        of_cap(&flat, &at, &clean),
        Err(PrepareError::Flat { .. })
    ));
    let found = of_cap(&flat, &at, &asked).unwrap();
    assert_eq!(found.epochs.channels(), expected.epochs.channels());
    for (channel, name) in found.epochs.channels().iter().enumerate() {
        let (own, before) = (
            found.epochs.channel(channel),
            expected.epochs.channel(channel),
        );
        let off: Vec<f64> = own.iter().zip(before).map(|(a, b)| a - b).collect();
        match name.as_str() {
            // A spline over 18 electrodes at 40° flattens the peak at C3.
            "C3" | "F4" => assert!(rms(&off) < 0.35 * rms(before) && rms(&off) > 0.0, "{name}"),
            _ => assert_eq!(own, before, "{name}"),
        }
    }
    let said = |prepared: &Prepared| -> Vec<EegWarning> {
        let kinds = prepared
            .warnings
            .iter()
            .filter_map(|warning| warning.kind());
        kinds.collect()
    };
    assert!(said(&found).contains(&EegWarning::Electrodes {
        names: "C3, F4".into(),
        fault: ElectrodesFault::Interpolated {
            from: 18,
            share: 0.1
        }
    }));
    let is_computed = |kind: &EegWarning| {
        matches!(
            kind,
            EegWarning::Electrodes {
                fault: ElectrodesFault::Interpolated { .. },
                ..
            }
        )
    };
    assert!(!said(&expected).iter().any(is_computed));
    let refused = |interpolated: &[&str], without: &[&str], named: &[&str]| {
        let owned = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect();
        let channels = match named {
            [] => ChannelChoice::AllBut(owned(without)),
            named => ChannelChoice::Named(owned(named)),
        };
        let asked = PrepareConfig {
            interpolated: owned(interpolated),
            channels,
            ..clean.clone()
        };
        of_cap(&recording, &at, &asked).unwrap_err().to_string()
    };
    assert!(refused(&["C9"], &[], &[]).contains("expected the channel `C9`"));
    assert!(refused(&["C3"], &["C3"], &[]).contains("both left out and interpolated"));
    assert!(refused(&["VEOG"], &[], &[]).contains("VEOG"));
    assert!(refused(&["Fz"], &[], &["C3", "C4", "Cz"]).contains("at least 8 other electrodes"));
}

#[test]
fn blinks_go_by_regression_and_alpha_stays() {
    let (recording, at, _) = cap();
    let plain = config(&[("touch", "touch")]);
    let asked = PrepareConfig {
        eog: vec!["VEOG".into(), "HEOG".into()],
        ..plain.clone()
    };
    let before = of_cap(&recording, &at, &plain).unwrap();
    let found = of_cap(&recording, &at, &asked).unwrap();
    let names = found.epochs.channels().iter();
    assert!(names.into_iter().all(|name| !name.contains("EOG")));
    // What changes within an epoch is taken away; the level of each stays.
    let within = |prepared: &Prepared| -> f64 {
        let epochs = &prepared.epochs;
        let each = (0..epochs.count()).map(|epoch| spread(epochs.signal(0, epoch)));
        each.sum::<f64>() / epochs.count() as f64
    };
    let left = within(&found) / within(&before);
    assert!(left < 0.3, "{left}");
    let wave = |prepared: &Prepared| prepared.epochs.channel(8).to_vec();
    let same = piezotact::statistics::correlation(&wave(&found), &wave(&before));
    assert!(same > 0.95, "{same}");
}
