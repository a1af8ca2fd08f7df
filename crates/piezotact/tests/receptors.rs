//! Levels re the thresholds of receptors, and peaks, of recordings that are one stroke.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use std::f64::consts::TAU;

use crate::known_cuts::Random;
use piezotact::compare::{FrictionChange, Periods, Summary, friction_change, summarise};
use piezotact::criterion::Outcome;
use piezotact::feature::{Analysis, FeatureConfig, Receptor, Statistics, analyse};
use piezotact::filter::HighPass;
use piezotact::quantity::{Hertz, SampleRate, Unit};
use piezotact::recording::{Channel, Condition, Provenance, Recording};
use piezotact::roles::Roles;
use piezotact::statistics::rank_correlation;
use piezotact::stroke::{CutBy, Interval, Rule, Segmentation, Stroke};

fn gesture() -> Option<HighPass> {
    Some(HighPass::gesture())
}

/// `samples` in m/s² as one stroke, with a PSD of `segment` samples.
fn analysed(
    samples: Vec<f64>,
    rate_hz: f64,
    high_pass: Option<HighPass>,
    segment: Option<usize>,
) -> Analysis {
    let all = Interval {
        start: 0,
        end: samples.len(),
    };
    let channel = Channel {
        name: "acc".into(),
        unit: Unit::MetrePerSecondSquared,
        samples,
    };
    let rate = SampleRate::new(rate_hz).unwrap();
    let own = Condition::default();
    let recording = Recording::new(vec![channel], rate, own, Provenance::default()).unwrap();
    let segmentation = Segmentation {
        strokes: vec![Stroke {
            steady: all,
            contact: all,
            cut_by: CutBy::Person,
            criteria: Vec::new(),
        }],
        rejected: Vec::new(),
        rule: Rule::Whole,
        roles: Roles::guess(&recording).0,
        force_zeros: None,
        cuts: None,
        untouched: None,
        warnings: Vec::new(),
    };
    let mut config = FeatureConfig::usual(rate, &[all.len()], high_pass).unwrap();
    config.welch.segment = segment.unwrap_or(config.welch.segment);
    analyse(&recording, &segmentation, &config).unwrap()
}

/// A tone of `peak_um` at `hz` over 4 s, in a little noise.
fn tone(hz: f64, peak_um: f64, rate_hz: f64, seed: u64) -> Vec<f64> {
    let mut random = Random::new(seed);
    let start = seed as f64;
    (0..(4.0 * rate_hz) as usize)
        .map(|i| {
            let turn = TAU * hz * i as f64 / rate_hz + start;
            peak_um * 1e-6 * (TAU * hz).powi(2) * turn.sin() + 1e-5 * random.normal()
        })
        .collect()
}

fn summary(recordings: &[Analysis]) -> Summary {
    let own = Condition::default();
    let members: Vec<(&Analysis, &Condition)> = recordings.iter().map(|a| (a, &own)).collect();
    summarise("tone", &members, Periods::default()).unwrap()
}

/// A tone between the filter and 10 Hz counts, whatever the segments of the PSD: 20 µm at 8 Hz lie 6.5 dB above the threshold, and were
/// called 4.2 dB below; 100 µm at 6 Hz with a filter at 2 Hz were 70.7 dB below.
#[test]
fn a_tone_below_10_hz_is_compared_with_its_threshold() {
    let threshold_um = |hz: f64| 10f64.powf((28.0 - 6.0 * (hz / 3.0).log2()) / 20.0);
    let lower = Some(HighPass {
        order: 4,
        cutoff_hz: Hertz(2.0),
    });
    for (hz, peak_um, high_pass) in [
        (8.0, 20.0, gesture()),
        (6.0, 100.0, lower),
        (6.0, 100.0, None),
        (20.0, 10.0, gesture()),
    ] {
        let truth_db = 20.0 * (peak_um / threshold_um(hz)).log10();
        for segment in [None, Some(512), Some(4000)] {
            let a = analysed(tone(hz, peak_um, 4000.0, 3), 4000.0, high_pass, segment);
            let stroke = &a.strokes[0];
            let level_db = stroke.meissner_level_db.unwrap();
            // The threshold changes over the lines of a Hann window.
            assert!(
                (level_db - truth_db).abs() < 0.5,
                "{hz} Hz, {segment:?}: {level_db} for {truth_db}"
            );
            let detected_db = 10.0 * stroke.detection_power.unwrap().log10();
            assert!(
                (detected_db - truth_db).abs() < 0.5,
                "{hz} Hz: {detected_db}"
            );
        }
        let all = [1, 2, 3]
            .map(|seed| analysed(tone(hz, peak_um, 4000.0, seed), 4000.0, high_pass, None));
        let found = &summary(&all).receptors[0];
        assert_eq!(found.excited, Outcome::Met, "{found}");
    }
}

/// A tone that the filter takes away is unknown, not absent: below is said only where what was recorded there is below too.
#[test]
fn below_is_not_said_of_what_the_filter_takes_away() {
    let found = |hz: f64, peak_um: f64| {
        let all = [1, 2, 3]
            .map(|seed| analysed(tone(hz, peak_um, 4000.0, seed), 4000.0, gesture(), None));
        summary(&all).receptors[0]
    };
    let hidden = found(4.0, 100.0);
    assert!(hidden.level_db.unwrap() < -3.0, "{hidden}");
    assert_eq!(hidden.excited, Outcome::NotDecided, "{hidden}");
    assert!(hidden.to_string().contains("at 7.5 to 40 Hz"), "{hidden}");
    let quiet = found(20.0, 1.0);
    assert_eq!(quiet.excited, Outcome::NotMet, "{quiet}");
}

