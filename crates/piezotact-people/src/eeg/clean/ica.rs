//! Independent components by `FastICA`.

use piezotact::Warning;
use piezotact::statistics::correlation;
use piezotact::statistics::random::Random;
use piezotact::warning::{Few, FewWarning};
use serde::{Deserialize, Serialize};

use crate::eeg::epochs::{Epochs, EpochsError};
use crate::eeg::linear::{eigen, product, transposed};
use crate::eeg::{EegWarning, IcaFault};

/// Directions whose variance is below this share of the largest are none: of an average reference, or interpolated channels.
const LEAST_VARIANCE: f64 = 1e-10;
/// So many samples for the square of the number of components are wanted.
const SAMPLES_PER_SQUARE: usize = 30;

/// How components are found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IcaConfig {
    /// How many, of the largest variance.
    pub components: usize,
    /// The iterations after which it stops.
    pub max_iterations: usize,
    /// It has converged when no component turns by more than this (1 − |cos|).
    pub tolerance: f64,
    /// The seed of the first directions.
    pub seed: u64,
}

/// One independent component beside the channels of eye movements.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct EyeComponent {
    /// Its share of the variance of all electrodes, 0–1.
    pub share: f64,
    /// The EOG channel that it follows most.
    pub eog: String,
    /// Its correlation with that channel, −1 to 1.
    pub correlation: f64,
    /// Whether it was taken out.
    pub taken_out: bool,
    /// What it adds to each electrode, V.
    pub weights_v: Vec<f64>,
}

/// The independent components of a recording, and which of them were taken out as eye movements.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct EyeComponents {
    /// The electrodes that they were found in.
    pub channels: Vec<String>,
    /// After how many iterations.
    pub iterations: usize,
    /// All of them; the one that explains most variance first.
    pub components: Vec<EyeComponent>,
}

/// Independent components of EEG.
#[derive(Clone, Debug, PartialEq)]
pub struct Ica {
    channels: Vec<String>,
    config: IcaConfig,
    /// Components × channels, 1/V.
    unmixing: Vec<f64>,
    /// Channels × components, V.
    mixing: Vec<f64>,
    /// The mean of each channel, V.
    means: Vec<f64>,
    /// The sum of the variances of the channels, V².
    variance: f64,
    /// After how many iterations it stopped.
    pub iterations: usize,
    /// How far each component still turned in the last one (1 − |cos|).
    changes: Vec<f64>,
    /// What to know before relying on it.
    pub warnings: Vec<Warning>,
}

impl Ica {
    /// The components of the channels named, over all epochs, of unit variance; the one that explains most variance first. Filter above 1 Hz
    /// before, and leave EOG channels out.
    ///
    /// Formula: whitening by principal components, then w ← E{x·tanh(wᵀx)} − E{1 − tanh²(wᵀx)}·w for all components at once, made orthogonal by
    /// (W·Wᵀ)^(−1/2)·W. The largest weight of each component is positive.
    ///
    /// Source: A. Hyvärinen (1999), IEEE Trans. Neural Netw. 10 (symmetric `FastICA`, contrast log cosh).
    ///
    /// # Errors
    /// [`EpochsError`] for more components than independent directions, no component or iteration, a tolerance that is not above 0, or a name that
    /// no channel has.
    pub fn fit(
        epochs: &Epochs,
        channels: &[&str],
        config: &IcaConfig,
    ) -> Result<Self, EpochsError> {
        if config.max_iterations == 0 || !(config.tolerance > 0.0 && config.tolerance < 1.0) {
            return Err(EpochsError::Shape {
                expected: "at least 1 iteration and a tolerance between 0 and 1".to_owned(),
                found: format!("{} and {}", config.max_iterations, config.tolerance),
            });
        }
        let indices = epochs.indices(channels)?;
        let (n, k) = (indices.len(), config.components);
        let samples = epochs.count() * epochs.samples();
        let means: Vec<f64> = indices
            .iter()
            .map(|c| epochs.channel(*c).iter().sum::<f64>() / samples as f64)
            .collect();
        let centred: Vec<Vec<f64>> = indices
            .iter()
            .zip(&means)
            .map(|(c, mean)| epochs.channel(*c).iter().map(|v| v - mean).collect())
            .collect();
        let mut covariance = vec![0.0; n * n];
        for i in 0..n {
            for j in 0..=i {
                let sum: f64 = centred[i].iter().zip(&centred[j]).map(|(a, b)| a * b).sum();
                covariance[i * n + j] = sum / samples as f64;
                covariance[j * n + i] = covariance[i * n + j];
            }
        }
        let (variances, directions) = eigen(&covariance, n);
        let least = LEAST_VARIANCE * variances.first().copied().unwrap_or(0.0);
        let rank = variances
            .iter()
            .filter(|v| **v > least && **v > 0.0)
            .count();
        if k == 0 || k > rank {
            return Err(EpochsError::Components { found: k, rank });
        }
        let whitening: Vec<f64> = (0..k * n)
            .map(|i| directions[i] / variances[i / n].sqrt())
            .collect();
        let colouring: Vec<f64> = (0..n * k)
            .map(|i| directions[(i % k) * n + i / k] * variances[i % k].sqrt())
            .collect();
        let white = combined(&whitening, &centred, k);
        let (turn, iterations, changes) = turned(&white, config);
        let unmixing = product(&turn, &whitening, k, k, n);
        let mixing = product(&colouring, &transposed(&turn, k, k), n, k, k);
        let mut ica = Self {
            channels: channels.iter().map(|c| (*c).to_owned()).collect(),
            config: *config,
            unmixing,
            mixing,
            means,
            variance: variances.iter().sum(),
            iterations,
            changes,
            warnings: Vec::new(),
        };
        ica.sort();
        let wanted = SAMPLES_PER_SQUARE * k * k;
        if samples < wanted {
            let warning = FewWarning::Few {
                found: samples,
                recommended: wanted,
                what: Few::IcaSamples { components: k },
            };
            ica.warnings.push(warning.into());
        }
        Ok(ica)
    }

