//! A camera that follows the fingertip along the surface.

use super::RATE_HZ;
use super::parameters::HandParameters;
use piezotact_bench::random::Random;

/// The last position that the camera saw, and how many samples ago.
pub(crate) struct Camera {
    every: usize,
    noise_m: f64,
    random: Random,
    age: usize,
    seen_m: f64,
}

impl Camera {
    /// That of `hand`; none without images.
    pub(crate) fn of(hand: &HandParameters, random: Random) -> Option<Self> {
        (hand.track_hz > 0.0).then(|| Self {
            every: ((RATE_HZ / hand.track_hz).round() as usize).max(1),
            noise_m: hand.track_noise_m,
            random,
            age: 0,
            seen_m: 0.0,
        })
    }

    /// What it says while the fingertip is at `place_m`, m: the position of its last image.
    pub(crate) fn read(&mut self, place_m: f64) -> f64 {
        if self.age == 0 {
            self.seen_m = place_m + self.noise_m * self.random.normal();
        }
        self.age = (self.age + 1) % self.every;
        self.seen_m
    }
}
