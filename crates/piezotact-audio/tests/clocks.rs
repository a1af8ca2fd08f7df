//! Output and input on two clocks: what a recording says of it, and what corrects it.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use piezotact::Series;
use piezotact::align::{AlignConfig, Compared, Named, align_recordings};
use piezotact::quantity::{Drive, SampleRate, Unit};
use piezotact::recording::{Channel, Clocks, Condition, Provenance, Recording, RecordingWarning};
use piezotact::sound::delay;
use piezotact::statistics::random::Random;

use super::bench::{codes, recorded_at};

const RATE_HZ: f64 = 8_000.0;

/// Noise up to about 1 kHz, as friction-induced vibration is, of `seconds`.
fn texture(seconds: usize) -> Series<Drive> {
    let mut random = Random::stream(3, 0, "texture");
    let mut before = [0.0; 3];
    let samples = (0..seconds * RATE_HZ as usize).map(|_| {
        let mut value = 0.4 * random.normal();
        for state in &mut before {
            *state += 0.5 * (value - *state);
            value = *state;
        }
        value.clamp(-0.9, 0.9)
    });
    Series::new(samples.collect(), SampleRate::new(RATE_HZ).unwrap()).unwrap()
}

fn apart(recording: &Recording) -> Option<(f64, f64)> {
    let warnings = recording.about.warnings.iter();
    warnings
        .filter_map(|warning| warning.kind())
        .find_map(|kind| match kind {
            RecordingWarning::ClocksDiffer {
                of:
                    Clocks::Device {
                        ppm,
                        uncertainty_ppm,
                    },
            } => Some((ppm, uncertainty_ppm)),
            _ => None,
        })
}

fn samples<'a>(recording: &'a Recording, name: &str) -> &'a [f64] {
    let channels = recording.channels().iter();
    &channels
        .into_iter()
        .find(|one| one.name == name)
        .unwrap()
        .samples
}

/// Over three minutes, 50 ppm are 9 ms.
#[test]
fn two_clocks_are_estimated_said_and_corrected() {
    two_clocks_are_corrected_over(180);
}

/// Over ten minutes, 30 ms.
#[test]
#[ignore = "ten minutes of samples: ./x soak runs it"]
fn soak_two_clocks_are_estimated_said_and_corrected() {
    two_clocks_are_corrected_over(600);
}

fn two_clocks_are_corrected_over(seconds: usize) {
    let drive = texture(seconds);
    let recording = recorded_at("clock_ppm = 50.0", &drive);
    let (ppm, uncertainty) = apart(&recording).unwrap();
    assert!(
        (ppm - 50.0).abs() < 1.0 && uncertainty < 1.0,
        "{ppm} ± {uncertainty}"
    );

    let played = Recording::new(
        vec![Channel {
            name: "drive".into(),
            unit: Unit::FullScale,
            samples: drive.samples().to_vec(),
        }],
        drive.rate(),
        Condition::default(),
        Provenance::default(),
    );
    let played = played.unwrap();
    let named = |file, recording| Named { file, recording };
    let compared = Compared::of(
        named("played.wav", &played),
        named("recorded.parquet", &recording),
        Some("drive"),
    );
    let compared = compared.unwrap();
    let config = AlignConfig::usual(drive.rate(), drive.rate()).unwrap();
    let found = align_recordings(&compared, &config).unwrap();
    assert!(
        (found.alignment.drift_ppm - 50.0).abs() < 1.0,
        "{:?}",
        found.alignment.drift_ppm
    );
    let placed = found.on_drive(&compared).unwrap();
    let own: Vec<&Channel> = placed.channels().iter().collect();
    assert_eq!(own.len(), 3, "drive, its loopback, acceleration");
    // Ten seconds at each end, against the drive that stands beside it.
    let of = |at_s: f64, recording: &Recording, names: [&str; 2]| {
        let [a, b] = names.map(|name| {
            let from = (at_s * RATE_HZ) as usize;
            samples(recording, name)[from..from + 10 * RATE_HZ as usize].to_vec()
        });
        let found = delay(&a, &b).unwrap();
        (found.samples as f64 + found.fraction) / RATE_HZ
    };
    let names = [own[2].name.as_str(), "drive"];
    let corrected = [5.0, seconds as f64 - 20.0].map(|at_s| of(at_s, &placed, names));
    assert!((corrected[1] - corrected[0]).abs() < 1e-5, "{corrected:?}");
}

#[test]
fn one_clock_is_not_taken_for_two() {
    for looped in ["", "noise = 0.001", "clock_ppm = 0.01"] {
        let recording = recorded_at(looped, &texture(30));
        assert_eq!(apart(&recording), None, "{looped}: {:?}", codes(&recording));
    }
    // Half a second late by an underrun is no drift.
    let late = "faults = [{ what = \"underrun\", at_s = 12, for_s = 0.5 }]";
    let codes = codes(&recorded_at(late, &texture(30)));
    assert!(
        codes.iter().any(|code| code == "samples_lost/playback"),
        "{codes:?}"
    );
    let clocks = ["clocks_differ/device", "samples_lost/delay_step"];
    assert!(
        !codes.iter().any(|code| clocks.contains(&code.as_str())),
        "{codes:?}"
    );
}
