//! The vibrations of `expected.txt`, acceleration in m/s² at 8 kHz; those of `golden/perception.py`.

use std::f64::consts::{FRAC_PI_2, PI, SQRT_2, TAU};

use piezotact::feature::Weighting;
use piezotact::fourier::{Complex, RealTransform};
use piezotact::quantity::{Acceleration, Hertz, SampleRate};
use piezotact::series::Series;

pub(crate) const FS: f64 = 8000.0;
pub(crate) type Signal = Vec<f64>;

fn samples(seconds: f64) -> usize {
    (seconds * FS).round() as usize
}

fn made(seconds: f64, of: impl Fn(f64) -> f64) -> Signal {
    (0..samples(seconds)).map(|i| of(i as f64 / FS)).collect()
}

pub(crate) fn series(x: &[f64]) -> Series<Acceleration> {
    Series::new(x.to_vec(), SampleRate::new(FS).unwrap()).unwrap()
}

/// The detection threshold of a tone of `seconds`, rms m/s²: the more sensitive channel; the Pacinian one integrates with 0.2 s.
pub(crate) fn threshold(hz: f64, seconds: f64) -> f64 {
    let pacinian = Weighting::Pacinian.threshold_m_s2(Hertz(hz));
    let integrated = pacinian / (1.0 - (-seconds / 0.2).exp()).sqrt();
    Weighting::RapidlyAdapting
        .threshold_m_s2(Hertz(hz))
        .min(integrated)
}

pub(crate) fn ramp(mut x: Signal, seconds: f64) -> Signal {
    let n = samples(seconds);
    let last = x.len() - 1;
    for i in 0..n {
        let gain = (FRAC_PI_2 * (i as f64 + 0.5) / n as f64).sin().powi(2);
        x[i] *= gain;
        x[last - i] *= gain;
    }
    x
}

/// A tone without ramps at `sl_db` over the threshold of one of `of_s`.
fn bare(hz: f64, sl_db: f64, seconds: f64, of_s: f64, phase: f64) -> Signal {
    let top = threshold(hz, of_s) * 10f64.powf(sl_db / 20.0) * SQRT_2;
    made(seconds, |t| top * (TAU * hz * t + phase).sin())
}

pub(crate) fn tone(hz: f64, sl_db: f64) -> Signal {
    tone_of(hz, sl_db, 1.0, 1.0)
}

pub(crate) fn tone_of(hz: f64, sl_db: f64, seconds: f64, of_s: f64) -> Signal {
    ramp(bare(hz, sl_db, seconds, of_s, 0.0), 0.010)
}

fn turned(hz: f64, sl_db: f64, phase: f64) -> Signal {
    ramp(bare(hz, sl_db, 1.0, 1.0, phase), 0.010)
}

pub(crate) fn louder(mut x: Signal, db: f64) -> Signal {
    for v in &mut x {
        *v *= 10f64.powf(db / 20.0);
    }
    x
}

pub(crate) fn plus(a: &[f64], b: &[f64]) -> Signal {
    a.iter().zip(b).map(|(a, b)| a + b).collect()
}

pub(crate) fn equal_energy(mut x: Signal, like: &[f64]) -> Signal {
    let energy = |x: &[f64]| x.iter().map(|v| v * v).sum::<f64>();
    let gain = (energy(like) / energy(&x)).sqrt();
    for v in &mut x {
        *v *= gain;
    }
    x
}

pub(crate) fn modulated(x: &[f64], rate_hz: f64, depth: f64) -> Signal {
    let gain = |i: usize| 1.0 + depth * (TAU * rate_hz * i as f64 / FS - FRAC_PI_2).sin();
    x.iter().enumerate().map(|(i, v)| v * gain(i)).collect()
}

pub(crate) fn am(hz: f64, rate_hz: f64, depth: f64) -> Signal {
    let flat = bare(hz, 25.0, 1.0, 1.0, 0.0);
    let x = ramp(modulated(&flat, rate_hz, depth), 0.010);
    equal_energy(x, &ramp(flat, 0.010))
}

fn hashed(i: u64, seed: u64) -> f64 {
    let mut h = (i * 2_654_435_761 + seed * 40_503 + 12_345) & 0xFFFF_FFFF;
    h ^= h >> 16;
    h = (h * 2_246_822_519) & 0xFFFF_FFFF;
    h ^= h >> 13;
    h = (h * 3_266_489_917) & 0xFFFF_FFFF;
    h ^= h >> 16;
    (h as f64 + 0.5) / 4_294_967_296.0
}

