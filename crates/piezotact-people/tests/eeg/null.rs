//! Studies without an effect find a cluster in 5 % of cases.

use piezotact::statistics::random::Random;
use piezotact_people::eeg::cluster::{self, ClusterConfig, Grid};
use piezotact_people::eeg::reference::Montage;

use super::names;

/// Channels around both hands' areas × 3 frequencies × 12 times.
fn grid() -> Grid {
    let channels = [
        "FC3", "C3", "CP3", "C5", "C1", "FC4", "C4", "CP4", "C6", "C2",
    ];
    let montage = Montage::ten_ten(&names(&channels)).unwrap();
    Grid::new(channels.len(), 3, 12, &montage.neighbours(30.0)).unwrap()
}

/// The share of studies of `people` with a cluster of p ≤ 0.05.
fn found_share(studies: u64, people: usize, flips: usize) -> f64 {
    let grid = grid();
    let config = ClusterConfig::two_sided(people, flips, 11).unwrap();
    let found = (0..studies).filter(|study| {
        let mut random = Random::stream(2024, *study, "null study");
        let values: Vec<Vec<f64>> = (0..people)
            .map(|_| {
                // Neighbouring times are alike, as those of wavelets are.
                let mut last = 0.0;
                (0..grid.nodes())
                    .map(|_| {
                        last = 0.6 * last + 0.8 * random.normal();
                        last
                    })
                    .collect()
            })
            .collect();
        let test = cluster::test(&values, &grid, &config).unwrap();
        test.clusters.iter().any(|cluster| cluster.p_value <= 0.05)
    });
    let share = found.count() as f64 / studies as f64;
    println!(
        "{studies} studies of {people} people, {flips} flips: {:.1} %",
        100.0 * share
    );
    share
}

/// 5 % of 100 studies; the standard error is 2.2 %, and three of them are allowed.
#[test]
fn few_null_studies_find_a_cluster() {
    assert!(found_share(100, 10, 1000) < 0.12);
}

/// 5 ± 2 %: two standard errors of 500 studies.
#[test]
#[ignore = "1000 studies take some seconds in release mode: ./x soak null_studies"]
fn soak_null_studies_find_a_cluster_in_five_percent() {
    assert!((found_share(500, 10, 1000) - 0.05).abs() <= 0.02);
    // So many people that flips are drawn.
    assert!((found_share(500, 16, 500) - 0.05).abs() <= 0.02);
}
