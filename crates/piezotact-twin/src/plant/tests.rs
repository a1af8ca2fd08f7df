use std::f64::consts::TAU;

use num_complex::Complex;
use piezotact::Series;
use piezotact::device::DeviceDescription;
use piezotact::quantity::{Acceleration, Degrees, Hertz, Newtons};
use piezotact::resample::Resampler;
use piezotact::spectrum::{WelchConfig, welch};
use piezotact::statistics::{mean, standard_deviation};
use piezotact_bench::halves::SimulatedBench;
use piezotact_bench::{Placement as Placed, Until};

use super::*;
use crate::{RATE_HZ, TwinBench};

fn hz(rate_hz: f64) -> SampleRate {
    SampleRate::new(rate_hz).unwrap()
}

fn set() -> DeviceAtGain {
    DeviceDescription::drv2667().at_usual_gain()
}

fn run(load_n: f64, angle_deg: f64) -> RunPlan {
    RunPlan {
        label: "plant".into(),
        load: Some(Newtons(load_n)),
        angle: Degrees(angle_deg),
        placement: Placed::New,
        until: Until::Stopped,
    }
}

/// The built-in parameters without noise, and with a force that is held exactly.
fn quiet() -> TwinParameters {
    let mut parameters = TwinParameters::built_in();
    parameters.accelerometer.white_m_s2 = 0.0;
    parameters.accelerometer.flicker_m_s2 = 0.0;
    parameters.force_cell.noise_n = 0.0;
    parameters.output.noise_db = -400.0;
    parameters.hand.force_spread_n = 0.0;
    parameters
}

fn played(plant: &mut TwinPlant, drive: &[f64]) -> [Vec<f64>; 2] {
    let mut channels = [Vec::new(), Vec::new()];
    plant.process(drive, &mut channels);
    channels
}

/// The largest departure from the response of the bench at 200 frequencies from 20 Hz to 1 kHz.
struct Departure {
    magnitude_db: f64,
    phase_deg: f64,
    /// From 100 Hz on.
    phase_above_deg: f64,
}

fn departure(number: u64, rate_hz: f64, delay_s: f64, run: &RunPlan) -> Departure {
    let mut parameters = quiet();
    parameters.output.quadratic = 0.0;
    parameters.accelerometer.sensitivity_spread = 0.0;
    let person = Participant::of(number, 7, &parameters);
    let mut plant = TwinPlant::delayed(
        &parameters,
        &person,
        &set(),
        run,
        hz(rate_hz),
        Seconds(delay_s),
    )
    .unwrap();
    // An impulse that neither clips nor is too steep.
    let size = 1e-3;
    let mut drive = vec![0.0; (1.5 * rate_hz) as usize];
    drive[0] = size;
    let [answer, _] = played(&mut plant, &drive);
    let stage = OutputStage::new(&parameters.output, &set());
    let gain = stage.setup().gain.voltage_ratio() * stage.setup().volts_per_full_scale;
    let placement = Placement::of(&parameters, number, 7, "plant");
    let mut most = Departure {
        magnitude_db: 0.0,
        phase_deg: 0.0,
        phase_above_deg: 0.0,
    };
    for i in 0..200 {
        let frequency_hz = 20.0 * 50f64.powf(f64::from(i) / 199.0);
        let turn = Complex::from_polar(1.0, -TAU * frequency_hz / rate_hz);
        let found = answer
            .iter()
            .rev()
            .fold(Complex::ZERO, |sum, y| sum * turn + y)
            / size;
        let bench = gain
            * stage.high_pass(frequency_hz)
            * person
                .finger
                .response(frequency_hz, run.load.unwrap().0, run.angle.0, &placement)
            * Complex::from_polar(1.0, -TAU * frequency_hz * plant.delay_s());
        let ratio = found / bench;
        most.magnitude_db = most.magnitude_db.max((20.0 * ratio.norm().log10()).abs());
        let phase_deg = ratio.arg().to_degrees().abs();
        most.phase_deg = most.phase_deg.max(phase_deg);
        if frequency_hz >= 100.0 {
            most.phase_above_deg = most.phase_above_deg.max(phase_deg);
        }
    }
    most
}

/// Ten people at their own loads and angles: the magnitude is that of the bench at every delay, and the phase comes closer to it the
/// longer the delay is. Without delay products of two ripples come before the drive and are cut off: 0.2 dB.
#[test]
fn the_transfer_function_is_that_of_the_bench() {
    it_is_that_of_the_bench_of([0, 4, 9]);
}

#[test]
#[ignore = "many repetitions: ./x soak runs it"]
fn soak_the_transfer_function_is_that_of_the_bench() {
    it_is_that_of_the_bench_of(0..10);
}

