//! Warnings about the analysis of EEG.

use piezotact::Warning;
use piezotact::number::digits;
use serde::{Deserialize, Serialize};

/// A larger share of interpolated electrodes is unusual.
const MOST_INTERPOLATED: f64 = 0.1;

/// One thing to know before relying on a result of EEG.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "code", rename_all = "snake_case")]
pub enum EegWarning {
    /// The difference of two tasks is nearly the same in all people.
    #[error(
        "{tasks}: d_z is {d_z:+.0}, so the difference is nearly the same in all people: check that the documents are of different people and \
            recordings"
    )]
    #[serde(rename = "eeg_difference_without_scatter")]
    TooAlike { tasks: String, d_z: f64 },
    /// A warning of some of the documents of a study.
    #[error("{names}: {warning}")]
    #[serde(rename = "eeg_of_people")]
    OfPeople { names: String, warning: Warning },
    /// Which epochs are left, or what they share, makes a comparison doubtful.
    #[error("{fault}; {}", fault.advice())]
    #[serde(rename = "eeg_epochs")]
    Epochs {
        #[serde(flatten)]
        fault: EpochsFault,
    },
    /// Markers that may not be those of this recording, or not in time with it.
    #[error("{fault}; {}", fault.advice())]
    #[serde(rename = "eeg_markers")]
    Markers {
        #[serde(flatten)]
        fault: MarkersFault,
    },
    /// Power is wrong where a filter or a wavelet reaches over an edge.
    #[error("{by}; {}", by.advice())]
    #[serde(rename = "eeg_smeared")]
    Smeared {
        #[serde(flatten)]
        by: Smeared,
    },
    /// Electrodes are too few or too far away for values over the scalp.
    #[error("{fault}; {}", fault.advice())]
    #[serde(rename = "eeg_positions")]
    Positions {
        #[serde(flatten)]
        fault: PositionsFault,
    },
    /// Electrodes whose signals are doubtful.
    #[error("{}{fault}; {}", named(names), fault.advice())]
    #[serde(rename = "eeg_electrodes_doubtful")]
    Electrodes {
        names: String,
        #[serde(flatten)]
        fault: ElectrodesFault,
    },
    /// Electrodes that are left out.
    #[error("{names}: left out, as {why}; {}", why.advice())]
    #[serde(rename = "eeg_electrodes_left_out")]
    ElectrodesLeftOut {
        names: String,
        #[serde(flatten)]
        why: LeftOutElectrodes,
    },
    /// What some of the documents of a study do not have.
    #[error("{}", what.sentence(names))]
    #[serde(rename = "eeg_not_common")]
    NotCommon {
        names: String,
        #[serde(flatten)]
        what: NotCommon,
    },
    /// Changes of power are biased.
    #[error("{channel}: {}; {}", by.sentence(*epochs), by.advice())]
    #[serde(rename = "eeg_biased")]
    Biased {
        channel: String,
        epochs: usize,
        #[serde(flatten)]
        by: Bias,
    },
}

/// What biases changes of power.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "by", rename_all = "snake_case")]
pub enum Bias {
    /// The baseline's power is so uncertain that the ratio to it is biased.
    Ratio { bias_points: f64 },
    /// Percentages were computed for each epoch and then averaged.
    EachEpoch { bias_points: f64 },
    /// Power scatters so much from epoch to epoch that maps of few epochs are biased.
    Bursts { scatter: f64 },
}

impl Bias {
    /// What is biased, with this number of epochs.
    fn sentence(&self, epochs: usize) -> String {
        match self {
            Self::Ratio { bias_points } => format!(
                "with {epochs} epochs the power of the baseline is uncertain, and percentages are too high by about {bias_points:.1} points (a \
                 desynchronisation looks smaller)"
            ),
            Self::EachEpoch { bias_points } => format!(
                "percentages of each of {epochs} epochs were averaged: an epoch whose baseline is low by chance counts most, so no change would show \
                 as {bias_points:+.1} percentage points"
            ),
            Self::Bursts { scatter } => format!(
                "the variance of power over {epochs} epochs is {scatter:.0} times that of noise, so that maps in dB of few epochs are too low"
            ),
        }
    }

    /// What a person can do.
    fn advice(&self) -> &'static str {
        match self {
            Self::Ratio { .. } => "record more epochs or take a longer baseline",
            Self::EachEpoch { .. } => "average power before the baseline is divided",
            Self::Bursts { .. } => "compare equal numbers of epochs only",
        }
    }
}

/// What some of the documents of a study do not have.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "what", rename_all = "snake_case")]
pub enum NotCommon {
    /// Electrodes that some documents do not have.
    Electrodes { kept: usize },
    /// Some people did not take part in all tasks; the names are theirs.
    Tasks { people: usize, of: usize },
    /// Documents with surfaces that others do not have.
    Surfaces,
}

