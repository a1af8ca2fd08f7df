//! Sets in which every pair of samples is together: Steiner triple systems, balanced blocks, coverings, and their sharing.

use serde::{Deserialize, Serialize};

use super::coverage::PairCoverage;
use super::error::{DesignError, must};
use crate::campaign::random::Stream;

/// The largest number of samples that sets are built of.
const MOST_SAMPLES: usize = 100;
/// Moves of the search for a covering with one set less.
const MOVES: usize = 400_000;
/// Searches for a covering with one set less, each from another start.
const STARTS: u64 = 4;

/// How sets were built.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Method {
    /// Base blocks developed modulo the number of samples.
    Cyclic,
    /// The construction of Bose (1939).
    Bose,
    /// The construction of Skolem (1958).
    Skolem,
    /// Every subset of that size.
    AllSubsets,
    /// A greedy covering, improved by a seeded search.
    Search,
}

/// Sets of samples as indices, with the coverage that was counted on them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Blocks {
    /// The number of samples.
    pub points: usize,
    /// The size of a set.
    pub size: usize,
    /// The sets.
    pub blocks: Vec<Vec<usize>>,
    /// How they were built.
    pub method: Method,
    /// The smallest number of sets that can hold all pairs, after Schönheim: a bound that need not be reached.
    pub bound: usize,
    /// What was counted on the sets.
    pub coverage: PairCoverage,
}

impl Blocks {
    fn proven(
        points: usize,
        size: usize,
        mut blocks: Vec<Vec<usize>>,
        method: Method,
    ) -> Result<Self, DesignError> {
        for block in &mut blocks {
            block.sort_unstable();
        }
        let coverage = PairCoverage::of(points, &blocks);
        if !coverage.is_complete() {
            return Err(DesignError::NoBalancedDesign { points, size });
        }
        Ok(Self {
            points,
            size,
            blocks,
            method,
            bound: schonheim_bound(points, size),
            coverage,
        })
    }

    /// The sets by the names of `samples`, of which there are `points`; indices beyond are left out.
    #[must_use]
    pub fn named(&self, samples: &[String]) -> Vec<Vec<String>> {
        let name = |i: &usize| samples.get(*i).cloned();
        let set = |block: &Vec<usize>| block.iter().filter_map(name).collect();
        self.blocks.iter().map(set).collect()
    }
}

fn check_size(points: usize, size: usize) -> Result<(), DesignError> {
    if size < 2 || size > points || points > MOST_SAMPLES {
        return Err(DesignError::ImpossibleSize {
            points,
            size,
            most: MOST_SAMPLES,
        });
    }
    Ok(())
}

/// The smallest number of sets of `size` that can hold all pairs of `points` samples: ⌈n/k·⌈(n − 1)/(k − 1)⌉⌉; 0 for sets of
/// fewer than two.
///
/// Source: Schönheim (1964), Pacific J. Math. 14, 1405. A bound: it is not always reached.
#[must_use]
pub fn schonheim_bound(points: usize, size: usize) -> usize {
    if size < 2 || points < 2 {
        return 0;
    }
    (points * (points - 1).div_ceil(size - 1)).div_ceil(size)
}

/// n(n − 1)/6 triplets in which every pair of n = `points` samples is together once; counted before they are returned.
///
/// # Errors
///
/// n that is not 1 or 3 modulo 6, below 3 or above 100.
///
/// Source: base blocks {0, 1, 3} modulo 7 and {0, 1, 4}, {0, 2, 7} modulo 13; else Bose (1939), Ann. Eugen. 9, 353 and
/// Skolem (1958), Math. Scand. 6, 273.
pub fn steiner_triples(points: usize) -> Result<Blocks, DesignError> {
    check_size(points, 3)?;
    let (blocks, method) = match (points, points % 6) {
        (7, _) => (developed(7, &[&[0, 1, 3]]), Method::Cyclic),
        (13, _) => (developed(13, &[&[0, 1, 4], &[0, 2, 7]]), Method::Cyclic),
        (_, 3) => (bose(points / 6), Method::Bose),
        (_, 1) => (skolem(points / 6), Method::Skolem),
        _ => return Err(DesignError::NoBalancedDesign { points, size: 3 }),
    };
    balanced(Blocks::proven(points, 3, blocks, method)?)
}

