//! Inter-trial coherence: how alike the phase of epochs is.

use std::f64::consts::PI;

use piezotact::Doubt;
use piezotact::fourier::Complex;

use super::EegDoubt;
use super::epochs::Epochs;
use super::tfr::{Method, Sink, TfrError, TfrPlan};

/// Below so many epochs the coherence of random phases is above 0.16.
const ENOUGH: usize = 30;

/// Inter-trial coherence, 0–1.
#[derive(Clone, Debug, PartialEq)]
pub struct Coherence {
    /// The names of the channels.
    pub channels: Vec<String>,
    /// The frequencies, Hz.
    pub frequencies_hz: Vec<f64>,
    /// The times from the event, s.
    pub times_s: Vec<f64>,
    /// The temporal smear at each frequency, s.
    pub smears_s: Vec<f64>,
    /// How many epochs it is of.
    pub epochs: usize,
    /// Channels × frequencies × times, 0–1.
    pub values: Vec<f64>,
    /// What random phases have on average.
    pub expected_of_chance: f64,
    /// What to know before relying on it.
    pub doubts: Vec<Doubt>,
}

/// The inter-trial coherence of `epochs`, channels × frequencies × times, 0–1: the length of the mean of z/|z| over epochs.
///
/// Formula: |Σ z/|z||/n. Random phases have √(π/4n) on average, so conditions with unequal numbers of epochs are not comparable.
///
/// Source: C. Tallon-Baudry et al. (1996), J. Neurosci. 16; as MNE-Python's `tfr_array_morlet(output="itc")`.
///
/// # Errors
/// [`PhaseError`] for fewer than two epochs, for which it is 1 whatever they hold, for a plan of multitapers, and for epochs of another
/// rate or length than planned.
pub fn inter_trial_coherence(plan: &TfrPlan, epochs: &Epochs) -> Result<Coherence, PhaseError> {
    let count = epochs.count();
    if count < 2 {
        return Err(PhaseError::FewEpochs { found: count });
    }
    if plan.config().method != Method::Morlet {
        return Err(TfrError::PhaseOfTapers.into());
    }
    let times = plan.times();
    let frequencies = plan.config().frequencies_hz.len();
    let mut sink = PhaseSink {
        frequencies,
        times,
        sums: vec![Complex::default(); epochs.channels().len() * frequencies * times],
    };
    plan.run(epochs, &mut sink)?;
    let expected_of_chance = (PI / (4.0 * count as f64)).sqrt();
    let doubt = EegDoubt::CoherenceFloor {
        epochs: count,
        expected: expected_of_chance,
    };
    let step = plan.config().decimation;
    Ok(Coherence {
        channels: epochs.channels().to_vec(),
        frequencies_hz: plan.config().frequencies_hz.clone(),
        times_s: (0..times).map(|i| epochs.time_s(i * step)).collect(),
        smears_s: plan.smears_s().to_vec(),
        epochs: count,
        values: sink
            .sums
            .iter()
            .map(|sum| sum.norm() / count as f64)
            .collect(),
        expected_of_chance,
        doubts: (count < ENOUGH).then(|| doubt.into()).into_iter().collect(),
    })
}

struct PhaseSink {
    frequencies: usize,
    times: usize,
    sums: Vec<Complex<f64>>,
}

impl Sink for PhaseSink {
    fn take(&mut self, channel: usize, _: usize, frequency: usize, z: &[Complex<f64>], _: f64) {
        let start = (channel * self.frequencies + frequency) * self.times;
        for (sum, value) in self.sums[start..start + self.times].iter_mut().zip(z) {
            let length = value.norm();
            // A signal of zeros has no phase, and adds none.
            if length > 0.0 {
                *sum += value / length;
            }
        }
    }
}

/// A coherence that cannot be.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PhaseError {
    /// A single epoch.
    #[error(
        "expected at least 2 epochs, found {found}: the coherence of a single one is always 1; give more epochs"
    )]
    FewEpochs {
        /// How many.
        found: usize,
    },
    /// The plan or the epochs.
    #[error(transparent)]
    Tfr(#[from] TfrError),
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::eeg::tfr::TfrConfig;
    use piezotact::quantity::SampleRate;
    use piezotact::statistics::random::Random;

    #[test]
    fn one_phase_is_coherent_and_random_phases_are_not() {
        let rate = SampleRate::new(100.0).unwrap();
        let mut random = Random::stream(5, 0, "phases");
        let count = 200;
        let mut volts = Vec::new();
        for locked in [1.0, 0.0] {
            for _ in 0..count {
                let phase = (1.0 - locked) * std::f64::consts::TAU * random.uniform();
                volts.extend((0..200).map(|i| (0.2 * PI * f64::from(i) + phase).sin()));
            }
        }
        let names = vec!["locked".to_owned(), "random".to_owned()];
        let epochs = Epochs::new(names, vec!["a".into(); count], rate, 0.0, volts).unwrap();
        let config = TfrConfig {
            method: Method::Morlet,
            frequencies_hz: vec![10.0],
            cycles: vec![4.0],
            decimation: 50,
        };
        let plan = TfrPlan::plan(&config, rate, 200).unwrap();
        let found = inter_trial_coherence(&plan, &epochs).unwrap();
        assert!(found.values[..4].iter().all(|v| (v - 1.0).abs() < 1e-12));
        assert!(
            found.values[4..]
                .iter()
                .all(|v| *v < 4.0 * found.expected_of_chance)
        );
        assert!(found.doubts.is_empty());
        let one = Epochs::new(
            vec!["a".into()],
            vec!["a".into()],
            rate,
            0.0,
            vec![1.0; 200],
        )
        .unwrap();
        assert_eq!(
            inter_trial_coherence(&plan, &one),
            Err(PhaseError::FewEpochs { found: 1 })
        );
    }
}