/// Gaussian noise whose expected power is `sl_db` over threshold, without ramps.
pub(crate) fn noise(low_hz: f64, high_hz: f64, sl_db: f64, seconds: f64, seed: u64) -> Signal {
    let n = samples(seconds);
    let inside = |k: usize| (low_hz..=high_hz).contains(&(k as f64 * FS / n as f64));
    let lines: Vec<usize> = (1..=n / 2).filter(|k| inside(*k)).collect();
    let weight: f64 = lines
        .iter()
        .map(|k| {
            let hz = Hertz(*k as f64 * FS / n as f64);
            let rapid = Weighting::RapidlyAdapting.threshold_m_s2(hz);
            rapid.min(Weighting::Pacinian.threshold_m_s2(hz)).powi(-2)
        })
        .sum();
    let size = 10f64.powf(sl_db / 20.0) / weight.sqrt() * n as f64 / 2.0;
    let mut bins = vec![Complex::default(); n / 2 + 1];
    for k in lines {
        let (u, v) = (hashed(2 * k as u64, seed), hashed(2 * k as u64 + 1, seed));
        bins[k] = Complex::from_polar(size * (-2.0 * u.ln()).sqrt(), TAU * v);
    }
    RealTransform::new(n).inverse(bins)
}

/// Full modulation whose envelope is held over sixths of a period, passing from one to the next within a cycle.
fn steps(hz: f64, rate_hz: f64) -> Signal {
    let flat = bare(hz, 25.0, 1.0, 1.0, 0.0);
    let part = |i: usize| (i as f64 / FS * rate_hz * 6.0).floor() as usize;
    let envelope = |i: usize| 1.0 + (TAU * rate_hz * i as f64 / FS - FRAC_PI_2).sin();
    let mut sums = vec![(0.0, 0usize); part(flat.len()) + 1];
    for i in 0..flat.len() {
        let (sum, count) = &mut sums[part(i)];
        *sum += envelope(i).powi(2);
        *count += 1;
    }
    let held = |i: isize| {
        let i = i.clamp(0, flat.len() as isize - 1) as usize;
        let (sum, count) = sums[part(i)];
        (sum / count as f64).sqrt()
    };
    let cycle = (FS / hz).round() as isize;
    let mut x = flat.clone();
    for (i, v) in x.iter_mut().enumerate() {
        let last = i as isize + (cycle - 1) / 2;
        *v *= (last - cycle + 1..=last).map(held).sum::<f64>() / cycle as f64;
    }
    equal_energy(ramp(x, 0.010), &ramp(flat, 0.010))
}

pub(crate) fn padded(x: &[f64]) -> Signal {
    place(x.len() as f64 / FS + 0.1, &[(0.05, x)])
}

pub(crate) fn place(seconds: f64, parts: &[(f64, &[f64])]) -> Signal {
    let mut out = vec![0.0; samples(seconds)];
    for (start, x) in parts {
        for (o, v) in out[samples(*start)..].iter_mut().zip(*x) {
            *o += v;
        }
    }
    out
}

fn decay(tau: f64) -> Signal {
    let top = threshold(200.0, 1.0) * 10f64.powf(1.5) * SQRT_2;
    let x = made((6.0 * tau).max(0.1), |t| {
        top * (-t / tau).exp() * (TAU * 200.0 * t).sin()
    });
    padded(&x)
}

pub(crate) fn taps(every: usize) -> Signal {
    let tap = tone_of(250.0, 20.0, 0.05, 1.0);
    let strong = louder(tap.clone(), 4.0);
    let parts: Vec<(f64, &[f64])> = (0..12)
        .map(|i| {
            let tap = if i % every == 0 { &strong } else { &tap };
            (i as f64 * 0.3, tap.as_slice())
        })
        .collect();
    place(3.6, &parts)
}

fn pulses(starts: &[f64]) -> Signal {
    let top = threshold(250.0, 1.0) * 10f64.powf(1.25) * 4.0;
    let pulse = made(0.003, |t| {
        top * (TAU * t / 0.003).sin() * (PI * t / 0.003).sin().powi(2)
    });
    let parts: Vec<(f64, &[f64])> = starts
        .iter()
        .map(|s| (0.01 + s, pulse.as_slice()))
        .collect();
    place(1.05, &parts)
}

