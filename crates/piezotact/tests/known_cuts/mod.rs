//! Recordings of active touch with known cuts: a small generator of its own, which knows nothing of the rules that
//! cut them.
#![allow(dead_code, reason = "each test file uses its part")]
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use std::f64::consts::TAU;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

pub(crate) const RATE_HZ: f64 = 5000.0;
const LOAD_N: f64 = 0.2;

/// What a finger does in one contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Kind {
    /// Lands moving, slides, lifts.
    Plain,
    /// Lands, waits, slides, lifts.
    Hesitant,
    /// Lands and lifts again without sliding.
    TouchOnly,
    /// Taps, then lands moving and slides.
    DoubleTouch,
    /// Leaves the surface for a moment while it slides.
    Bounce,
    /// Sticks and slips.
    StickSlip,
    /// Stops on its way.
    Pause,
}

/// A contact as it was made.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Truth {
    pub(crate) kind: Kind,
    /// First touch and last, s.
    pub(crate) contact_s: (f64, f64),
    /// Where the finger slides, s.
    pub(crate) sliding_s: (f64, f64),
}

impl Truth {
    /// The cut of a valid stroke, when `landing_s` and `take_off_s` are cut away, s.
    pub(crate) fn cut_s(&self, landing_s: f64, take_off_s: f64) -> Option<(f64, f64)> {
        matches!(self.kind, Kind::Plain | Kind::Hesitant | Kind::DoubleTouch).then(|| {
            (
                (self.contact_s.0 + landing_s).max(self.sliding_s.0),
                (self.contact_s.1 - take_off_s).min(self.sliding_s.1),
            )
        })
    }
}

/// Acceleration of the nail in m/s², the three forces in N, and what is true of them.
pub(crate) struct Recorded {
    pub(crate) acceleration: Vec<f64>,
    pub(crate) fx_n: Vec<f64>,
    pub(crate) fy_n: Vec<f64>,
    pub(crate) fz_n: Vec<f64>,
    pub(crate) truths: Vec<Truth>,
}

/// A recording as a table of text, forces in mN.
pub(crate) fn table(made: &Recorded) -> String {
    let mut text = String::from("time (s),nail (m/s2),fx (mN),fy (mN),fz (mN)");
    for i in 0..made.acceleration.len() {
        let [x, y, z] = [&made.fx_n, &made.fy_n, &made.fz_n].map(|axis| axis[i] * 1e3);
        let (time_s, nail) = (i as f64 / RATE_HZ, made.acceleration[i]);
        text += &format!("\n{time_s:.4},{nail:.5},{x:.3},{y:.3},{z:.3}");
    }
    text
}

pub(crate) struct Random(ChaCha8Rng);

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    pub(crate) fn uniform(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.0.next_u64() >> 11) as f64 / (1u64 << 53) as f64
    }

    pub(crate) fn normal(&mut self) -> f64 {
        (-2.0 * (1.0 - self.uniform(0.0, 1.0)).ln()).sqrt() * (TAU * self.uniform(0.0, 1.0)).cos()
    }
}

/// A recording of some ten contacts of all kinds, with a drifting force cell.
pub(crate) fn active_touch(seed: u64) -> Recorded {
    let mut random = Random::new(seed);
    let kinds: Vec<Kind> = (0..10)
        .map(|_| match random.uniform(0.0, 1.0) {
            u if u < 0.45 => Kind::Plain,
            u if u < 0.57 => Kind::Hesitant,
            u if u < 0.65 => Kind::TouchOnly,
            u if u < 0.75 => Kind::DoubleTouch,
            u if u < 0.82 => Kind::Bounce,
            u if u < 0.92 => Kind::StickSlip,
            _ => Kind::Pause,
        })
        .collect();
    recorded(&mut random, &kinds)
}

/// A recording of contacts of `kinds`, one after the other.
pub(crate) fn recorded(random: &mut Random, kinds: &[Kind]) -> Recorded {
    let mut pressing = Vec::new();
    let mut sliding = Vec::new();
    let mut shaking = Vec::new();
    let mut truths = Vec::new();
    let mut time_s = random.uniform(0.5, 1.0);
    for &kind in kinds {
        let length_s = random.uniform(0.8, 1.5);
        let mut contact = (time_s, time_s + length_s);
        let mut slide = contact;
        if kind == Kind::DoubleTouch {
            let tap_s = random.uniform(0.06, 0.15);
            pressing.push((time_s, time_s + tap_s));
            let wait_s = tap_s + random.uniform(0.15, 0.3);
            contact = (time_s + wait_s, time_s + wait_s + length_s);
            slide = contact;
        }
        match kind {
            Kind::Hesitant => {
                let wait_s = random.uniform(0.25, 0.8);
                slide = (contact.0 + wait_s, contact.1 + wait_s);
                contact.1 += wait_s;
                pressing.push(contact);
                sliding.push(slide);
            }
            Kind::TouchOnly => {
                pressing.push(contact);
                slide = (contact.0, contact.0);
            }
            Kind::Bounce => {
                let at_s = contact.0 + length_s * random.uniform(0.4, 0.6);
                let off_s = random.uniform(0.03, 0.08);
                pressing.extend([(contact.0, at_s), (at_s + off_s, contact.1 + off_s)]);
                contact.1 += off_s;
                slide = contact;
                sliding.push(slide);
            }
            Kind::Pause => {
                let at_s = contact.0 + length_s * random.uniform(0.4, 0.6);
                let off_s = random.uniform(0.25, 0.5);
                contact.1 += off_s;
                pressing.push(contact);
                sliding.extend([(contact.0, at_s), (at_s + off_s, contact.1)]);
                slide = contact;
            }
            Kind::StickSlip => {
                pressing.push(contact);
                shaking.push((contact, random.uniform(3.0, 12.0), random.uniform(0.4, 0.8)));
            }
            Kind::Plain | Kind::DoubleTouch => {
                pressing.push(contact);
                sliding.push(slide);
            }
        }
        truths.push(Truth {
            kind,
            contact_s: contact,
            sliding_s: slide,
        });
        time_s = contact.1 + random.uniform(0.4, 0.8);
    }
    let samples = ((time_s + random.uniform(0.2, 0.6)) * RATE_HZ) as usize;
    let mut made = signals(random, samples, &pressing, &sliding, &shaking);
    made.truths = truths;
    made
}

