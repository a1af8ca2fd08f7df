//! Transfer functions of known plants under seeded noise: confidence intervals and warnings.
#![allow(
    clippy::print_stdout,
    clippy::unwrap_used,
    reason = "a test stops where something is missing, and prints what it measured"
)]

use piezotact::recording::{RecordingWarning, ReversedSign};
use std::f64::consts::TAU;

use num_complex::Complex;
use piezotact::Warning;
use piezotact::integrity::{ChannelFault, SignalWarning};
use piezotact::quantity::{Acceleration, Band, Drive, Force, Hertz, Quantity, SampleRate};
use piezotact::series::Series;
use piezotact::spectrum::{Detrend, WelchConfig};
use piezotact::transfer::{
    Blocks, Estimator, Known, Limits, TransferFunction, TransferWarning, best_linear, estimate,
    estimate_sweeps, max_pair_difference_db, pooled,
};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

const RATE_HZ: f64 = 5_000.0;

fn rate() -> SampleRate {
    SampleRate::new(RATE_HZ).unwrap()
}

/// White noise of the standard normal distribution.
pub(super) struct Noise(ChaCha8Rng);

impl Noise {
    pub(super) fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    fn uniform(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 * 2f64.powi(-53)
    }

    pub(super) fn next(&mut self) -> f64 {
        let radius = (-2.0 * (1.0 - self.uniform()).ln()).sqrt();
        radius * (TAU * self.uniform()).cos()
    }

    pub(super) fn take(&mut self, n: usize) -> Vec<f64> {
        (0..n).map(|_| self.next()).collect()
    }
}

/// A finger-like plant of a few samples' memory, so that no estimate of it leaks.
const PLANT: [f64; 5] = [0.0, 0.5, 1.0, 0.3, -0.4];

fn filtered(plant: &[f64], x: &[f64]) -> Vec<f64> {
    (0..x.len())
        .map(|i| {
            plant
                .iter()
                .take(i + 1)
                .enumerate()
                .map(|(k, h)| h * x[i - k])
                .sum()
        })
        .collect()
}

fn truth(hz: f64) -> Complex<f64> {
    let turn = |k: usize| Complex::from_polar(1.0, -TAU * hz * k as f64 / RATE_HZ);
    PLANT.iter().enumerate().map(|(k, h)| turn(k) * *h).sum()
}

/// A resonator: y'' + 2ζω₀y' + ω₀²y = ω₀²x, by its exact sampled impulse response.
fn resonator(frequency_hz: f64, damping_ratio: f64, seconds: f64) -> Vec<f64> {
    let omega = TAU * frequency_hz;
    let damped = omega * (1.0 - damping_ratio * damping_ratio).sqrt();
    (0..(seconds * RATE_HZ) as usize)
        .map(|i| i as f64 / RATE_HZ)
        .map(|t| {
            omega * omega / damped * (-damping_ratio * omega * t).exp() * (damped * t).sin()
                / RATE_HZ
        })
        .collect()
}

fn series<Q: Quantity>(samples: Vec<f64>) -> Series<Q> {
    Series::new(samples, rate()).unwrap()
}

fn function_of(
    drive: Vec<f64>,
    response: Vec<f64>,
    segment: usize,
) -> TransferFunction<Drive, Acceleration> {
    let config = WelchConfig::hann(segment);
    estimate(
        &series::<Drive>(drive),
        &series::<Acceleration>(response),
        &config,
        Estimator::H1,
    )
    .unwrap()
}

#[test]
fn limits_widen_as_coherence_falls_and_end_at_nothing() {
    let at = |coherence: f64, averages: usize| {
        let h = vec![Complex::from(2.0); 2];
        let function: TransferFunction<Drive, Acceleration> = TransferFunction::from_lines(
            h,
            vec![coherence; 2],
            10.0,
            rate(),
            Estimator::H1,
            averages,
        )
        .unwrap();
        function.confidence()
    };
    // t(0.975, 198) = 1.97202; √(0.01/0.99/198) = 0.0071424.
    let close = at(0.99, 100).unwrap();
    assert!(
        (close.high[1] - 2.0 * (1.0 + 1.972_02 * 0.007_142_4)).abs() < 1e-6,
        "{}",
        close.high[1]
    );
    assert!((close.phase_reach_rad[1] - (1.972_02f64 * 0.007_142_4).asin()).abs() < 1e-6);
    let mut previous = 0.0;
    for coherence in [1.0, 0.999, 0.9, 0.5, 0.2, 0.05, 0.01, 1e-3] {
        let found = at(coherence, 20).unwrap();
        let width = found.high[1] - found.low[1];
        assert!(
            width >= previous && found.low[1] >= 0.0,
            "{coherence}: {width} after {previous}"
        );
        previous = width;
    }
    let nothing = at(0.0, 20).unwrap();
    assert!(nothing.low[1] == 0.0 && nothing.high[1].is_infinite());
    assert!(at(0.5, 0).is_none() && at(0.5, 1).is_none());
}

