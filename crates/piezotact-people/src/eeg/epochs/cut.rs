//! Epochs cut from a continuous recording.

use std::fmt;

use piezotact::quantity::SampleRate;
use serde::{Deserialize, Serialize};

use super::{Epochs, EpochsError};

/// A continuous recording: channels × samples, in V.
#[derive(Clone, Copy, Debug)]
pub struct Continuous<'a> {
    /// The names of the channels.
    pub channels: &'a [String],
    pub rate: SampleRate,
    /// Channels × samples, V.
    pub volts: &'a [f64],
    /// The indices of samples before which others are missing: the recording was interrupted, or a drop-out was found there.
    pub gaps: &'a [usize],
}

/// Something that happened while EEG was recorded.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Event {
    /// The index of the sample at which it happened.
    pub sample: usize,
    /// What it belongs to: the condition of its epoch.
    pub condition: String,
}

/// The extent of epochs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct CutConfig {
    /// The first time from the event, s; negative before it.
    pub start_s: f64,
    /// The last time from the event, s, included.
    pub end_s: f64,
}

/// Why there is no epoch of an event.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum NotCut {
    /// It would begin before the recording.
    BeforeStart,
    /// It would end after the recording.
    AfterEnd,
    /// Samples are missing within it.
    Gap {
        /// The index of the sample before which they are missing.
        before: usize,
    },
    /// A channel holds one value within it: the electrode was off, or samples were lost.
    Held {
        /// The channel.
        channel: String,
    },
    /// An electrode is far below or above its usual level within it: its contact was lost.
    Off {
        /// The electrode.
        channel: String,
    },
    /// A channel has samples within it that are no numbers.
    NoNumbers {
        /// The channel.
        channel: String,
    },
    /// An event of the file calls a part of it bad.
    CalledBad {
        /// The name of the event.
        name: String,
    },
}

impl fmt::Display for NotCut {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::BeforeStart => f.write_str("it begins before the recording"),
            Self::AfterEnd => f.write_str("it ends after the recording"),
            Self::Gap { before } => write!(f, "samples are missing before sample {before}"),
            Self::NoNumbers { channel } => {
                write!(f, "{channel} has samples that are no numbers within it")
            }
            Self::CalledBad { name } => write!(f, "{name} calls a part of it bad"),
            Self::Off { channel } => {
                write!(f, "{channel} is off within it, far from its usual level")
            }
            Self::Held { channel } => write!(f, "{channel} holds one value within it"),
        }
    }
}

/// An event without an epoch.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LeftOut {
    /// The index of the event.
    pub event: usize,
    pub condition: String,
    pub reason: NotCut,
}

/// Epochs and the events that have none.
#[derive(Clone, Debug, PartialEq)]
pub struct Cut {
    /// The epochs, in the order of the events.
    pub epochs: Epochs,
    /// The events without an epoch, in their order.
    pub left_out: Vec<LeftOut>,
}

/// The epochs of `recording` around `events`, V: from `start_s` to `end_s`, both included, each to the nearest sample. An epoch that
/// would leave the recording or hold a gap is left out and listed.
///
/// Formula: samples round(`start_s`·rate) to round(`end_s`·rate) from the event.
///
/// Source: as MNE-Python's `Epochs` (`tmin`, `tmax`), without a baseline.
///
/// # Errors
/// [`EpochsError`] when the recording has no sample, its buffer is not channels × samples, the extent is not ascending, or no epoch is left.
pub fn cut(
    recording: &Continuous<'_>,
    events: &[Event],
    config: &CutConfig,
) -> Result<Cut, EpochsError> {
    let CutConfig { start_s, end_s } = *config;
    let rate = recording.rate.hz();
    if !(start_s.is_finite() && end_s.is_finite() && start_s < end_s) {
        return Err(EpochsError::Extent { start_s, end_s });
    }
    let channels = recording.channels.len();
    if channels == 0
        || recording.volts.is_empty()
        || !recording.volts.len().is_multiple_of(channels)
    {
        return Err(EpochsError::Shape {
            expected: format!("equally many samples of each of {channels} channels"),
            found: format!("{} values", recording.volts.len()),
        });
    }
    let length = recording.volts.len() / channels;
    let (first, last) = ((start_s * rate).round(), (end_s * rate).round());
    let mut kept = Vec::new();
    let mut conditions = Vec::new();
    let mut left_out = Vec::new();
    for (index, event) in events.iter().enumerate() {
        let (from, to) = (event.sample as f64 + first, event.sample as f64 + last);
        let gap = recording.gaps.iter().copied().filter(|gap| {
            let gap = *gap as f64;
            gap > from && gap <= to
        });
        let reason = match gap.min() {
            _ if from < 0.0 => Some(NotCut::BeforeStart),
            _ if to > (length - 1) as f64 => Some(NotCut::AfterEnd),
            Some(before) => Some(NotCut::Gap { before }),
            None => None,
        };
        match reason {
            Some(reason) => left_out.push(LeftOut {
                event: index,
                condition: event.condition.clone(),
                reason,
            }),
            None => {
                kept.push(from as usize..to as usize + 1);
                conditions.push(event.condition.clone());
            }
        }
    }
    if kept.is_empty() {
        return Err(EpochsError::NoneCut {
            events: events.len(),
            why: left_out.first().map_or_else(
                || "there is no event".to_owned(),
                |left| format!("of the first, {}", left.reason),
            ),
        });
    }
    let mut volts = Vec::with_capacity(channels * kept.len() * kept[0].len());
    for signal in recording.volts.chunks_exact(length) {
        for extent in &kept {
            volts.extend_from_slice(&signal[extent.clone()]);
        }
    }
    let names = recording.channels.to_vec();
    let epochs = Epochs::new(names, conditions, recording.rate, first / rate, volts)?;
    Ok(Cut { epochs, left_out })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_epoch_crosses_a_gap_or_an_end() {
        let channels = ["C3".to_owned(), "C4".to_owned()];
        let volts: Vec<f64> = (0..200).map(f64::from).collect();
        let recording = Continuous {
            channels: &channels,
            rate: SampleRate::new(10.0).unwrap(),
            volts: &volts,
            gaps: &[50],
        };
        let event = |sample| Event {
            sample,
            condition: format!("at {sample}"),
        };
        // −0.5 s to 1 s at 10 Hz: from 5 samples before to 10 after.
        let config = CutConfig {
            start_s: -0.5,
            end_s: 1.0,
        };
        let events = [4, 5, 39, 40, 54, 55, 89, 90].map(event);
        let found = cut(&recording, &events, &config).unwrap();
        assert_eq!(
            found.epochs.conditions(),
            ["at 5", "at 39", "at 55", "at 89"]
        );
        let why: Vec<NotCut> = found
            .left_out
            .iter()
            .map(|left| left.reason.clone())
            .collect();
        let gap = || NotCut::Gap { before: 50 };
        assert_eq!(why, [NotCut::BeforeStart, gap(), gap(), NotCut::AfterEnd]);
        assert_eq!(found.epochs.samples(), 16);
        assert_eq!(found.epochs.signal(1, 2)[0], 150.0);
        assert!((found.epochs.first_s() + 0.5).abs() < 1e-12);
        assert!(matches!(
            cut(&recording, &events[..1], &config),
            Err(EpochsError::NoneCut { events: 1, .. })
        ));
        let backwards = CutConfig {
            start_s: 1.0,
            end_s: 0.0,
        };
        assert!(cut(&recording, &events, &backwards).is_err());
    }
}