impl NotCommon {
    /// What is not common, and what to do.
    fn sentence(&self, names: &str) -> String {
        match self {
            Self::Electrodes { kept } => format!(
                "not in all documents: {names}; maps and clusters are of the other {kept} electrodes; interpolate bad electrodes, and check that no \
                 channel has another name in one recording"
            ),
            Self::Tasks { people, of } => format!(
                "{people} of {of} participants did not take part in all tasks ({names}), and each contrast is of those who took part in both; give a \
                 document of each participant and task"
            ),
            Self::Surfaces => format!(
                "not in all documents: {names}; the mean of surfaces and its contrasts use only the surfaces that all documents have; name surfaces \
                 alike in all tasks"
            ),
        }
    }
}

/// Why electrodes are left out.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "why", rename_all = "snake_case")]
pub enum LeftOutElectrodes {
    /// Channels that a table calls bad are left out.
    #[error("the table of channels beside the file marks them as bad")]
    CalledBad,
    /// Channels called as electrodes whose unit is none of a potential.
    #[error("their unit `{unit}` is none of a potential")]
    NotInVolts { unit: String },
}

impl LeftOutElectrodes {
    /// What a person can do.
    fn advice(&self) -> &'static str {
        match self {
            Self::CalledBad => "name all channels to analyse them",
            Self::NotInVolts { .. } => "correct the unit in the file (µV, mV, V)",
        }
    }
}

/// What is doubtful about electrodes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "fault", rename_all = "snake_case")]
pub enum ElectrodesFault {
    /// Electrodes that are far noisier than the others.
    #[error("far noisier than the other electrodes, whose median is {} µV (robust SD): the contact may be bad", digits(1e6 * middle_v))]
    Noisy { middle_v: f64 },
    /// Electrodes that record far less than the others.
    #[error("far below the other electrodes, whose median is {} µV (robust SD): not connected, or beside the reference", digits(1e6 * middle_v))]
    Quiet { middle_v: f64 },
    /// An electrode that is off in many epochs.
    #[error("off in {lost} of {of} epochs, which are left out for all electrodes")]
    Off { lost: usize, of: usize },
    /// Pairs of electrodes that record the same.
    #[error(
        "differ by less than 5 %: gel may bridge them, or a channel was copied; count them as one electrode"
    )]
    Bridged,
    /// Signals whose size is not that of EEG.
    #[error(
        "the median electrode has a robust SD of {} µV, and scalp EEG has 1 to 50 µV (changes in % and dB do not depend on it, limits of rejection \
            do)",
        digits(1e6 * median_v)
    )]
    Amplitude { median_v: f64 },
    /// Channels that a table calls bad are analysed.
    #[error("analysed although the table of channels beside the file marks them as bad")]
    CalledBad,
    /// Channels without a position are in the mean of all electrodes.
    #[error(
        "in the average of all electrodes, without a position of the 10-10 system: if one of them is no electrode, it is now in all channels"
    )]
    UnknownInReference,
    /// Signals that were computed from those of other electrodes.
    #[error(
        "interpolated from {from} electrodes{}: these signals contain no information of their own, so an effect at these electrodes was not \
            measured there",
        if *share > MOST_INTERPOLATED {
            format!(" (they are {:.0} % of the electrodes, usual are at most 10 %)", 100.0 * share)
        } else {
            String::new()
        }
    )]
    Interpolated { from: usize, share: f64 },
}

impl ElectrodesFault {
    /// What a person can do.
    fn advice(&self) -> &'static str {
        match self {
            Self::Noisy { .. } | Self::Quiet { .. } => "leave them out or interpolate them",
            Self::Off { .. } => "leave it out or interpolate it to keep these epochs",
            Self::Bridged => "leave one of each pair out, or interpolate it",
            Self::Amplitude { .. } => "check the unit of the signals",
            Self::CalledBad => "leave them out, or correct the table",
            Self::UnknownInReference => "leave out what is no electrode",
            Self::Interpolated { .. } => "do not rely on an effect at these electrodes alone",
        }
    }
}

/// What is doubtful about the positions of electrodes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "fault", rename_all = "snake_case")]
pub enum PositionsFault {
    /// Values on the scalp were asked for far from any electrode.
    #[error(
        "{positions} positions are up to {angle_deg:.0}° from the nearest electrode: values there are extrapolated"
    )]
    Far { positions: usize, angle_deg: f64 },
    /// A cluster test without neighbouring electrodes.
    #[error(
        "none of {electrodes} electrodes are neighbours: positions are not known, or they are too far apart, so clusters join frequencies and times \
            of one electrode alone"
    )]
    NoNeighbours { electrodes: usize },
}

impl PositionsFault {
    /// What a person can do.
    fn advice(&self) -> &'static str {
        match self {
            Self::Far { .. } => "state the positions of the electrodes, or leave the map out",
            Self::NoNeighbours { .. } => {
                "state the positions of the electrodes, or leave clusters over the scalp out"
            }
        }
    }
}