fn named(function: &TransferFunction<Drive, Acceleration>, wanted: fn(&Warning) -> bool) {
    let warnings = &function.about.warnings;
    assert!(warnings.iter().any(wanted), "{warnings:?}");
}

/// A drive to 1 kHz, as the thesis has it.
fn band_limited(n: usize, seed: u64) -> Vec<f64> {
    // A windowed sinc of 201 taps.
    let taps: Vec<f64> = (-100i32..=100)
        .map(|k| {
            let t = f64::from(k);
            let window = 0.5 + 0.5 * (TAU * t / 202.0).cos();
            let sinc = if k == 0 {
                0.4
            } else {
                (0.4 * std::f64::consts::PI * t).sin() / (std::f64::consts::PI * t)
            };
            window * sinc
        })
        .collect();
    let mut drive = filtered(&taps, &Noise::new(seed).take(n));
    drive.iter_mut().for_each(|v| *v *= 0.25);
    drive
}

/// A spike of a thousand times the level leaves a coherence of a few hundredths: that is related, and worth a warning.
#[test]
fn a_weak_relation_and_a_tone_are_named() {
    let drive = band_limited(100_000, 1);
    let mut response = filtered(&resonator(200.0, 0.2, 0.1), &drive);
    response[50_000] += 100.0;
    let function = function_of(drive, response, 2048);
    named(
        &function,
        |d| matches!(d.kind(), Some(TransferWarning::LowCoherence { share, .. }) if share > 0.5),
    );
    let tone: Vec<f64> = (0..100_000)
        .map(|i| 0.5 * (TAU * 100.0 * f64::from(i) / RATE_HZ).sin())
        .collect();
    let mut response: Vec<f64> = tone.iter().map(|v| 3.0 * v).collect();
    for (sample, noise) in response.iter_mut().zip(Noise::new(2).take(100_000)) {
        *sample += 0.01 * noise;
    }
    let function = function_of(tone, response, 2048);
    named(
        &function,
        |d| matches!(d.kind(), Some(TransferWarning::NotExcited { share, .. }) if share > 0.9),
    );
}

#[test]
fn a_measurement_as_it_should_be_has_no_warning() {
    let drive = band_limited(100_000, 1);
    let mut response = filtered(&[vec![0.0; 8], resonator(200.0, 0.2, 0.1)].concat(), &drive);
    for (sample, noise) in response.iter_mut().zip(Noise::new(2).take(100_000)) {
        *sample += 0.01 * noise;
    }
    let function = function_of(drive, response, 2048);
    assert_eq!(function.about.warnings, []);
    let excited = function.excited.unwrap();
    assert!(
        excited.low().0 < 5.0 && (1_000.0..1_100.0).contains(&excited.high().0),
        "{excited}"
    );
    assert_eq!(
        function.not_excited(Band::new(Hertz(10.0), Hertz(950.0)).unwrap()),
        None
    );
    let Some(TransferWarning::NotExcited { bands, share }) = function
        .not_excited(Band::new(Hertz(10.0), Hertz(2_000.0)).unwrap())
        .as_ref()
        .and_then(Warning::kind)
    else {
        panic!("half of this band is not excited")
    };
    assert!(
        bands.len() == 1 && (0.45..0.5).contains(&share),
        "{bands:?} {share}"
    );
}

#[test]
fn swapped_channels_are_named() {
    let drive = band_limited(100_000, 1);
    let plant = [vec![0.0; 8], resonator(200.0, 0.2, 0.1)].concat();
    let response = filtered(&plant, &drive);
    let function = function_of(response, drive, 2048);
    let Some(TransferWarning::Acausal { lead_s, .. }) = function
        .about
        .warnings
        .iter()
        .filter(|d| matches!(d.kind(), Some(TransferWarning::Acausal { .. })))
        .find_map(Warning::kind)
    else {
        panic!("{:?}", function.about.warnings)
    };
    assert!((1e-3..5e-3).contains(&lead_s), "{lead_s}");
}

