use super::*;
use piezotact::statistics::random::Random;

/// People with noise at nodes of a chain of channels, and an effect at a part of them.
fn study(seed: u64, people: usize, grid: &Grid, effect: f64) -> Vec<Vec<f64>> {
    let mut random = Random::stream(seed, 0, "cluster study");
    let node = |i: usize| {
        let [channel, _, time] = grid.place(i);
        if channel < 3 && (3..9).contains(&time) {
            effect
        } else {
            0.0
        }
    };
    (0..people)
        .map(|_| {
            (0..grid.nodes())
                .map(|i| node(i) + random.normal())
                .collect()
        })
        .collect()
}

fn chain(channels: usize, frequencies: usize, times: usize) -> Grid {
    let pairs: Vec<[usize; 2]> = (1..channels).map(|c| [c - 1, c]).collect();
    Grid::new(channels, frequencies, times, &pairs).unwrap()
}

/// The same by a search that knows nothing of union and find, for every flip.
fn plain(people: &[Vec<f64>], grid: &Grid, threshold_t: f64) -> (Vec<f64>, Vec<f64>) {
    let n = people.len();
    let masses = |signs: usize| {
        let flipped: Vec<Vec<f64>> = people
            .iter()
            .enumerate()
            .map(|(i, p)| {
                let sign = if signs >> i & 1 == 1 { -1.0 } else { 1.0 };
                p.iter().map(|v| sign * v).collect()
            })
            .collect();
        let rows: Vec<&[f64]> = flipped.iter().map(Vec::as_slice).collect();
        let t = statistics(&rows, grid.nodes());
        let mut left: Vec<usize> = (0..t.len()).filter(|i| t[*i].abs() > threshold_t).collect();
        let mut masses = Vec::new();
        while let Some(start) = left.pop() {
            let (mut open, mut mass) = (vec![start], 0.0);
            while let Some(node) = open.pop() {
                mass += t[node];
                let near = |a: usize, b: usize| {
                    let (mut joined, high, low) = (false, a.max(b), a.min(b));
                    grid.for_each_lower(high, |other| joined |= other == low);
                    joined
                };
                let (with, without): (Vec<usize>, Vec<usize>) = left
                    .iter()
                    .partition(|other| near(**other, node) && t[**other] * t[node] > 0.0);
                open.extend(with);
                left = without;
            }
            masses.push(mass);
        }
        masses
    };
    let chance = (0..1 << (n - 1))
        .map(|signs| {
            masses(2 * signs)
                .into_iter()
                .map(f64::abs)
                .fold(0.0, f64::max)
        })
        .collect();
    (masses(0), chance)
}

#[test]
fn clusters_are_those_of_a_plain_search() {
    let grid = chain(5, 2, 12);
    for seed in 0..4 {
        let people = study(seed, 7, &grid, 0.8);
        let config = ClusterConfig::two_sided(7, 1000, 1).unwrap();
        let found = test(&people, &grid, &config).unwrap();
        let (masses, chance) = plain(&people, &grid, config.threshold_t);
        assert_eq!((found.flips, found.tried), (64, Tried::All));
        let mut expected = masses;
        expected.sort_by(|a, b| b.abs().total_cmp(&a.abs()));
        assert_eq!(found.clusters.len(), expected.len());
        for (cluster, mass) in found.clusters.iter().zip(expected) {
            assert!((cluster.mass - mass).abs() < 1e-9);
            let larger = chance.iter().filter(|c| **c >= mass.abs() - 1e-9).count();
            assert!((cluster.p_value - larger as f64 / 64.0).abs() < 1e-12);
        }
    }
}

#[test]
fn the_order_of_people_and_conditions_changes_nothing() {
    let grid = chain(4, 2, 10);
    for (people, flips) in [(8, 1000), (14, 300)] {
        let values = study(3, people, &grid, 0.7);
        let config = ClusterConfig::two_sided(people, flips, 7).unwrap();
        let found = test(&values, &grid, &config).unwrap();
        assert!(!found.clusters.is_empty());
        let mut turned = values.clone();
        turned.reverse();
        turned.swap(1, 4);
        assert_eq!(test(&turned, &grid, &config).unwrap(), found);
        let negative: Vec<Vec<f64>> = values
            .iter()
            .map(|p| p.iter().map(|v| -v).collect())
            .collect();
        let back = test(&negative, &grid, &config).unwrap();
        assert_eq!(back.chance, found.chance);
        for (a, b) in back.clusters.iter().zip(&found.clusters) {
            assert_eq!(
                (-a.mass, a.p_value, &a.nodes),
                (b.mass, b.p_value, &b.nodes)
            );
        }
    }
}

#[test]
fn one_direction_has_twice_as_many_flips() {
    let grid = chain(4, 1, 10);
    let people = study(5, 6, &grid, 1.5);
    let both = ClusterConfig::two_sided(6, 1000, 1).unwrap();
    let of = |tail| test(&people, &grid, &ClusterConfig { tail, ..both }).unwrap();
    let (positive, negative) = (of(Tail::Positive), of(Tail::Negative));
    assert_eq!((positive.flips, of(Tail::Both).flips), (64, 32));
    assert!(positive.clusters.iter().all(|c| c.mass > 0.0));
    assert!(negative.clusters.iter().all(|c| c.mass < 0.0));
    // The observed signs alone: 1 of 64.
    assert!((positive.clusters[0].p_value - 1.0 / 64.0).abs() < 1e-12);
}

#[test]
fn few_people_are_reported_and_constant_nodes_are_none() {
    let grid = chain(2, 1, 4);
    let mut people = study(6, 4, &grid, 3.0);
    for person in &mut people {
        person[0] = 0.7;
    }
    let config = ClusterConfig::two_sided(4, 100, 1).unwrap();
    let found = test(&people, &grid, &config).unwrap();
    assert_eq!(found.t[0], 0.0);
    assert_eq!(found.warnings.len(), 1);
    assert!(found.clusters.iter().all(|c| c.p_value >= 0.125 - 1e-12));
}

#[test]
fn what_cannot_be_is_refused() {
    let grid = chain(2, 1, 4);
    let people = study(7, 5, &grid, 0.0);
    let config = ClusterConfig::two_sided(5, 100, 1).unwrap();
    assert!(test(&people[..1], &grid, &config).is_err());
    let mut short = people.clone();
    short[2].pop();
    assert!(matches!(
        test(&short, &grid, &config),
        Err(ClusterError::Shape { found, .. }) if found.ends_with("of person 2 (from 0)")
    ));
    let mut broken = people.clone();
    broken[1][3] = f64::NAN;
    assert!(matches!(
        test(&broken, &grid, &config),
        Err(ClusterError::NotFinite { person: 1 })
    ));
    let zero = ClusterConfig {
        threshold_t: 0.0,
        ..config
    };
    assert!(test(&people, &grid, &zero).is_err());
    assert!(test(&people, &grid, &ClusterConfig { flips: 0, ..config }).is_err());
    assert!(ClusterConfig::two_sided(1, 1, 1).is_none());
    assert!(differences(&people, &short).is_err());
    assert!(Grid::new(0, 1, 1, &[]).is_err() && Grid::new(2, 1, 1, &[[0, 2]]).is_err());
}
