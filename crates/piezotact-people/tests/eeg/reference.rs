//! Against `reference/eeg.npz` beside the checkout (MNE-Python 1.13.2).

use piezotact::quantity::SampleRate;
use piezotact_people::eeg::cluster::{self, ClusterConfig, Grid, Tail, Tried};
use piezotact_people::eeg::tfr::{TfrConfig, TfrPlan};

use super::{assert_relative, epochs, names};
use crate::shared_data::shared;

pub(super) struct Npz(zip::ZipArchive<std::fs::File>);

impl Npz {
    pub(super) fn open() -> Option<Self> {
        let file = std::fs::File::open(shared("reference/eeg.npz")?).unwrap();
        Some(Self(zip::ZipArchive::new(file).unwrap()))
    }

    fn read<T: npyz::Deserialize>(&mut self, key: &str) -> Vec<T> {
        let file = self.0.by_name(&format!("{key}.npy")).unwrap();
        npyz::NpyFile::new(file).unwrap().into_vec().unwrap()
    }

    /// The people, channels × times each, the grid and the threshold of the cluster test.
    pub(super) fn cluster(&mut self) -> (Vec<Vec<f64>>, Grid, ClusterConfig) {
        let (people, times, channels) = (10, 100, 64);
        let x: Vec<f64> = self.read("clus_X");
        let people: Vec<Vec<f64>> = x
            .chunks(times * channels)
            .take(people)
            .map(|one| turned(one, times, channels))
            .collect();
        let adjacency: Vec<bool> = self.read("adjacency");
        let pairs: Vec<[usize; 2]> = (0..channels * channels)
            .filter(|i| adjacency[*i])
            .map(|i| [i / channels, i % channels])
            .collect();
        let config = ClusterConfig {
            threshold_t: self.read::<f64>("threshold")[0],
            tail: Tail::Both,
            flips: 1000,
            seed: 1,
        };
        (
            people,
            Grid::new(channels, 1, times, &pairs).unwrap(),
            config,
        )
    }
}

/// Rows × columns as columns × rows.
fn turned(values: &[f64], rows: usize, columns: usize) -> Vec<f64> {
    (0..columns)
        .flat_map(|column| (0..rows).map(move |row| values[row * columns + column]))
        .collect()
}

#[test]
fn morlet_power_is_that_of_mne() {
    let Some(mut npz) = Npz::open() else {
        return;
    };
    let (count, channels, samples) = (4, 3, 2000);
    let eeg: Vec<f64> = npz.read("eeg");
    let volts: Vec<f64> = (0..channels)
        .flat_map(|c| (0..count).map(move |e| e * channels + c))
        .flat_map(|signal| eeg[signal * samples..(signal + 1) * samples].to_vec())
        .collect();
    let given = epochs(&names(&["C3", "Cz", "C4"]), count, 1000.0, 0.0, volts);
    let config = TfrConfig {
        frequencies_hz: npz.read("freqs"),
        cycles: npz.read("n_cycles"),
        decimation: 5,
    };
    let plan = TfrPlan::plan(&config, SampleRate::new(1000.0).unwrap(), samples).unwrap();
    let found = plan.average(&given).unwrap();
    let expected: Vec<f64> = npz.read("avg_power");
    // MNE transforms in another length, and the weakest power is 1e-4 of the strongest.
    assert_relative("Morlet power", &found.values, &expected, 1e-9);
    // Cycles are half the frequency: one standard deviation for all, 1/(4π) s.
    let sd = 1.0 / (4.0 * std::f64::consts::PI);
    assert!(
        plan.smears_s()
            .iter()
            .all(|smear| (smear - sd).abs() < 1e-12)
    );
}

#[test]
fn clusters_are_those_of_mne() {
    let Some(mut npz) = Npz::open() else {
        return;
    };
    let (people, grid, config) = npz.cluster();
    let found = cluster::test(&people, &grid, &config).unwrap();
    let expected = turned(&npz.read::<f64>("clus_t"), 100, 64);
    // t is small where people's mean is: relative to the largest there.
    super::assert_near("cluster t", &found.t, &expected, 1e-10);
    let (count, sizes): (Vec<i64>, Vec<i64>) = (npz.read("n_clusters"), npz.read("clus_size"));
    let (p, masses): (Vec<f64>, Vec<f64>) = (npz.read("clus_p"), npz.read("clus_mass"));
    assert_eq!(found.clusters.len() as i64, count[0]);
    assert_eq!((found.flips, found.tried), (512, Tried::All));
    for ((p, mass), size) in p.iter().zip(masses).zip(sizes) {
        let same = found
            .clusters
            .iter()
            .find(|c| (c.mass - mass).abs() <= 1e-9 * mass.abs());
        let same = same.unwrap_or_else(|| panic!("no cluster of mass {mass}"));
        assert_eq!(same.nodes.len() as i64, size, "{mass}");
        assert_eq!(same.p_value, *p, "{mass}");
    }
}
