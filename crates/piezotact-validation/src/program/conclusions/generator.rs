//! Recordings whose truth is known: a finger that slides over surfaces, with forces, vibration, motion, rests and lifts. Nothing of it is the
//! twin's.

use std::f64::consts::TAU;

use anyhow::Result;
use piezotact::quantity::{Newtons, SampleRate, Unit};
use piezotact::recording::{Channel, Condition, Provenance, Recording};
use piezotact::statistics::rms;
use piezotact::study::{Naming, Recorded};

use super::super::signal::{Draws, RATE_HZ};

/// Silence before the first stroke and behind the last, s.
const REST_S: f64 = 1.0;
/// The time between strokes, s: the finger is lifted and moves back.
const LIFT_S: f64 = 0.7;
/// Force and speed rise and fall so long, s.
const RAMP_S: f64 = 0.08;
/// The level of a texture is that at this speed and load …
const SPEED_M_S: f64 = 0.03;
const LOAD_N: f64 = 0.2;
/// … and follows them as power laws with these exponents.
const ON_SPEED: f64 = 1.0;
const ON_LOAD: f64 = 0.3;
/// Levels of strokes of one recording differ by this, dB (standard deviation); speeds by this share.
const STROKE_SD_DB: f64 = 0.6;
const STROKE_SPEED_SD: f64 = 0.01;
/// The harmonics of a period, the highest of which lies below the band's end.
const HARMONICS: i32 = 8;

/// A surface, as a finger feels it.
#[derive(Clone, Debug)]
pub(super) struct Surface {
    pub(super) name: &'static str,
    /// The periods that move with the speed, each with its share of the power, m: those of the surface, then of the finger's ridges.
    pub(super) combs: Vec<(f64, f64)>,
    /// Rms at 30 mm/s and 0.2 N, m/s².
    pub(super) level_m_s2: f64,
    /// Where its noise ends, Hz.
    pub(super) high_hz: f64,
    pub(super) friction: f64,
    /// Ra, m.
    pub(super) ra_m: f64,
}

impl Surface {
    /// The expected rms at a speed and a load, m/s².
    pub(super) fn level_at(&self, speed_m_s: f64, load_n: f64) -> f64 {
        self.level_m_s2 * (speed_m_s / SPEED_M_S).powf(ON_SPEED) * (load_n / LOAD_N).powf(ON_LOAD)
    }
}

/// The channel of motion that recordings have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Motion {
    None,
    Speed,
    Position,
}

/// What is recorded: every surface at every speed and load.
#[derive(Clone, Debug)]
pub(super) struct Plan {
    pub(super) surfaces: Vec<Surface>,
    pub(super) speeds_m_s: Vec<f64>,
    pub(super) loads_n: Vec<f64>,
    /// The recordings of each condition.
    pub(super) repeats: usize,
    /// The standard deviation of the level between recordings of one condition, dB.
    pub(super) session_sd_db: f64,
    pub(super) strokes: usize,
    pub(super) stroke_s: f64,
    pub(super) motion: Motion,
    /// Slow changes of the speed within a stroke, as a share of it.
    pub(super) wobble: f64,
    /// The finger stops in the middle of a stroke for this time, s.
    pub(super) pause_s: f64,
    /// The noise of the force channels, N (standard deviation).
    pub(super) force_noise_n: f64,
    /// The noise of the accelerometer, m/s² (standard deviation).
    pub(super) sensor_noise_m_s2: f64,
}

impl Plan {
    /// Samples A and B of one surface and C of another, at 10, 20 and 30 mm/s and 0.2 N, one recording of six strokes each.
    pub(super) fn usual(texture: Texture) -> Self {
        Self {
            surfaces: texture.surfaces(),
            speeds_m_s: vec![0.01, 0.02, 0.03],
            loads_n: vec![LOAD_N],
            repeats: 1,
            session_sd_db: 0.0,
            strokes: 6,
            stroke_s: 1.5,
            motion: Motion::None,
            wobble: 0.0,
            pause_s: 0.0,
            force_noise_n: 0.003,
            sensor_noise_m_s2: 0.003,
        }
    }
}

/// A kind of texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Texture {
    /// A period of 0.4 mm.
    Fine,
    /// A period of 0.7 mm.
    Medium,
    /// A period of 1.1 mm, whose line lies near the end of the band at the slowest speed.
    Coarse,
    /// A period of 0.55 mm in noise of three times its power.
    Weak,
    /// Noise.
    Rough,
    /// Noise, and the ridges of the finger 0.46 mm apart on all samples.
    Ridged,
}