#[test]
fn a_response_that_is_late_by_more_than_a_segment_is_named() {
    let drive = band_limited(200_000, 3);
    for late_s in [0.3, 1.0, 5.0] {
        let late = (late_s * RATE_HZ) as usize;
        let mut response = vec![0.0; late];
        response.extend(filtered(
            &resonator(200.0, 0.2, 0.1),
            &drive[..drive.len() - late],
        ));
        let function = function_of(drive.clone(), response, 1024);
        let Some(TransferWarning::LateResponse {
            delay_s, segment_s, ..
        }) = function
            .about
            .warnings
            .iter()
            .filter(|d| matches!(d.kind(), Some(TransferWarning::LateResponse { .. })))
            .find_map(Warning::kind)
        else {
            panic!("{late_s}: {:?}", function.about.warnings)
        };
        assert!(
            (delay_s - late_s).abs() < 2e-3 && delay_s > segment_s,
            "{delay_s}"
        );
        assert!(!function.about.warnings.iter().any(|d| matches!(
            d.kind(),
            Some(TransferWarning::Unrelated { .. } | TransferWarning::Acausal { .. })
        )));
    }
}

#[test]
fn signals_without_anything_in_common_are_not_called_late() {
    let function = function_of(band_limited(100_000, 1), band_limited(100_000, 2), 1024);
    named(&function, |d| {
        matches!(d.kind(), Some(TransferWarning::Unrelated { .. }))
    });
    assert!(!function.about.warnings.iter().any(|d| matches!(
        d.kind(),
        Some(TransferWarning::LateResponse { .. } | TransferWarning::Acausal { .. })
    )));
}

/// From force to acceleration a passive finger takes power in; with one sign reversed it would give some.
#[test]
fn inverted_polarity_is_named() {
    let drive = band_limited(100_000, 1);
    // The acceleration of a mass on spring and damper: the second difference of its displacement.
    let moved = filtered(&resonator(120.0, 0.3, 0.1), &drive);
    let acceleration: Vec<f64> = moved.windows(3).map(|w| w[2] - 2.0 * w[1] + w[0]).collect();
    let of = |sign: f64| {
        let force = series::<Force>(drive[1..drive.len() - 1].iter().map(|f| sign * f).collect());
        let config = WelchConfig::hann(2048);
        estimate(
            &force,
            &series::<Acceleration>(acceleration.clone()),
            &config,
            Estimator::H1,
        )
        .unwrap()
    };
    assert!(
        !of(1.0)
            .about
            .warnings
            .contains(&Warning::from(RecordingWarning::Sign {
                of: ReversedSign::Power
            }))
    );
    assert!(
        of(-1.0)
            .about
            .warnings
            .contains(&Warning::from(RecordingWarning::Sign {
                of: ReversedSign::Power
            }))
    );
}

#[test]
fn a_gap_in_the_drive_is_named() {
    let drive = band_limited(100_000, 1);
    // Away with 300 to 400 Hz: minus its own band-pass.
    let mut plan = piezotact_fourier::ComplexPlanner::new();
    let mut bins: Vec<Complex<f64>> = drive.iter().map(|x| Complex::from(*x)).collect();
    plan.plan_fft_forward(bins.len()).process(&mut bins);
    let n = bins.len();
    for (k, bin) in bins.iter_mut().enumerate() {
        let hz = k.min(n - k) as f64 * RATE_HZ / n as f64;
        if (300.0..400.0).contains(&hz) {
            *bin = Complex::default();
        }
    }
    plan.plan_fft_inverse(n).process(&mut bins);
    let drive: Vec<f64> = bins.iter().map(|b| b.re / n as f64).collect();
    let mut response = filtered(&PLANT, &drive);
    for (sample, noise) in response.iter_mut().zip(Noise::new(2).take(100_000)) {
        *sample += 0.01 * noise;
    }
    let function = function_of(drive, response, 2048);
    let Some(TransferWarning::NotExcited { bands, .. }) = function
        .about
        .warnings
        .iter()
        .filter(|d| matches!(d.kind(), Some(TransferWarning::NotExcited { .. })))
        .find_map(Warning::kind)
    else {
        panic!("{:?}", function.about.warnings)
    };
    assert!(bands.len() == 1, "{bands:?}");
    assert!(
        (bands[0].low().0 - 300.0).abs() < 8.0 && (bands[0].high().0 - 400.0).abs() < 8.0,
        "{bands:?}"
    );
}

