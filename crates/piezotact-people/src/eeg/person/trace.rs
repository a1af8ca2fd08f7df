//! What tells recordings apart, whatever their reference, their scale and their markers' exact places.

use piezotact::quantity::Seconds;
use piezotact::statistics::mean;
use serde::{Deserialize, Serialize};

use crate::eeg::epochs::Epochs;

/// From one level to the next.
const STEP: Seconds = Seconds(0.02);
/// Markers of a copy are at most so far from those of the original, s.
const FURTHEST_S: f64 = 0.4;
/// So many epochs are looked for in the other recording.
const LOOKED: usize = 16;
/// What stands in the place of a variance of 0, V².
const NOTHING_V2: f64 = 1e-30;

/// How the changes of electrodes scatter about their mean over the time of each epoch, less what is the same in all epochs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Trace {
    /// From one level to the next, s.
    pub step_s: f64,
    /// The levels of each epoch, 0.1 dB.
    pub epochs: Vec<Vec<i16>>,
}

impl Trace {
    /// The trace of epochs.
    ///
    /// Formula: the level of the variance over electrodes (of one electrode alone, the square) of changes over 20 ms, mean over 20 ms, less its
    /// mean over epochs at each time, and over times in each epoch. A reference is taken away from all electrodes alike and changes no variance;
    /// a scale is a constant of the level; changes hold little of blinks, which look alike in all people.
    ///
    /// Source: the global field power, D. Lehmann and W. Skrandies (1980), Electroencephalogr. Clin. Neurophysiol. 48.
    pub(super) fn of(epochs: &Epochs) -> Self {
        let step = epochs.rate().samples_in(STEP).max(1);
        let channels = epochs.channels().len();
        let variance = |epoch: usize, sample: usize| {
            let changes = (0..channels).map(|channel| {
                let signal = epochs.signal(channel, epoch);
                signal[sample + step] - signal[sample]
            });
            let (sum, squares) = changes.fold((0.0, 0.0), |(sum, squares), value| {
                (sum + value, squares + value * value)
            });
            let n = channels as f64;
            match channels {
                1 => squares,
                _ => squares / n - (sum / n) * (sum / n),
            }
        };
        let level = |epoch: usize, at: usize| {
            let own = (at * step..(at + 1) * step).map(|sample| variance(epoch, sample));
            10.0 * (own.sum::<f64>() / step as f64).max(NOTHING_V2).log10()
        };
        let times = (epochs.samples() / step).saturating_sub(1);
        let levels: Vec<Vec<f64>> = (0..epochs.count())
            .map(|epoch| (0..times).map(|at| level(epoch, at)).collect())
            .collect();
        let shared: Vec<f64> = (0..times)
            .map(|at| mean(&levels.iter().map(|own| own[at]).collect::<Vec<_>>()))
            .collect();
        let own = |levels: &Vec<f64>| {
            let apart = levels.iter().zip(&shared);
            let apart: Vec<f64> = apart.map(|(level, shared)| level - shared).collect();
            let middle = mean(&apart);
            let tenths = apart.iter().map(|level| 10.0 * (level - middle));
            tenths.map(|tenths| tenths.round() as i16).collect()
        };
        Self {
            step_s: step as f64 / epochs.rate().hz(),
            epochs: levels.iter().map(own).collect(),
        }
    }

    /// How alike two recordings are: the mean over epochs of the shorter one of the largest correlation with an epoch of the other, at the one
    /// shift of all markers at which that is largest. About 0.3 of different recordings, above 0.7 of the same.
    pub(in crate::eeg) fn likeness(&self, other: &Self) -> f64 {
        let (few, many) = match self.epochs.len() <= other.epochs.len() {
            true => (self, other),
            false => (other, self),
        };
        if few.epochs.is_empty() || (few.step_s - many.step_s).abs() > 1e-9 {
            return 0.0;
        }
        let values = |levels: &Vec<i16>| levels.iter().map(|level| f64::from(*level)).collect();
        let every = few.epochs.len().div_ceil(LOOKED);
        let looked: Vec<Vec<f64>> = few.epochs.iter().step_by(every).map(values).collect();
        let all: Vec<Vec<f64>> = many.epochs.iter().map(values).collect();
        let furthest = (FURTHEST_S / few.step_s).round() as usize;
        let of_shift = |at: fn(&[f64], &[f64], usize) -> f64, shift: usize| {
            let largest = looked.iter().map(|own| {
                let found = all.iter().map(|other| at(own, other, shift));
                found.fold(0.0, f64::max)
            });
            mean(&largest.collect::<Vec<_>>())
        };
        let shifts = (0..=furthest).flat_map(|shift| {
            [
                of_shift(correlation_behind, shift),
                of_shift(
                    |own, other, shift| correlation_behind(other, own, shift),
                    shift,
                ),
            ]
        });
        shifts.fold(0.0, f64::max)
    }
}

/// The correlation of `first`, from the value `shift` on, with `second`; both scatter about 0.
fn correlation_behind(first: &[f64], second: &[f64], shift: usize) -> f64 {
    let first = first.get(shift..).unwrap_or_default();
    let (mut both, mut a, mut b) = (0.0, 0.0, 0.0);
    for (x, y) in first.iter().zip(second) {
        both += x * y;
        a += x * x;
        b += y * y;
    }
    match a * b > 0.0 {
        true => both / (a * b).sqrt(),
        false => 0.0,
    }
}
