//! Short effects in recordings that hold silence before and after them.

use std::f64::consts::TAU;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use super::*;
use crate::quantity::SampleRate;

const RATE_HZ: f64 = 5000.0;

/// A decaying tone of `hz` that begins at `peak_m_s2`, in 2 s of the noise of a sensor (5 mm/s²).
fn recorded(seconds: f64, peak_m_s2: f64, hz: f64, seed: u64) -> Series<Acceleration> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut uniform = || (rng.next_u64() >> 11) as f64 * 2f64.powi(-52) - 1.0;
    let mut samples: Vec<f64> = (0..10_000).map(|_| 0.0087 * uniform()).collect();
    for i in 0..(seconds * RATE_HZ) as usize {
        let t_s = i as f64 / RATE_HZ;
        samples[3000 + i] += peak_m_s2 * (-t_s / (0.3 * seconds)).exp() * (TAU * hz * t_s).cos();
    }
    Series::new(samples, SampleRate::new(RATE_HZ).unwrap()).unwrap()
}

fn scored(reference: &Series<Acceleration>, test: &Series<Acceleration>) -> Score {
    let band = Band::new(Hertz(20.0), Hertz(1000.0)).unwrap();
    score(reference, test, &ScoreConfig::over(band, RATE_HZ)).unwrap()
}

fn by_spectra(reference: &Series<Acceleration>, test: &Series<Acceleration>) -> Score {
    let band = Band::new(Hertz(20.0), Hertz(1000.0)).unwrap();
    let config = ScoreConfig {
        judged_by: ScoreModel::Spectral,
        ..ScoreConfig::over(band, RATE_HZ)
    };
    score(reference, test, &config).unwrap()
}

/// "0.00–37.04 JND" used to be "so close that a longer recording cannot decide".
#[test]
fn an_interval_that_holds_everything_says_nothing() {
    let mut found = by_spectra(
        &recorded(0.3, 10.0, 220.0, 1),
        &recorded(0.3, 9.0, 220.0, 2),
    );
    found.verdict = Verdict::NotDecided { needed_s: None };
    let mut said = |low_jnd: f64, high_jnd: f64| {
        found.spectral = Difference {
            jnd: 1.2,
            low_jnd,
            high_jnd,
            ..found.spectral
        };
        found.in_words()
    };
    let wide = said(0.0, 37.04);
    assert!(wide.contains("the interval says nothing"), "{wide}");
    let close = said(1.1, 1.3);
    assert!(close.contains("published range"), "{close}");
}

/// "Below the threshold" in every third octave and "above" in sum stood side by side without the sum.
#[test]
fn the_sum_over_third_octaves_is_shown_where_none_reaches_the_threshold() {
    use crate::page::Shown as _;
    let model = Model::over(Band::new(Hertz(20.0), Hertz(1000.0)).unwrap());
    // Tones 3 dB below the threshold, in eight third octaves.
    let centres_hz = [50.1, 63.1, 79.4, 100.0, 125.9, 158.5, 199.5, 251.2];
    let with = |gain: f64, seed: u64| {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let samples = (0..50_000).map(|i| {
            let t_s = i as f64 / RATE_HZ;
            let tones = centres_hz.iter().map(|hz| {
                let rms = 0.708 * gain * model.threshold_m_s2(Hertz(*hz));
                rms * 2f64.sqrt() * (TAU * (hz * t_s + seed as f64 * 0.37)).sin()
            });
            tones.sum::<f64>() + 1e-4 * (rng.next_u64() >> 11) as f64 * 2f64.powi(-53)
        });
        Series::new(samples.collect(), SampleRate::new(RATE_HZ).unwrap()).unwrap()
    };
    let said = |gain: f64| {
        let score = scored(&with(gain, 1), &with(gain, 2));
        assert!(score.reference_sensation_db > 0.0);
        let scored = ScoredRecordings {
            names: ["a", "b"].map(Into::into),
            provenance: Default::default(),
            sensitivity: Vec::new(),
            score,
        };
        format!("{:?}", scored.page())
    };
    assert!(said(1.0).contains("adds up to"));
    assert!(!said(2.0).contains("adds up to"));
}

