use super::*;
use crate::eeg::epochs::{Criterion, CutConfig};
use crate::eeg::prepare::{ChannelChoice, ConditionCount, MarkerChoice, PrepareConfig, Reference};
use piezotact::quantity::Hertz;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng as _, SeedableRng as _};

/// Epochs with 10 Hz of random phase and amplitude in noise; its power falls to a quarter after the marker at C3.
pub(super) fn prepared(channels: &[&str], epochs: usize, seed: u64) -> Prepared {
    let rate = SampleRate::new(128.0).unwrap();
    let (first_s, samples) = (-2.0, 448);
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut draw = move || rng.next_u64() as f64 / u64::MAX as f64 - 0.5;
    let mut volts = Vec::new();
    for name in channels {
        for _ in 0..epochs {
            let (phase, amplitude) = (6.3 * draw(), 1e-5 * (1.0 + 0.6 * draw()));
            for i in 0..samples {
                let t = first_s + i as f64 / 128.0;
                let gain = if t > 0.0 && *name == "C3" { 0.5 } else { 1.0 };
                volts.push(
                    gain * amplitude * (std::f64::consts::TAU * 10.0 * t + phase).sin()
                        + 2e-6 * draw(),
                );
            }
        }
    }
    let conditions = vec!["S2".to_owned(); epochs];
    let names = channels.iter().map(|name| (*name).to_owned()).collect();
    Prepared {
        config: PrepareConfig {
            markers: vec![MarkerChoice {
                marker: "S 2".into(),
                condition: "S2".into(),
            }],
            task: None,
            extent: CutConfig {
                start_s: first_s,
                end_s: 1.5,
            },
            channels: ChannelChoice::AllBut(Vec::new()),
            filters: Vec::new(),
            eog: Vec::new(),
            reference: Reference::AsRecorded,
            criteria: vec![Criterion::PeakToPeak { above_v: 1e-4 }],
            min_epochs: 2,
        },
        task: "control".into(),
        epochs: Epochs::new(names, conditions, rate, first_s, volts).unwrap(),
        counts: EpochCounts {
            conditions: vec![ConditionCount {
                condition: "S2".into(),
                markers: epochs,
                kept: epochs,
                ..ConditionCount::default()
            }],
            not_whole: Vec::new(),
            rejected: Vec::new(),
        },
        doubts: Vec::new(),
    }
}

pub(super) fn config(order: Order) -> PersonConfig {
    let frequencies_hz: Vec<f64> = (6..=14).map(f64::from).collect();
    PersonConfig {
        power: TfrConfig {
            method: crate::eeg::tfr::Method::Morlet,
            cycles: frequencies_hz.iter().map(|hz| hz / 2.0).collect(),
            frequencies_hz,
            decimation: 1,
        },
        step_s: 0.03,
        bands: vec![NamedBand {
            name: "alpha".into(),
            hz: Band::new(Hertz(8.0), Hertz(12.0)).unwrap(),
        }],
        regions: ["C3", "C4"]
            .map(|name| Region {
                name: name.into(),
                channels: vec![name.into()],
            })
            .to_vec(),
        baseline_s: [-1.5, -0.5],
        window_s: [0.2, 1.0],
        order,
        min_epochs: 10,
    }
}

fn subject() -> Subject {
    Subject {
        participant: "P01".into(),
        task: "control".into(),
    }
}