/// Noise without low frequencies that fills the recording: the filter's transients at its ends were called 10 dB above the threshold.
#[test]
fn the_ends_of_a_recording_are_no_low_frequencies() {
    let rate_hz = 4000.0;
    for seed in 0..6 {
        let mut random = Random::new(seed);
        // Tones at 60 Hz and above with phases and levels of chance, 12 m/s² rms in all.
        let tones: Vec<(f64, f64)> = (0..40)
            .map(|k| (60.0 + 11.37 * f64::from(k), TAU * random.normal()))
            .collect();
        let level = 12.0 * (2.0 / tones.len() as f64).sqrt();
        let samples: Vec<f64> = (0..(2.0 * rate_hz) as usize)
            .map(|i| {
                let t = i as f64 / rate_hz;
                let each = tones.iter().map(|(hz, start)| (TAU * hz * t + start).sin());
                level * each.sum::<f64>()
            })
            .collect();
        let truth = (samples.iter().map(|v| v * v).sum::<f64>() / samples.len() as f64).sqrt();
        let plain = analysed(samples.clone(), rate_hz, None, None);
        let filtered = analysed(samples, rate_hz, gesture(), None);
        let stroke = &filtered.strokes[0];
        assert!(
            (stroke.rms / truth - 1.0).abs() < 5e-3,
            "{} for {truth}",
            stroke.rms
        );
        let level_db = stroke.meissner_level_db.unwrap();
        assert!(
            level_db < -10.0,
            "{level_db} dB, and without a filter {:?}",
            plain.strokes[0].meissner_level_db
        );
    }
}

/// At 800 Hz Meissner is computed, and that Pacini is not is said with the reason: both were missing without a word.
#[test]
fn at_low_rates_a_receptor_is_computed_or_the_reason_said() {
    let all =
        [1, 2, 3].map(|seed| analysed(tone(20.0, 100.0, 800.0, seed), 800.0, gesture(), None));
    let [meissner, pacini] = &summary(&all).receptors[..] else {
        panic!("two receptors");
    };
    assert_eq!(
        (meissner.receptor, meissner.excited),
        (Receptor::Meissner, Outcome::Met)
    );
    assert_eq!(
        (pacini.level_db, pacini.excited),
        (None, Outcome::NotDecided)
    );
    let said = pacini.to_string();
    assert!(
        said.starts_with("Pacini not computed")
            && said.contains("400 Hz")
            && said.contains("500 Hz"),
        "{said}"
    );
}

/// The strongest line of noise, and the slope of a tone below the band, are no peaks; a tone within the band is one.
#[test]
fn a_highest_peak_is_said_where_there_is_a_peak() {
    for hz in [2.5, 5.0, 6.0, 8.0] {
        let one = analysed(tone(hz, 1000.0, 3000.0, 1), 3000.0, None, None);
        assert_eq!(summary(&[one]).peaks, [], "{hz} Hz");
    }
    let mut random = Random::new(4);
    let noise: Vec<f64> = (0..80_000).map(|_| random.normal()).collect();
    let found = summary(&[analysed(noise, 4000.0, gesture(), None)]);
    assert_eq!(found.peaks, []);
    let one = analysed(tone(125.0, 10.0, 4000.0, 1), 4000.0, gesture(), None);
    let highest = summary(&[one]).peaks[0].frequency_hz;
    assert!((highest - 125.0).abs() < 0.5, "{highest} Hz");
}

/// Friction that rises in rank from 0.49987 to 0.50000 does not change; one that doubles does, with its size.
#[test]
fn friction_that_changes_by_less_than_its_scatter_does_not_rise() {
    let ra: Vec<f64> = (1..=6).map(|i| 1e-6 * f64::from(i)).collect();
    let said = |friction: &[f64], scatter: f64| {
        let of = |mean: &f64| Statistics {
            mean: *mean,
            sd: scatter,
            median: *mean,
        };
        let pairs: Vec<(f64, Statistics)> =
            ra.iter().copied().zip(friction.iter().map(of)).collect();
        let change: FrictionChange = friction_change(&pairs).unwrap();
        change.conclusion(&rank_correlation(&ra, friction).unwrap(), "Ra")
    };
    let flat = [0.49987, 0.49989, 0.49992, 0.49994, 0.49997, 0.5];
    let flat = said(&flat, 0.0);
    assert!(
        !flat.contains("rises") && flat.contains("+0.03 %"),
        "{flat}"
    );
    let rising = [0.25, 0.3, 0.35, 0.4, 0.45, 0.5];
    let clear = said(&rising, 0.01);
    assert!(
        clear.starts_with("friction rises with Ra") && clear.contains(" %"),
        "{clear}"
    );
    let slight = [0.500, 0.505, 0.51, 0.515, 0.52, 0.525];
    let scattered = said(&slight, 0.1);
    assert!(
        !scattered.contains("rises") && scattered.contains("scatter"),
        "{scattered}"
    );
}