fn it_is_that_of_the_bench_of(people: impl IntoIterator<Item = u64> + Clone) {
    // Delay, s; the largest departure in magnitude, dB, and in phase from 20 Hz and from 100 Hz on, degrees.
    for (delay_s, most_db, from_20_deg, from_100_deg) in [
        (0.0, 0.2, 12.0, 12.0),
        (0.02, 0.06, 6.0, 1.0),
        (0.05, 0.06, 2.0, 0.4),
    ] {
        for number in people.clone() {
            let run = run(0.1 + 0.05 * number as f64, 20.0 + 2.0 * number as f64);
            let found = departure(number, 48_000.0, delay_s, &run);
            let Departure {
                magnitude_db,
                phase_deg,
                phase_above_deg,
            } = found;
            assert!(
                magnitude_db < most_db && phase_deg < from_20_deg && phase_above_deg < from_100_deg,
                "P{number}, {delay_s} s: {magnitude_db:.3} dB, {phase_deg:.2}°, {phase_above_deg:.2}° from 100 Hz on"
            );
        }
    }
}

/// At the rates of sound devices and at the ends of what is possible.
#[test]
#[ignore = "many repetitions: ./x soak runs it"]
fn soak_every_rate_has_it() {
    for rate_hz in [8_000.0, 44_100.0, 96_000.0, 192_000.0, 200_000.0] {
        let found = departure(3, rate_hz, 0.02, &run(0.2, 20.0));
        assert!(
            found.magnitude_db < 0.06 && found.phase_deg < 6.0,
            "{rate_hz} Hz: {:.3} dB, {:.2}°",
            found.magnitude_db,
            found.phase_deg
        );
    }
}

/// Noise of 0.1 of full scale, limited to 1 kHz, at 48 kHz.
fn excitation(seconds: usize) -> Vec<f64> {
    let mut random = Random::stream(5, 0, "excitation");
    let to_output = Resampler::new(hz(4_000.0), hz(48_000.0), Hertz(1_500.0)).unwrap();
    let slow: Vec<f64> = (0..4_000 * seconds)
        .map(|_| 0.1 * random.normal())
        .collect();
    to_output.process(&slow)
}

/// What the bench acquires of `drive`, from the start of the playback on, at 5 kHz.
fn on_bench(
    parameters: &TwinParameters,
    person: &Participant,
    drive: &[f64],
    run: &RunPlan,
) -> [Vec<f64>; 2] {
    let bench = TwinBench::new(parameters, person.clone(), &set());
    let lead = (bench.lead_s() * RATE_HZ) as usize;
    let mut under_way = bench.begin(drive, run).unwrap();
    let mut all = [Vec::new(), Vec::new()];
    while let Some(mut channels) = under_way.next_channels() {
        let force = channels.remove(2);
        all[0].extend(channels.remove(1));
        all[1].extend(force);
    }
    let until = lead + (drive.len() as f64 * RATE_HZ / 48_000.0) as usize;
    all.map(|channel| channel[lead..until].to_vec())
}

fn to_acquisition(samples: &[f64]) -> Vec<f64> {
    let plan = Resampler::new(hz(48_000.0), hz(RATE_HZ), Hertz(2_200.0)).unwrap();
    plan.process(samples)
}

/// The parabola through three loads, of which the outer two are three standard deviations of the held force off, at the loads between
/// them. At 0.1 N it reaches from the least force that a hand holds to 0.19 N.
#[test]
fn the_response_follows_the_load() {
    let parameters = TwinParameters::built_in();
    // A soft touch changes most with the load; half of the 0.1 dB that the plant may depart from the bench.
    for (number, middle_n, most_db) in [(2, 0.1, 0.05), (3, 0.2, 0.03), (4, 0.6, 0.03)] {
        let person = Participant::of(number, 7, &parameters);
        let run = run(middle_n, 20.0);
        let plant = TwinPlant::new(&parameters, &person, &set(), &run, hz(8_000.0)).unwrap();
        let load_n = |u: f64| (plant.middle + u * plant.span).exp();
        let (low_n, high_n) = ((middle_n - 0.09).max(0.05), middle_n + 0.09);
        assert!((load_n(-1.0) - low_n).abs() < 1e-12 && (load_n(1.0) - high_n).abs() < 1e-12);
        for frequency_hz in [20.0, 60.0, 150.0, 400.0, 1000.0] {
            let at = |load_n: f64| {
                let finger = &person.finger;
                finger.response(frequency_hz, load_n, 20.0, &Placement::exact())
            };
            let [low, middle, high] = [-1.0, 0.0, 1.0].map(|u| at(load_n(u)));
            for u in [-0.8, -0.5, -0.2, 0.3, 0.7] {
                let found = weights(u);
                let found = low * found[0] + middle * found[1] + high * found[2];
                let ratio = found / at(load_n(u));
                let error_db = (20.0 * ratio.norm().log10()).abs();
                assert!(
                    error_db < most_db,
                    "{middle_n} N, {u}, {frequency_hz} Hz: {error_db:.4} dB"
                );
            }
        }
    }
}