#[test]
fn a_clipped_response_is_named() {
    let drive = band_limited(100_000, 1);
    let response = filtered(&PLANT, &drive)
        .into_iter()
        .map(|y| y.clamp(-0.5, 0.5))
        .collect();
    named(
        &function_of(drive, response, 2048),
        |d| matches!(d.kind(), Some(SignalWarning::Channel { channel, fault: ChannelFault::Clipped { .. }, .. }) if channel.contains("acceleration")),
    );
}

/// A resonance 4 Hz wide: seen with lines of 0.6 Hz, too narrow for lines of 2.4 Hz, which underestimate it.
#[test]
fn a_resonance_that_segments_do_not_resolve_is_named() {
    let drive = Noise::new(5).take(600_000);
    let response = filtered(&resonator(200.0, 0.01, 0.4), &drive);
    let peak = |segment: usize| {
        let function = function_of(drive.clone(), response.clone(), segment);
        let height = function.peak_magnitude(Band::new(Hertz(150.0), Hertz(250.0)).unwrap());
        (height, function)
    };
    let (true_height, fine) = peak(16_384);
    assert!(
        !fine
            .about
            .warnings
            .iter()
            .any(|d| matches!(d.kind(), Some(TransferWarning::UnresolvedResonance { .. }))),
        "{:?}",
        fine.about.warnings
    );
    let (height, coarse) = peak(2_048);
    named(
        &coarse,
        |d| matches!(d.kind(), Some(TransferWarning::UnresolvedResonance { at_hz, .. }) if (at_hz - 200.0).abs() < 3.0),
    );
    let lost_db = 20.0 * (true_height / height).log10();
    assert!(
        lost_db > 0.5,
        "{lost_db} dB: nothing was lost and the warning is wrong"
    );
}

/// Two stretches under drives of one spectrum, pooled, are the estimate over both.
#[test]
fn repeats_under_one_drive_pool_as_one() {
    let (x, mut noise) = (Noise::new(1).take(20_000), Noise::new(2));
    let mut answer = || -> Vec<f64> {
        filtered(&PLANT, &x)
            .iter()
            .map(|y| y + 0.5 * noise.next())
            .collect()
    };
    let (first, second) = (answer(), answer());
    let config = WelchConfig {
        overlap: 0.0,
        detrend: Detrend::None,
        ..WelchConfig::hann(1000)
    };
    let of = |drive: Vec<f64>, response: Vec<f64>| {
        estimate(
            &series::<Drive>(drive),
            &series::<Acceleration>(response),
            &config,
            Estimator::H1,
        )
        .unwrap()
    };
    let whole = of(x.repeat(2), [first.clone(), second.clone()].concat());
    let (a, b) = (of(x.clone(), first), of(x, second));
    let one = pooled(&[&a, &b]).unwrap();
    assert_eq!(one.averages, 40);
    for line in 0..=500 {
        assert!((one.response()[line] - whole.response()[line]).norm() < 1e-12);
        assert!(
            (one.coherence()[line] - whole.coherence()[line]).abs() < 1e-12,
            "{line}"
        );
    }
    let band = Band::new(Hertz(20.0), Hertz(2_000.0)).unwrap();
    let apart = max_pair_difference_db(&[&a, &b], band).unwrap();
    assert!((0.2..2.0).contains(&apart), "{apart}");
    assert!(pooled::<Drive, Acceleration>(&[]).is_err());
}

/// The response of a quadratic distortion to periods of `drive`, without noise: PLANT on it and on a share of its square.
fn distorting(drive: &[f64], share: f64) -> Vec<f64> {
    let bent: Vec<f64> = drive.iter().map(|x| x + share * x * x).collect();
    filtered(&PLANT, &bent)
}

const PERIOD: usize = 4_000;

/// A random-phase multisine on odd lines to 1 kHz, one of four left out, of rms 1.
fn multisine(realisation: u64) -> Vec<f64> {
    let mut omitted = Noise::new(99);
    let mut phases = Noise::new(1_000 + realisation);
    let mut lines = Vec::new();
    for group in 0..100 {
        let out = (omitted.uniform() * 4.0) as usize;
        lines.extend(
            (0..4)
                .filter(|k| *k != out)
                .map(|k| 2 * (4 * group + k) + 1),
        );
    }
    let amplitude = (2.0 / lines.len() as f64).sqrt();
    let tones: Vec<(usize, f64)> = lines.iter().map(|k| (*k, TAU * phases.uniform())).collect();
    (0..PERIOD)
        .map(|i| {
            let turn = TAU * i as f64 / PERIOD as f64;
            amplitude
                * tones
                    .iter()
                    .map(|(k, phase)| (turn * *k as f64 + phase).cos())
                    .sum::<f64>()
        })
        .collect()
}