/// A click of 10 m/s² used to be 20 dB below the threshold, because 2 s of silence were averaged with it.
#[test]
fn a_click_is_scored_without_the_silence_around_it() {
    for seconds in [0.005, 0.02, 0.08, 0.3] {
        let click = recorded(seconds, 10.0, 220.0, 1);
        let same = scored(&click, &recorded(seconds, 10.0, 220.0, 2));
        assert!(
            same.reference_sensation_db > 10.0,
            "{seconds} s: {}",
            same.reference_sensation_db
        );
        assert_eq!(
            same.verdict,
            Verdict::BelowJnd,
            "{seconds} s: {}",
            same.sentence
        );
        let kept = same.warnings.iter().find_map(|one| match one.kind() {
            Some(ScoreWarning::SilenceExcluded { kept_s, .. }) => Some(kept_s),
            _ => None,
        });
        assert!(
            kept.is_some_and(|kept_s| kept_s < seconds + 0.03),
            "{seconds} s: {kept:?}"
        );
        let softer = scored(&click, &recorded(seconds, 5.0, 220.0, 2));
        assert!(
            matches!(softer.verdict, Verdict::Distinguishable { .. }),
            "{seconds} s: {}",
            softer.sentence
        );
        assert!(
            (softer.level_error_db + 6.0).abs() < 0.5,
            "{seconds} s: {}",
            softer.level_error_db
        );
    }
}

/// The level of a vibration does not depend on how much silence was recorded with it.
#[test]
fn silence_does_not_change_a_level() {
    let whole = recorded(0.3, 10.0, 220.0, 1);
    let part = |from: usize, to: usize| {
        Series::<Acceleration>::new(whole.samples()[from..to].to_vec(), whole.rate()).unwrap()
    };
    let alone = part(3000, 4500);
    let level = |x: &Series<Acceleration>| scored(x, x).reference_sensation_db;
    let (own, padded) = (level(&alone), level(&whole));
    assert!((own - padded).abs() < 1.0, "{own} {padded}");
}

/// A cut of a longer vibration says little of it, however well it follows: below 0.3 s, for spectra below a segment, it is refused by its
/// own name.
#[test]
fn a_short_cut_of_a_longer_vibration_is_refused() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let mut uniform = || (rng.next_u64() >> 11) as f64 * 2f64.powi(-52) - 1.0;
    let samples: Vec<f64> = (0..50_000).map(|_| uniform()).collect();
    let rate = SampleRate::new(RATE_HZ).unwrap();
    let whole = Series::<Acceleration>::new(samples.clone(), rate).unwrap();
    let cut = |n: usize| Series::new(samples[..n].to_vec(), rate).unwrap();
    let (short, shorter) = (cut(2_000), cut(1_000));
    let band = Band::new(Hertz(20.0), Hertz(1000.0)).unwrap();
    let perceived = ScoreConfig::over(band, RATE_HZ);
    let spectral = ScoreConfig {
        judged_by: ScoreModel::Spectral,
        ..perceived.clone()
    };
    for (cut, config, limits) in [
        (&short, &spectral, ["0.82 s", "0.400 s"]),
        (&shorter, &perceived, ["0.30 s", "0.200 s"]),
    ] {
        for (pair, name) in [
            ([&whole, cut], "the test"),
            ([cut, &whole], "the reference"),
        ] {
            let said = score(pair[0], pair[1], config).unwrap_err().to_string();
            let expected = [name, limits[0], limits[1], "record longer"];
            assert!(expected.iter().all(|part| said.contains(part)), "{said}");
        }
    }
    let found = score(&whole, &short, &perceived).unwrap();
    assert_eq!(found.verdict, Verdict::BelowJnd, "{}", found.sentence);
}