    /// The warning that components still changed in the last iteration.
    #[must_use]
    pub fn not_converged(&self) -> Option<Warning> {
        let change = self.changes.iter().copied().fold(0.0, f64::max);
        let unsettled = EegWarning::Ica {
            fault: IcaFault::NotConverged {
                iterations: self.iterations,
                change,
                wanted: self.config.tolerance,
            },
        };
        (change > self.config.tolerance).then(|| unsettled.into())
    }

    /// Components in the order of what they explain, each with its largest weight positive.
    fn sort(&mut self) {
        let (k, n) = (self.config.components, self.channels.len());
        let column = |c: usize| (0..n).map(move |row| row * k + c);
        let power = |c: usize| {
            column(c)
                .map(|i| self.mixing[i] * self.mixing[i])
                .sum::<f64>()
        };
        let mut order: Vec<usize> = (0..k).collect();
        order.sort_by(|a, b| power(*b).total_cmp(&power(*a)));
        let signs: Vec<f64> = order
            .iter()
            .map(|c| {
                let weights = column(*c).map(|i| self.mixing[i]);
                weights
                    .fold(
                        0.0f64,
                        |most, w| if w.abs() > most.abs() { w } else { most },
                    )
                    .signum()
            })
            .collect();
        self.changes = order.iter().map(|c| self.changes[*c]).collect();
        self.unmixing = (0..k * n)
            .map(|i| signs[i / n] * self.unmixing[order[i / n] * n + i % n])
            .collect();
        self.mixing = (0..n * k)
            .map(|i| signs[i % k] * self.mixing[(i / k) * k + order[i % k]])
            .collect();
    }

    /// How far each component still turned in the last iteration (1 − |cos|). One that has settled is what it is even where others, such as those of
    /// noise, cannot be told from each other.
    #[must_use]
    pub fn changes(&self) -> &[f64] {
        &self.changes
    }

    /// What each component adds to each channel, channels × components, V.
    #[must_use]
    pub fn mixing(&self) -> &[f64] {
        &self.mixing
    }

    /// The components of `epochs`, components × epochs × samples, without a unit.
    ///
    /// # Errors
    /// [`EpochsError::NoChannel`] for a channel that is not there.
    pub fn sources(&self, epochs: &Epochs) -> Result<Vec<Vec<f64>>, EpochsError> {
        let names: Vec<&str> = self.channels.iter().map(String::as_str).collect();
        let indices = epochs.indices(&names)?;
        let centred: Vec<Vec<f64>> = indices
            .iter()
            .zip(&self.means)
            .map(|(c, mean)| epochs.channel(*c).iter().map(|v| v - mean).collect())
            .collect();
        Ok(combined(&self.unmixing, &centred, self.config.components))
    }

