//! EEG: single-trial power in windows, and clusters over people.

use std::path::Path;

use anyhow::Result;
use piezotact::quantity::{Band, Hertz};
use piezotact_people::eeg::cluster::{self, ClusterConfig, Grid, Tail};
use piezotact_people::eeg::epochs::Epochs;
use piezotact_people::eeg::tfr::{TfrConfig, TfrPlan, Window};

use super::{Prepared, load, rate};

const CHANNELS: usize = 64;
const EPOCHS: usize = 100;
const SAMPLES: usize = 2000;

/// The mean power of each of 100 trials of 2 s at 1 kHz, 64 channels, in two windows of 8 to 12 Hz: Morlet wavelets at 4 to 40 Hz.
pub(super) fn e1(folder: &Path) -> Result<Prepared> {
    let volts = load(folder, "E1")?;
    let input_bytes = volts.len() * 8;
    let channels = (0..CHANNELS).map(|at| format!("E{at}")).collect();
    let conditions = vec!["task".to_owned(); EPOCHS];
    let epochs = Epochs::new(channels, conditions, rate(1000.0)?, 0.0, volts)?;
    let frequencies_hz: Vec<f64> = (4..41).map(f64::from).collect();
    let config = TfrConfig {
        cycles: frequencies_hz.iter().map(|hz| hz / 2.0).collect(),
        frequencies_hz,
        decimation: 1,
    };
    let band = Band::new(Hertz(8.0), Hertz(12.0))?;
    let windows = [[0.2, 0.7], [0.8, 1.3]].map(|extent_s| Window { band, extent_s });
    let rate = rate(1000.0)?;
    Ok(Prepared {
        input_bytes,
        work: Box::new(move || {
            let plan = TfrPlan::plan(&config, rate, SAMPLES)?;
            Ok(plan.trials(&epochs, &windows)?.values)
        }),
    })
}

/// Clusters over 100 times and 64 sensors of 10 people, all 512 sign flips; the sensors are a square of 8 by 8.
pub(super) fn e2(folder: &Path) -> Result<Prepared> {
    const TIMES: usize = 100;
    const SIDE: usize = 8;
    let values = load(folder, "E2")?;
    let input_bytes = values.len() * 8;
    let people: Vec<Vec<f64>> = values
        .chunks_exact(CHANNELS * TIMES)
        .map(<[f64]>::to_vec)
        .collect();
    let beside = (0..CHANNELS).flat_map(|at| {
        let right = (at % SIDE + 1 < SIDE).then_some([at, at + 1]);
        let below = (at + SIDE < CHANNELS).then_some([at, at + SIDE]);
        [right, below].into_iter().flatten()
    });
    let grid = Grid::new(CHANNELS, 1, TIMES, &beside.collect::<Vec<_>>())?;
    let config = ClusterConfig {
        threshold_t: 2.262_157,
        tail: Tail::Both,
        flips: 1000,
        seed: 1,
    };
    Ok(Prepared {
        input_bytes,
        work: Box::new(move || {
            let found = cluster::test(&people, &grid, &config)?;
            // The largest masses first, as the order of equals is nobody's.
            let mut masses: Vec<f64> = found.clusters.iter().map(|one| one.mass.abs()).collect();
            masses.sort_by(|one, other| other.total_cmp(one));
            masses.truncate(20);
            let ps = found.clusters.iter().map(|one| one.p_value);
            let smallest = ps.fold(1.0, f64::min);
            Ok([found.t, masses, vec![smallest]].concat())
        }),
    })
}
