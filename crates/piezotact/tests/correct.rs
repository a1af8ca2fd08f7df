//! The experiment of the table that closed loops are measured against: a plant with two resonances, a deep notch, a
//! high-pass, a delay, a weak distortion, a clip at full scale and noise; five seeds, three levels.
#![allow(
    clippy::print_stdout,
    clippy::unwrap_used,
    reason = "a test stops where something is missing, and prints what it measured"
)]

use std::f64::consts::TAU;

use num_complex::Complex;
use piezotact::correct::{CorrectConfig, Correction};
use piezotact::lineage::Mode;
use piezotact::quantity::{Acceleration, Band, Drive, Hertz, SampleRate};
use piezotact::render::{Inverse, RenderConfig, render};
use piezotact::series::Series;
use piezotact::spectrum::{WelchConfig, WelchPlan};
use piezotact::statistics::{peak, rms};
use piezotact::transfer::{Estimator, TransferFunction, estimate};
use piezotact_fourier::ComplexPlanner;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

const RATE_HZ: f64 = 5_000.0;

fn rate() -> SampleRate {
    SampleRate::new(RATE_HZ).unwrap()
}

fn band() -> Band {
    Band::new(Hertz(20.0), Hertz(1_000.0)).unwrap()
}

struct Noise(ChaCha8Rng);

impl Noise {
    fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    fn uniform(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 * 2f64.powi(-53)
    }

    fn next(&mut self) -> f64 {
        let radius = (-2.0 * (1.0 - self.uniform()).ln()).sqrt();
        radius * (TAU * self.uniform()).cos()
    }
}

/// `x` with every line multiplied by `by` of its frequency; circular.
fn shaped(x: &[f64], by: &dyn Fn(f64) -> Complex<f64>) -> Vec<f64> {
    let n = x.len();
    let mut plan = ComplexPlanner::new();
    let mut bins: Vec<Complex<f64>> = x.iter().map(|x| Complex::from(*x)).collect();
    plan.plan_fft_forward(n).process(&mut bins);
    for (k, bin) in bins.iter_mut().enumerate() {
        let signed = if 2 * k <= n {
            k as f64
        } else {
            k as f64 - n as f64
        };
        let hz = signed * RATE_HZ / n as f64;
        let h = by(hz.abs());
        *bin *= if hz < 0.0 { h.conj() } else { h };
    }
    plan.plan_fft_inverse(n).process(&mut bins);
    bins.iter().map(|b| b.re / n as f64).collect()
}

/// Resonances at 180 and 620 Hz, a notch of −35 dB at 420 Hz, a high-pass at 30 Hz, 0.6 ms of delay. The description leaves
/// open how wide they are, how loud the noise is and what the texture looks like; all that was fitted to the rows of the
/// table that correct nothing (no compensation, plain division, two constant regularisations).
fn plant(hz: f64) -> Complex<f64> {
    let s = Complex::new(0.0, TAU * hz);
    let second = |f: f64, zeta: f64| {
        let w = TAU * f;
        Complex::from(w * w) / (s * s + s * (2.0 * zeta * w) + w * w)
    };
    let notch = {
        let (w, zeta) = (TAU * 420.0, 0.069);
        (s * s + s * (2.0 * zeta * 0.0178 * w) + w * w) / (s * s + s * (2.0 * zeta * w) + w * w)
    };
    let high = {
        let w = TAU * 30.0;
        s * s / (s * s + s * (2f64.sqrt() * w) + w * w)
    };
    0.36 * (0.3 + second(180.0, 0.02) + 1.2 * second(620.0, 0.02))
        * notch
        * high
        * Complex::from_polar(1.0, -TAU * hz * 0.6e-3)
}

/// What the plant answers: clip, weak square and cube, the linear part, noise.
fn answer(drive: &[f64], noise: &mut Noise) -> Vec<f64> {
    let bent: Vec<f64> = drive
        .iter()
        .map(|u| u.clamp(-1.0, 1.0))
        .map(|u| u + 0.085 * u * u - 0.15 * u * u * u)
        .collect();
    shaped(&bent, &plant)
        .iter()
        .map(|y| y + 3.7e-3 * noise.next())
        .collect()
}

