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
    /// Many epochs of a condition were rejected.
    #[error(
        "{condition}: {rejected} of {of} epochs were rejected: those that are left may be of another kind of trial; look at the signals, and \
            correct blinks by regression or ICA before epochs are rejected"
    )]
    #[serde(rename = "eeg_many_epochs_rejected")]
    ManyRejected {
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
    #[serde(rename = "eeg_epochs_rejected_unevenly")]
    UnevenlyRejected {
        most: String,
        most_share: f64,
        least: String,
        least_share: f64,
    },
    /// A filter is longer than what it filters.
    #[error(
        "the filter is {filter_s:.2} s long and the signal {signal_s:.2} s: all of it is distorted at its ends; take a higher cut-off or a longer \
            recording"
    )]
    #[serde(rename = "eeg_filter_longer_than_signal")]
    FilterLongerThanSignal { filter_s: f64, signal_s: f64 },
    /// A part of a window is so near to an end of the epoch that the wavelet reaches beyond it.
    #[error(
        "{:.0} % of the {window} lies within {reach_s:.2} s (2 SD of the wavelet) of an end of the epoch, where power is too low: cut longer \
            epochs, or take fewer cycles",
        100.0 * touched_share
    )]
    #[serde(rename = "eeg_window_at_edge")]
    WindowAtEdge {
        window: String,
        touched_share: f64,
        reach_s: f64,
    },
    /// Baseline and window are nearer to each other than the wavelet smears.
    #[error(
        "baseline and window are {gap_s:.2} s apart, and the wavelet smears over {reach_s:.2} s (2 SD): each holds some power of the other; move \
            the baseline, or take fewer cycles"
    )]
    #[serde(rename = "eeg_baseline_near_window")]
    BaselineNearWindow { gap_s: f64, reach_s: f64 },
    /// The baseline's power is so uncertain that the ratio to it is biased.
    #[error(
        "{channel}: with {epochs} epochs the power of the baseline is uncertain, and percentages are too high by about {bias_points:.1} points (a \
            desynchronisation looks smaller); record more epochs or take a longer baseline"
    )]
    #[serde(rename = "eeg_erd_ratio_bias")]
    RatioBias {
        channel: String,
        bias_points: f64,
        epochs: usize,
    },
    /// Percentages were computed for each epoch and then averaged.
    #[error(
        "percentages of each of {epochs} epochs were averaged: an epoch whose baseline is low by chance counts most, so no change would show as \
            {bias_points:+.1} percentage points at {channel}; average power before the baseline is divided"
    )]
    #[serde(rename = "eeg_erd_per_epoch_baseline")]
    PerEpochBaseline {
        channel: String,
        bias_points: f64,
        epochs: usize,
    },
    /// So few people that the smallest probability is large.
    #[error(
        "{people} people have {flips} different sign flips, so the smallest possible p is {smallest_p:.3}{}; measure {} participants or more",
        match tests {
        1 => ": no cluster can be below 0.05".to_owned(),
        tests => format!(
        ", and {:.3} after Holm over {tests} pairs of tasks: no cluster may be below 0.05",
        (smallest_p * *tests as f64).min(1.0)
        ),
        },
        people_for(*tests)
    )]
    #[serde(rename = "eeg_cluster_few_people")]
    FewPeople {
        people: usize,
        flips: usize,
        smallest_p: f64,
        tests: usize,
    },
    /// ICA stopped before its rule.
    #[error(
        "ICA stopped after {iterations} iterations with a change of {change:.1e}, and {wanted:.1e} was asked for: components may be mixed; give \
            more samples or fewer components"
    )]
    #[serde(rename = "eeg_ica_not_converged")]
    NotConverged {
        iterations: usize,
        change: f64,
        wanted: f64,
    },
    /// Independent components of signals that hold slow drifts.
    #[error(
        "Independent components of signals with changes below {wanted_hz} Hz: components may describe drifts in the place of blinks; filter with a \
            high-pass of {wanted_hz} Hz or more"
    )]
    #[serde(rename = "eeg_ica_without_high_pass")]
    SlowForIca { wanted_hz: f64 },
    /// No independent component follows the eyes.
    #[error(
        "No independent component was taken out: the largest correlation with an EOG channel is {correlation:.2} ({eog}), and {wanted:.2} was asked \
            for. Blinks may still be in the signals; look at the components, state a lower correlation, or take the regression"
    )]
    #[serde(rename = "eeg_no_eye_component")]
    NoEyeComponent {
        eog: String,
        correlation: f64,
        wanted: f64,
    },
    /// Signals that were computed from those of other electrodes.
    #[error(
        "{names}: interpolated from {from} electrodes. These signals hold nothing that the others do not hold: an effect there is no measurement at \
            this place{}",
        if *share > MOST_INTERPOLATED {
        format!(". They are {:.0} % of the electrodes; usual are at most 10 %", 100.0 * share)
        } else {
        String::new()
        }
    )]
    #[serde(rename = "eeg_electrodes_interpolated")]
    Interpolated {
        names: String,
        from: usize,
        share: f64,
    },
    /// ICA has few samples for its number of components.
    #[error(
        "{samples} samples for {components} components, and about {wanted} are wanted (30 times the square of their number): components may be \
            those of noise; give more samples or fewer components"
    )]
    #[serde(rename = "eeg_ica_few_samples")]
    FewSamplesForIca {
        samples: usize,
        wanted: usize,
        components: usize,
    },
    /// Values on the scalp were asked for far from any electrode.
    #[error(
        "{positions} positions are up to {angle_deg:.0}° from the nearest electrode: values there are extrapolated"
    )]
    #[serde(rename = "eeg_map_far_from_electrodes")]
    FarFromElectrodes { positions: usize, angle_deg: f64 },
    /// Some people did not take part in all tasks.
    #[error(
        "{people} of {of} participants did not take part in all tasks ({names}): each contrast is of those who took part in both"
    )]
    #[serde(rename = "eeg_people_without_all_tasks")]
    PeopleWithoutAllTasks {
        people: usize,
        of: usize,
        names: String,
    },
    /// Electrodes that some documents do not have.
    #[error(
        "Not in all documents: {names}. Maps and clusters are of the other {kept} electrodes; interpolate those that are bad, and check that no \
            channel has another name in one recording"
    )]
    #[serde(rename = "eeg_electrodes_not_common")]
    ElectrodesNotCommon { names: String, kept: usize },
    /// A cluster test without neighbouring electrodes.
    #[error(
        "none of {electrodes} electrodes are neighbours: positions are not known, or they are too far apart, so clusters join frequencies and times \
            of one electrode alone"
    )]
    #[serde(rename = "eeg_cluster_no_neighbours")]
    NoNeighbours { electrodes: usize },
    /// The recording was made by the digital twin.
    #[error(
        "the digital twin made this EEG: no person took part, and nothing follows from it about people"
    )]
    #[serde(rename = "eeg_simulated")]
    Simulated,
    /// Channels that a table calls bad are left out.
    #[error(
        "{names}: left out, as the table of channels beside the file calls them bad; name all channels to analyse them"
    )]
    #[serde(rename = "eeg_bad_channels_left_out")]
    BadLeftOut { names: String },
    /// Channels without a position are in the mean of all electrodes.
    #[error(
        "{names}: in the average of all electrodes, without a position of the 10-10 system: if one of them is no electrode, it is now in all \
            channels; leave it out"
    )]
    #[serde(rename = "eeg_unknown_in_reference")]
    UnknownInReference { names: String },
    /// Channels without a position are left out of a current source density.
    #[error("{names}: left out of the current source density, as their positions are not known")]
    #[serde(rename = "eeg_csd_without_position")]
    WithoutPosition { names: String },
    /// Power scatters so much from epoch to epoch that maps of few epochs are biased.
    #[error(
        "{channel}: power comes in bursts (variance over {epochs} epochs {scatter:.0} times that of noise): maps in dB are then too low for few \
            epochs in spite of their correction; compare equal numbers of epochs only"
    )]
    #[serde(rename = "eeg_power_in_bursts")]
    Bursts {
        channel: String,
        scatter: f64,
        epochs: usize,
    },
    /// The difference of two tasks is nearly the same in all people.
    #[error(
        "{tasks}: d_z is {d_z:+.0}, so the difference is nearly the same in all people: check that the documents are of different people and \
            recordings"
    )]
    #[serde(rename = "eeg_difference_without_scatter")]
    TooAlike { tasks: String, d_z: f64 },
    /// Electrodes that are far noisier than the others.
    #[error(
        "{names}: far noisier than the other electrodes, whose median is {} µV (robust SD): the contact may be bad; leave them out or interpolate \
            them",
        digits(1e6 * middle_v)
    )]
    #[serde(rename = "eeg_electrodes_noisy")]
    Noisy { names: String, middle_v: f64 },
    /// Electrodes that record far less than the others.
    #[error(
        "{names}: far below the other electrodes, whose median is {} µV (robust SD): not connected, or beside the reference; leave them out or \
            interpolate them",
        digits(1e6 * middle_v)
    )]
    #[serde(rename = "eeg_electrodes_quiet")]
    Quiet { names: String, middle_v: f64 },
    /// Pairs of electrodes that record the same.
    #[error(
        "{pairs}: record the same but for 5 %, so gel may bridge them, or a channel was copied; values at these electrodes are one measurement"
    )]
    #[serde(rename = "eeg_electrodes_bridged")]
    Bridged { pairs: String },
    /// Signals whose size is not that of EEG.
    #[error(
        "The median electrode has a robust SD of {} µV, and scalp EEG has 1 to 50 µV: check the unit of the signals. Changes in % and dB do not \
            depend on it, limits of rejection do",
        digits(1e6 * median_v)
    )]
    #[serde(rename = "eeg_amplitude_implausible")]
    Amplitude { median_v: f64 },
    /// Markers of the file that are others than those of the table beside it.
    #[error(
        "{table}: {without} of {of} events have no marker of the file within one sample, and the file has {markers} markers, which are used: the \
            table may be of another recording; name it as the table of events to use it"
    )]
    #[serde(rename = "eeg_events_differ")]
    EventsDiffer {
        table: String,
        without: usize,
        of: usize,
        markers: usize,
    },
    /// What some of the documents of a study warning.
    #[error("{names}: {example}")]
    #[serde(rename = "eeg_of_people")]
    OfPeople { names: String, example: Warning },
    /// Documents with surfaces that others do not have.
    #[error(
        "not all documents have all surfaces ({names}): the mean of surfaces and its contrasts are of the others alone; name surfaces alike in all \
            tasks"
    )]
    #[serde(rename = "eeg_surfaces_not_common")]
    SurfacesNotCommon { names: String },
    /// Channels that a table calls bad are analysed.
    #[error(
        "{names}: analysed although the table of channels beside the file calls them bad; leave them out, or correct the table"
    )]
    #[serde(rename = "eeg_bad_channels_used")]
    BadUsed { names: String },
    /// Epochs share samples with the next one.
    #[error(
        "{overlapping} of {of} epochs hold samples of the next one: markers are as little as {shortest_s:.2} s apart, and baseline and window take \
            {needed_s:.2} s, so a baseline may hold the movement before; take a shorter baseline or fewer markers"
    )]
    #[serde(rename = "eeg_epochs_overlap")]
    EpochsOverlap {
        overlapping: usize,
        of: usize,
        shortest_s: f64,
        needed_s: f64,
    },
    /// Markers that stand twice at one sample.
    #[error(
        "{count} markers stand twice at the same sample under the same condition, and were taken once: check that the triggers were not exported \
            twice"
    )]
    #[serde(rename = "eeg_markers_twice")]
    MarkersTwice { count: usize },
    /// A filter takes away a part of a band.
    #[error(
        "{band}: the filter ({filter}) takes away a part of the band; move it out of the band, or state a narrower band"
    )]
    #[serde(rename = "eeg_filter_in_band")]
    FilterInBand { band: String, filter: String },
    /// A current source density of few electrodes.
    #[error(
        "the current source density of {electrodes} electrodes is coarse (about 32 are usual): its values depend on where they are; take the \
            average reference, or record with more electrodes"
    )]
    #[serde(rename = "eeg_csd_few_electrodes")]
    FewForDensity { electrodes: usize },
    /// Tasks with different numbers of epochs.
    #[error(
        "{most} has {most_epochs:.0} epochs of each surface and {fewest} has {fewest_epochs:.0}: values of fewer epochs scatter more, and the bias \
            of a percentage differs; the maps are corrected for it, but equal numbers are safer"
    )]
    #[serde(rename = "eeg_epochs_unequal")]
    UnequalEpochs {
        most: String,
        most_epochs: f64,
        fewest: String,
        fewest_epochs: f64,
    },
    /// Some samples of a channel are at the limit of the amplifier.
    #[error(
        "{channel}: {:.2} % of the samples are at the limit of the amplifier: power is wrong there; reject these epochs by their amplitude, or \
            record with a lower gain",
        100.0 * share
    )]
    #[serde(rename = "eeg_some_saturated")]
    SomeSaturated { channel: String, share: f64 },
    /// Pulses that are so regular that they match with another shift as well.
    #[error(
        "{matched} pulses match with a shift of {shift_s:+.3} s as well, since they are regular: the drift is right with both, the offset with one \
            of them; send pulses at irregular intervals, or record all of them with both devices"
    )]
    #[serde(rename = "eeg_pulses_periodic")]
    PulsesPeriodic { matched: usize, shift_s: f64 },
}

/// The fewest people with whom one of `tests` clusters can be below 5 % after Holm: 2ⁿ⁻¹ sign flips.
fn people_for(tests: usize) -> usize {
    ((20.0 * tests as f64).log2().ceil() as usize) + 1
}
