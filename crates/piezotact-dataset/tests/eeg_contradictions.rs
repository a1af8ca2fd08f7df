//! EEG files whose headers or clocks contradict their samples.
#![allow(
    clippy::unwrap_used,
    reason = "a test that fails where it cannot go on"
)]

use piezotact_dataset::eeg::read_eeg;

use crate::eeg_odd::{footer, header, said, samples, segments};

/// Multiplexed samples that a header calls vectorized, and the other way round.
#[test]
fn a_wrong_orientation_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.vhdr");
    // Channels of slow waves with noise of their own and a signal that all of them share.
    let warned_of = |is_multiplexed: bool, stated: &str, noise: f64, of_all: &[f64]| {
        let mut random = crate::support::Lcg(3);
        let count = if of_all.len() == 2001 { 5 } else { 8 };
        let channels: Vec<Vec<f32>> = (0..count)
            .map(|c| {
                let slow = |k: usize| (k as f64 * (0.1 + 0.01 * f64::from(c))).sin() + of_all[k];
                let noisy = |k| slow(k) + noise * (random.below(2000) as f64 / 1000.0 - 1.0);
                (0..2000).map(noisy).map(|value| value as f32).collect()
            })
            .collect();
        let order: Vec<f32> = match is_multiplexed {
            true => (0..2000)
                .flat_map(|k| channels.iter().map(move |c| c[k]))
                .collect(),
            false => channels.concat(),
        };
        let bytes: Vec<u8> = order.iter().flat_map(|value| value.to_le_bytes()).collect();
        std::fs::write(path.with_extension("eeg"), bytes).unwrap();
        let names: String = (1..=count).map(|c| format!("Ch{c}=C{c},,1,µV\n")).collect();
        let text = format!(
            "Brain Vision Data Exchange Header File Version 1.0\n[Common Infos]\nDataFile=a.eeg\nDataOrientation={stated}\nNumberOfChannels={count}\n\
             SamplingInterval=4000\n[Binary Infos]\nBinaryFormat=IEEE_FLOAT_32\n[Channel Infos]\n{names}"
        );
        std::fs::write(&path, text).unwrap();
        let read = read_eeg(&path).unwrap();
        let warnings = &read.segments[0].recording.about.warnings;
        warnings
            .iter()
            .any(|one| one.to_string().contains("the channels may be mixed up"))
    };
    let warned =
        |is_multiplexed, stated, noise| warned_of(is_multiplexed, stated, noise, &[0.0; 2000]);
    for noise in [0.0, 0.3] {
        assert!(warned(true, "VECTORIZED", noise) && warned(false, "MULTIPLEXED", noise));
        assert!(!warned(true, "MULTIPLEXED", noise) && !warned(false, "VECTORIZED", noise));
    }
    // The mains, as the reference brings them into every channel; their period is five samples, as many as there are channels.
    let hum = |length: usize, level: f64| -> Vec<f64> {
        let turn = std::f64::consts::TAU * 50.02 / 250.0;
        (0..length)
            .map(|k| level * (turn * k as f64).sin())
            .collect()
    };
    let mut random = crate::support::Lcg(5);
    let broad: Vec<f64> = (0..2000)
        .map(|_| 20.0 * (random.below(2000) as f64 / 1000.0 - 1.0))
        .collect();
    for of_all in [hum(2000, 20.0), hum(2001, 20.0), broad] {
        assert!(!warned_of(true, "MULTIPLEXED", 1.0, &of_all));
        assert!(!warned_of(false, "VECTORIZED", 1.0, &of_all));
    }
    assert!(warned_of(true, "VECTORIZED", 0.1, &hum(2000, 0.2)));
    assert!(warned_of(false, "MULTIPLEXED", 0.1, &hum(2000, 0.2)));
    assert!(warned_of(true, "VECTORIZED", 0.1, &hum(2001, 0.2)));
    // Of noise alone nothing is known.
    assert!(!warned(true, "MULTIPLEXED", 1e3) && !warned(false, "VECTORIZED", 1e3));
}

/// A clock that is set back by 20 s after 30 s: two parts that overlap.
#[test]
fn a_clock_of_xdf_that_goes_back_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.xdf");
    let file = |back_s: f64| {
        let mut bytes = b"XDF:".to_vec();
        bytes.extend(header(1, 1, ["EEG", "lab1", "250", "double64"]));
        let time = |k: usize| 1000.0 + k as f64 / 250.0 - if k < 7500 { 0.0 } else { back_s };
        let each = (0..15_000_usize).map(|k| (time(k), (k as f64).to_le_bytes().to_vec()));
        bytes.extend(samples(1, &each.collect::<Vec<_>>()));
        bytes.extend(footer(1));
        std::fs::write(&path, bytes).unwrap();
        segments(&path)
    };
    let parts = file(20.0);
    assert_eq!(parts.len(), 2);
    said(
        &parts[0].recording.about.warnings,
        "the clock of stream `EEG1` went back: part 2 begins 20.0 s before the one before it ends",
    );
    for forward in [0.0, -20.0] {
        let warnings = &file(forward)[0].recording.about.warnings;
        assert!(
            !warnings
                .iter()
                .any(|one| one.to_string().contains("went back"))
        );
    }
}