const BLOCKS: Blocks = Blocks {
    lead: PERIOD,
    length: PERIOD,
    in_a_row: 4,
    stride: 5 * PERIOD,
    rows: 6,
};

/// Six realisations of five periods each; what comes of them with noise of `noise` rms.
fn multisines(share: f64, noise: f64) -> (Vec<f64>, Vec<f64>) {
    multisines_of(share, noise, 0)
}

/// The same with the phases and the noise of `seed`.
fn multisines_of(share: f64, noise: f64, seed: u64) -> (Vec<f64>, Vec<f64>) {
    let drive: Vec<f64> = (0..6)
        .flat_map(|m| multisine(6 * seed + m).repeat(5))
        .collect();
    let mut response = distorting(&drive, share);
    let noises = Noise::new(7 + seed).take(drive.len());
    for (sample, noise_sample) in response.iter_mut().zip(noises) {
        *sample += noise * noise_sample;
    }
    (drive, response)
}

fn rms_of_even_lines(period: &[f64], band: Band) -> f64 {
    let mut plan = piezotact_fourier::ComplexPlanner::new();
    let mut bins: Vec<Complex<f64>> = period.iter().map(|x| Complex::from(*x)).collect();
    plan.plan_fft_forward(PERIOD).process(&mut bins);
    let lines = (1..PERIOD / 2)
        .filter(|k| k.is_multiple_of(2) && band.contains(*k as f64 * RATE_HZ / PERIOD as f64));
    let powers: Vec<f64> = lines
        .map(|k| bins[k].norm_sqr() * 2.0 / (PERIOD * PERIOD) as f64)
        .collect();
    (powers.iter().sum::<f64>() / powers.len() as f64).sqrt()
}

/// A known quadratic distortion and a known noise, told apart within 1 dB in every third octave with 15 lines and more.
#[test]
#[ignore = "many repetitions: ./x soak runs it"]
fn soak_multisines_tell_noise_from_distortion() {
    // Noise above the distortion and below it.
    for (share, noise) in [(0.05, 0.02), (0.05, 0.3), (0.2, 0.02)] {
        let (drive, response) = multisines(share, noise);
        let found = best_linear(
            &series::<Drive>(drive),
            &series::<Acceleration>(response),
            BLOCKS,
            1_000,
            Known::default(),
        )
        .unwrap();
        // White noise of this rms has its power spread evenly over half as many lines as samples.
        let true_noise = noise * (2.0 / PERIOD as f64).sqrt();
        let mut judged = 0;
        for level in &found.distortion.levels {
            // The distortion alone, without noise and without the linear answer, in the mean of the realisations.
            let true_power: f64 = (0..6)
                .map(|m| {
                    let x = multisine(m);
                    let squared: Vec<f64> = x.repeat(2).iter().map(|x| share * x * x).collect();
                    rms_of_even_lines(&filtered(&PLANT, &squared)[PERIOD..], level.band_hz).powi(2)
                        / 6.0
                })
                .sum();
            let lines = (level.band_hz.high().0 - level.band_hz.low().0) / 2.5;
            if lines < 15.0 {
                continue;
            }
            judged += 1;
            let db = |found: f64, truth: f64| 20.0 * (found / truth).log10();
            let (noise_db, even_db) = (
                db(level.noise, true_noise),
                db(level.even.unwrap(), true_power.sqrt()),
            );
            println!(
                "{share} {noise} {}: noise {noise_db:+.2} dB, even {even_db:+.2} dB",
                level.band_hz
            );
            assert!(
                noise_db.abs() < 1.0 && even_db.abs() < 1.0,
                "{noise_db} {even_db}"
            );
            // A square makes nothing on odd lines: what is left there is below both.
            let largest = level.even.unwrap().max(level.noise);
            assert!(level.odd.unwrap() < 0.5 * largest, "{level:?}");
        }
        assert!(judged >= 7, "{judged}");
    }
}