    /// The correlation of each component with the channel named, −1 to 1, such as with an EOG channel; 0 for a constant one.
    ///
    /// Source: Pearson's correlation over all samples, as MNE-Python's `find_bads_eog(measure="correlation")`.
    ///
    /// # Errors
    /// [`EpochsError::NoChannel`] for a channel that is not there.
    pub fn correlations(&self, epochs: &Epochs, channel: &str) -> Result<Vec<f64>, EpochsError> {
        let index = epochs.indices(&[channel])?[0];
        let with = epochs.channel(index);
        let sources = self.sources(epochs)?;
        Ok(sources
            .iter()
            .map(|source| correlation(source, with))
            .map(|r| if r.is_finite() { r } else { 0.0 })
            .collect())
    }

    /// Each component beside the channels named `eog`; those whose correlation with one of them is at least `least_share` in size are called
    /// eye movements. Look at their maps before they are taken out.
    ///
    /// Formula: the share of a component of unit variance is the sum of its squared weights, re the variance of all channels.
    ///
    /// Source: Pearson's correlation, as MNE-Python's `find_bads_eog(measure="correlation")`.
    ///
    /// # Errors
    /// [`EpochsError::NoChannel`] for a channel that is not there.
    pub fn beside_eyes(
        &self,
        epochs: &Epochs,
        eog: &[&str],
        least_share: f64,
    ) -> Result<EyeComponents, EpochsError> {
        let k = self.config.components;
        let mut best = vec![("", 0.0); k];
        for channel in eog {
            let found = self.correlations(epochs, channel)?;
            for (best, r) in best.iter_mut().zip(found) {
                if best.0.is_empty() || r.abs() > f64::abs(best.1) {
                    *best = (channel, r);
                }
            }
        }
        let component = |(at, (eog, correlation)): (usize, (&str, f64))| {
            let rows = self.mixing.chunks_exact(k);
            let weights_v: Vec<f64> = rows.map(|row| row[at]).collect();
            EyeComponent {
                share: weights_v.iter().map(|w| w * w).sum::<f64>() / self.variance,
                eog: eog.to_owned(),
                correlation,
                taken_out: correlation.abs() >= least_share,
                weights_v,
            }
        };
        Ok(EyeComponents {
            channels: self.channels.clone(),
            iterations: self.iterations,
            components: best.into_iter().enumerate().map(component).collect(),
        })
    }

    /// `epochs` without the components of the indices `out`, V. Channels that were not fitted are as they were.
    ///
    /// # Errors
    /// [`EpochsError`] for a component that does not exist, or a channel that is not there.
    pub fn without(&self, epochs: &Epochs, out: &[usize]) -> Result<Epochs, EpochsError> {
        let (k, n) = (self.config.components, self.channels.len());
        if let Some(&found) = out.iter().find(|c| **c >= k) {
            return Err(EpochsError::Shape {
                expected: format!("components below {k}"),
                found: found.to_string(),
            });
        }
        let names: Vec<&str> = self.channels.iter().map(String::as_str).collect();
        let indices = epochs.indices(&names)?;
        let all = epochs.channels().len();
        let mut weights = vec![0.0; all * all];
        for i in 0..all {
            weights[i * all + i] = 1.0;
        }
        for (row, to) in indices.iter().enumerate() {
            for (column, from) in indices.iter().enumerate() {
                let taken: f64 = out
                    .iter()
                    .map(|c| self.mixing[row * k + c] * self.unmixing[c * n + column])
                    .sum();
                weights[to * all + from] -= taken;
            }
        }
        // About the means that were fitted.
        let mut shifts = vec![0.0; all];
        for (i, mean) in indices.iter().zip(&self.means) {
            shifts[*i] = *mean;
        }
        let (count, samples) = (epochs.count(), epochs.samples());
        let mut at = 0;
        let moved = epochs.mapped(|signal, out| {
            let shift = shifts[at / count];
            for (out, value) in out.iter_mut().zip(&signal[..samples]) {
                *out = value - shift;
            }
            at += 1;
        });
        let mixed = moved.mixed(epochs.channels().to_vec(), &weights);
        let mut at = 0;
        Ok(mixed.mapped(|signal, out| {
            let shift = shifts[at / count];
            for (out, value) in out.iter_mut().zip(signal) {
                *out = value + shift;
            }
            at += 1;
        }))
    }
}