/// What makes power wrong at an edge.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "by", rename_all = "snake_case")]
pub enum Smeared {
    /// A filter is longer than what it filters.
    #[error(
        "the filter is {filter_s:.2} s long and the signal {signal_s:.2} s: all of it is distorted at its ends"
    )]
    LongFilter { filter_s: f64, signal_s: f64 },
    /// A part of a window is so near to an end of the epoch that the wavelet reaches beyond it.
    #[error(
        "{:.0} % of the {window} lies within {reach_s:.2} s (2 SD of the wavelet) of an end of the epoch, where power is too low",
        100.0 * touched_share
    )]
    Edge {
        window: String,
        touched_share: f64,
        reach_s: f64,
    },
    /// Baseline and window are nearer to each other than the wavelet smears.
    #[error(
        "baseline and window are {gap_s:.2} s apart, and the wavelet smears over {reach_s:.2} s (2 SD): each holds some power of the other"
    )]
    Baseline { gap_s: f64, reach_s: f64 },
    /// A filter takes away a part of a band.
    #[error("{band}: the filter ({filter}) takes away a part of the band")]
    FilterInBand { band: String, filter: String },
}

impl Smeared {
    /// What a person can do.
    fn advice(&self) -> &'static str {
        match self {
            Self::LongFilter { .. } => "take a higher cut-off or a longer recording",
            Self::Edge { .. } => "cut longer epochs, or take fewer cycles",
            Self::Baseline { .. } => "move the baseline, or take fewer cycles",
            Self::FilterInBand { .. } => {
                "move the filter out of the band, or state a narrower band"
            }
        }
    }
}

/// What is doubtful about markers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "fault", rename_all = "snake_case")]
pub enum MarkersFault {
    /// Markers that stand twice at one sample.
    #[error(
        "{count} markers stand twice at the same sample under the same condition, and were taken once"
    )]
    Twice { count: usize },
    /// Markers of the file that are others than those of the table beside it.
    #[error(
        "{table}: {without} of {of} events have no marker of the file within one sample, and the file has {markers} markers, which are used: the \
            table may be of another recording"
    )]
    OtherTable {
        table: String,
        without: usize,
        of: usize,
        markers: usize,
    },
    /// Pulses that are so regular that they match with another shift as well.
    #[error(
        "{matched} regular pulses also match with a shift of {shift_s:+.3} s: the drift is correct with both shifts, the offset only with one"
    )]
    Periodic { matched: usize, shift_s: f64 },
}

impl MarkersFault {
    /// What a person can do.
    fn advice(&self) -> &'static str {
        match self {
            Self::Twice { .. } => "check that the triggers were not exported twice",
            Self::OtherTable { .. } => "name it as the table of events to use it",
            Self::Periodic { .. } => {
                "send pulses at irregular intervals, or record all of them with both devices"
            }
        }
    }
}

/// What is doubtful about the epochs of a condition.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "fault", rename_all = "snake_case")]
pub enum EpochsFault {
    /// Many epochs of a condition were rejected.
    #[error(
        "{condition}: {rejected} of {of} epochs were rejected, so that those that are left may be of another kind of trial"
    )]
    Rejected {
        condition: String,
        rejected: usize,
        of: usize,
    },
    /// Conditions differ in the share of rejected epochs.
    #[error(
        "{:.0} % of the epochs of {most} were rejected and {:.0} % of {least}: conditions whose epochs were selected unequally can differ for that \
            reason alone",
        100.0 * most_share,
        100.0 * least_share
    )]
    RejectedUnevenly {
        most: String,
        most_share: f64,
        least: String,
        least_share: f64,
    },
    /// Tasks with different numbers of epochs.
    #[error(
        "{most} has {most_epochs:.0} epochs of each surface and {fewest} has {fewest_epochs:.0}: values of fewer epochs scatter more, and the bias \
            of a percentage differs (only maps are corrected for it)"
    )]
    Unequal {
        most: String,
        most_epochs: f64,
        fewest: String,
        fewest_epochs: f64,
    },
    /// Epochs share samples with the next one.
    #[error(
        "{overlapping} of {of} epochs hold samples of the next one: markers are as little as {shortest_s:.2} s apart, and baseline and window take \
            {needed_s:.2} s, so a baseline may hold the movement before"
    )]
    Overlap {
        overlapping: usize,
        of: usize,
        shortest_s: f64,
        needed_s: f64,
    },
}

impl EpochsFault {
    /// What a person can do.
    fn advice(&self) -> &'static str {
        match self {
            Self::Rejected { .. } => {
                "look at the signals, and correct blinks by regression or ICA before epochs are rejected"
            }
            Self::RejectedUnevenly { .. } | Self::Unequal { .. } => {
                "compare equal numbers of epochs"
            }
            Self::Overlap { .. } => "take a shorter baseline or fewer markers",
        }
    }
}

/// The names before what is said of them.
fn named(names: &str) -> String {
    match names {
        "" => String::new(),
        names => format!("{names}: "),
    }
}

/// The code of a warning and what it is about, for tests: `eeg_markers/twice`.
#[cfg(test)]
pub(crate) fn code_and_cause(warning: &Warning) -> String {
    let mut tags = ["fault", "what", "why", "by"].iter();
    match tags.find_map(|tag| warning.fields.get(*tag)?.as_str()) {
        Some(cause) => format!("{}/{cause}", warning.code),
        None => warning.code.clone(),
    }
}
