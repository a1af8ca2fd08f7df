//! Epochs left out because of what they hold.

use std::collections::BTreeMap;
use std::fmt;

use piezotact::Warning;
use serde::{Deserialize, Serialize};

use super::{Epochs, EpochsError};
use crate::eeg::{EegWarning, EpochsFault};

/// More than this share of a condition's epochs rejected is a warning.
const MANY_SHARE: f64 = 0.3;
/// Conditions whose shares of rejected epochs differ by more than this are a warning.
const UNEVEN_SHARE: f64 = 0.15;

/// A rule by which a signal is rejected.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Criterion {
    /// Its largest less its smallest value is above this.
    PeakToPeak {
        /// The largest allowed, V.
        above_v: f64,
    },
    /// Its largest less its smallest value is below this: the electrode is not connected.
    Flat {
        /// The smallest allowed, V.
        below_v: f64,
    },
    /// The least-squares line through it changes by more than this over the epoch, in either direction.
    Drift {
        /// The largest allowed, V.
        above_v: f64,
    },
}

impl Criterion {
    /// What the criterion measures of `signal`, V.
    fn measure(self, signal: &[f64]) -> f64 {
        match self {
            Self::PeakToPeak { .. } | Self::Flat { .. } => {
                let least = signal.iter().copied().fold(f64::INFINITY, f64::min);
                let most = signal.iter().copied().fold(f64::NEG_INFINITY, f64::max);
                most - least
            }
            Self::Drift { .. } => {
                let n = signal.len() as f64;
                let middle = (n - 1.0) / 2.0;
                let moment: f64 = signal
                    .iter()
                    .enumerate()
                    .map(|(i, v)| (i as f64 - middle) * v)
                    .sum();
                let squares = n * (n * n - 1.0) / 12.0;
                (moment / squares * (n - 1.0)).abs()
            }
        }
    }

    fn rejects(self, found_v: f64) -> bool {
        match self {
            Self::PeakToPeak { above_v } | Self::Drift { above_v } => found_v > above_v,
            Self::Flat { below_v } => found_v < below_v,
        }
    }

    /// How many times what was found is beyond the limit.
    fn beyond(self, found_v: f64) -> f64 {
        match self {
            Self::PeakToPeak { above_v } | Self::Drift { above_v } => found_v / above_v,
            Self::Flat { below_v } => below_v / found_v.max(f64::MIN_POSITIVE),
        }
    }

    /// Its limit, V.
    fn limit_v(self) -> f64 {
        match self {
            Self::PeakToPeak { above_v } | Self::Drift { above_v } => above_v,
            Self::Flat { below_v } => below_v,
        }
    }
}

impl fmt::Display for Criterion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (what, side) = match self {
            Self::PeakToPeak { .. } => ("peak-to-peak", "above"),
            Self::Flat { .. } => ("peak-to-peak", "below"),
            Self::Drift { .. } => ("drift", "above"),
        };
        let limit = piezotact::number::rounded(1e6 * self.limit_v());
        write!(f, "{what} {side} {limit} µV")
    }
}

/// An epoch that was rejected, and by what.
#[derive(Clone, Debug, PartialEq)]
pub struct Rejected {
    /// The index of the epoch among those given.
    pub epoch: usize,
    pub condition: String,
    /// The channel that is furthest beyond its limit.
    pub channel: String,
    /// How many channels a criterion rejected.
    pub channels: usize,
    /// The criterion that the channel is furthest beyond.
    pub criterion: Criterion,
    /// What the criterion measured, V.
    pub found_v: f64,
}

/// How many epochs of a condition were kept and rejected.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Kept {
    pub kept: usize,
    pub rejected: usize,
}

impl Kept {
    /// The share of epochs that were rejected, 0–1.
    #[must_use]
    pub fn rejected_share(self) -> f64 {
        self.rejected as f64 / (self.kept + self.rejected).max(1) as f64
    }
}

/// Epochs that are kept, and those that are not.
#[derive(Clone, Debug, PartialEq)]
pub struct Rejection {
    /// The epochs that no criterion rejected.
    pub epochs: Epochs,
    /// Those that one did, in their order.
    pub rejected: Vec<Rejected>,
    /// How many of each condition.
    pub counts: BTreeMap<String, Kept>,
    /// What the criteria are.
    pub criteria: Vec<Criterion>,
    /// What to know before relying on the epochs.
    pub warnings: Vec<Warning>,
}