impl EyeComponents {
    /// The indices of those that were taken out, ascending.
    #[must_use]
    pub fn taken_out(&self) -> Vec<usize> {
        let all = self.components.iter().enumerate();
        all.filter(|(_, one)| one.taken_out)
            .map(|(at, _)| at)
            .collect()
    }
}

/// Sums of `signals` with `weights`, rows × signals.
fn combined(weights: &[f64], signals: &[Vec<f64>], rows: usize) -> Vec<Vec<f64>> {
    let n = signals.len();
    let samples = signals.first().map_or(0, Vec::len);
    (0..rows)
        .map(|row| {
            let mut out = vec![0.0; samples];
            for (weight, signal) in weights[row * n..(row + 1) * n].iter().zip(signals) {
                for (sum, value) in out.iter_mut().zip(signal) {
                    *sum += weight * value;
                }
            }
            out
        })
        .collect()
}

/// So many samples of all signals stay in the cache of a processor.
const AT_A_TIME: usize = 512;

/// The rotation of white signals to independent ones, the iterations that it took, and the last change of each row.
fn turned(white: &[Vec<f64>], config: &IcaConfig) -> (Vec<f64>, usize, Vec<f64>) {
    let k = white.len();
    let all = white[0].len();
    let samples = all as f64;
    let mut random = Random::stream(config.seed, k as u64, "fast ica");
    let start: Vec<f64> = (0..k * k).map(|_| random.normal()).collect();
    let mut turn = orthogonal(&start, k);
    let mut changes = vec![f64::INFINITY; k];
    let mut source = vec![0.0; AT_A_TIME];
    for iteration in 1..=config.max_iterations {
        let (mut next, mut slopes) = (vec![0.0; k * k], vec![0.0; k]);
        for from in (0..all).step_by(AT_A_TIME) {
            let to = (from + AT_A_TIME).min(all);
            let source = &mut source[..to - from];
            for row in 0..k {
                source.fill(0.0);
                for (weight, signal) in turn[row * k..(row + 1) * k].iter().zip(white) {
                    for (sum, value) in source.iter_mut().zip(&signal[from..to]) {
                        *sum += weight * value;
                    }
                }
                for value in source.iter_mut() {
                    *value = value.tanh();
                    slopes[row] += 1.0 - *value * *value;
                }
                for (sum, signal) in next[row * k..(row + 1) * k].iter_mut().zip(white) {
                    let own = source.iter().zip(&signal[from..to]);
                    *sum += own.map(|(g, x)| g * x).sum::<f64>();
                }
            }
        }
        for (i, value) in next.iter_mut().enumerate() {
            *value = (*value - slopes[i / k] * turn[i]) / samples;
        }
        let next = orthogonal(&next, k);
        let change = |row: usize| {
            let rows = next[row * k..(row + 1) * k].iter().zip(&turn[row * k..]);
            let cosine: f64 = rows.map(|(a, b)| a * b).sum();
            (1.0 - cosine.abs()).abs()
        };
        changes = (0..k).map(change).collect();
        turn = next;
        if changes.iter().all(|change| *change <= config.tolerance) {
            return (turn, iteration, changes);
        }
    }
    (turn, config.max_iterations, changes)
}