/// Eight seconds of random drive.
fn characterised(seed: u64) -> TransferFunction<Drive, Acceleration> {
    let mut noise = Noise::new(seed);
    let white: Vec<f64> = (0..40_000).map(|_| noise.next()).collect();
    let drive = shaped(&white, &|hz| {
        Complex::from(if (2.0..1_200.0).contains(&hz) {
            1.0
        } else {
            0.0
        })
    });
    let scale = 0.5 / peak(&drive);
    let drive: Vec<f64> = drive.iter().map(|x| x * scale).collect();
    let response = answer(&drive, &mut noise);
    estimate(
        &Series::<Drive>::new(drive, rate()).unwrap(),
        &Series::<Acceleration>::new(response, rate()).unwrap(),
        &WelchConfig::hann(1_024),
        Estimator::H1,
    )
    .unwrap()
}

/// Ten seconds of a broad texture with a rms of `level`.
fn texture(level: f64, seed: u64) -> Series<Acceleration> {
    let mut noise = Noise::new(1_000 + seed);
    let white: Vec<f64> = (0..50_000).map(|_| noise.next()).collect();
    let shape = |hz: f64| {
        let (low, high) = ((hz / 6.0).powi(2), (hz / 480.0).powi(4));
        Complex::from(if band().contains(hz) {
            (low / (1.0 + low) / (1.0 + high)).sqrt()
        } else {
            0.0
        })
    };
    let x = shaped(&white, &shape);
    let scale = level / rms(&x);
    Series::new(x.iter().map(|x| x * scale).collect(), rate()).unwrap()
}

/// How far a measurement is from its target.
#[derive(Clone, Copy, Default)]
struct Missed {
    /// The error of the PSD within the band on Hann segments of 1024, dB: rms and largest.
    rms_db: f64,
    max_db: f64,
    /// The power of the difference of the waveforms over that of the target, dB.
    nmse_db: f64,
}

impl Missed {
    fn of(target: &[f64], measured: &[f64]) -> Self {
        let mut plan = WelchPlan::new(&WelchConfig::hann(1_024), rate()).unwrap();
        let wanted = plan.estimate::<Acceleration>(&[target]).unwrap();
        let got = plan.estimate::<Acceleration>(&[measured]).unwrap();
        let errors: Vec<f64> = wanted
            .frequencies_hz()
            .iter()
            .zip(wanted.values.iter().zip(&got.values))
            .filter(|(hz, _)| band().contains(**hz))
            .map(|(_, (t, m))| 10.0 * (m / t).log10())
            .collect();
        let difference: Vec<f64> = target.iter().zip(measured).map(|(t, m)| m - t).collect();
        Self {
            rms_db: rms(&errors),
            max_db: errors.iter().fold(0.0, |most: f64, e| most.max(e.abs())),
            nmse_db: 20.0 * (rms(&difference) / rms(target)).log10(),
        }
    }

    fn mean(all: &[Self]) -> Self {
        let of = |value: fn(&Self) -> f64| all.iter().map(value).sum::<f64>() / all.len() as f64;
        Self {
            rms_db: of(|m| m.rms_db),
            max_db: of(|m| m.max_db),
            nmse_db: of(|m| m.nmse_db),
        }
    }
}

impl std::fmt::Display for Missed {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "{:.2}/{:.1} dB, NMSE {:.1} dB",
            self.rms_db, self.max_db, self.nmse_db
        )
    }
}

fn played(drive: &Series<Drive>, lead: usize, length: usize, noise: &mut Noise) -> Vec<f64> {
    let response = answer(drive.samples(), noise);
    response[lead..lead + length].to_vec()
}

/// What the drive of plain division leaves, and how much of full scale it asks for.
fn divided(level: f64, seed: u64) -> (Missed, f64) {
    let (function, target) = (characterised(seed), texture(level, seed));
    let mut config = RenderConfig::over(band(), rate());
    config.inverse.inverse = Inverse::Plain;
    config.clipping = piezotact::render::Overload::Allow;
    let rendered = render(&target, &function, &config).unwrap();
    let measured = played(
        &rendered.drive,
        rate().samples_in(config.modelling_delay),
        target.samples().len(),
        &mut Noise::new(seed),
    );
    let missed = Missed::of(target.samples(), &measured);
    (missed, rendered.headroom.peak)
}

