//! Whether drive and response are related, and by how much one follows the other: what is said of pairs of which the truth
//! is known.
#![allow(
    clippy::print_stdout,
    clippy::unwrap_used,
    reason = "a test stops where something is missing, and prints what it measured"
)]

use piezotact::transfer::TransferWarning;
use std::f64::consts::TAU;

use piezotact::quantity::{Acceleration, Drive, Quantity, SampleRate};
use piezotact::series::Series;
use piezotact::spectrum::{WelchConfig, Window};
use piezotact::transfer::{Estimator, TransferFunction, cross_spectra, estimate};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

const RATE_HZ: f64 = 1_000.0;

fn noise(seed: u64, samples: usize) -> Vec<f64> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut uniform = || (random.next_u64() >> 11) as f64 * 2f64.powi(-53);
    (0..samples)
        .map(|_| (-2.0 * (1.0 - uniform()).ln()).sqrt() * (TAU * uniform()).cos())
        .collect()
}

/// Noise whose neighbouring samples are alike: low frequencies are stronger by 20 dB.
fn coloured(seed: u64, samples: usize) -> Vec<f64> {
    let mut last = 0.0;
    noise(seed, samples)
        .into_iter()
        .map(|x| {
            last = 0.8 * last + x;
            last
        })
        .collect()
}

fn series<Q: Quantity>(samples: Vec<f64>) -> Series<Q> {
    Series::new(samples, SampleRate::new(RATE_HZ).unwrap()).unwrap()
}

fn function(x: &[f64], y: &[f64], config: &WelchConfig) -> TransferFunction<Drive, Acceleration> {
    let (x, y) = (series(x.to_vec()), series(y.to_vec()));
    estimate(&x, &y, config, Estimator::H1).unwrap()
}

fn unrelated(function: &TransferFunction<Drive, Acceleration>) -> bool {
    let mut warnings = function.about.warnings.iter();
    warnings.any(|warning| matches!(warning.kind(), Some(TransferWarning::Unrelated { .. })))
}

fn delay_said(function: &TransferFunction<Drive, Acceleration>) -> Option<f64> {
    function
        .about
        .warnings
        .iter()
        .find_map(|warning| match warning.kind() {
            Some(TransferWarning::LateResponse { delay_s, .. }) => Some(delay_s),
            Some(TransferWarning::Acausal { lead_s, .. }) => Some(-lead_s),
            _ => None,
        })
}

fn hann(segment: usize, overlap: f64) -> WelchConfig {
    WelchConfig {
        overlap,
        ..WelchConfig::hann(segment)
    }
}

/// Of 400 unrelated pairs for each way of averaging, at most 5 % (and what 400 pairs scatter by) are taken for related, and
/// of none a delay is said.
#[test]
#[ignore = "many repetitions: ./x soak runs it"]
fn soak_unrelated_pairs_are_called_related_as_often_as_stated() {
    const PAIRS: u64 = 400;
    type Make = fn(u64, usize) -> Vec<f64>;
    let makes: [(&str, Make); 2] = [("white", noise), ("coloured", coloured)];
    for (config, samples) in [
        (hann(128, 0.5), 4_000),
        (hann(128, 0.75), 4_000),
        (hann(64, 0.5), 400),
        (hann(512, 0.5), 2_048),
        (
            WelchConfig {
                window: Window::Rectangular,
                ..hann(128, 0.0)
            },
            4_000,
        ),
    ] {
        for (called, make) in makes {
            let (mut related, mut late) = (0, 0);
            for seed in 0..PAIRS {
                let (x, y) = (make(2 * seed, samples), make(2 * seed + 1, samples));
                let found = function(&x, &y, &config);
                related += usize::from(!unrelated(&found));
                late += usize::from(delay_said(&found).is_some());
            }
            println!(
                "{called}, seeds 0 to {}: segments of {}, {} % overlap of {samples} samples: {related} of {PAIRS} taken for related, {late} for late",
                2 * PAIRS - 1,
                config.segment,
                config.overlap * 100.0
            );
            // 5 % of 400 and two and a half standard deviations.
            assert!(related <= 31, "{related}");
            assert!(late <= 8, "{late}");
        }
    }
}

