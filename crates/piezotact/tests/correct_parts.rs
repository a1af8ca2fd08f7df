//! What a correction may and may not do, one thing at a time.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use num_complex::Complex;
use piezotact::correct::{CorrectConfig, Correction};
use piezotact::lineage::Mode;
use piezotact::quantity::{Acceleration, Band, Decibels, Drive, Hertz, SampleRate};
use piezotact::render::{PhaseForm, RenderConfig, RenderError, share_of_least_error};
use piezotact::series::Series;
use piezotact::spectrum::{Spectrum, WelchPlan};
use piezotact::statistics::rms;
use piezotact::transfer::{Estimator, TransferFunction};
use piezotact::verify::VerifyError;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

fn rate() -> SampleRate {
    SampleRate::new(5_000.0).unwrap()
}

fn band() -> Band {
    Band::new(Hertz(50.0), Hertz(1_000.0)).unwrap()
}

fn noise(seed: u64, samples: usize, level: f64) -> Vec<f64> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut uniform = || (random.next_u64() >> 11) as f64 * 2f64.powi(-53) - 0.5;
    (0..samples)
        .map(|_| level * 2.0 * (uniform() + uniform() + uniform()))
        .collect()
}

fn series(samples: Vec<f64>) -> Series<Acceleration> {
    Series::new(samples, rate()).unwrap()
}

/// A device that answers a drive of 1 with 10 m/s² at every frequency.
fn flat() -> TransferFunction<Drive, Acceleration> {
    TransferFunction::from_lines(
        vec![Complex::new(10.0, 0.0); 1025],
        vec![1.0; 1025],
        2_500.0 / 1_024.0,
        rate(),
        Estimator::H1,
        100,
    )
    .unwrap()
}

fn correction(target: &Series<Acceleration>, mode: Mode) -> Correction<Acceleration> {
    let config = RenderConfig::over(band(), rate());
    Correction::new(target, &flat(), &config, &CorrectConfig::usual(mode)).unwrap()
}

fn silence(correction: &Correction<Acceleration>) -> Spectrum<Acceleration> {
    let quiet = noise(99, 20_000, 1e-6);
    let mut plan = WelchPlan::new(correction.welch(), rate()).unwrap();
    plan.estimate::<Acceleration>(&[&quiet]).unwrap()
}

/// What `gain` times the flat device answers.
fn answer(drive: &Series<Drive>, gain: f64) -> Series<Acceleration> {
    series(drive.samples().iter().map(|u| gain * 10.0 * u).collect())
}

fn level_db(drive: &Series<Drive>) -> f64 {
    20.0 * rms(drive.samples()).log10()
}

/// The share solves x·exp(x) = c with x = −2·ln(share), from next to no cost to any.
#[test]
fn shares_solve_their_equation() {
    for cost in [0.0, -1.0, f64::NAN] {
        assert!((share_of_least_error(cost) - 1.0).abs() < 1e-15);
    }
    for exponent in -60..=90 {
        let cost = 10f64.powf(f64::from(exponent) / 10.0);
        let x = -2.0 * share_of_least_error(cost).ln();
        assert!(
            (x * x.exp() / cost - 1.0).abs() < 1e-9,
            "{cost}: {}",
            x * x.exp()
        );
    }
    // W(1), the omega constant, from tables.
    let omega = 0.567_143_290_409_783_8;
    assert!((share_of_least_error(1.0) - f64::exp(-0.5 * omega)).abs() < 1e-15);
}