/// (M·Mᵀ)^(−1/2)·M: the orthogonal matrix nearest to M.
fn orthogonal(matrix: &[f64], k: usize) -> Vec<f64> {
    let square = product(matrix, &transposed(matrix, k, k), k, k, k);
    let (values, vectors) = eigen(&square, k);
    let least = f64::EPSILON * values.first().copied().unwrap_or(1.0);
    let scaled: Vec<f64> = (0..k * k)
        .map(|i| vectors[i] / values[i / k].max(least).sqrt())
        .collect();
    let root = product(&transposed(&vectors, k, k), &scaled, k, k, k);
    product(&root, matrix, k, k, k)
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezotact::quantity::SampleRate;

    /// Four sources of known kinds in five channels; the last channel is of the eyes.
    fn mixed() -> (Epochs, Vec<Vec<f64>>) {
        let n = 4000;
        let mut random = Random::stream(9, 0, "sources");
        let blink = |i: usize| 8.0 * (-((i % 800) as f64 - 400.0).powi(2) / 900.0).exp();
        let sources: Vec<Vec<f64>> = vec![
            (0..n).map(blink).collect(),
            (0..n).map(|i| (0.11 * i as f64).sin() * 1.4).collect(),
            (0..n)
                .map(|i| if (i / 37) % 2 == 0 { 1.0 } else { -1.0 })
                .collect(),
            (0..n).map(|_| (random.uniform() - 0.5) * 3.4).collect(),
        ];
        let mixing = [
            [30.0, 4.0, 2.0, 1.0],
            [9.0, -3.0, 6.0, 2.0],
            [3.0, 8.0, -4.0, -2.0],
            [1.0, 2.0, 3.0, 7.0],
            [60.0, 0.0, 0.0, 0.0],
        ];
        let mut volts = Vec::new();
        for row in mixing {
            for i in 0..n {
                let sum: f64 = row.iter().zip(&sources).map(|(w, s)| w * s[i]).sum();
                volts.push(1e-6 * sum + 5e-6);
            }
        }
        let names = ["Fp1", "C3", "C4", "Oz", "VEOG"]
            .map(str::to_owned)
            .to_vec();
        let rate = SampleRate::new(500.0).unwrap();
        (
            Epochs::new(names, vec!["a".into(); 4], rate, 0.0, volts).unwrap(),
            sources,
        )
    }

    const CONFIG: IcaConfig = IcaConfig {
        components: 4,
        max_iterations: 200,
        tolerance: 1e-8,
        seed: 1,
    };
    const EEG: [&str; 4] = ["Fp1", "C3", "C4", "Oz"];

    #[test]
    fn sources_are_found_and_the_eyes_go() {
        let (epochs, sources) = mixed();
        let ica = Ica::fit(&epochs, &EEG, &CONFIG).unwrap();
        assert!(ica.warnings.is_empty(), "{:?}", ica.warnings);
        let found = ica.sources(&epochs).unwrap();
        for source in &sources {
            let best = found
                .iter()
                .map(|f| correlation(f, source).abs())
                .fold(0.0, f64::max);
            // Components are uncorrelated, and these sources are so only by about 0.1.
            assert!(best > 0.94, "{best}");
        }
        let beside = ica.beside_eyes(&epochs, &["Oz", "VEOG"], 0.8).unwrap();
        let eyes = beside.taken_out();
        assert_eq!(eyes.len(), 1);
        let blinks = &beside.components[eyes[0]];
        assert_eq!((eyes[0], blinks.eog.as_str()), (0, "VEOG"));
        let shares: f64 = beside.components.iter().map(|one| one.share).sum();
        assert!((shares - 1.0).abs() < 1e-9, "{shares}");
        // 30 and 9 µV of the blink, whose standard deviation is what it adds.
        let of_blinks = blinks.weights_v[1] / blinks.weights_v[0];
        assert!((of_blinks - 0.3).abs() < 0.05, "{of_blinks}");
        let clean = ica.without(&epochs, &eyes).unwrap();
        let of_blink = |e: &Epochs| correlation(e.channel(0), &sources[0]).abs();
        assert!(
            of_blink(&epochs) > 0.9 && of_blink(&clean) < 0.4,
            "{}",
            of_blink(&clean)
        );
        assert_eq!(clean.channel(4), epochs.channel(4));
        // Nothing taken out is nothing changed, and one seed gives one result.
        let same = ica.without(&epochs, &[]).unwrap();
        assert!(
            same.volts()
                .iter()
                .zip(epochs.volts())
                .all(|(a, b)| (a - b).abs() < 1e-18)
        );
        assert_eq!(Ica::fit(&epochs, &EEG, &CONFIG).unwrap(), ica);
    }

    #[test]
    fn what_cannot_be_is_refused_or_reported() {
        let (epochs, _) = mixed();
        let with = |change: fn(&mut IcaConfig)| {
            let mut config = CONFIG;
            change(&mut config);
            Ica::fit(&epochs, &EEG, &config)
        };
        assert!(matches!(
            with(|c| c.components = 5),
            Err(EpochsError::Components { rank: 4, .. })
        ));
        assert!(with(|c| c.components = 0).is_err() && with(|c| c.max_iterations = 0).is_err());
        assert!(with(|c| c.tolerance = f64::NAN).is_err());
        let early = with(|c| c.max_iterations = 1).unwrap();
        let unsettled = early.not_converged().unwrap();
        assert!(matches!(
            unsettled.kind(),
            Some(EegWarning::Ica {
                fault: IcaFault::NotConverged { iterations: 1, .. }
            })
        ));
        assert!(early.without(&epochs, &[4]).is_err());
    }
}