fn balanced(built: Blocks) -> Result<Blocks, DesignError> {
    if built.coverage.is_balanced() {
        return Ok(built);
    }
    Err(DesignError::NoBalancedDesign {
        points: built.points,
        size: built.size,
    })
}

/// Base blocks shifted by every number below `points`.
fn developed(points: usize, bases: &[&[usize]]) -> Vec<Vec<usize>> {
    let shifted = |base: &&[usize], by: usize| base.iter().map(|i| (i + by) % points).collect();
    bases
        .iter()
        .flat_map(|base| (0..points).map(move |by| shifted(base, by)))
        .collect()
}

/// Triplets of 6t + 3 points: 2t + 1 columns of three.
fn bose(t: usize) -> Vec<Vec<usize>> {
    let columns = 2 * t + 1;
    let at = |column: usize, level: usize| column + columns * (level % 3);
    let mut blocks: Vec<Vec<usize>> = (0..columns)
        .map(|a| (0..3).map(|level| at(a, level)).collect())
        .collect();
    for b in 0..columns {
        for a in 0..b {
            let between = (a + b) * (t + 1) % columns;
            blocks.extend((0..3).map(|l| vec![at(a, l), at(b, l), at(between, l + 1)]));
        }
    }
    blocks
}

/// Triplets of 6t + 1 points: 2t columns of three and one point more.
fn skolem(t: usize) -> Vec<Vec<usize>> {
    let columns = 2 * t;
    let at = |column: usize, level: usize| column + columns * (level % 3);
    let last = 3 * columns;
    let mut blocks = Vec::new();
    for a in 0..t {
        blocks.push((0..3).map(|level| at(a, level)).collect());
        blocks.extend((0..3).map(|l| vec![last, at(t + a, l), at(a, l + 1)]));
    }
    for b in 0..columns {
        for a in 0..b {
            let sum = (a + b) % columns;
            let between = if sum.is_multiple_of(2) {
                sum / 2
            } else {
                sum / 2 + t
            };
            blocks.extend((0..3).map(|l| vec![at(a, l), at(b, l), at(between, l + 1)]));
        }
    }
    blocks
}

/// Difference sets: samples, size, base block.
const DIFFERENCE_SETS: [(usize, &[usize]); 6] = [
    (7, &[0, 1, 2, 4]),
    (11, &[1, 3, 4, 5, 9]),
    (13, &[0, 1, 3, 9]),
    (21, &[0, 1, 4, 14, 16]),
    (31, &[1, 5, 11, 24, 25, 27]),
    (15, &[0, 1, 2, 4, 5, 8, 10]),
];

/// Sets of `size` in which every pair of `points` samples is together equally often; counted before they are returned.
/// Triplets are Steiner systems; other sizes those of known difference sets, of pairs, of all samples but one, and of all.
///
/// # Errors
///
/// Sizes that cannot be, and those for which no construction is known here: [`covering`] serves them.
///
/// Source: Bose (1939), Ann. Eugen. 9, 353; Baumert (1971), Cyclic Difference Sets, Springer.
pub fn balanced_blocks(points: usize, size: usize) -> Result<Blocks, DesignError> {
    check_size(points, size)?;
    if size == 2 || size + 1 >= points {
        let built = Blocks::proven(points, size, subsets(points, size), Method::AllSubsets)?;
        return balanced(built);
    }
    if size == 3 {
        return steiner_triples(points);
    }
    let known = DIFFERENCE_SETS
        .iter()
        .find(|(n, base)| *n == points && base.len() == size);
    let Some((_, base)) = known else {
        return Err(DesignError::NoBalancedDesign { points, size });
    };
    balanced(Blocks::proven(
        points,
        size,
        developed(points, &[base]),
        Method::Cyclic,
    )?)
}