/// The epochs whose signals, of all channels named, no criterion rejects. Each rejected epoch is listed with the channel
/// that is furthest beyond a limit and the number of channels that are beyond one, and counted by condition.
///
/// Formula: peak-to-peak is max − min; drift is |slope of the least-squares line|·(last time − first time).
///
/// Source: as MNE-Python's `Epochs` (`reject`, `flat`); drift as EEGLAB's `rejtrend`, without its condition on R².
///
/// # Errors
/// [`EpochsError`] without a criterion, for a limit that is no positive number, a channel that does not exist, or when every epoch
/// is rejected.
pub fn reject(
    epochs: &Epochs,
    channels: &[&str],
    criteria: &[Criterion],
) -> Result<Rejection, EpochsError> {
    if criteria.is_empty() {
        return Err(EpochsError::NoCriterion);
    }
    for criterion in criteria {
        let found_v = criterion.limit_v();
        if !(found_v > 0.0 && found_v.is_finite()) {
            return Err(EpochsError::Limit { found_v });
        }
    }
    let indices = epochs.indices(channels)?;
    let mut kept = Vec::new();
    let mut rejected = Vec::new();
    let mut counts = BTreeMap::<String, Kept>::new();
    for (epoch, condition) in epochs.conditions().iter().enumerate() {
        let count = counts.entry(condition.clone()).or_default();
        let beyond = indices.iter().filter_map(|&channel| {
            let signal = epochs.signal(channel, epoch);
            let all = criteria.iter().filter_map(|criterion| {
                let found_v = criterion.measure(signal);
                criterion
                    .rejects(found_v)
                    .then_some((channel, *criterion, found_v))
            });
            all.max_by(|a, b| a.1.beyond(a.2).total_cmp(&b.1.beyond(b.2)))
        });
        let beyond: Vec<(usize, Criterion, f64)> = beyond.collect();
        let worst = beyond
            .iter()
            .copied()
            .max_by(|a, b| a.1.beyond(a.2).total_cmp(&b.1.beyond(b.2)));
        match worst {
            Some((channel, criterion, found_v)) => {
                count.rejected += 1;
                rejected.push(Rejected {
                    epoch,
                    condition: condition.clone(),
                    channel: epochs.channels()[channel].clone(),
                    channels: beyond.len(),
                    criterion,
                    found_v,
                });
            }
            None => {
                count.kept += 1;
                kept.push(epoch);
            }
        }
    }
    if kept.is_empty() {
        let first = &rejected[0];
        return Err(EpochsError::AllRejected {
            epochs: epochs.count(),
            why: format!("{}: {}", first.channel, first.criterion),
        });
    }
    Ok(Rejection {
        epochs: epochs.kept(&kept),
        warnings: warnings_of(&counts),
        rejected,
        counts,
        criteria: criteria.to_vec(),
    })
}

fn warnings_of(counts: &BTreeMap<String, Kept>) -> Vec<Warning> {
    let mut warnings: Vec<Warning> = counts
        .iter()
        .filter(|(_, count)| count.rejected_share() > MANY_SHARE)
        .map(|(condition, count)| {
            EegWarning::Epochs {
                fault: EpochsFault::Rejected {
                    condition: condition.clone(),
                    rejected: count.rejected,
                    of: count.kept + count.rejected,
                },
            }
            .into()
        })
        .collect();
    let share = |(_, count): &(&String, &Kept)| count.rejected_share();
    let most = counts.iter().max_by(|a, b| share(a).total_cmp(&share(b)));
    let least = counts.iter().min_by(|a, b| share(a).total_cmp(&share(b)));
    if let (Some(most), Some(least)) = (most, least)
        && share(&most) - share(&least) > UNEVEN_SHARE
    {
        warnings.push(
            EegWarning::Epochs {
                fault: EpochsFault::RejectedUnevenly {
                    most: most.0.clone(),
                    most_share: share(&most),
                    least: least.0.clone(),
                    least_share: share(&least),
                },
            }
            .into(),
        );
    }
    warnings
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezotact::quantity::SampleRate;

    #[test]
    fn epochs_are_rejected_by_what_they_hold() {
        let n = 100;
        let tone = |size: f64| (0..n).map(move |i| size * (0.7 * f64::from(i)).sin());
        let ramp = |size: f64| (0..n).map(move |i| size * f64::from(i) / f64::from(n - 1));
        let mut volts: Vec<f64> = Vec::new();
        volts.extend(tone(10e-6));
        volts.extend(tone(80e-6));
        volts.extend(tone(1e-9));
        volts.extend(ramp(60e-6));
        volts.extend(tone(12e-6));
        // A channel of the eyes, which is not looked at.
        volts.extend((0..5).flat_map(|_| tone(300e-6)));
        let names = |n: &[&str]| n.iter().map(|s| (*s).to_owned()).collect::<Vec<_>>();
        let epochs = Epochs::new(
            names(&["C3", "EOG"]),
            names(&["rest", "touch", "touch", "touch", "rest"]),
            SampleRate::new(100.0).unwrap(),
            0.0,
            volts,
        )
        .unwrap();
        let criteria = [
            Criterion::PeakToPeak { above_v: 100e-6 },
            Criterion::Flat { below_v: 1e-6 },
            Criterion::Drift { above_v: 50e-6 },
        ];
        let found = reject(&epochs, &["C3"], &criteria).unwrap();
        let why: Vec<(usize, Criterion)> = found
            .rejected
            .iter()
            .map(|r| (r.epoch, r.criterion))
            .collect();
        assert_eq!(why, [(1, criteria[0]), (2, criteria[1]), (3, criteria[2])]);
        assert!((found.rejected[2].found_v - 60e-6).abs() < 1e-12);
        assert_eq!(found.epochs.conditions(), ["rest", "rest"]);
        let touch = found.counts["touch"];
        assert_eq!((touch.kept, touch.rejected), (0, 3));
        // Three of three, and none of two of the other condition.
        assert_eq!(found.warnings.len(), 2);
        assert!(reject(&epochs, &["EOG"], &criteria).is_err());
        assert!(reject(&epochs, &["C3"], &[]).is_err());
        let microvolts = Criterion::Flat { below_v: f64::NAN };
        assert!(matches!(
            reject(&epochs, &["C3"], &[microvolts]),
            Err(EpochsError::Limit { .. })
        ));
    }
}