impl Texture {
    pub(super) const ALL: [Self; 6] = [
        Self::Fine,
        Self::Medium,
        Self::Coarse,
        Self::Weak,
        Self::Rough,
        Self::Ridged,
    ];

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Fine => "fine",
            Self::Medium => "medium",
            Self::Coarse => "coarse",
            Self::Weak => "weak",
            Self::Rough => "rough",
            Self::Ridged => "ridged",
        }
    }

    /// A and B are of one surface; C is 8 dB louder, brighter and 1.37 times as long in its period.
    fn surfaces(self) -> Vec<Surface> {
        let combs = |longer: f64| match self {
            Self::Fine => vec![(0.0004 * longer, 0.7)],
            Self::Medium => vec![(0.0007 * longer, 0.7)],
            Self::Coarse => vec![(0.0011 * longer, 0.7)],
            Self::Weak => vec![(0.00055 * longer, 0.25)],
            Self::Rough => Vec::new(),
            Self::Ridged => vec![(0.00046, 0.3)],
        };
        let surface = |name, longer| Surface {
            name,
            combs: combs(longer),
            level_m_s2: 1.0,
            high_hz: 220.0,
            friction: 0.6,
            ra_m: 4e-6,
        };
        let other = Surface {
            level_m_s2: 2.5,
            high_hz: 450.0,
            friction: 0.8,
            ra_m: 20e-6,
            ..surface("C", 1.37)
        };
        vec![surface("A", 1.0), surface("B", 1.0), other]
    }
}

/// One recording, with what it says of itself and what is true of it.
#[derive(Clone, Debug)]
pub(super) struct Made {
    /// What it says of itself.
    pub(super) sample: String,
    pub(super) speed_m_s: f64,
    pub(super) load_n: f64,
    /// What is true: the surface (absent where nothing is touched), the speed, the load, and the recording of which it is a copy.
    pub(super) surface: Option<Surface>,
    pub(super) true_speed_m_s: f64,
    pub(super) true_load_n: f64,
    pub(super) origin: usize,
    /// A period of the drive, m: with one sample alone nobody can tell it from one of the surface.
    pub(super) drive_m: Option<f64>,
    pub(super) acceleration: Vec<f64>,
    pub(super) normal_n: Vec<f64>,
    pub(super) tangential_n: Vec<f64>,
    /// The way that the finger has slid, m, and its speed, m/s, without the ways back.
    pub(super) path_m: Vec<f64>,
    pub(super) slides_m_s: Vec<f64>,
    pub(super) motion: Option<Channel>,
}

impl Made {
    /// A line of so much amplitude, whose phase in turns is `turns` at a sample.
    pub(super) fn add(&mut self, amplitude: f64, turns: impl Fn(&Self, usize) -> f64) {
        let line: Vec<f64> = (0..self.acceleration.len())
            .map(|i| amplitude * (TAU * turns(self, i)).sin())
            .collect();
        let all = self.acceleration.iter_mut().zip(line);
        all.for_each(|(a, line)| *a += line);
    }

    /// A line at a fixed frequency.
    pub(super) fn add_line(&mut self, hz: f64, amplitude: f64, draws: &mut Draws) {
        let turn = draws.uniform();
        self.add(amplitude, |_, i| hz * i as f64 / RATE_HZ + turn);
    }

    /// Changes the acceleration while the finger slides, and what it slides with.
    pub(super) fn while_sliding(&mut self, change: impl Fn(usize, f64) -> f64) {
        for i in 0..self.acceleration.len() {
            if self.slides_m_s[i] > 0.0 {
                self.acceleration[i] = change(i, self.acceleration[i]);
            }
        }
    }