/// Of all ways to save the same power, this one takes the fewest decibels, rms.
#[test]
fn shares_cost_the_least_error() {
    let costs: Vec<f64> = noise(3, 500, 2.0).iter().map(|x| 10f64.powf(*x)).collect();
    let error = |shares: &[f64]| rms(&shares.iter().map(|s| 20.0 * s.log10()).collect::<Vec<_>>());
    let power =
        |shares: &[f64]| -> f64 { costs.iter().zip(shares).map(|(cost, s)| cost * s * s).sum() };
    // What other rules save, at the strength at which they save as much.
    let saving = |rule: &dyn Fn(f64, f64) -> f64, wanted: f64| -> Vec<f64> {
        let (mut weak, mut strong) = (-9.0, 9.0);
        for _ in 0..80 {
            let middle = 0.5 * (weak + strong);
            let shares: Vec<f64> = costs.iter().map(|c| rule(*c, 10f64.powf(middle))).collect();
            if power(&shares) > wanted {
                weak = middle;
            } else {
                strong = middle;
            }
        }
        costs.iter().map(|c| rule(*c, 10f64.powf(strong))).collect()
    };
    let all: f64 = costs.iter().sum();
    for kept in [0.9, 0.5, 0.1] {
        let ours = error(&saving(&|c, l| share_of_least_error(l * c), kept * all));
        let quotient = error(&saving(&|c, l| 1.0 / (1.0 + l * c), kept * all));
        let alike = error(&saving(&|_, l| 1.0 / (1.0 + l), kept * all));
        let cut = error(&saving(&|c, l| (1.0 / (l * c)).sqrt().min(1.0), kept * all));
        assert!(
            ours < quotient && ours < alike && ours < cut,
            "{kept}: {ours:.2} {quotient:.2} {alike:.2} {cut:.2} dB"
        );
    }
}

/// However wrong a response, a step is 6 dB; up and down.
#[test]
fn no_step_is_larger_than_it_may_be() {
    let target = series(noise(1, 20_000, 0.5));
    for mode in [Mode::Texture, Mode::Replicate] {
        for gain in [0.01, 30.0] {
            let mut correction = correction(&target, mode);
            let quiet = silence(&correction);
            let before = correction.drive().unwrap();
            let response = answer(&before, gain);
            correction.learn(&[&response], &quiet).unwrap();
            let changed = level_db(&correction.drive().unwrap()) - level_db(&before);
            assert!(
                changed.abs() < 6.1 && changed.signum() == (1.0 - gain).signum(),
                "{mode:?}, {gain}: {changed:.2} dB"
            );
        }
    }
}

/// A gain that is wrong is put right, in both modes, and then left alone; the edges outside the band follow nothing.
#[test]
fn a_wrong_gain_is_put_right_and_the_edges_stay() {
    let target = series(noise(2, 40_000, 0.5));
    for mode in [Mode::Texture, Mode::Replicate] {
        let mut correction = correction(&target, mode);
        let quiet = silence(&correction);
        let first = correction.drive().unwrap();
        for _ in 0..8 {
            let response = answer(&correction.drive().unwrap(), 0.8);
            correction.learn(&[&response], &quiet).unwrap();
        }
        let last = correction.drive().unwrap();
        let mut plan = WelchPlan::new(correction.welch(), rate()).unwrap();
        let [before, after] =
            [&first, &last].map(|drive| plan.estimate::<Drive>(&[drive.samples()]).unwrap());
        let change_db = |hz: f64| {
            let line = (hz / before.resolution_hz).round() as usize;
            10.0 * (after.values[line] / before.values[line]).log10()
        };
        for hz in [100.0, 400.0, 900.0] {
            assert!(
                (change_db(hz) - 1.938).abs() < 0.1,
                "{mode:?}: {hz} Hz {}",
                change_db(hz)
            );
        }
        assert!(
            change_db(1_060.0).abs() < 0.5,
            "{mode:?}: {}",
            change_db(1_060.0)
        );
        let step = {
            let response = answer(&last, 0.8);
            correction.learn(&[&response], &quiet).unwrap()
        };
        assert!(step.corrected > 0.99 && step.change_db < 0.1, "{step:?}");
    }
}