/// All subsets of two, of all but one, or of all.
fn subsets(points: usize, size: usize) -> Vec<Vec<usize>> {
    if size == points {
        return vec![(0..points).collect()];
    }
    if size == 2 {
        return (0..points)
            .flat_map(|b| (0..b).map(move |a| vec![a, b]))
            .collect();
    }
    (0..points)
        .map(|out| (0..points).filter(|i| *i != out).collect())
        .collect()
}

/// Sets of `size` in which every pair of `points` samples is together at least once, as few as a search of four starts of
/// 400 000 moves from `seed` found, with Schönheim's bound beside them. More sets than the bound may be needed or not.
///
/// # Errors
///
/// Sizes that cannot be: below 2, above the number of samples, or more than 100 samples.
///
/// Source: greedy covering and threshold accepting, Dueck and Scheuer (1990), J. Comput. Phys. 90, 161; docs/decisions/campaigns.md.
pub fn covering(points: usize, size: usize, seed: u64) -> Result<Blocks, DesignError> {
    check_size(points, size)?;
    if let Ok(built) = balanced_blocks(points, size)
        && built.blocks.len() == built.bound
    {
        return Ok(built);
    }
    let bound = schonheim_bound(points, size);
    let mut best = greedy(points, size);
    // Where the search fails by more than a few sets, its time is not worth it: it ends with the first failure.
    while best.len() > bound {
        let fewer = (0..STARTS).find_map(|start| {
            let mut draws = Stream::of(seed, &["covering", &start.to_string()]);
            search(points, size, best.len() - 1, &mut draws)
        });
        match fewer {
            Some(found) => best = found,
            None => break,
        }
    }
    Blocks::proven(points, size, best, Method::Search)
}

/// Sets that each take the pairs not yet together, one sample after the other.
fn greedy(points: usize, size: usize) -> Vec<Vec<usize>> {
    let mut open = vec![vec![true; points]; points];
    let mut blocks = Vec::new();
    loop {
        let next = (0..points).find_map(|a| (0..a).find(|b| open[a][*b]).map(|b| vec![b, a]));
        let Some(mut block) = next else {
            return blocks;
        };
        while block.len() < size {
            let gain = |i: usize| block.iter().filter(|j| open[i][**j]).count();
            let free = (0..points).filter(|i| !block.contains(i));
            // The first of the best.
            let Some(best) = free.max_by_key(|i| (gain(*i), points - i)) else {
                break;
            };
            block.push(best);
        }
        for &a in &block {
            for &b in &block {
                open[a][b] = false;
            }
        }
        blocks.push(block);
    }
}

/// `sets` sets of `size` that hold all pairs, if the search finds them: one sample of one set is exchanged, and a loss of one
/// pair is accepted now and then.
fn search(points: usize, size: usize, sets: usize, draws: &mut Stream) -> Option<Vec<Vec<usize>>> {
    let mut blocks: Vec<Vec<usize>> = Vec::with_capacity(sets);
    let mut counts = vec![vec![0_usize; points]; points];
    for _ in 0..sets {
        let mut block: Vec<usize> = Vec::with_capacity(size);
        while block.len() < size {
            let drawn = draws.below(points);
            if !block.contains(&drawn) {
                block.push(drawn);
            }
        }
        for (i, &a) in block.iter().enumerate() {
            for &b in &block[..i] {
                counts[a][b] += 1;
                counts[b][a] += 1;
            }
        }
        blocks.push(block);
    }
    let mut open = (0..points)
        .flat_map(|b| (0..b).map(move |a| (a, b)))
        .filter(|(a, b)| counts[*a][*b] == 0)
        .count();
    for _ in 0..MOVES {
        if open == 0 {
            return Some(blocks);
        }
        let block = &mut blocks[draws.below(sets)];
        let (place, new) = (draws.below(size), draws.below(points));
        if block.contains(&new) {
            continue;
        }
        let old = block[place];
        let others = || block.iter().copied().filter(|i| *i != old);
        let lost = others().filter(|i| counts[old][*i] == 1).count();
        let won = others().filter(|i| counts[new][*i] == 0).count();
        let accepted = lost <= won || (lost == won + 1 && draws.below(40) == 0);
        if !accepted {
            continue;
        }
        for i in others() {
            counts[old][i] -= 1;
            counts[i][old] -= 1;
            counts[new][i] += 1;
            counts[i][new] += 1;
        }
        block[place] = new;
        open = open + lost - won;
    }
    None
}

