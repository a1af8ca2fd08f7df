//! Quick synthetic strokes: PSDs of noise with a shape, whose level and spectrum differ from stroke to stroke as those of a finger do.
#![allow(dead_code, reason = "its two users need other parts of it")]
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use std::f64::consts::TAU;

use piezotact::compare::Texture;
use piezotact::discrimination::{ExcitationPlan, Model};
use piezotact::quantity::Unit;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// Lines of 5 Hz up to 1 kHz.
pub(crate) const BINS: usize = 201;
pub(crate) const RESOLUTION_HZ: f64 = 5.0;
/// Strokes of one sample of the twin, held at one speed and force, differ by 0.6–0.9 dB of level; their spectra by as much.
pub(crate) const LEVEL_SD_DB: f64 = 0.8;
pub(crate) const SPECTRUM_SD_DB: f64 = 0.8;
/// The independent segments behind the PSD of a stroke of a second.
const AVERAGES: usize = 5;

pub(crate) struct Random(ChaCha8Rng);

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    pub(crate) fn uniform(&mut self) -> f64 {
        ((self.0.next_u64() >> 11) as f64 + 0.5) / (1u64 << 53) as f64
    }

    pub(crate) fn normal(&mut self) -> f64 {
        (-2.0 * self.uniform().ln()).sqrt() * (TAU * self.uniform()).cos()
    }
}

/// What a sample's spectrum is changed by: dB at `f` for an amount of 1.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Change {
    /// All of it is louder.
    Level,
    /// Octave by octave up, about 120 Hz.
    Tilt,
    /// One hump is louder and the other softer.
    Humps,
}

impl Change {
    pub(crate) const ALL: [Self; 3] = [Self::Level, Self::Tilt, Self::Humps];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Level => "level",
            Self::Tilt => "tilt",
            Self::Humps => "humps",
        }
    }

    fn db(self, f: f64) -> f64 {
        match self {
            Self::Level => 1.0,
            Self::Tilt => (f / 120.0).log2(),
            Self::Humps => (3.0 * (f / 120.0).log2()).tanh(),
        }
    }
}

/// A texture: two broad humps over a floor, some 25 dB over threshold, changed by `amount` of `change`.
pub(crate) fn spectrum(change: Change, amount: f64) -> Vec<f64> {
    (0..BINS)
        .map(|k| {
            let f = k as f64 * RESOLUTION_HZ;
            if f < 5.0 {
                return 0.0;
            }
            let hump = |centre: f64, width: f64| (-2.0 * ((f / centre).ln() / width).powi(2)).exp();
            let shape = 0.001 + hump(70.0, 0.5) + 0.64 * hump(210.0, 0.4);
            0.02 * shape * 10f64.powf(0.1 * amount * change.db(f))
        })
        .collect()
}

/// The spectrum that is `jnd` of the model from the unchanged one.
pub(crate) fn spectrum_apart(model: &Model, change: Change, jnd: f64) -> Vec<f64> {
    let plan = ExcitationPlan::new(model, BINS, RESOLUTION_HZ);
    let plain = plan.of(&spectrum(change, 0.0));
    let apart =
        |amount: f64| model.distance_jnd(&plain.sums, &plan.of(&spectrum(change, amount)).sums);
    let (mut low, mut high) = (0.0, 20.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if apart(middle) < jnd {
            low = middle;
        } else {
            high = middle;
        }
    }
    spectrum(change, if jnd > 0.0 { high } else { 0.0 })
}

/// The PSD of one stroke of a texture, `wander_db` away from its level.
pub(crate) fn stroke(random: &mut Random, texture: &[f64], wander_db: f64) -> Vec<f64> {
    let level_db = wander_db + LEVEL_SD_DB * random.normal();
    // A deviation for every octave from 5 Hz, with straight lines between.
    let octaves: Vec<f64> = (0..10).map(|_| SPECTRUM_SD_DB * random.normal()).collect();
    texture
        .iter()
        .enumerate()
        .map(|(k, value)| {
            let place = (k.max(1) as f64).log2();
            let (at, share) = (place as usize, place.fract());
            let db = level_db + octaves[at] * (1.0 - share) + octaves[at + 1] * share;
            let product: f64 = (0..AVERAGES).map(|_| random.uniform()).product();
            value * 10f64.powf(0.1 * db) * -product.ln() / AVERAGES as f64
        })
        .collect()
}

/// A sample of `recordings` with `strokes` each; recordings differ by `session_db` of level.
pub(crate) fn sample(
    random: &mut Random,
    name: &str,
    texture: &[f64],
    [recordings, strokes]: [usize; 2],
    session_db: f64,
) -> Texture {
    Texture {
        name: name.into(),
        recordings: (0..recordings)
            .map(|_| {
                let wander_db = session_db * random.normal();
                (0..strokes)
                    .map(|_| stroke(random, texture, wander_db))
                    .collect()
            })
            .collect(),
        resolution_hz: RESOLUTION_HZ,
        unit: Unit::MetrePerSecondSquared,
        highest_hz: RESOLUTION_HZ * (BINS - 1) as f64,
    }
}