fn every(rate_hz: usize) -> Vec<f64> {
    (0..rate_hz).map(|i| i as f64 / rate_hz as f64).collect()
}

fn gapped(gap_s: f64) -> Signal {
    let one = tone_of(250.0, 25.0, 0.1, 0.2);
    place(0.3 + gap_s, &[(0.05, &one), (0.15 + gap_s, &one)])
}

fn after_masker(hz: f64) -> [Signal; 2] {
    let short = |sl, s| ramp(bare(hz, sl, s, s, 0.0), 0.005);
    let (masker, probe) = (short(25.0, 0.03), short(8.0, 0.02));
    [
        place(0.35, &[(0.05, &masker)]),
        place(0.35, &[(0.05, &masker), (0.18, &probe)]),
    ]
}

fn pedestal(start_s: f64) -> [Signal; 2] {
    let x = tone_of(250.0, 20.0, 0.7, 0.7);
    let bump = ramp(vec![10f64.powf(0.15) - 1.0; samples(0.05)], 0.005);
    let mut y = x.clone();
    for (v, more) in y[samples(start_s)..].iter_mut().zip(bump) {
        *v *= 1.0 + more;
    }
    [padded(&x), padded(&y)]
}

fn in_order(first: f64, second: f64) -> Signal {
    let [a, b] = [first, second].map(|hz| tone_of(hz, 25.0, 0.16, 0.16));
    place(0.42, &[(0.05, &a), (0.21, &b)])
}

fn onsets(first: f64, second: f64) -> Signal {
    let [a, b] = [first, second].map(|hz| tone_of(hz, 20.0, 0.1, 0.1));
    place(0.3, &[(0.05, &a), (0.084, &b)])
}

fn three(hz: f64, db: f64) -> Signal {
    let others = plus(&tone(25.0, 20.0), &turned(300.0, 20.0, 1.0));
    plus(&others, &louder(turned(hz, 20.0, 2.0), db))
}

fn rising() -> [Signal; 2] {
    let flat = bare(250.0, 25.0, 1.0, 1.0, 0.0);
    let rise = flat
        .iter()
        .enumerate()
        .map(|(i, v)| v * i as f64 / FS)
        .collect();
    [
        equal_energy(ramp(rise, 0.010), &flat),
        equal_energy(ramp(flat.clone(), 0.010), &flat),
    ]
}

/// 1 kHz at 0.65 of its threshold, modulated at 200 Hz.
fn unfelt(depth: f64) -> Signal {
    let top = 0.65 * threshold(1000.0, 1.0) * SQRT_2;
    ramp(
        made(1.0, |t| {
            top * (TAU * 1000.0 * t).sin() * (1.0 + depth * (TAU * 200.0 * t).sin())
        }),
        0.010,
    )
}