/// Ten steps of a loop. The best drive by a second measurement of each, and what a third says of that one.
fn looped(mode: Mode, level: f64, seed: u64) -> Missed {
    let function = characterised(seed);
    let target = texture(level, seed);
    let mut config = RenderConfig::over(band(), rate());
    config.inverse.inverse = Inverse::Plain;
    let mut correction =
        Correction::new(&target, &function, &config, &CorrectConfig::usual(mode)).unwrap();
    let mut noise = Noise::new(7_000 + seed);
    let silence = answer(&vec![0.0; 50_000], &mut noise);
    let quiet = WelchPlan::new(correction.welch(), rate())
        .unwrap()
        .estimate::<Acceleration>(&[&silence])
        .unwrap();
    let lead = rate().samples_in(config.modelling_delay);
    let length = target.samples().len();
    let mut best: Option<(f64, Series<Drive>)> = None;
    for _ in 0..=10 {
        let drive = correction.drive().unwrap();
        assert!(peak(drive.samples()) <= 1.0);
        // As the loop does: two measurements teach, the second of which judged.
        let [first, second] = [0, 1].map(|_| {
            Series::<Acceleration>::new(answer(drive.samples(), &mut noise), rate()).unwrap()
        });
        let judged = &second.samples()[lead..lead + length];
        let missed = Missed::of(correction.target().samples(), judged);
        let found = match mode {
            Mode::Replicate => missed.nmse_db,
            Mode::Texture => missed.rms_db,
        };
        if best.as_ref().is_none_or(|(least, _)| found < *least) {
            best = Some((found, drive.clone()));
        }
        correction.learn(&[&first, &second], &quiet).unwrap();
    }
    let (_, drive) = best.unwrap();
    let again = played(&drive, lead, length, &mut noise);
    Missed::of(correction.target().samples(), &again)
}

/// dB rms, and the largest line.
type Errors = (f64, f64);

/// The table's own figures at 0.25, 0.10 and 0.05, dB rms and largest: plain division, and the best closed loop.
const TABLE: [(f64, Errors, Errors); 3] = [
    (0.25, (5.6, 17.3), (3.1, 17.7)),
    (0.10, (2.7, 7.9), (1.4, 8.6)),
    (0.05, (1.0, 3.9), (0.21, 1.3)),
];

#[test]
fn closed_loops_beat_the_table_on_its_own_plant() {
    closed_loops_beat_the_table_on_its_own_plant_in(1..=1);
}

#[test]
#[ignore = "many repetitions: ./x soak runs it"]
fn soak_closed_loops_beat_the_table_on_its_own_plant() {
    closed_loops_beat_the_table_on_its_own_plant_in(1..=5);
}

fn closed_loops_beat_the_table_on_its_own_plant_in(seeds: std::ops::RangeInclusive<u64>) {
    for (level, table_plain, table) in TABLE {
        let all = |of: &(dyn Fn(u64) -> Missed + Sync)| {
            std::thread::scope(|scope| {
                let seeds: Vec<_> = seeds
                    .clone()
                    .map(|seed| scope.spawn(move || of(seed)))
                    .collect();
                let each: Vec<Missed> = seeds.into_iter().map(|s| s.join().unwrap()).collect();
                Missed::mean(&each)
            })
        };
        let plain = all(&|seed| divided(level, seed).0);
        let asked = divided(level, 1).1;
        let replicate = all(&|seed| looped(Mode::Replicate, level, seed));
        let texture = all(&|seed| looped(Mode::Texture, level, seed));
        println!(
            "{level}: plain division {plain}, asks for {asked:.1} of full scale; replicate {replicate}; texture {texture}; table: plain {}/{}, best {}/{}",
            table_plain.0, table_plain.1, table.0, table.1
        );
        // The plant is as hard as the table's: what corrects nothing does no better on it by more than a tenth.
        assert!(plain.rms_db > 0.9 * table_plain.0 && plain.max_db > 0.9 * table_plain.1);
        assert!(texture.rms_db < table.0 && texture.max_db < table.1);
        // The other aim is the waveform.
        assert!(replicate.nmse_db < plain.nmse_db - 3.0, "{replicate}");
    }
}
