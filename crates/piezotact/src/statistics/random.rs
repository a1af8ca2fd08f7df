//! Seeded randomness. The generator is `ChaCha8` by name, and what is drawn from it is written here, so that
//! one seed gives one sequence on every machine for ever.

use std::f64::consts::TAU;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// A stream of random numbers that belongs to one seed, one number (a participant, a repeat) and one name.
#[derive(Clone, Debug)]
pub struct Random {
    generator: ChaCha8Rng,
    spare: Option<f64>,
}

impl Random {
    /// The stream `name` of `number` under `seed`. Streams of different names are independent.
    #[must_use]
    pub fn stream(seed: u64, number: u64, name: &str) -> Self {
        let mut key = [0; 32];
        key[..8].copy_from_slice(&seed.to_le_bytes());
        key[8..16].copy_from_slice(&number.to_le_bytes());
        // FNV-1a, twice with different offsets: names differ in 128 bits.
        for (half, offset) in [(16, 0xcbf2_9ce4_8422_2325_u64), (24, 0x9e37_79b9_7f4a_7c15)] {
            let hash = name.bytes().fold(offset, |hash, byte| {
                (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
            });
            key[half..half + 8].copy_from_slice(&hash.to_le_bytes());
        }
        Self {
            generator: ChaCha8Rng::from_seed(key),
            spare: None,
        }
    }

    /// A number from 0 up to, not including, 1, of 53 random bits.
    pub fn uniform(&mut self) -> f64 {
        (self.generator.next_u64() >> 11) as f64 * 2f64.powi(-53)
    }

    /// A number of the standard normal distribution (Box and Muller 1958).
    pub fn normal(&mut self) -> f64 {
        if let Some(spare) = self.spare.take() {
            return spare;
        }
        let radius = (-2.0 * (1.0 - self.uniform()).ln()).sqrt();
        let (sin, cos) = (TAU * self.uniform()).sin_cos();
        self.spare = Some(radius * sin);
        radius * cos
    }

    /// A number of the standard normal distribution, truncated at ±2 to avoid unrealistic participants.
    pub fn person(&mut self) -> f64 {
        self.normal().clamp(-2.0, 2.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A stored seed must always give the same sequence. The tolerance covers the last bits of `ln`, `sin` and `cos`.
    #[test]
    fn one_seed_one_sequence() {
        let mut random = Random::stream(7, 1, "golden");
        let drawn: Vec<f64> = (0..4).map(|_| random.normal()).collect();
        let stored = GOLDEN;
        assert!(
            drawn.iter().zip(stored).all(|(a, b)| (a - b).abs() < 1e-12),
            "{drawn:?}"
        );
        assert_ne!(
            Random::stream(7, 1, "other").uniform(),
            Random::stream(7, 1, "golden").uniform()
        );
    }

    const GOLDEN: [f64; 4] = [
        -0.445_181_646_271_506_8,
        -0.043_205_595_666_876_44,
        -0.004_316_242_204_727_36,
        1.065_767_572_392_687_4,
    ];

    #[test]
    fn normal_numbers_have_mean_0_and_variance_1() {
        let mut random = Random::stream(1, 0, "moments");
        let drawn: Vec<f64> = (0..100_000).map(|_| random.normal()).collect();
        let mean = drawn.iter().sum::<f64>() / 1e5;
        let variance = drawn.iter().map(|v| v * v).sum::<f64>() / 1e5;
        // Four standard errors: 4/√1e5 and 4·√(2/1e5).
        assert!(
            mean.abs() < 0.0127 && (variance - 1.0).abs() < 0.0179,
            "{mean} {variance}"
        );
    }
}
