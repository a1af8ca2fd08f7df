//! Regression on the electro-oculogram.

use crate::eeg::epochs::{Epochs, EpochsError};
use crate::eeg::linear::inverse;

/// How much of each EOG channel is in each EEG channel.
#[derive(Clone, Debug, PartialEq)]
pub struct EogRegression {
    channels: Vec<String>,
    eog: Vec<String>,
    coefficients: Vec<f64>,
}

impl EogRegression {
    /// The coefficients of `eog` channels in `channels`, from epochs whose mean is taken away from each signal. Fit on epochs that hold blinks
    /// and little of what is studied, with the reference that they will be used with.
    ///
    /// Formula: least squares, (E·Eᵀ)⁻¹·E·x over all epochs and samples.
    ///
    /// Source: G. Gratton, M. G. H. Coles and E. Donchin (1983), Electroencephalogr. Clin. Neurophysiol. 55; as MNE-Python's `EOGRegression`.
    ///
    /// # Errors
    /// [`EpochsError`] without a channel, for a name that no channel has or that stands in both lists, or EOG channels that are constant
    /// or multiples of each other.
    pub fn fit(epochs: &Epochs, eog: &[&str], channels: &[&str]) -> Result<Self, EpochsError> {
        if eog.is_empty() || channels.is_empty() {
            return Err(EpochsError::NoEog);
        }
        if let Some(name) = channels.iter().find(|name| eog.contains(name)) {
            return Err(EpochsError::Both {
                name: (*name).to_owned(),
            });
        }
        let centred = |indices: Vec<usize>| -> Vec<Vec<f64>> {
            indices
                .into_iter()
                .map(|channel| {
                    let signals = epochs.channel(channel).chunks_exact(epochs.samples());
                    signals
                        .flat_map(|signal| {
                            let mean = signal.iter().sum::<f64>() / signal.len() as f64;
                            signal.iter().map(move |v| v - mean)
                        })
                        .collect()
                })
                .collect()
        };
        let artefacts = centred(epochs.indices(eog)?);
        let signals = centred(epochs.indices(channels)?);
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let n = artefacts.len();
        let covariance: Vec<f64> = (0..n * n)
            .map(|i| dot(&artefacts[i / n], &artefacts[i % n]))
            .collect();
        let inverted = inverse(&covariance, n).ok_or(EpochsError::Dependent { eog: n })?;
        let mut coefficients = Vec::with_capacity(signals.len() * n);
        for signal in &signals {
            let with: Vec<f64> = artefacts
                .iter()
                .map(|artefact| dot(artefact, signal))
                .collect();
            coefficients.extend((0..n).map(|i| dot(&inverted[i * n..(i + 1) * n], &with)));
        }
        let owned = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect();
        Ok(Self {
            channels: owned(channels),
            eog: owned(eog),
            coefficients,
        })
    }

    /// The coefficients, channels × EOG channels, without a unit.
    #[must_use]
    pub fn coefficients(&self) -> &[f64] {
        &self.coefficients
    }

    /// `epochs` less what the EOG channels, each about its mean over the epoch, put into the channels fitted, V. Other channels are as they were.
    ///
    /// # Errors
    /// [`EpochsError::NoChannel`] for a channel that is not there.
    pub fn apply(&self, epochs: &Epochs) -> Result<Epochs, EpochsError> {
        let names = |names: &[String]| {
            let names: Vec<&str> = names.iter().map(String::as_str).collect();
            epochs.indices(&names)
        };
        let (channels, eog) = (names(&self.channels)?, names(&self.eog)?);
        let all = epochs.channels().len();
        let mut weights = vec![0.0; all * all];
        for i in 0..all {
            weights[i * all + i] = 1.0;
        }
        for (row, channel) in channels.iter().enumerate() {
            for (column, artefact) in eog.iter().enumerate() {
                weights[channel * all + artefact] = -self.coefficients[row * eog.len() + column];
            }
        }
        // The mean of the artefact stays out: only the change of it within an epoch is taken away.
        let centred = epochs.mapped_channels(&eog, |signal, out| {
            let mean = signal.iter().sum::<f64>() / signal.len() as f64;
            for (out, value) in out.iter_mut().zip(signal) {
                *out = value - mean;
            }
        });
        let mixed = centred.mixed(epochs.channels().to_vec(), &weights);
        Ok(mixed.with_channels_of(epochs, &eog))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezotact::quantity::SampleRate;
    use piezotact::statistics::random::Random;

    #[test]
    fn blinks_go_and_the_rest_stays() {
        let mut random = Random::stream(8, 0, "blinks");
        let n = 2000;
        let brain: Vec<f64> = (0..n).map(|_| random.normal() * 5e-6).collect();
        let blink: Vec<f64> = (0..n)
            .map(|i| 100e-6 * (-((i % 500) as f64 - 250.0).powi(2) / 800.0).exp())
            .collect();
        let mut volts: Vec<f64> = brain.iter().zip(&blink).map(|(b, e)| b + 0.3 * e).collect();
        volts.extend(&blink);
        let names = vec!["Fz".to_owned(), "VEOG".to_owned()];
        let rate = SampleRate::new(500.0).unwrap();
        let epochs = Epochs::new(names, vec!["a".into(); 4], rate, 0.0, volts).unwrap();
        let fit = EogRegression::fit(&epochs, &["VEOG"], &["Fz"]).unwrap();
        assert!((fit.coefficients()[0] - 0.3).abs() < 0.02);
        let clean = fit.apply(&epochs).unwrap();
        let left: f64 = clean
            .channel(0)
            .chunks_exact(500)
            .zip(brain.chunks_exact(500))
            .flat_map(|(a, b)| {
                let mean = |x: &[f64]| x.iter().sum::<f64>() / x.len() as f64;
                let (ma, mb) = (mean(a), mean(b));
                a.iter()
                    .zip(b)
                    .map(move |(a, b)| (a - ma - b + mb).powi(2))
                    .collect::<Vec<_>>()
            })
            .sum();
        assert!((left / n as f64).sqrt() < 1e-6);
        assert_eq!(clean.channel(1), epochs.channel(1));
        assert!(EogRegression::fit(&epochs, &["VEOG"], &["VEOG"]).is_err());
        assert!(EogRegression::fit(&epochs, &[], &["Fz"]).is_err());
    }
}