/// The square does not touch the odd lines: the best linear approximation is the plant's response. Over 12 measurements, each with
/// its own phases and noise, the limits that are called 95 % hold it on 93–97 % of the lines.
#[test]
fn the_best_linear_approximation_of_multisines_lies_within_its_limits() {
    let (mut held, mut lines) = (0u32, 0u32);
    for seed in 0..12 {
        let (mut drive, mut response) = multisines_of(0.2, 0.1, 100 + seed);
        // The onset may be found some samples late: the recording goes on a little.
        for signal in [&mut drive, &mut response] {
            signal.extend([0.0; 50]);
        }
        let mut found = best_linear(
            &series::<Drive>(drive),
            &series::<Acceleration>(response),
            BLOCKS,
            1_000,
            Known::default(),
        )
        .unwrap();
        found.function.known_input = true;
        let confidence = found.function.confidence().unwrap();
        assert_eq!(confidence.of, Limits::BestLinear);
        for (line, hz) in found
            .function
            .lines_in(Band::new(Hertz(20.0), Hertz(980.0)).unwrap())
        {
            let error_db =
                20.0 * (found.function.response()[line].norm() / truth(hz).norm()).log10();
            assert!(error_db.abs() < 0.4, "{error_db} dB at {hz}");
            lines += 1;
            held += u32::from(
                (confidence.low[line]..=confidence.high[line]).contains(&truth(hz).norm()),
            );
        }
        let (level_db, band) = found.distortion.worst().unwrap();
        assert!(level_db > -25.0, "{level_db} at {band}");
    }
    let share = 100.0 * f64::from(held) / f64::from(lines);
    println!("{share:.1} % of {lines} limits of multisines hold the plant");
    assert!((93.0..=97.0).contains(&share), "{share}");
}

fn sweeps(seed: u64) -> TransferFunction<Drive, Acceleration> {
    let (length, sweeps) = (20_000, 3);
    let drive: Vec<f64> = (0..sweeps)
        .flat_map(|_| {
            (0..length).map(|i| {
                let (t, duration) = (i as f64 / RATE_HZ, 3.6);
                let growth = (1_000.0f64 / 5.0).ln() / duration;
                let edge = (t / 0.02).min((duration - t) / 0.02).clamp(0.0, 1.0);
                edge * (TAU * 5.0 / growth * ((growth * t).exp() - 1.0)).sin()
            })
        })
        .collect();
    let mut response = filtered(&PLANT, &drive);
    for (sample, noise) in response.iter_mut().zip(Noise::new(seed).take(drive.len())) {
        *sample += 0.05 * noise;
    }
    let blocks = Blocks {
        lead: 0,
        length,
        in_a_row: sweeps,
        stride: length * sweeps,
        rows: 1,
    };
    // The onset is found some samples into the fade: the recording goes on a little.
    let padded = |mut x: Vec<f64>| {
        x.extend([0.0; 50]);
        x
    };
    estimate_sweeps(
        &series(padded(drive)),
        &series(padded(response)),
        blocks,
        2_048,
        Estimator::H1,
        Known::default(),
    )
    .unwrap()
}

#[test]
fn sweeps_give_the_plant() {
    let function = sweeps(4);
    for (line, hz) in function.lines_in(Band::new(Hertz(15.0), Hertz(900.0)).unwrap()) {
        let error_db = 20.0 * (function.response()[line].norm() / truth(hz).norm()).log10();
        assert!(
            error_db.abs() < 0.3 && function.coherence()[line] > 0.98,
            "{error_db} dB at {hz}: {}",
            function.coherence()[line]
        );
    }
}

/// The limits of sweeps that are called 95 % hold the plant on 93–97 % of the lines of 15 measurements.
#[test]
fn the_limits_of_sweeps_hold_the_plant() {
    let (mut held, mut lines) = (0u32, 0u32);
    for seed in 0..15 {
        let mut function = sweeps(50 + seed);
        function.known_input = true;
        let confidence = function.confidence().unwrap();
        for (line, hz) in function.lines_in(Band::new(Hertz(15.0), Hertz(900.0)).unwrap()) {
            lines += 1;
            held += u32::from(
                (confidence.low[line]..=confidence.high[line]).contains(&truth(hz).norm()),
            );
        }
    }
    let share = 100.0 * f64::from(held) / f64::from(lines);
    println!("{share:.1} % of {lines} limits of sweeps hold the plant");
    assert!((93.0..=97.0).contains(&share), "{share}");
}