/// Reference and test of a key.
pub(crate) fn pair(key: &str) -> [Signal; 2] {
    let ramped = |x| ramp(x, 0.010);
    let level = |hz, sl, db| [tone(hz, sl), louder(tone(hz, sl), db)];
    if let Some((case, value)) = key.split_once('.')
        && let Ok(value) = value.parse::<f64>()
    {
        match case {
            "1" => return level(value, 20.0, 2.4),
            "2" => return level(value, 35.0, 2.2),
            "3" => return level(value, 20.0, 1.0),
            "4" => return level(value, 20.0, 4.0),
            "10" => return [tone(200.0, value), tone(240.0, value)],
            "13" => return [tone(300.0, 25.0), am(300.0, value, 1.0)],
            "14" => return [am(300.0, value, 1.0), steps(300.0, value)],
            "23" => {
                let x = tone(value, 25.0);
                return [x.clone(), plus(&x, &tone(3.0 * value, -6.0))];
            }
            _ => (),
        }
    }
    match key {
        "5" => level(125.0, 10.0, 1.6),
        "6" => [tone(80.0, 20.0), tone(100.0, 20.0)],
        "7" => [tone(80.0, 35.0), tone(94.4, 35.0)],
        "8" => [tone(80.0, 20.0), tone(84.8, 20.0)],
        "9" => [tone(80.0, 20.0), tone(128.0, 20.0)],
        "11" => [three(80.0, 0.0), three(80.0, 2.4)],
        "12" => [three(80.0, 0.0), three(100.0, 0.0)],
        "15" => [unfelt(0.0), unfelt(0.9)],
        "16" => [decay(0.050), decay(0.0615)],
        "17" => [decay(0.0108), decay(0.0173)],
        "18" => [1.0, 1.13].map(|s| padded(&tone_of(200.0, 20.0, s, 1.0))),
        "19" => [onsets(50.0, 250.0), onsets(250.0, 50.0)],
        "20" => [taps(2), taps(3)],
        "21" => [1, 2].map(|seed| ramped(noise(40.0, 500.0, 25.0, 5.0, seed))),
        "22" => [0.0, FRAC_PI_2].map(|turn| plus(&tone(100.0, 25.0), &turned(300.0, 25.0, turn))),
        "25" => [
            tone(250.0, 25.0),
            plus(&tone(250.0, 25.0), &tone(25.0, 25.0)),
        ],
        "II.2" => [tone(130.8, 25.0), tone(261.6, 25.0)],
        "II.5" => [tone(250.0, 25.0), am(250.0, 50.0, 1.0)],
        "II.8" => rising(),
        "II.10" => [in_order(100.0, 200.0), in_order(200.0, 100.0)],
        "II.11" => [0.015, 0.06].map(|s| padded(&ramp(bare(250.0, 25.0, s, 0.015, 0.0), 0.003))),
        "II.14" => level(250.0, 20.0, 2.4),
        "II.16" => [tone(300.0, 25.0), am(300.0, 25.0, 1.0)],
        "II.17" => {
            let x = tone(300.0, 25.0);
            let mut y = x.clone();
            for v in &mut y[2800..5200] {
                *v *= 0.75;
            }
            [x, y]
        }
        "II.18a" | "II.18b" | "II.18c" => {
            let starts: Vec<f64> = (0..20)
                .flat_map(|k| [0.0, 0.005, 0.010].map(|j| k as f64 * 0.05 + j))
                .collect();
            let rate = match key {
                "II.18a" => 25,
                "II.18b" => 20,
                _ => 60,
            };
            [pulses(&starts), pulses(&every(rate))]
        }
        "II.19" => [tone(150.0, 10.0), tone(150.0, 30.0)],
        "II.20" => [3, 4].map(|seed| ramped(noise(60.0, 400.0, 20.0, 1.0, seed))),
        "II.21" => {
            let x = tone(100.0, 25.0);
            [x.clone(), equal_energy(plus(&x, &tone(106.0, 25.0)), &x)]
        }
        "II.22" => {
            let x = tone(200.0, 30.0);
            let top = x.iter().copied().fold(0.0, f64::max);
            let beat = ramped(made(1.0, |t| top * (TAU * 230.0 * t).sin()));
            [x.clone(), plus(&x, &louder(beat, -10.0))]
        }
        "II.23" => {
            let x = tone(100.0, 20.0);
            [plus(&x, &louder(tone(140.0, 20.0), -12.0)), x]
        }
        "II.24" => [
            plus(&tone(50.0, 20.0), &tone(140.0, 20.0)),
            tone(140.0, 20.0),
        ],
        "II.25" => [tone(250.0, 25.0), am(250.0, 30.0, 0.12)],
        "II.26" => [tone(250.0, 25.0), am(250.0, 30.0, 0.03)],
        "II.27" => [tone(250.0, 25.0), am(250.0, 30.0, 0.35)],
        "II.28" | "II.29" => {
            let whole = place(0.3, &[(0.05, &tone_of(250.0, 25.0, 0.2, 0.2))]);
            [whole, gapped(if key == "II.28" { 0.010 } else { 0.040 })]
        }
        "II.30.250" => [0.05, 0.5].map(|s| padded(&tone_of(250.0, 10.0, s, 0.05))),
        "II.30.20" => [0.05, 0.5].map(|s| padded(&tone_of(20.0, 10.0, s, 0.05))),
        "II.32" => [tone(80.0, 20.0), tone(82.0, 20.0)],
        "II.34.20" => after_masker(20.0),
        "II.34.500" => after_masker(500.0),
        "II.35.100" => pedestal(0.1),
        "II.35.650" => pedestal(0.65),
        other => panic!("no pair called {other}"),
    }
}