/// The two as they are, with noise and a force that wanders: one drive, and the transfer function from the acceleration of the bench
/// to that of the plant, by segments.
#[test]
fn bench_and_plant_answer_alike() {
    let parameters = TwinParameters::built_in();
    let person = Participant::of(2, 7, &parameters);
    let run = run(0.3, 30.0);
    let drive = excitation(40);
    let [bench, _] = on_bench(&parameters, &person, &drive, &run);
    let mut plant = TwinPlant::new(&parameters, &person, &set(), &run, hz(48_000.0)).unwrap();
    let [answer, _] = played(&mut plant, &drive);
    // The plant's delay besides the actuator's, which is the bench's too: 960 samples.
    let answer = to_acquisition(&answer[960..]);
    let length = 2_500;
    for frequency_hz in [30.0, 60.0, 120.0, 250.0, 500.0, 900.0] {
        let line = |x: &[f64]| -> Complex<f64> {
            let hann = |i: usize| 0.5 - 0.5 * (TAU * i as f64 / length as f64).cos();
            let turned = |(i, v): (usize, &f64)| {
                Complex::from_polar(v * hann(i), -TAU * frequency_hz * i as f64 / RATE_HZ)
            };
            x.iter().enumerate().map(turned).sum()
        };
        let (mut cross, mut power) = (Complex::ZERO, 0.0);
        for start in (0..190_000 - length).step_by(length / 2) {
            let (a, b) = (
                line(&bench[start..start + length]),
                line(&answer[start..start + length]),
            );
            cross += a.conj() * b;
            power += a.norm_sqr();
        }
        let ratio = cross / power;
        let (level_db, phase_deg) = (20.0 * ratio.norm().log10(), ratio.arg().to_degrees());
        // 150 segments in which the held force differs by some mN, and the phase at 30 Hz by what 20 ms cannot hold.
        let most_deg = if frequency_hz < 100.0 { 5.0 } else { 1.0 };
        assert!(
            level_db.abs() < 0.1 && phase_deg.abs() < most_deg,
            "{frequency_hz} Hz: {level_db:.3} dB, {phase_deg:.2}°"
        );
    }
}

/// One sample at a time, odd numbers, and all at once.
#[test]
fn blocks_do_not_change_a_sample() {
    let parameters = TwinParameters::built_in();
    let person = Participant::of(1, 7, &parameters);
    let drive = &excitation(1)[..20_000];
    let make = || TwinPlant::new(&parameters, &person, &set(), &run(0.2, 20.0), hz(44_100.0));
    let whole = played(&mut make().unwrap(), drive);
    for block in [1, 7, 64, 333, 4_096] {
        let mut plant = make().unwrap();
        let mut channels = [Vec::new(), Vec::new()];
        for part in drive.chunks(block) {
            plant.process(part, &mut channels);
        }
        assert!(channels == whole, "blocks of {block}");
    }
}

/// The density of the noise at rest, about 200 Hz and about 1 kHz, is that of the bench.
#[test]
#[ignore = "many repetitions: ./x soak runs it"]
fn soak_noise_has_the_density_of_the_bench() {
    let parameters = TwinParameters::built_in();
    let person = Participant::of(4, 7, &parameters);
    let (run, silence) = (run(0.2, 20.0), vec![0.0; 48_000 * 40]);
    let [bench, bench_n] = on_bench(&parameters, &person, &silence, &run);
    let density = |x: &[f64], rate_hz: f64, low_hz: f64, high_hz: f64| -> f64 {
        let series = Series::<Acceleration>::new(x.to_vec(), hz(rate_hz)).unwrap();
        let spectrum = welch(&series, &WelchConfig::hann((rate_hz / 5.0) as usize)).unwrap();
        let near = spectrum.frequencies_hz().into_iter().zip(spectrum.values);
        let near = near.filter(|(f, _)| (low_hz..high_hz).contains(f));
        mean(&near.map(|(_, value)| value).collect::<Vec<f64>>())
    };
    for rate_hz in [48_000.0, 96_000.0] {
        let mut plant = TwinPlant::new(&parameters, &person, &set(), &run, hz(rate_hz)).unwrap();
        let [answer, force_n] = played(&mut plant, &vec![0.0; 40 * rate_hz as usize]);
        for (low_hz, high_hz) in [(150.0, 250.0), (800.0, 1200.0)] {
            // 20 bins or more of 399 half-overlapping segments each: four standard errors of a ratio are 8 %.
            for (found, expected) in [(&answer, &bench), (&force_n, &bench_n)] {
                let ratio = density(found, rate_hz, low_hz, high_hz)
                    / density(expected, RATE_HZ, low_hz, high_hz);
                assert!(
                    (ratio - 1.0).abs() < 0.08,
                    "{rate_hz} Hz, {low_hz} Hz: {ratio}"
                );
            }
        }
    }
}

