//! Epochs of a recording and their averages, as a document.

mod page;

use piezotact::Warning;
use piezotact::document::Content;
use piezotact::quantity::SampleRate;
use serde::{Deserialize, Serialize};

use super::clean::EyeComponents;
use super::epochs::Epochs;
use super::prepare::{EpochCounts, PrepareConfig, Prepared};
use super::source::Subject;

pub(in crate::eeg) use page::drawn_channels;

/// The average of the epochs of one condition.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Evoked {
    /// The condition.
    pub condition: String,
    /// Of how many epochs.
    pub epochs: usize,
    /// For each channel, the mean at each time, V.
    pub mean_v: Vec<Vec<f64>>,
    /// For each channel, the standard error of the mean at each time, V; 0 for one epoch.
    pub error_v: Vec<Vec<f64>>,
}

/// Epochs of a recording, counted and averaged.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct EegEpochs {
    /// The file.
    pub file: String,
    /// Who and what it is of.
    pub subject: Subject,
    /// How epochs were made.
    pub config: PrepareConfig,
    /// The rate.
    pub rate_hz: SampleRate,
    /// The electrodes.
    pub channels: Vec<String>,
    /// Which markers have an epoch.
    pub counts: EpochCounts,
    /// The independent components, where eye movements were taken out by them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub eye_components: Option<EyeComponents>,
    /// The times from the marker, s.
    pub times_s: Vec<f64>,
    /// The part of epochs whose mean was taken away from each signal before averaging, s; absent where epochs begin at the marker.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub baseline_s: Option<[f64; 2]>,
    /// The average of each condition.
    pub evoked: Vec<Evoked>,
    /// What to know before relying on it.
    #[serde(alias = "doubts")]
    pub warnings: Vec<Warning>,
}

impl Content for EegEpochs {
    const SCHEMA: &'static str = "eeg_epochs";
}

/// The averages of `prepared` by condition, V, each epoch less its mean before the marker.
///
/// Formula: mean and standard error s/√n over epochs at each sample.
///
/// Source: S. J. Luck (2014), *An Introduction to the Event-Related Potential Technique*, 2nd ed., chapter 8.
///
/// # Errors
/// None: `prepared` has epochs of each condition.
#[must_use]
pub fn evoked(file: &str, subject: &Subject, prepared: &Prepared) -> EegEpochs {
    let epochs = &prepared.epochs;
    let times_s: Vec<f64> = (0..epochs.samples()).map(|i| epochs.time_s(i)).collect();
    let before = times_s.partition_point(|t| *t <= 0.0);
    let has_baseline = before > 1 && before < times_s.len();
    let before = if has_baseline { before } else { 0 };
    let conditions = prepared.counts.conditions.iter();
    EegEpochs {
        file: file.to_owned(),
        subject: subject.clone(),
        config: prepared.config.clone(),
        rate_hz: prepared.rate(),
        channels: epochs.channels().to_vec(),
        counts: prepared.counts.clone(),
        eye_components: prepared.eye_components.clone(),
        baseline_s: has_baseline.then(|| [times_s[0], times_s[before - 1]]),
        evoked: conditions
            .map(|count| averaged(epochs, &count.condition, before))
            .collect(),
        times_s,
        warnings: prepared.warnings.clone(),
    }
}

fn averaged(epochs: &Epochs, condition: &str, before: usize) -> Evoked {
    let own: Vec<usize> = (0..epochs.count())
        .filter(|epoch| epochs.conditions()[*epoch] == condition)
        .collect();
    let n = own.len() as f64;
    let (mut mean_v, mut error_v) = (Vec::new(), Vec::new());
    for channel in 0..epochs.channels().len() {
        let (mut sums, mut squares) = (vec![0.0; epochs.samples()], vec![0.0; epochs.samples()]);
        let levels: Vec<f64> = own
            .iter()
            .map(|epoch| level(&epochs.signal(channel, *epoch)[..before]))
            .collect();
        for (epoch, level) in own.iter().zip(&levels) {
            for (sum, value) in sums.iter_mut().zip(epochs.signal(channel, *epoch)) {
                *sum += (value - level) / n;
            }
        }
        for (epoch, level) in own.iter().zip(&levels) {
            let signal = epochs.signal(channel, *epoch).iter().zip(&sums);
            for (square, (value, mean)) in squares.iter_mut().zip(signal) {
                *square += (value - level - mean).powi(2);
            }
        }
        let error = |square: &f64| match own.len() {
            0 | 1 => 0.0,
            _ => (square / (n - 1.0) / n).sqrt(),
        };
        error_v.push(squares.iter().map(error).collect());
        mean_v.push(sums);
    }
    Evoked {
        condition: condition.to_owned(),
        epochs: own.len(),
        mean_v,
        error_v,
    }
}

/// The mean, or 0 of nothing.
fn level(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn averages_have_their_error() {
        let rate = SampleRate::new(10.0).unwrap();
        // Two epochs of 4 samples from −0.1 s on: a step of 1 and of 3 V at the marker's next sample, on levels of 5 and 7 V.
        let volts = vec![5.0, 5.0, 6.0, 6.0, 7.0, 7.0, 10.0, 10.0];
        let conditions = vec!["a".to_owned(), "a".to_owned()];
        let epochs = Epochs::new(vec!["C3".into()], conditions, rate, -0.1, volts).unwrap();
        let found = averaged(&epochs, "a", 2);
        assert_eq!(found.mean_v, [[0.0, 0.0, 2.0, 2.0]]);
        assert_eq!(found.error_v, [[0.0, 0.0, 1.0, 1.0]]);
    }
}