    /// As it comes to a study; it is cited by its place.
    pub(super) fn recorded(&self, place: usize) -> Result<Recorded> {
        let channel = |name: &str, unit: Unit, samples: &[f64]| Channel {
            name: name.into(),
            unit,
            samples: samples.to_vec(),
        };
        let mut channels = vec![
            channel("nail", Unit::MetrePerSecondSquared, &self.acceleration),
            channel("fx", Unit::Newton, &self.tangential_n),
            channel("fz", Unit::Newton, &self.normal_n),
        ];
        channels.extend(self.motion.clone());
        let own = Condition {
            sample: Some(self.sample.clone()),
            load_n: Some(Newtons(self.load_n)),
            speed_m_s: Some(self.speed_m_s),
            ..Condition::default()
        };
        let rate = SampleRate::new(RATE_HZ)?;
        Ok(Recorded {
            file: place.to_string(),
            name: format!("{} {place}", self.sample),
            recording: Recording::new(channels, rate, own, Provenance::default())?,
            naming: Naming::default(),
            cuts: None,
            cuts_are_looked_for_in: String::new(),
        })
    }
}

/// Every recording of `plan`, drawn by `draws`.
pub(super) fn generate(plan: &Plan, draws: &mut Draws) -> Vec<Made> {
    let mut all = Vec::new();
    for surface in &plan.surfaces {
        for speed_m_s in &plan.speeds_m_s {
            for load_n in &plan.loads_n {
                for _ in 0..plan.repeats {
                    let place = all.len();
                    all.push(made(plan, surface, [*speed_m_s, *load_n], place, draws));
                }
            }
        }
    }
    all
}

/// What the finger does: its speed, the place that it has come to, and how it presses, 0–1.
struct Finger {
    slides_m_s: Vec<f64>,
    moves_m_s: Vec<f64>,
    presses: Vec<f64>,
    /// The level of the stroke, as an amplitude ratio.
    level: Vec<f64>,
}

fn finger(plan: &Plan, speed_m_s: f64, draws: &mut Draws) -> Finger {
    let count = |seconds: f64| (seconds * RATE_HZ) as usize;
    let samples = 2 * count(REST_S) + plan.strokes * count(plan.stroke_s + LIFT_S);
    let mut finger = Finger {
        slides_m_s: vec![0.0; samples],
        moves_m_s: vec![0.0; samples],
        presses: vec![0.0; samples],
        level: vec![0.0; samples],
    };
    let session_db = plan.session_sd_db * draws.normal();
    for stroke in 0..plan.strokes {
        let from = count(REST_S) + stroke * count(plan.stroke_s + LIFT_S);
        let own = speed_m_s * (1.0 + STROKE_SPEED_SD * draws.normal());
        let level = 10f64.powf((session_db + STROKE_SD_DB * draws.normal()) / 20.0);
        let turn = draws.uniform();
        let mut way_m = 0.0;
        for i in 0..count(plan.stroke_s) {
            let at_s = i as f64 / RATE_HZ;
            let inside_s = at_s.min(plan.stroke_s - at_s);
            // The finger presses before it slides.
            let ramp = |after_s: f64| ((inside_s - after_s) / RAMP_S).clamp(0.0, 1.0);
            let wobble = 1.0 + plan.wobble * (TAU * (2.0 * at_s + turn)).sin();
            let away_s = (at_s - 0.5 * plan.stroke_s).abs() - 0.5 * plan.pause_s;
            let stops = if plan.pause_s > 0.0 {
                (away_s / 0.02).clamp(0.0, 1.0)
            } else {
                1.0
            };
            let v = own * ramp(0.5 * RAMP_S) * wobble * stops;
            finger.slides_m_s[from + i] = v;
            finger.moves_m_s[from + i] = v;
            finger.presses[from + i] = ramp(0.0);
            finger.level[from + i] = level;
            way_m += v / RATE_HZ;
        }
        let (back, lift) = (from + count(plan.stroke_s), 0.8 * LIFT_S);
        for i in 0..count(lift) {
            let sine = (TAU * 0.5 * i as f64 / RATE_HZ / lift).sin();
            finger.moves_m_s[back + i] = -way_m * 2.0 * sine * sine / lift;
        }
    }
    finger
}