/// Pairs of γ² 0.46 with 57 averages are related, every one; of γ² 0.05, little above chance (0.018), nearly all.
#[test]
fn weakly_related_pairs_are_related() {
    let (samples, config) = (58 * 64, hann(128, 0.5));
    for (coherence, pairs, least) in [(0.46, 120, 120), (0.1, 120, 120), (0.05, 120, 110)] {
        let gain = f64::sqrt(coherence / (1.0 - coherence));
        let mut related = 0;
        for seed in 0..pairs {
            let x = noise(3 * seed, samples);
            let other = noise(3 * seed + 1, samples);
            let y: Vec<f64> = x.iter().zip(&other).map(|(x, o)| gain * x + o).collect();
            let found = function(&x, &y, &config);
            related += usize::from(!unrelated(&found));
            assert_eq!(delay_said(&found), None, "seed {seed}");
        }
        println!("γ² {coherence}: {related} of {pairs} related");
        assert!(related >= least, "{related} of {pairs}");
    }
}

/// A tone that both channels share, as hum, is no relation of the others.
#[test]
fn a_tone_in_both_makes_no_relation() {
    let (samples, config) = (20_000, hann(256, 0.5));
    let mut found = 0;
    for seed in 0..20 {
        let hum = |t: usize| (TAU * 50.0 * t as f64 / RATE_HZ).sin();
        let with = |seed| -> Vec<f64> {
            let own = noise(seed, samples).into_iter().enumerate();
            own.map(|(t, x)| x + hum(t)).collect()
        };
        let function = function(&with(2 * seed), &with(2 * seed + 1), &config);
        found += usize::from(unrelated(&function));
        assert_eq!(delay_said(&function), None);
    }
    println!("{found} of 20 with a tone in both are unrelated");
    // In SciPy 88 % of such pairs, and 81 % with a tone of twice that amplitude.
    assert!(found >= 14, "{found} of 20");
}

/// One record, whatever the length of segments, has one delay: that which it has, within what is said of its uncertainty.
#[test]
fn one_record_has_one_delay() {
    let x = noise(5, 60_000);
    for (delay, gain) in [(107i64, 1.0), (263, 0.3), (-63, 0.3), (0, 0.3), (900, 0.1)] {
        let own = noise(6, 60_000);
        let y: Vec<f64> = (0..60_000i64)
            .map(|t| {
                let from = usize::try_from(t - delay).ok();
                let heard = from.and_then(|from| x.get(from)).copied();
                gain * heard.unwrap_or(0.0) + own[t as usize]
            })
            .collect();
        for segment in [128, 256, 512, 1_024] {
            let found = function(&x, &y, &hann(segment, 0.5));
            let said = delay_said(&found);
            println!("{delay} ms, segments of {segment}: {said:?}");
            assert!(!unrelated(&found), "{delay} {segment}");
            match said {
                None => assert_eq!(delay, 0),
                Some(said) => {
                    assert!((said * 1e3 - delay as f64).abs() < 1.5, "{delay}: {said}");
                }
            }
        }
    }
    // Signals that have nothing in common have none, whatever the length.
    for segment in [128, 256, 512, 1_024, 2_048] {
        let found = function(&x, &noise(7, 60_000), &hann(segment, 0.5));
        assert_eq!(delay_said(&found), None);
        assert!(unrelated(&found), "{:?}", found.about.warnings);
    }
}

/// What is said of an unrelated pair.
#[test]
fn an_unrelated_pair_is_said_with_what_chance_reaches() {
    let (x, y) = (noise(1, 4_000), noise(2, 4_000));
    let config = hann(128, 0.5);
    let spectra =
        cross_spectra::<Drive, Acceleration>(&series(x.clone()), &series(y.clone()), &config);
    let relation = spectra.unwrap().relation().unwrap();
    assert!(!relation.is_shown() && relation.lines == 63);
    // The mean of held values of Beta(1, n − 1) is a little below 1/n.
    assert!((relation.chance * relation.averages - 0.95).abs() < 0.01);
    let said = function(&x, &y, &config).about.warnings[0].to_string();
    println!("{said}");
    assert!(said.contains("no relation between drive and response is shown"));
}
