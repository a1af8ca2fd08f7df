//! Signals of electrodes that are computed from those of the others.

use crate::eeg::{EegWarning, ElectrodesFault};
use piezotact::Warning;

use super::{PrepareConfig, PrepareError};
use crate::eeg::epochs::{Epochs, EpochsError};
use crate::eeg::reference::{Interpolation, Montage};

/// From fewer electrodes nothing is interpolated.
const FEWEST: usize = 8;

/// `epochs` with the electrodes that `config` has interpolated, by spherical splines from those whose position is known; all in `order`.
pub(super) fn interpolated(
    epochs: Epochs,
    config: &PrepareConfig,
    order: &[String],
    measured: Option<&Montage>,
    warnings: &mut Vec<Warning>,
) -> Result<Epochs, PrepareError> {
    let wanted = &config.interpolated;
    if wanted.is_empty() {
        return Ok(epochs);
    }
    let positions = |names: &[String]| match measured {
        None => Montage::known(names),
        Some(montage) => montage.of(names),
    };
    let without = |name: &String| EpochsError::NoPosition { name: name.clone() };
    let targets = wanted.iter().zip(positions(wanted));
    let targets: Vec<[f64; 3]> = targets
        .map(|(name, position)| position.ok_or_else(|| without(name)))
        .collect::<Result<_, _>>()?;
    let own = epochs.channels();
    let known: Vec<(usize, [f64; 3])> = positions(own)
        .into_iter()
        .enumerate()
        .filter_map(|(at, position)| Some((at, position?)))
        .collect();
    if known.len() < FEWEST {
        return Err(PrepareError::FewForInterpolation {
            names: wanted.join(", "),
            found: known.len(),
            needed: FEWEST,
        });
    }
    let names = known.iter().map(|(at, _)| own[*at].clone()).collect();
    let montage = Montage::new(names, known.iter().map(|(_, p)| *p).collect())?;
    let plan = Interpolation::plan(&montage, &targets)?;
    let there = |name: &&String| own.contains(name) || wanted.contains(name);
    let all: Vec<String> = order.iter().filter(there).cloned().collect();
    let mut weights = vec![0.0; all.len() * own.len()];
    for (name, row) in all.iter().zip(weights.chunks_exact_mut(own.len())) {
        if let Some(at) = own.iter().position(|one| one == name) {
            row[at] = 1.0;
        } else if let Some(at) = wanted.iter().position(|one| one == name) {
            let sums = &plan.weights()[at * known.len()..(at + 1) * known.len()];
            for ((at, _), weight) in known.iter().zip(sums) {
                row[*at] = *weight;
            }
        }
    }
    warnings.push(
        EegWarning::Electrodes {
            names: wanted.join(", "),
            fault: ElectrodesFault::Interpolated {
                from: known.len(),
                share: wanted.len() as f64 / all.len() as f64,
            },
        }
        .into(),
    );
    warnings.extend(plan.warnings);
    Ok(epochs.mixed(all, &weights))
}