/// How far a ramp between `from_s` and `to_s` has come at `t_s`, 0–1, smoothly.
fn ramp(t_s: f64, from_s: f64, to_s: f64) -> f64 {
    let x = ((t_s - from_s) / (to_s - from_s)).clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

type Span = (f64, f64);

fn signals(
    random: &mut Random,
    samples: usize,
    pressing: &[Span],
    sliding: &[Span],
    shaking: &[(Span, f64, f64)],
) -> Recorded {
    let length_s = samples as f64 / RATE_HZ;
    let level = random.uniform(0.15, 2.0);
    let noise = random.uniform(0.003, 0.015);
    let friction = random.uniform(0.45, 0.9);
    let force_noise_n = random.uniform(0.002, 0.005);
    let wander_n = random.uniform(0.02, 0.045);
    let drift_n = [
        random.uniform(-0.1, 0.1),
        random.uniform(-0.05, 0.05),
        random.uniform(-0.02, 0.02),
    ];
    let gesture = (random.uniform(0.5, 2.0), random.uniform(0.8, 2.5));
    let landings: Vec<(f64, f64, f64)> = pressing
        .iter()
        .map(|_| {
            (
                random.uniform(0.05, 0.09),
                random.uniform(0.04, 0.07),
                random.uniform(2.0, 10.0),
            )
        })
        .collect();
    let mut made = Recorded {
        acceleration: Vec::with_capacity(samples),
        fx_n: Vec::with_capacity(samples),
        fy_n: Vec::with_capacity(samples),
        fz_n: Vec::with_capacity(samples),
        truths: Vec::new(),
    };
    let mut held_n = 0.0;
    let mut rough = [0.0; 2];
    let keep = (-1.0 / (0.3 * RATE_HZ)).exp();
    for i in 0..samples {
        let t_s = i as f64 / RATE_HZ;
        held_n = keep * held_n + wander_n * (1.0 - keep * keep).sqrt() * random.normal();
        // Vibration with most of its power between some 40 and 400 Hz.
        let white = random.normal();
        rough[0] += 0.35 * (white - rough[0]);
        rough[1] += 0.03 * (rough[0] - rough[1]);
        let texture = (rough[0] - rough[1]) / 0.42;
        let (mut force_n, mut vibration) = (0.0, 0.0);
        for ((from_s, to_s), (land_s, lift_s, knock)) in pressing.iter().zip(&landings) {
            let shape =
                ramp(t_s, *from_s, from_s + land_s) * (1.0 - ramp(t_s, to_s - lift_s, *to_s));
            force_n += shape * (LOAD_N + held_n).max(0.05);
            let since_s = t_s - from_s;
            if (0.0..0.1).contains(&since_s) {
                vibration += knock * (-since_s / 0.012).exp() * (TAU * 180.0 * since_s).sin();
            }
            let since_s = t_s - to_s;
            if (0.0..0.1).contains(&since_s) {
                vibration += 0.3 * knock * (-since_s / 0.01).exp() * (TAU * 150.0 * since_s).sin();
            }
        }
        let speed: f64 = sliding
            .iter()
            .map(|(from_s, to_s)| {
                ramp(t_s, *from_s, from_s + 0.035) * (1.0 - ramp(t_s, to_s - 0.035, *to_s))
            })
            .sum();
        let touching = (force_n / LOAD_N).min(1.0);
        vibration += level * texture * speed * (1.0 + 0.15 * (TAU * 1.3 * t_s).sin()) * touching;
        let mut coefficient = friction * (0.35 + 0.65 * speed);
        for ((from_s, to_s), slip_hz, depth) in shaking {
            if t_s > *from_s && t_s < *to_s {
                let phase = ((t_s - from_s) * slip_hz).fract();
                coefficient = 1.4 * (1.0 - depth + depth * phase.min((1.0 - phase) * 60.0));
                let since_s = phase / slip_hz;
                vibration += 3.0 * (-since_s / 0.015).exp() * texture;
            }
        }
        let drift = drift_n[0] * t_s / length_s
            + drift_n[1] * (1.0 - (-t_s / 20.0).exp())
            + drift_n[2] * (TAU * t_s / 25.0).sin();
        made.fz_n
            .push(force_n + drift + force_noise_n * random.normal());
        made.fy_n
            .push(coefficient * force_n + 0.3 * drift + force_noise_n * random.normal());
        made.fx_n
            .push(0.05 * coefficient * force_n + force_noise_n * random.normal());
        made.acceleration
            .push(vibration + gesture.0 * (TAU * gesture.1 * t_s).sin() + noise * random.normal());
    }
    made
}