/// What two measurements of one drive do not share is not learned.
#[test]
fn what_does_not_repeat_is_not_learned() {
    let target = series(noise(4, 40_000, 0.5));
    let response = |drive: &Series<Drive>, seed: u64| {
        let came = drive
            .samples()
            .iter()
            .zip(noise(seed, drive.samples().len(), 0.3));
        series(came.map(|(u, n)| 10.0 * u + n).collect())
    };
    let error_after = |both: bool| {
        let mut correction = correction(&target, Mode::Replicate);
        let quiet = silence(&correction);
        let drive = correction.drive().unwrap();
        let (one, other) = (response(&drive, 5), response(&drive, 6));
        let heard: Vec<&Series<Acceleration>> = if both { vec![&one, &other] } else { vec![&one] };
        correction.learn(&heard, &quiet).unwrap();
        let now = correction.drive().unwrap();
        let added: Vec<f64> = now
            .samples()
            .iter()
            .zip(drive.samples())
            .map(|(a, b)| a - b)
            .collect();
        rms(&added) / rms(drive.samples())
    };
    let (one, both) = (error_after(false), error_after(true));
    assert!(both < 0.3 * one, "{both} of {one}");
}

/// The level that is offered fits, and half a decibel more does not.
#[test]
fn the_level_that_is_offered_fits() {
    for (mode, loud) in [(Mode::Texture, 9.0), (Mode::Replicate, 9.0)] {
        let target = series(noise(7, 20_000, loud));
        let mut asked = correction(&target, mode);
        asked.drive().unwrap();
        assert!(
            !asked.fits() && asked.asked() > 1.0,
            "{mode:?}: {}",
            asked.asked()
        );
        let fits_at = asked.fits_at();
        for (more_db, fits) in [(0.0, true), (0.5, false)] {
            let softer = target.clone().amplified(Decibels(fits_at.0 + more_db));
            let mut correction = correction(&softer, mode);
            let drive = correction.drive().unwrap();
            assert!(drive.peak() <= 1.0);
            assert_eq!(correction.fits(), fits, "{mode:?} {fits_at:?} {more_db}");
        }
        // With free phases more fits than with the waveform's own.
        assert!(fits_at.0 < 0.0);
    }
}

#[test]
fn what_cannot_be_learned_from_is_refused() {
    let target = series(noise(8, 20_000, 0.5));
    let mut one = correction(&target, Mode::Texture);
    let quiet = silence(&one);
    let drive = one.drive().unwrap();
    let other_rate =
        Series::<Acceleration>::new(drive.samples().to_vec(), SampleRate::new(10_000.0).unwrap())
            .unwrap();
    assert!(matches!(
        one.learn(&[&other_rate], &quiet),
        Err(VerifyError::Rate { .. })
    ));
    assert!(matches!(
        one.learn(&[], &quiet),
        Err(VerifyError::TooShort { found: 0, .. })
    ));
    let flat_line = series(vec![0.0; 20_000]);
    assert!(matches!(
        one.learn(&[&flat_line], &quiet),
        Err(VerifyError::Silent { .. })
    ));
    let mut minimum = RenderConfig::over(band(), rate());
    minimum.inverse.phase = PhaseForm::Minimum;
    let refused = Correction::new(
        &target,
        &flat(),
        &minimum,
        &CorrectConfig::usual(Mode::Replicate),
    );
    assert!(matches!(refused, Err(RenderError::Phase)));
}

/// A target softer than the sensor's noise in part of the band is said to be.
#[test]
fn lines_that_the_noise_hides_are_named() {
    let target = series(noise(9, 20_000, 0.01));
    let correction = correction(&target, Mode::Texture);
    assert!(correction.hidden(&silence(&correction)).unwrap().is_none());
    let mut plan = WelchPlan::new(correction.welch(), rate()).unwrap();
    let loud = plan
        .estimate::<Acceleration>(&[&noise(10, 20_000, 0.02)])
        .unwrap();
    let warning = correction.hidden(&loud).unwrap().unwrap().to_string();
    assert!(
        warning.starts_with(
            "100 % of the band (50–1000 Hz) holds a target below the noise of the sensor"
        ),
        "{warning}"
    );
}