/// The amplitude of the harmonic at `frequency_hz` in the second half of `x`.
fn harmonic(x: &[f64], rate_hz: f64, frequency_hz: f64) -> f64 {
    let x = &x[x.len() / 2..];
    let turned =
        |(i, v): (usize, &f64)| Complex::from_polar(*v, -TAU * frequency_hz * i as f64 / rate_hz);
    2.0 * x
        .iter()
        .enumerate()
        .map(turned)
        .sum::<Complex<f64>>()
        .norm()
        / x.len() as f64
}

/// A tone that clips has the harmonics that it has on the bench, and twice the drive makes it no louder.
#[test]
fn a_loud_tone_clips_as_on_the_bench() {
    let parameters = quiet();
    let person = Participant::of(0, 7, &parameters);
    let run = run(0.2, 20.0);
    let tone = |amplitude: f64| -> Vec<f64> {
        (0..96_000)
            .map(|i| amplitude * (TAU * 100.0 * f64::from(i) / 48_000.0).sin())
            .collect()
    };
    let answer = |drive: &[f64]| {
        let mut plant = TwinPlant::new(&parameters, &person, &set(), &run, hz(48_000.0)).unwrap();
        let [answer, _] = played(&mut plant, drive);
        answer
    };
    let [bench, _] = on_bench(&parameters, &person, &tone(1.0), &run);
    let plant = answer(&tone(1.0));
    for times in [1.0, 2.0, 3.0, 5.0, 7.0] {
        let found = harmonic(&plant, 48_000.0, 100.0 * times);
        let expected = harmonic(&bench, RATE_HZ, 100.0 * times);
        let level_db = 20.0 * (found / expected).log10();
        // The responses agree within 0.1 dB; a second is half of what is left of the start of the tone.
        assert!(level_db.abs() < 0.1, "harmonic {times}: {level_db:.3} dB");
    }
    // Sound outputs end at full scale.
    assert!(answer(&tone(2.5)).iter().all(|a| a.is_finite()));
    let (full, more) = (
        harmonic(&plant, 48_000.0, 100.0),
        harmonic(&answer(&tone(2.0)), 48_000.0, 100.0),
    );
    assert!(more / full < 1.25, "{}", more / full);
}

/// A minute of a hand that means 0.3 N: 30 mN that forget over 0.3 s leave 4 mN of the mean, of which four are allowed.
#[test]
fn the_hand_holds_its_force() {
    let parameters = TwinParameters::built_in();
    let person = Participant::of(5, 7, &parameters);
    let mut plant =
        TwinPlant::new(&parameters, &person, &set(), &run(0.3, 20.0), hz(8_000.0)).unwrap();
    let [_, force_n] = played(&mut plant, &vec![0.0; 8_000 * 60]);
    assert!((mean(&force_n) - 0.3).abs() < 0.016, "{}", mean(&force_n));
    // The wandering of 30 mN and the cell's 3 mN · √(8/5): the estimate of it has 100 independent values.
    let spread_n = standard_deviation(&force_n);
    assert!((spread_n - 0.0302).abs() < 0.009, "{spread_n}");
}

/// A drive that is no number is played as silence, and does not stay in the filters.
#[test]
fn what_is_no_number_is_silence() {
    let parameters = TwinParameters::built_in();
    let person = Participant::of(5, 7, &parameters);
    let make = || TwinPlant::new(&parameters, &person, &set(), &run(0.3, 20.0), hz(8_000.0));
    let [broken, _] = played(&mut make().unwrap(), &[f64::NAN; 100]);
    let [silent, _] = played(&mut make().unwrap(), &[0.0; 100]);
    assert!(broken == silent);
    let loud = [f64::INFINITY, f64::NEG_INFINITY, 1e300];
    let [loud, _] = played(&mut make().unwrap(), &loud);
    assert!(loud.iter().all(|a| a.is_finite()));
}

#[test]
fn what_cannot_be_is_refused() {
    let parameters = TwinParameters::built_in();
    let person = Participant::of(1, 7, &parameters);
    let refused = |run: &RunPlan, rate_hz: f64| {
        let refused = TwinPlant::new(&parameters, &person, &set(), run, hz(rate_hz));
        assert!(matches!(refused, Err(DeviceError::Impossible { .. })));
    };
    refused(&run(0.2, 20.0), 7_999.0);
    refused(&run(0.2, 20.0), 200_001.0);
    refused(&run(5.0, 20.0), 48_000.0);
    refused(&run(0.2, 80.0), 48_000.0);
    refused(
        &RunPlan {
            load: None,
            ..run(0.2, 20.0)
        },
        48_000.0,
    );
}