/// `sets` of `points` samples shared over `participants` persons: numbers of sets differ by one at most, and samples occur as
/// equally with each person as exchanges of two sets reach. Every set goes to one person: its sets, as indices of sets.
///
/// # Errors
///
/// No set, no person, or more persons than sets.
///
/// Source: docs/decisions/campaigns.md.
pub fn shares(
    points: usize,
    sets: &[Vec<usize>],
    participants: usize,
) -> Result<Vec<Vec<usize>>, DesignError> {
    if sets.is_empty() {
        return Err(DesignError::NoSets);
    }
    let (what, found) = (
        "the number of persons who share the sets",
        participants as f64,
    );
    must(
        what,
        found,
        1.0..=sets.len() as f64,
        "1 up to the number of sets",
    )?;
    let mut owner: Vec<usize> = (0..sets.len())
        .map(|i| i * participants / sets.len())
        .collect();
    let mut counts = vec![vec![0_i64; points]; participants];
    for (set, &of) in sets.iter().zip(&owner) {
        set.iter()
            .filter(|i| **i < points)
            .for_each(|i| counts[of][*i] += 1);
    }
    // An exchange that lowers the sum of squares is made; the sum falls each time, so this ends.
    while let Some((a, b)) = exchange(sets, &owner, &counts) {
        let (first, second) = (owner[a], owner[b]);
        for &i in sets[a].iter().filter(|i| **i < points) {
            counts[first][i] -= 1;
            counts[second][i] += 1;
        }
        for &i in sets[b].iter().filter(|i| **i < points) {
            counts[second][i] -= 1;
            counts[first][i] += 1;
        }
        owner.swap(a, b);
    }
    let of = |person: usize| (0..sets.len()).filter(|i| owner[*i] == person).collect();
    Ok((0..participants).map(of).collect())
}

