//! Drive and response sampled by two clocks, or with samples missing that nobody reported.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use piezotact::recording::{Clocks, LostBy, RecordingWarning};
use std::f64::consts::{PI, TAU};

use piezotact::Series;
use piezotact::quantity::{Acceleration, Band, Drive, Hertz, SampleRate};
use piezotact::spectrum::WelchConfig;
use piezotact::transfer::{
    Estimator, Known, OneClock, TransferFunction, estimate, estimate_without, on_one_clock,
};

const RATE_HZ: f64 = 5_000.0;

/// Numbers that look normal.
struct Noise(u64);

impl Noise {
    fn normal(&mut self) -> f64 {
        let mut uniform = || {
            self.0 = self
                .0
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (self.0 >> 11) as f64 / (1_u64 << 53) as f64
        };
        (0..4).map(|_| uniform()).sum::<f64>() * 1.732 - 3.464
    }
}

/// The samples of `signal` at `place(i)`, by a windowed sinc of 64 that passes what is below `pass`, re half the rate.
fn at(signal: &[f64], count: usize, pass: f64, place: impl Fn(f64) -> f64) -> Vec<f64> {
    (0..count)
        .map(|i| {
            let at = place(i as f64);
            let first = at.floor() as i64;
            (first - 31..=first + 32)
                .filter_map(|k| {
                    let sample = usize::try_from(k).ok().and_then(|k| signal.get(k))?;
                    let x = at - k as f64;
                    let sinc = if x.abs() < 1e-9 {
                        pass
                    } else {
                        (PI * pass * x).sin() / (PI * x)
                    };
                    Some(sample * sinc * (0.5 + 0.5 * (PI * x / 33.0).cos()))
                })
                .sum()
        })
        .collect()
}

/// Noise up to 1200 Hz and what a resonance at 180 Hz makes of it.
fn pair(seed: u64, count: usize) -> (Vec<f64>, Vec<f64>) {
    let mut noise = Noise(seed);
    let white: Vec<f64> = (0..count).map(|_| noise.normal()).collect();
    let drive = at(&white, count, 1200.0 / 2500.0, |i| i);
    let (r, turn) = (0.95, TAU * 180.0 / RATE_HZ);
    let (mut before, mut last) = (0.0, 0.0);
    let mut response = Vec::with_capacity(count);
    let mut old = 0.0;
    for x in &drive {
        let now = x - old + 2.0 * r * turn.cos() * last - r * r * before;
        (old, before, last) = (*x, last, now);
        response.push(now);
    }
    (drive, response)
}

fn noisy(samples: Vec<f64>, seed: u64, rms: f64) -> Vec<f64> {
    let mut noise = Noise(seed ^ 0x5eed);
    samples
        .into_iter()
        .map(|v| v + rms * noise.normal())
        .collect()
}

fn series(drive: &[f64], response: &[f64]) -> (Series<Drive>, Series<Acceleration>) {
    let rate = SampleRate::new(RATE_HZ).unwrap();
    (
        Series::new(drive.to_vec(), rate).unwrap(),
        Series::new(response.to_vec(), rate).unwrap(),
    )
}

fn welch() -> WelchConfig {
    WelchConfig::hann(2048)
}

fn function(drive: &[f64], response: &[f64]) -> TransferFunction<Drive, Acceleration> {
    let (drive, response) = series(drive, response);
    estimate(&drive, &response, &welch(), Estimator::H1).unwrap()
}

fn found(drive: &[f64], response: &[f64]) -> Option<OneClock<Acceleration>> {
    let (drive, response) = series(drive, response);
    on_one_clock(&drive, &response, &welch())
}