#[test]
fn a_desynchronisation_is_found_where_it_is() {
    let prepared = prepared(&["C3", "C4"], 40, 1);
    let of = |order| {
        person(
            "a.vhdr",
            &subject(),
            &prepared,
            &Positions::OfNames,
            &config(order),
        )
        .unwrap()
    };
    let found = of(Order::PowerFirst);
    let [c3, c4] = &found.regions[..] else {
        panic!()
    };
    assert!(
        (c3.percent + 74.0).abs() < 4.0 && c4.percent.abs() < 4.0,
        "{c3:?} {c4:?}"
    );
    assert!((c3.decibels - 10.0 * (1.0 + c3.percent / 100.0).log10()).abs() < 1e-9);
    // freqs/2 cycles: 80 ms at every frequency.
    assert!((found.smears[0].smear_s - 0.0796).abs() < 1e-3);
    let text = found.change_sentence(c3);
    for part in [
        "−1.5 to −0.5 s",
        "power averaged over epochs",
        "±80 ms",
        "40 epochs",
        "0.2 to 1 s",
    ] {
        assert!(text.contains(part), "{text}");
    }
    assert_eq!(found.maps[0].decibels.len(), 2 * 9 * found.times_s.len());
    assert!(found.times_s[0] >= -1.85 && *found.times_s.last().unwrap() <= 1.35);
    let biased = of(Order::PercentOfEachEpoch);
    assert!(
        biased
            .doubts
            .iter()
            .any(|d| d.code == "eeg_erd_per_epoch_baseline")
    );
    assert!(
        biased
            .change_sentence(&biased.regions[0])
            .contains("biased")
    );
    // Two electrodes give no map, and the report says so.
    assert!(
        found
            .no_map_sentence()
            .unwrap()
            .contains("2 of 2 electrodes")
    );
    let text = serde_json::to_string(&found).unwrap();
    let back: EegErd = serde_json::from_str(&text).unwrap();
    assert_eq!(back, found);
}

#[test]
fn bad_input_is_named() {
    let prepared = prepared(&["C3", "C4"], 8, 1);
    let refused = |positions: &Positions, config: &PersonConfig, parts: &[&str]| {
        let text = person("a", &subject(), &prepared, positions, config)
            .unwrap_err()
            .to_string();
        for part in parts {
            assert!(text.contains(part), "expected `{part}` in {text}");
        }
    };
    let own = config(Order::PowerFirst);
    refused(
        &Positions::OfNames,
        &own,
        &["S2: expected at least 10 epochs, found 8"],
    );
    let mut renamed = own.clone();
    renamed.regions[0].channels = vec!["Cz".into()];
    refused(
        &Positions::OfNames,
        &renamed,
        &["region C3 among C3, C4; found `Cz`"],
    );
    let other = Montage::new(vec!["E1".into()], vec![[0.0, 0.0, 1.0]]).unwrap();
    refused(
        &Positions::Measured(other),
        &own,
        &["channels C3, C4, found those of E1"],
    );
    let mut long = own.clone();
    long.power.cycles = vec![20.0; 9];
    refused(&Positions::OfNames, &long, &["wavelet"]);
}

#[test]
fn a_map_holds_the_values_of_its_electrodes() {
    let names = ["C3", "Cz", "C4", "F3", "F4", "P3", "P4", "Oz", "Fz", "Pz"];
    let montage = Montage::ten_ten(&names.map(String::from)).unwrap();
    let electrodes: Vec<Electrode> = montage
        .channels
        .iter()
        .zip(&montage.positions)
        .map(|(name, position)| Electrode {
            name: name.clone(),
            position: *position,
        })
        .collect();
    let values: Vec<f64> = montage.positions.iter().map(|p| 10.0 * p[0]).collect();
    let (panel, _) = head_map("x".into(), &electrodes, &values).unwrap();
    let at = |x: f64, y: f64| {
        let index = |v: f64| ((v + 1.0) * 80.0).round() as usize;
        panel.values[index(-y) * panel.columns + index(x)]
    };
    let piezotact::figure::MapGround::Head {
        electrodes: drawn, ..
    } = &panel.ground
    else {
        panic!()
    };
    for ((x, y, _), value) in drawn.iter().zip(&values) {
        assert!(
            (at(*x, *y) - value).abs() < 0.8,
            "{x} {y}: {} {value}",
            at(*x, *y)
        );
    }
    // Far below the ears nothing is known.
    assert!(panel.values.iter().any(|v| v.is_nan()));
    assert!(head_map("x".into(), &electrodes[..7], &values[..7]).is_none());
}