/// Two sets of two persons whose exchange makes samples more equal.
fn exchange(sets: &[Vec<usize>], owner: &[usize], counts: &[Vec<i64>]) -> Option<(usize, usize)> {
    let gain = |a: usize, b: usize| {
        let (first, second) = (&counts[owner[a]], &counts[owner[b]]);
        let moved = |of: &[usize], not: &[usize], from: &[i64], to: &[i64]| -> i64 {
            of.iter()
                .filter(|i| !not.contains(i) && **i < from.len())
                .map(|i| 2 * (from[*i] - to[*i]) - 2)
                .sum()
        };
        moved(&sets[a], &sets[b], first, second) + moved(&sets[b], &sets[a], second, first)
    };
    (0..sets.len())
        .flat_map(|b| (0..b).map(move |a| (a, b)))
        .find(|(a, b)| owner[*a] != owner[*b] && gain(*a, *b) > 0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steiner_systems_hold_every_pair_once() {
        for points in (3..=63).filter(|n| n % 6 == 1 || n % 6 == 3) {
            let built = steiner_triples(points).unwrap();
            assert_eq!(built.blocks.len(), points * (points - 1) / 6, "{points}");
            assert!(built.coverage.counts.iter().enumerate().all(|(a, row)| {
                row.iter()
                    .enumerate()
                    .all(|(b, n)| *n == usize::from(a != b))
            }));
            assert!(
                built
                    .coverage
                    .presentations
                    .iter()
                    .all(|n| *n == (points - 1) / 2)
            );
        }
        for points in [0, 2, 5, 8, 12, 14, 101] {
            assert!(steiner_triples(points).is_err(), "{points}");
        }
    }

    #[test]
    fn known_designs_are_balanced_and_others_are_refused() {
        for (points, size, sets) in [
            (13, 4, 13),
            (7, 4, 7),
            (11, 5, 11),
            (21, 5, 21),
            (31, 6, 31),
            (15, 7, 15),
            (5, 4, 5),
            (6, 2, 15),
            (4, 4, 1),
        ] {
            let built = balanced_blocks(points, size).unwrap();
            assert!(built.coverage.is_balanced());
            assert_eq!(built.blocks.len(), sets, "{points} {size}");
        }
        assert_eq!(
            balanced_blocks(12, 4),
            Err(DesignError::NoBalancedDesign {
                points: 12,
                size: 4
            })
        );
        assert!(balanced_blocks(3, 4).is_err() && balanced_blocks(5, 1).is_err());
    }

    #[test]
    fn a_wrong_base_block_is_not_taken_for_a_design() {
        let wrong = developed(13, &[&[0, 1, 4], &[0, 2, 6]]);
        assert!(matches!(
            Blocks::proven(13, 3, wrong, Method::Cyclic),
            Err(DesignError::NoBalancedDesign {
                points: 13,
                size: 3
            })
        ));
    }

    #[test]
    fn twelve_samples_in_triplets_take_24_sets() {
        assert_eq!(schonheim_bound(12, 3), 24);
        assert_eq!(schonheim_bound(13, 3), 26);
        let built = covering(12, 3, 1).unwrap();
        assert!(built.coverage.is_complete());
        assert_eq!((built.blocks.len(), built.bound), (24, 24));
        assert_eq!(built, covering(12, 3, 1).unwrap());
        assert!(covering(4, 9, 1).is_err());
    }

    /// The smallest numbers of sets that are known: Gordon, Kuperberg and Patashnik (1995), J. Combin. Des. 3, 269.
    #[test]
    fn small_coverings_are_as_small_as_published() {
        for (size, known) in [
            (3, &[(5, 4), (6, 6), (8, 11), (10, 17), (11, 19)][..]),
            (
                4,
                &[(6, 3), (7, 5), (8, 6), (9, 8), (10, 9), (11, 11), (12, 12)],
            ),
        ] {
            for &(points, sets) in known {
                let built = covering(points, size, 7).unwrap();
                assert!(built.coverage.is_complete());
                assert_eq!(built.blocks.len(), sets, "{points} in sets of {size}");
            }
        }
    }

    #[test]
    fn two_persons_share_26_triplets_equally() {
        let built = steiner_triples(13).unwrap();
        let mut mixed = built.blocks.clone();
        mixed.sort();
        // The largest difference between two samples of one participant, in sets.
        let spread = |sets: &[Vec<usize>], own: &[usize]| {
            let own: Vec<usize> = own.iter().flat_map(|i| sets[*i].clone()).collect();
            let counts = (0..13).map(|i| own.iter().filter(|one| **one == i).count());
            counts.clone().max().unwrap() - counts.min().unwrap()
        };
        for (sets, most) in [(&built.blocks, 0), (&mixed, 2)] {
            let shared = shares(13, sets, 2).unwrap();
            assert_eq!(shared.iter().map(Vec::len).collect::<Vec<_>>(), [13, 13]);
            assert!(
                shared.iter().all(|own| spread(sets, own) <= most),
                "{shared:?}"
            );
            let mut all: Vec<usize> = shared.concat();
            all.sort_unstable();
            assert_eq!(all, (0..26).collect::<Vec<_>>());
        }
        assert!(shares(13, &built.blocks, 0).is_err() && shares(13, &built.blocks, 27).is_err());
    }
}
