//! Seeded draws of integers. The generator is `ChaCha8` by name, and no float takes part, so that a seed gives the same draws
//! on every platform.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use sha2::{Digest, Sha256};

/// A private stream of draws.
#[derive(Clone, Debug)]
pub(crate) struct Draws(ChaCha8Rng);

impl Draws {
    /// The stream `name` of `number` under `seed`: one draw more in another stream changes nothing in this one.
    pub(crate) fn stream(seed: u64, number: u64, name: &str) -> Self {
        let mut hash = Sha256::new();
        hash.update(seed.to_le_bytes());
        hash.update(number.to_le_bytes());
        hash.update(name.as_bytes());
        Self(ChaCha8Rng::from_seed(hash.finalize().into()))
    }

    /// A number from 0 up to, not including, `end`, all equally probable; 0 where `end` is 0. Draws that would favour small
    /// numbers are rejected.
    pub(crate) fn below(&mut self, end: usize) -> usize {
        let end = (end as u64).max(1);
        let rest = (u64::MAX % end + 1) % end;
        loop {
            let drawn = self.0.next_u64();
            if drawn <= u64::MAX - rest {
                return (drawn % end) as usize;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A stored seed must give the same numbers for ever.
    #[test]
    fn one_seed_one_sequence() {
        let mut draws = Draws::stream(7, 1, "golden");
        let drawn: Vec<usize> = (0..8).map(|_| draws.below(1000)).collect();
        assert_eq!(drawn, GOLDEN);
        assert_ne!(
            Draws::stream(7, 2, "golden").below(1 << 40),
            Draws::stream(7, 1, "golden").below(1 << 40)
        );
    }

    const GOLDEN: [usize; 8] = [713, 755, 873, 658, 891, 951, 831, 757];

    #[test]
    fn all_numbers_are_equally_probable() {
        let mut draws = Draws::stream(1, 0, "uniform");
        let mut counts = [0_usize; 3];
        for _ in 0..30_000 {
            counts[draws.below(3)] += 1;
        }
        // Four standard errors: 4·√(30 000·2/9).
        assert!(
            counts.iter().all(|n| n.abs_diff(10_000) < 327),
            "{counts:?}"
        );
        assert_eq!(draws.below(0), 0);
    }
}