fn made(
    plan: &Plan,
    surface: &Surface,
    [speed_m_s, load_n]: [f64; 2],
    origin: usize,
    draws: &mut Draws,
) -> Made {
    let finger = finger(plan, speed_m_s, draws);
    let samples = finger.presses.len();
    let sum = |speeds: &[f64]| -> Vec<f64> {
        let mut way_m = 0.0;
        let step = |v: &f64| {
            way_m += v / RATE_HZ;
            way_m
        };
        speeds.iter().map(step).collect()
    };
    let path_m = sum(&finger.slides_m_s);
    let noise = coloured(samples, [45.0, surface.high_hz], draws);
    let combs = combs(surface, speed_m_s, &path_m, draws);
    let share: f64 = surface.combs.iter().map(|(_, share)| share).sum();
    let mut acceleration: Vec<f64> = (0..samples)
        .map(|i| {
            let load_n = (load_n * finger.presses[i]).max(1e-3);
            let level = finger.level[i] * surface.level_at(finger.slides_m_s[i], load_n);
            level * ((1.0 - share).sqrt() * noise[i] + combs[i])
                + plan.sensor_noise_m_s2 * draws.normal()
        })
        .collect();
    // What landing and lifting knock, 3 m/s² for 10 ms, and the gesture below 5 Hz.
    for i in 1..samples {
        let knocks = (finger.presses[i] > 0.0) != (finger.presses[i - 1] > 0.0);
        for k in (0..samples.min(200)).filter(|k| knocks && i + k < samples) {
            let at_s = k as f64 / RATE_HZ;
            acceleration[i + k] += 3.0 * (-at_s / 0.01).exp() * (TAU * 90.0 * at_s).sin();
        }
    }
    let turn = draws.uniform();
    for (i, a) in acceleration.iter_mut().enumerate() {
        *a += 0.3 * (TAU * (1.3 * i as f64 / RATE_HZ + turn)).sin();
    }
    // Slow changes of the force by 4 %.
    let (mut slow, mut normal_n, mut tangential_n) = (0.0, Vec::new(), Vec::new());
    for press in &finger.presses {
        slow = 0.9995 * slow + 0.04 * 0.0316 * draws.normal();
        let force_n = load_n * press * (1.0 + slow);
        let noise = [0, 1].map(|_| plan.force_noise_n * draws.normal());
        normal_n.push(force_n + 0.01 + noise[0]);
        tangential_n.push(surface.friction * force_n - 0.005 + noise[1]);
    }
    let motion = |unit, samples| {
        Some(Channel {
            name: "motion".into(),
            unit,
            samples,
        })
    };
    Made {
        sample: surface.name.into(),
        speed_m_s,
        load_n,
        surface: Some(surface.clone()),
        true_speed_m_s: speed_m_s,
        true_load_n: load_n,
        origin,
        drive_m: None,
        acceleration,
        normal_n,
        tangential_n,
        motion: match plan.motion {
            Motion::None => None,
            Motion::Speed => motion(Unit::MetrePerSecond, finger.moves_m_s),
            Motion::Position => motion(Unit::Metre, sum(&finger.moves_m_s)),
        },
        path_m,
        slides_m_s: finger.slides_m_s,
    }
}

/// The combs of a surface along a path, of its share of power 1.
fn combs(surface: &Surface, speed_m_s: f64, path_m: &[f64], draws: &mut Draws) -> Vec<f64> {
    let mut all = vec![0.0; path_m.len()];
    for (period_m, share) in &surface.combs {
        let orders = (1..=HARMONICS).filter(|n| f64::from(*n) * speed_m_s / period_m < 900.0);
        let teeth: Vec<(f64, f64, f64)> = orders
            .map(|n| {
                let n = f64::from(n);
                (n / period_m, n.powf(-1.2), draws.uniform())
            })
            .collect();
        let power: f64 = teeth
            .iter()
            .map(|(_, height, _)| 0.5 * height * height)
            .sum();
        for (value, way_m) in all.iter_mut().zip(path_m) {
            let sum = |(wavenumber, height, turn): &(f64, f64, f64)| {
                height * (TAU * (wavenumber * way_m + turn)).sin()
            };
            *value += (share / power).sqrt() * teeth.iter().map(sum).sum::<f64>();
        }
    }
    all
}

/// Noise of rms 1 that rises to the first frequency and falls from the second on.
pub(super) fn coloured(samples: usize, hz: [f64; 2], draws: &mut Draws) -> Vec<f64> {
    let [low, high] = hz.map(|hz| (-TAU * hz / RATE_HZ).exp());
    let (mut slow, mut first, mut second) = (0.0, 0.0, 0.0);
    let mut noise = draws.white(samples);
    for value in &mut noise {
        slow = low * slow + (1.0 - low) * *value;
        first = high * first + (1.0 - high) * (*value - slow);
        second = high * second + (1.0 - high) * first;
        *value = second;
    }
    let level = rms(&noise);
    noise.iter_mut().for_each(|value| *value /= level);
    noise
}