/// The rms difference of the magnitudes over 30–1100 Hz, dB.
fn apart_db(
    a: &TransferFunction<Drive, Acceleration>,
    b: &TransferFunction<Drive, Acceleration>,
) -> f64 {
    let band = Band::new(Hertz(30.0), Hertz(1100.0)).unwrap();
    let squares: Vec<f64> = a
        .lines_in(band)
        .map(|(k, _)| (20.0 * (a.response()[k].norm() / b.response()[k].norm()).log10()).powi(2))
        .collect();
    (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
}

/// 10 to 200 parts per million either way are found, told with their uncertainty, and corrected for to within 0.1 dB.
#[test]
fn clocks_that_differ_are_found_and_corrected_for() {
    let (drive, response) = pair(1, 100_000);
    let truth = function(&drive, &response);
    for ppm in [10.0, -50.0, 200.0] {
        // A fast clock takes its sample i early.
        let late = at(&response, response.len(), 1.0, |i| i / (1.0 + ppm * 1e-6));
        let late = noisy(late, 3, 0.01);
        let before = apart_db(&function(&drive, &late), &truth);
        let one = found(&drive, &late).unwrap();
        let Some(RecordingWarning::ClocksDiffer {
            of:
                Clocks::Response {
                    ppm: told,
                    uncertainty_ppm: uncertainty,
                },
        }) = one.warnings[0].kind()
        else {
            panic!("{:?}", one.warnings);
        };
        assert_eq!(one.warnings.len(), 1);
        assert!(
            (told - ppm).abs() < 4.0 * uncertainty + 1e-3 * ppm.abs() && uncertainty < 1.0,
            "{ppm}: {told} ± {uncertainty}"
        );
        let after = apart_db(&function(&drive, one.response.samples()), &truth);
        assert!(after <= 0.1 && before > 0.1, "{ppm}: {before} → {after} dB");
    }
}

/// Samples of the response, or of the drive, that are missing are found where they are, counted, and moved back.
#[test]
fn missing_samples_are_found() {
    let (drive, response) = pair(2, 100_000);
    let truth = function(&drive, &response);
    for (from, count) in [(40_000, 30), (70_000, 3)] {
        for swapped in [false, true] {
            let mut gone = if swapped {
                drive.clone()
            } else {
                response.clone()
            };
            gone.drain(from..from + count);
            let length = gone.len();
            let (x, y) = match swapped {
                true => (gone, response[..length].to_vec()),
                false => (drive[..length].to_vec(), gone),
            };
            let y = noisy(y, 4, 0.01);
            let one = found(&x, &y).unwrap();
            let Some(RecordingWarning::SamplesLost {
                by: LostBy::Unreported { count: told, at_s },
            }) = one.warnings[0].kind()
            else {
                panic!("{:?}", one.warnings);
            };
            assert_eq!(one.warnings.len(), 1, "{:?}", one.warnings);
            let expected = count as f64 * if swapped { -1.0 } else { 1.0 };
            assert!((told - expected).abs() < 1e-9, "{told} of {expected}");
            let place = from as f64 / RATE_HZ;
            assert!((at_s - place).abs() < 0.5, "{at_s}");
            let [low, high] = one.missing_s[0];
            assert!((low..=high).contains(&place), "{low}–{high}");
            // Those within the stretch are mixed; the rest is whole.
            let after = apart_db(&function(&x, one.response.samples()), &truth);
            assert!(after < 0.5, "{after} dB");
        }
    }
}

/// Of 200 recordings on one clock none or two give a warning, whether the response is clear or half of it noise.
#[test]
fn one_clock_is_not_reported() {
    let mut reported = Vec::new();
    let (drive, response) = pair(5, 12_000);
    for seed in 0..200 {
        let level = if seed % 2 == 0 { 0.02 } else { 0.5 };
        let from = (seed as usize % 4) * 1_000;
        let y = noisy(response[from..from + 8_000].to_vec(), seed, level);
        if let Some(one) = found(&drive[from..from + 8_000], &y) {
            reported.push((seed, one.warnings));
        }
    }
    assert!(reported.len() <= 2, "{}: {reported:?}", reported.len());
}

/// What was reported as lost, with straight lines in its place, is left out, and too little that is left is refused.
#[test]
fn segments_that_touch_what_was_lost_are_left_out() {
    let (drive, response) = pair(6, 50_000);
    let truth = function(&drive, &response);
    let (mut x, mut y) = (drive.clone(), response.clone());
    for (from, count) in [(15_000, 250), (25_000, 40)] {
        for signal in [&mut x, &mut y] {
            let (a, b) = (signal[from - 1], signal[from + count]);
            for k in 0..count {
                signal[from + k] = a + (b - a) * (k + 1) as f64 / (count + 1) as f64;
            }
        }
    }
    let (x, y) = series(&x, &y);
    let known = Known {
        lost_s: &[[3.0, 3.05], [5.0, 5.008]],
        driven: None,
    };
    let across = estimate(&x, &y, &welch(), Estimator::H1).unwrap();
    let without = estimate_without(&x, &y, &welch(), Estimator::H1, known).unwrap();
    let left_out = without
        .about
        .warnings
        .iter()
        .find_map(|warning| match warning.kind() {
            Some(RecordingWarning::SamplesLost {
                by: LostBy::Segments { left_out, of },
            }) => Some((left_out, of)),
            _ => None,
        });
    assert_eq!(left_out, Some((4, 47)));
    assert_eq!(without.averages, 43);
    let (before, after) = (apart_db(&across, &truth), apart_db(&without, &truth));
    assert!(
        after < 0.2 * before && after < 0.005,
        "{before} → {after} dB"
    );
    let long = WelchConfig::hann(16_384);
    let few = estimate_without(&x, &y, &long, Estimator::H1, known).unwrap_err();
    assert!(few.to_string().contains("found 1 of 5"), "{few}");
}
