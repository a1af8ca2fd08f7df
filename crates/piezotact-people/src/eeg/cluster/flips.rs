//! Sign flips of people, and the nodes beyond the threshold under each.

use piezotact::statistics::random::Random;

use super::{ClusterConfig, Tail, Tried};

/// The sign flips to make besides the observed signs.
#[derive(Clone, Copy, Debug)]
pub(super) struct Flips {
    people: usize,
    /// People whose signs change: all, or all but the first where opposite signs are the same.
    free: usize,
    count: usize,
    tried: Tried,
}

impl Flips {
    pub(super) fn new(people: usize, config: &ClusterConfig) -> Self {
        let free = people - usize::from(config.tail == Tail::Both);
        let all = 1usize.checked_shl(free as u32).filter(|_| free < 48);
        let (count, tried) = match all.filter(|all| *all <= config.flips) {
            Some(all) => (all, Tried::All),
            None => (config.flips, Tried::Drawn { seed: config.seed }),
        };
        Self {
            people,
            free,
            count,
            tried,
        }
    }

    /// How many, with the observed signs.
    pub(super) fn count(self) -> usize {
        self.count
    }

    pub(super) fn tried(self) -> Tried {
        self.tried
    }

    /// Calls `to` with the signs of people of every flip but the observed one: true for those that change.
    pub(super) fn for_each(self, mut to: impl FnMut(&[bool])) {
        let mut signs = vec![false; self.people];
        let fixed = self.people - self.free;
        match self.tried {
            Tried::All => {
                // In the order of the Gray code: one person changes from one flip to the next.
                for step in 1..self.count {
                    let person = fixed + step.trailing_zeros() as usize;
                    signs[person] = !signs[person];
                    to(&signs);
                }
            }
            Tried::Drawn { seed } => {
                let mut random = Random::stream(seed, self.people as u64, "sign flips");
                for _ in 1..self.count {
                    for sign in &mut signs {
                        *sign = random.uniform() < 0.5;
                    }
                    to(&signs);
                }
            }
        }
    }
}

/// Sums over people with signs, and what they have to exceed.
pub(super) struct Sums {
    people: f64,
    arch: pulp::Arch,
    /// Σx² of each node.
    squares: Vec<f64>,
    /// The sum at which t is at the threshold.
    critical: Vec<f64>,
    sums: Vec<f64>,
    beyond: Vec<u8>,
    active: Vec<u32>,
    signs: Vec<bool>,
    age: usize,
}

/// After so many changes of one person each, sums are computed anew, so that rounding does not add up.
const ANEW: usize = 32;

impl Sums {
    pub(super) fn new(people: &[&[f64]], threshold_t: f64) -> Self {
        let nodes = people[0].len();
        let n = people.len() as f64;
        let mut squares = vec![0.0; nodes];
        for person in people {
            for (sum, value) in squares.iter_mut().zip(*person) {
                *sum += value * value;
            }
        }
        // |t| > h is s² > h²·n·Σx²/(n − 1 + h²). Where all |x| are 0 nothing is beyond.
        let h = threshold_t * threshold_t;
        let critical = squares
            .iter()
            .map(|squares| (h * n * squares / (n - 1.0 + h)).sqrt())
            .collect();
        Self {
            people: n,
            arch: pulp::Arch::new(),
            squares,
            critical,
            sums: vec![0.0; nodes],
            // Whole words of eight.
            beyond: vec![0; nodes.next_multiple_of(8)],
            active: Vec::new(),
            signs: Vec::new(),
            age: ANEW,
        }
    }

    /// Student's t of a node under the signs last summed.
    #[inline]
    pub(super) fn t(&self, node: usize) -> f64 {
        let (n, sum) = (self.people, self.sums[node]);
        let mean = sum / n;
        let spread = self.squares[node] - sum * mean;
        // What is left of rounding where people do not differ at all.
        if spread <= super::NO_SPREAD * self.squares[node] {
            return 0.0;
        }
        mean / (spread / (n * (n - 1.0))).sqrt()
    }

    /// The nodes beyond the threshold under `signs`, in ascending order.
    pub(super) fn active(&mut self, people: &[&[f64]], signs: &[bool]) -> Vec<u32> {
        let changed = self.signs.iter().zip(signs).filter(|(a, b)| a != b).count();
        if changed == 1 && self.age < ANEW {
            self.age += 1;
            for (person, (before, now)) in self.signs.iter().zip(signs).enumerate() {
                if before != now {
                    let factor = if *now { -2.0 } else { 2.0 };
                    let (sums, values) = (&mut self.sums, people[person]);
                    self.arch.dispatch(|| {
                        for (sum, value) in sums.iter_mut().zip(values) {
                            *sum += factor * value;
                        }
                    });
                }
            }
        } else {
            self.age = 0;
            self.sums.fill(0.0);
            for (values, sign) in people.iter().zip(signs) {
                let factor = if *sign { -1.0 } else { 1.0 };
                let sums = &mut self.sums;
                self.arch.dispatch(|| {
                    for (sum, value) in sums.iter_mut().zip(*values) {
                        *sum += factor * value;
                    }
                });
            }
        }
        self.signs.clear();
        self.signs.extend_from_slice(signs);
        let (sums, critical, beyond) = (&self.sums, &self.critical, &mut self.beyond);
        self.arch.dispatch(|| {
            for ((beyond, sum), critical) in beyond.iter_mut().zip(sums).zip(critical) {
                *beyond = u8::from(sum.abs() > *critical);
            }
        });
        let mut active = std::mem::take(&mut self.active);
        active.clear();
        for (word, bytes) in self.beyond.as_chunks::<8>().0.iter().enumerate() {
            let mut word_of = u64::from_le_bytes(*bytes);
            while word_of != 0 {
                active.push((8 * word) as u32 + word_of.trailing_zeros() / 8);
                word_of &= word_of - 1;
            }
        }
        active
    }

    /// Takes a list of nodes back, so that its memory is used again.
    pub(super) fn give_back(&mut self, active: Vec<u32>) {
        self.active = active;
    }
}
