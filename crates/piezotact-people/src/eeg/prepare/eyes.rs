//! Eye movements taken out of epochs, by regression on EOG channels or by independent components that follow them.

use piezotact::Warning;
use serde::{Deserialize, Serialize};

use super::{PrepareConfig, PrepareError};
use crate::eeg::clean::{EogRegression, EyeComponents, Ica, IcaConfig};
use crate::eeg::epochs::Epochs;
use crate::eeg::filter::Pass;
use crate::eeg::{EegWarning, IcaFault};

/// Components of signals with slower changes than these describe drifts, Hz.
const SLOWEST_HZ: f64 = 1.0;
/// When the search for components stops.
const MOST_ITERATIONS: usize = 200;
const TOLERANCE: f64 = 1e-4;

/// Components that follow the eyes by this share of what is asked for have to settle; others may be of noise, which has none of its own.
const NEARLY: f64 = 0.5;

/// How the part of eye movements in the electrodes is found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum EyeMethod {
    /// By regression on the EOG channels.
    #[default]
    Regression,
    /// By independent components that follow the EOG channels.
    Components(IndependentComponents),
}

impl EyeMethod {
    pub(super) fn is_regression(&self) -> bool {
        *self == Self::Regression
    }
}

/// Which independent components are eye movements.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct IndependentComponents {
    /// How many are looked for.
    pub components: usize,
    /// The seed of the first directions.
    pub seed: u64,
    /// The least correlation with an EOG channel of those that are taken out, 0–1.
    pub least_correlation: f64,
}

/// Epochs of the electrodes alone.
pub(super) struct Cleaned {
    pub(super) epochs: Epochs,
    pub(super) components: Option<EyeComponents>,
    pub(super) warnings: Vec<Warning>,
}

/// `epochs` of the electrodes named, without eye movements where EOG channels are stated.
pub(super) fn without_eyes(
    epochs: &Epochs,
    config: &PrepareConfig,
    electrodes: &[String],
) -> Result<Cleaned, PrepareError> {
    let names: Vec<&str> = electrodes.iter().map(String::as_str).collect();
    let eog: Vec<&str> = config.eog.iter().map(String::as_str).collect();
    let of = |epochs| Cleaned {
        epochs,
        components: None,
        warnings: Vec::new(),
    };
    match config.eyes {
        _ if eog.is_empty() => Ok(of(epochs.picked(&names)?)),
        EyeMethod::Regression => {
            let regression = EogRegression::fit(epochs, &eog, &names)?;
            Ok(of(regression.apply(epochs)?.picked(&names)?))
        }
        EyeMethod::Components(asked) => {
            let fit = IcaConfig {
                components: asked.components,
                max_iterations: MOST_ITERATIONS,
                tolerance: TOLERANCE,
                seed: asked.seed,
            };
            let ica = Ica::fit(epochs, &names, &fit)?;
            let found = ica.beside_eyes(epochs, &eog, asked.least_correlation)?;
            let clean = ica.without(epochs, &found.taken_out())?.picked(&names)?;
            let mut warnings = warnings(config, &asked, &found);
            let all = found.components.iter().zip(ica.changes());
            let settled = all
                .filter(|(one, _)| one.correlation.abs() >= NEARLY * asked.least_correlation)
                .all(|(_, change)| *change <= TOLERANCE);
            warnings.extend(ica.not_converged().filter(|_| !settled));
            warnings.extend(ica.warnings);
            Ok(Cleaned {
                epochs: clean,
                components: Some(found),
                warnings,
            })
        }
    }
}

fn warnings(
    config: &PrepareConfig,
    asked: &IndependentComponents,
    found: &EyeComponents,
) -> Vec<Warning> {
    let mut warnings = Vec::new();
    let is_fast = |pass: &Pass| matches!(pass, Pass::Above(hz) if *hz >= SLOWEST_HZ);
    if !config.filters.iter().any(is_fast) {
        let wanted_hz = SLOWEST_HZ;
        warnings.push(
            EegWarning::Ica {
                fault: IcaFault::NoHighPass { wanted_hz },
            }
            .into(),
        );
    }
    let all = found.components.iter();
    let strongest = all.max_by(|a, b| a.correlation.abs().total_cmp(&b.correlation.abs()));
    if let (true, Some(strongest)) = (found.taken_out().is_empty(), strongest) {
        let warning = EegWarning::Ica {
            fault: IcaFault::NoEyeComponent {
                eog: strongest.eog.clone(),
                correlation: strongest.correlation.abs(),
                wanted: asked.least_correlation,
            },
        };
        warnings.push(warning.into());
    }
    warnings
}
