//! Doubts about the analysis of EEG.

use std::fmt;

use piezotact::Doubt;
use piezotact::doubt::{Advice, DoubtKind, FieldValue};
use piezotact::number::digits;

/// Declares kinds of doubts with their codes and typed fields.
macro_rules! kinds {
    (
        $(#[$meta:meta])*
        pub enum $name:ident { $(
            $(#[$doc:meta])*
            $variant:ident($code:literal) { $(
                $(#[$field_doc:meta])*
                $field:ident: $type:ty
            ),* $(,)? }
        ),* $(,)? }
    ) => {
        $(#[$meta])*
        #[derive(Clone, Debug, PartialEq)]
        pub enum $name { $(
            $(#[$doc])*
            $variant { $( $(#[$field_doc])* $field: $type ),* }
        ),* }

        impl $name {
            fn of_doubt(doubt: &Doubt) -> Option<Self> {
                match doubt.code.as_ref() {
                    $( $code => Some(Self::$variant { $(
                        $field: doubt.field(stringify!($field), None)?
                    ),* }), )*
                    _ => None,
                }
            }
        }

        impl From<$name> for Doubt {
            fn from(kind: $name) -> Self {
                let advice = kind.advice();
                match kind { $(
                    $name::$variant { $($field),* } => Self::of_fields(
                        $code,
                        [$( (stringify!($field), FieldValue::into_value($field)) ),*],
                        None,
                        advice,
                    ),
                )* }
            }
        }
    };
}

kinds! {
    /// One thing to know before relying on a result of EEG.
    pub enum EegDoubt {
        /// Many epochs of a condition were rejected.
        ManyRejected("eeg_many_epochs_rejected") {
            /// The condition.
            condition: String,
            /// How many.
            rejected: usize,
            /// Of how many.
            of: usize,
        },
        /// Conditions differ in the share of rejected epochs.
        UnevenlyRejected("eeg_epochs_rejected_unevenly") {
            /// The condition with most.
            most: String,
            /// Its share.
            most_share: f64,
            /// The condition with least.
            least: String,
            /// Its share.
            least_share: f64,
        },
        /// A filter is longer than what it filters.
        FilterLongerThanSignal("eeg_filter_longer_than_signal") {
            /// The length of the filter, s.
            filter_s: f64,
            /// The length of the signal, s.
            signal_s: f64,
        },
        /// A part of a window is so near to an end of the epoch that the wavelet reaches beyond it.
        WindowAtEdge("eeg_window_at_edge") {
            /// `baseline` or `window`.
            window: String,
            /// The share of it that is too near.
            touched_share: f64,
            /// How far the wavelet of the lowest frequency reaches, s.
            reach_s: f64,
        },
        /// Baseline and window are nearer to each other than the wavelet smears.
        BaselineNearWindow("eeg_baseline_near_window") {
            /// The time between them, s.
            gap_s: f64,
            /// How far the wavelet of the lowest frequency reaches, s.
            reach_s: f64,
        },
        /// The baseline's power is so uncertain that the ratio to it is biased.
        RatioBias("eeg_erd_ratio_bias") {
            /// The channel where it is largest.
            channel: String,
            /// The estimated bias at no change, percentage points.
            bias_points: f64,
            /// How many epochs there are.
            epochs: usize,
        },
        /// Percentages were computed for each epoch and then averaged.
        PerEpochBaseline("eeg_erd_per_epoch_baseline") {
            /// The channel where the bias is largest.
            channel: String,
            /// The estimated bias at no change, percentage points.
            bias_points: f64,
            /// How many epochs there are.
            epochs: usize,
        },
        /// So few people that the smallest probability is large.
        FewPeople("eeg_cluster_few_people") {
            /// How many.
            people: usize,
            /// How many different sign flips there are.
            flips: usize,
            /// The smallest p that they can give.
            smallest_p: f64,
            /// Over how many tests it is adjusted by Holm.
            tests: usize,
        },
        /// ICA stopped before its rule.
        NotConverged("eeg_ica_not_converged") {
            /// After so many iterations.
            iterations: usize,
            /// The last change.
            change: f64,
            /// The change at which it would have stopped.
            wanted: f64,
        },
        /// Independent components of signals that hold slow drifts.
        SlowForIca("eeg_ica_without_high_pass") {
            /// From which frequency on they are wanted, Hz.
            wanted_hz: f64,
        },
        /// No independent component follows the eyes.
        NoEyeComponent("eeg_no_eye_component") {
            /// The EOG channel that one follows most.
            eog: String,
            /// Its correlation with it, 0–1.
            correlation: f64,
            /// The correlation from which on it is taken out.
            wanted: f64,
        },
        /// Signals that were computed from those of other electrodes.
        Interpolated("eeg_electrodes_interpolated") {
            /// Which.
            names: String,
            /// From how many.
            from: usize,
            /// Their share of all electrodes, 0–1.
            share: f64,
        },
        /// ICA has few samples for its number of components.
        FewSamplesForIca("eeg_ica_few_samples") {
            /// How many.
            samples: usize,
            /// How many are wanted.
            wanted: usize,
            /// Components.
            components: usize,
        },
        /// Values on the scalp were asked for far from any electrode.
        FarFromElectrodes("eeg_map_far_from_electrodes") {
            /// How many positions.
            positions: usize,
            /// The largest angle to the nearest electrode, degrees.
            angle_deg: f64,
        },
        /// A small number of epochs in a phase measure, which has a floor.
        CoherenceFloor("eeg_itc_floor") {
            /// How many epochs.
            epochs: usize,
            /// What is expected of random phases.
            expected: f64,
        },
        /// Some people did not take part in all tasks.
        PeopleWithoutAllTasks("eeg_people_without_all_tasks") {
            /// How many.
            people: usize,
            /// Of how many.
            of: usize,
            /// Who.
            names: String,
        },
        /// Electrodes that some documents do not have.
        ElectrodesNotCommon("eeg_electrodes_not_common") {
            /// Which.
            names: String,
            /// How many all have.
            kept: usize,
        },
        /// A cluster test without neighbouring electrodes.
        NoNeighbours("eeg_cluster_no_neighbours") {
            /// How many electrodes there are.
            electrodes: usize,
        },
        /// The recording was made by the digital twin.
        Simulated("eeg_simulated") {},
        /// Channels that a table calls bad are left out.
        BadLeftOut("eeg_bad_channels_left_out") {
            /// Which.
            names: String,
        },
        /// Channels without a position are in the mean of all electrodes.
        UnknownInReference("eeg_unknown_in_reference") {
            /// Which.
            names: String,
        },
        /// Channels without a position are left out of a current source density.
        WithoutPosition("eeg_csd_without_position") {
            /// Which.
            names: String,
        },
        /// Power scatters so much from epoch to epoch that maps of few epochs are biased.
        Bursts("eeg_power_in_bursts") {
            /// The channel where it scatters most.
            channel: String,
            /// The median variance over epochs, re the squared mean: 1 for noise.
            scatter: f64,
            /// How many epochs there are.
            epochs: usize,
        },
        /// The difference of two tasks is nearly the same in all people.
        TooAlike("eeg_difference_without_scatter") {
            /// The tasks.
            tasks: String,
            /// The mean difference in standard deviations.
            d_z: f64,
        },
        /// Electrodes that are far noisier than the others.
        Noisy("eeg_electrodes_noisy") {
            /// Which, with their robust deviation.
            names: String,
            /// That of the median electrode, V.
            middle_v: f64,
        },
        /// Electrodes that record far less than the others.
        Quiet("eeg_electrodes_quiet") {
            /// Which, with their robust deviation.
            names: String,
            /// That of the median electrode, V.
            middle_v: f64,
        },
        /// Pairs of electrodes that record the same.
        Bridged("eeg_electrodes_bridged") {
            /// Which.
            pairs: String,
        },
        /// Signals whose size is not that of EEG.
        Amplitude("eeg_amplitude_implausible") {
            /// The robust deviation of the median electrode, V.
            median_v: f64,
        },
        /// Markers of the file that are others than those of the table beside it.
        EventsDiffer("eeg_events_differ") {
            /// The table.
            table: String,
            /// How many events of it have no marker of the file within one sample.
            without: usize,
            /// Of how many.
            of: usize,
            /// How many markers the file has.
            markers: usize,
        },
        /// What some of the documents of a study doubt.
        OfPeople("eeg_of_people") {
            /// Whose: participants and tasks.
            names: String,
            /// Their doubt.
            example: Doubt,
        },
        /// Documents with surfaces that others do not have.
        SurfacesNotCommon("eeg_surfaces_not_common") {
            /// Which participants and tasks, and what they lack.
            names: String,
        },
        /// Channels that a table calls bad are analysed.
        BadUsed("eeg_bad_channels_used") {
            /// Which.
            names: String,
        },
        /// Epochs share samples with the next one.
        EpochsOverlap("eeg_epochs_overlap") {
            /// How many do.
            overlapping: usize,
            /// Of how many.
            of: usize,
            /// The shortest time from one marker to the next, s.
            shortest_s: f64,
            /// From the first to the last time that baseline or window need, s.
            needed_s: f64,
        },
        /// Markers that stand twice at one sample.
        MarkersTwice("eeg_markers_twice") {
            /// How many were taken once.
            count: usize,
        },
        /// A filter takes away a part of a band.
        FilterInBand("eeg_filter_in_band") {
            /// The band.
            band: String,
            /// The filter.
            filter: String,
        },
        /// A current source density of few electrodes.
        FewForDensity("eeg_csd_few_electrodes") {
            /// How many.
            electrodes: usize,
        },
        /// Tasks with different numbers of epochs.
        UnequalEpochs("eeg_epochs_unequal") {
            /// The task with most.
            most: String,
            /// The mean number of each surface in it.
            most_epochs: f64,
            /// The task with fewest.
            fewest: String,
            /// The mean number in it.
            fewest_epochs: f64,
        },
        /// Some samples of a channel are at the limit of the amplifier.
        SomeSaturated("eeg_some_saturated") {
            /// The channel.
            channel: String,
            /// The share of samples, 0–1.
            share: f64,
        },
        /// Pulses that are so regular that they match with another shift as well.
        PulsesPeriodic("eeg_pulses_periodic") {
            /// How many match.
            matched: usize,
            /// By how much the other match is shifted, s.
            shift_s: f64,
        },
    }
}

impl DoubtKind for EegDoubt {
    fn of(doubt: &Doubt) -> Option<Self> {
        Self::of_doubt(doubt)
    }

    fn advice(&self) -> Vec<Advice> {
        match self {
            Self::ManyRejected { .. } => vec![Advice::RecordAgain],
            Self::RatioBias {
                bias_points,
                epochs,
                ..
            } => vec![Advice::RecordMore {
                // The bias falls with one over the number of epochs.
                count: (*epochs as f64 * bias_points.abs()).ceil() as usize,
            }],
            Self::FewPeople { tests, .. } => vec![Advice::MeasureParticipants {
                // 2ⁿ⁻¹ flips, of which one has to be at most 5 % after Holm.
                count: ((20.0 * *tests as f64).log2().ceil() as usize) + 1,
            }],
            Self::FilterLongerThanSignal { .. }
            | Self::FewSamplesForIca { .. }
            | Self::NotConverged { .. } => vec![Advice::RecordLonger],
            Self::OfPeople { example, .. } => example.advice.clone(),
            _ => Vec::new(),
        }
    }
}

/// A larger share of interpolated electrodes is unusual.
const MOST_INTERPOLATED: f64 = 0.1;

impl fmt::Display for EegDoubt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::ManyRejected {
                condition,
                rejected,
                of,
            } => write!(
                f,
                "{condition}: {rejected} of {of} epochs were rejected: those that are left may be of another kind of trial; look at \
                 the signals, and correct blinks by regression or ICA before epochs are rejected"
            ),
            Self::UnevenlyRejected {
                most,
                most_share,
                least,
                least_share,
            } => write!(
                f,
                "{:.0} % of the epochs of {most} were rejected and {:.0} % of {least}: conditions whose epochs were selected unequally \
                 can differ for that reason alone",
                100.0 * most_share,
                100.0 * least_share
            ),
            Self::FilterLongerThanSignal { filter_s, signal_s } => write!(
                f,
                "the filter is {filter_s:.2} s long and the signal {signal_s:.2} s: all of it is distorted at its ends; take a higher cut-off or a longer \
                 recording"
            ),
            Self::WindowAtEdge {
                window,
                touched_share,
                reach_s,
            } => write!(
                f,
                "{:.0} % of the {window} lies within {reach_s:.2} s (2 SD of the wavelet) of an end of the epoch, where power is too \
                 low: cut longer epochs, or take fewer cycles",
                100.0 * touched_share
            ),
            Self::BaselineNearWindow { gap_s, reach_s } => write!(
                f,
                "baseline and window are {gap_s:.2} s apart, and the wavelet smears over {reach_s:.2} s (2 SD): each holds some power \
                 of the other; move the baseline, or take fewer cycles"
            ),
            Self::RatioBias {
                channel,
                bias_points,
                epochs,
            } => write!(
                f,
                "{channel}: with {epochs} epochs the power of the baseline is uncertain, and percentages are too high by about {bias_points:.1} points \
                 (a desynchronisation looks smaller); record more epochs or take a longer baseline"
            ),
            Self::PerEpochBaseline {
                channel,
                bias_points,
                epochs,
            } => write!(
                f,
                "percentages of each of {epochs} epochs were averaged: an epoch whose baseline is low by chance counts most, so no \
                 change would show as {bias_points:+.1} percentage points at {channel}; average power before the baseline is divided"
            ),
            Self::FewPeople {
                people,
                flips,
                smallest_p,
                tests: 1,
            } => write!(
                f,
                "{people} people have {flips} different sign flips, so the smallest possible p is {smallest_p:.3}: no cluster can be \
                 below 0.05"
            ),
            Self::FewPeople {
                people,
                flips,
                smallest_p,
                tests,
            } => write!(
                f,
                "{people} people have {flips} different sign flips, so the smallest possible p is {smallest_p:.3}, and {:.3} after Holm over \
                 {tests} pairs of tasks: no cluster may be below 0.05",
                (smallest_p * *tests as f64).min(1.0)
            ),
            Self::NotConverged {
                iterations,
                change,
                wanted,
            } => write!(
                f,
                "ICA stopped after {iterations} iterations with a change of {change:.1e}, and {wanted:.1e} was asked for: components \
                 may be mixed; give more samples or fewer components"
            ),
            Self::Noisy { names, middle_v } => write!(
                f,
                "{names}: far noisier than the other electrodes, whose median is {} µV (robust SD): the contact may be bad; leave them out or interpolate \
                 them",
                digits(1e6 * middle_v)
            ),
            Self::Quiet { names, middle_v } => write!(
                f,
                "{names}: far below the other electrodes, whose median is {} µV (robust SD): not connected, or beside the reference; leave them out \
                 or interpolate them",
                digits(1e6 * middle_v)
            ),
            Self::Bridged { pairs } => write!(
                f,
                "{pairs}: record the same but for 5 %, so gel may bridge them, or a channel was copied; values at these electrodes are one \
                 measurement"
            ),
            Self::Amplitude { median_v } => write!(
                f,
                "The median electrode has a robust SD of {} µV, and scalp EEG has 1 to 50 µV: check the unit of the signals. Changes in % and dB do not \
                 depend on it, limits of rejection do",
                digits(1e6 * median_v)
            ),
            Self::EventsDiffer {
                table,
                without,
                of,
                markers,
            } => write!(
                f,
                "{table}: {without} of {of} events have no marker of the file within one sample, and the file has {markers} markers, which are used: \
                 the table may be of another recording; name it as the table of events to use it"
            ),
            Self::OfPeople { names, example } => write!(f, "{names}: {example}"),
            Self::SlowForIca { wanted_hz } => write!(
                f,
                "Independent components of signals with changes below {wanted_hz} Hz: components may describe drifts in the place of blinks; \
                 filter with a high-pass of {wanted_hz} Hz or more"
            ),
            Self::NoEyeComponent {
                eog,
                correlation,
                wanted,
            } => write!(
                f,
                "No independent component was taken out: the largest correlation with an EOG channel is {correlation:.2} ({eog}), and {wanted:.2} \
                 was asked for. Blinks may still be in the signals; look at the components, state a lower correlation, or take the regression"
            ),
            Self::Interpolated { names, from, share } => {
                write!(
                    f,
                    "{names}: interpolated from {from} electrodes. These signals hold nothing that the others do not hold: an effect there is no \
                     measurement at this place"
                )?;
                if *share > MOST_INTERPOLATED {
                    write!(
                        f,
                        ". They are {:.0} % of the electrodes; usual are at most 10 %",
                        100.0 * share
                    )?;
                }
                Ok(())
            }
            Self::FewSamplesForIca {
                samples,
                wanted,
                components,
            } => write!(
                f,
                "{samples} samples for {components} components, and about {wanted} are wanted (30 times the square of their number): \
                 components may be those of noise; give more samples or fewer components"
            ),
            Self::FarFromElectrodes {
                positions,
                angle_deg,
            } => write!(
                f,
                "{positions} positions are up to {angle_deg:.0}° from the nearest electrode: values there are extrapolated"
            ),
            Self::PeopleWithoutAllTasks { people, of, names } => write!(
                f,
                "{people} of {of} participants did not take part in all tasks ({names}): each contrast is of those who took part in both"
            ),
            Self::ElectrodesNotCommon { names, kept } => write!(
                f,
                "Not in all documents: {names}. Maps and clusters are of the other {kept} electrodes; interpolate those that are bad, and check that no \
                 channel has another name in one recording"
            ),
            Self::NoNeighbours { electrodes } => write!(
                f,
                "none of {electrodes} electrodes are neighbours: positions are not known, or they are too far apart, so clusters join frequencies and \
                 times of one electrode alone"
            ),
            Self::Simulated {} => f.write_str(
                "the digital twin made this EEG: no person took part, and nothing follows from it about people",
            ),
            Self::BadLeftOut { names } => write!(
                f,
                "{names}: left out, as the table of channels beside the file calls them bad; name all channels to analyse them"
            ),
            Self::UnknownInReference { names } => write!(
                f,
                "{names}: in the average of all electrodes, without a position of the 10-10 system: if one of them is no electrode, it is now in all \
                 channels; leave it out"
            ),
            Self::WithoutPosition { names } => write!(
                f,
                "{names}: left out of the current source density, as their positions are not known"
            ),
            Self::Bursts {
                channel,
                scatter,
                epochs,
            } => write!(
                f,
                "{channel}: power comes in bursts (variance over {epochs} epochs {scatter:.0} times that of noise): maps in dB are then too low for few \
                 epochs in spite of their correction; compare equal numbers of epochs only"
            ),
            Self::TooAlike { tasks, d_z } => write!(
                f,
                "{tasks}: d_z is {d_z:+.0}, so the difference is nearly the same in all people: check that the documents are of different people \
                 and recordings"
            ),
            Self::SurfacesNotCommon { names } => write!(
                f,
                "not all documents have all surfaces ({names}): the mean of surfaces and its contrasts are of the others alone; name surfaces \
                 alike in all tasks"
            ),
            Self::BadUsed { names } => write!(
                f,
                "{names}: analysed although the table of channels beside the file calls them bad; leave them out, or correct the table"
            ),
            Self::EpochsOverlap {
                overlapping,
                of,
                shortest_s,
                needed_s,
            } => write!(
                f,
                "{overlapping} of {of} epochs hold samples of the next one: markers are as little as {shortest_s:.2} s apart, and baseline and \
                 window take {needed_s:.2} s, so a baseline may hold the movement before; take a shorter baseline or fewer markers"
            ),
            Self::MarkersTwice { count } => write!(
                f,
                "{count} markers stand twice at the same sample under the same condition, and were taken once: check that the triggers were not \
                 exported twice"
            ),
            Self::FilterInBand { band, filter } => write!(
                f,
                "{band}: the filter ({filter}) takes away a part of the band; move it out of the band, or state a narrower band"
            ),
            Self::FewForDensity { electrodes } => write!(
                f,
                "the current source density of {electrodes} electrodes is coarse (about 32 are usual): its values depend on where they are; \
                 take the average reference, or record with more electrodes"
            ),
            Self::UnequalEpochs {
                most,
                most_epochs,
                fewest,
                fewest_epochs,
            } => write!(
                f,
                "{most} has {most_epochs:.0} epochs of each surface and {fewest} has {fewest_epochs:.0}: values of fewer epochs scatter more, and \
                 the bias of a percentage differs; the maps are corrected for it, but equal numbers are safer"
            ),
            Self::SomeSaturated { channel, share } => write!(
                f,
                "{channel}: {:.2} % of the samples are at the limit of the amplifier: power is wrong there; reject these epochs by their \
                 amplitude, or record with a lower gain",
                100.0 * share
            ),
            Self::PulsesPeriodic { matched, shift_s } => write!(
                f,
                "{matched} pulses match with a shift of {shift_s:+.3} s as well, since they are regular: the drift is right with both, the \
                 offset with one of them; send pulses at irregular intervals, or record all of them with both devices"
            ),
            Self::CoherenceFloor { epochs, expected } => write!(
                f,
                "{epochs} epochs of random phase have an inter-trial coherence of {expected:.2} on average: compare conditions with \
                 the same number of epochs only"
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_doubt_comes_back() {
        let text = || "C3".to_owned();
        for kind in [
            EegDoubt::ManyRejected {
                condition: text(),
                rejected: 3,
                of: 4,
            },
            EegDoubt::UnevenlyRejected {
                most: text(),
                most_share: 0.5,
                least: text(),
                least_share: 0.1,
            },
            EegDoubt::FilterLongerThanSignal {
                filter_s: 3.3,
                signal_s: 2.0,
            },
            EegDoubt::WindowAtEdge {
                window: text(),
                touched_share: 0.2,
                reach_s: 0.3,
            },
            EegDoubt::BaselineNearWindow {
                gap_s: 0.1,
                reach_s: 0.3,
            },
            EegDoubt::RatioBias {
                channel: text(),
                bias_points: 2.0,
                epochs: 10,
            },
            EegDoubt::PerEpochBaseline {
                channel: text(),
                bias_points: 28.0,
                epochs: 60,
            },
            EegDoubt::FewPeople {
                people: 4,
                flips: 8,
                smallest_p: 0.125,
                tests: 3,
            },
            EegDoubt::NotConverged {
                iterations: 200,
                change: 1e-3,
                wanted: 1e-4,
            },
            EegDoubt::FewSamplesForIca {
                samples: 100,
                wanted: 1000,
                components: 6,
            },
            EegDoubt::SlowForIca { wanted_hz: 1.0 },
            EegDoubt::Noisy {
                names: text(),
                middle_v: 8e-6,
            },
            EegDoubt::Quiet {
                names: text(),
                middle_v: 8e-6,
            },
            EegDoubt::Bridged { pairs: text() },
            EegDoubt::Amplitude { median_v: 8e-12 },
            EegDoubt::EventsDiffer {
                table: text(),
                without: 3,
                of: 60,
                markers: 57,
            },
            EegDoubt::OfPeople {
                names: text(),
                example: EegDoubt::Simulated {}.into(),
            },
            EegDoubt::NoEyeComponent {
                eog: text(),
                correlation: 0.3,
                wanted: 0.7,
            },
            EegDoubt::Interpolated {
                names: text(),
                from: 60,
                share: 0.2,
            },
            EegDoubt::FarFromElectrodes {
                positions: 1,
                angle_deg: 40.0,
            },
            EegDoubt::PeopleWithoutAllTasks {
                people: 1,
                of: 10,
                names: text(),
            },
            EegDoubt::ElectrodesNotCommon {
                names: text(),
                kept: 60,
            },
            EegDoubt::NoNeighbours { electrodes: 3 },
            EegDoubt::SomeSaturated {
                channel: text(),
                share: 0.004,
            },
            EegDoubt::PulsesPeriodic {
                matched: 50,
                shift_s: -1.0,
            },
            EegDoubt::CoherenceFloor {
                epochs: 10,
                expected: 0.28,
            },
            EegDoubt::Simulated {},
            EegDoubt::UnknownInReference { names: text() },
            EegDoubt::WithoutPosition { names: text() },
            EegDoubt::SurfacesNotCommon { names: text() },
            EegDoubt::Bursts {
                channel: text(),
                scatter: 20.0,
                epochs: 12,
            },
            EegDoubt::TooAlike {
                tasks: text(),
                d_z: -500.0,
            },
            EegDoubt::BadLeftOut { names: text() },
            EegDoubt::BadUsed { names: text() },
            EegDoubt::EpochsOverlap {
                overlapping: 3,
                of: 20,
                shortest_s: 0.4,
                needed_s: 2.3,
            },
            EegDoubt::MarkersTwice { count: 4 },
            EegDoubt::FilterInBand {
                band: text(),
                filter: text(),
            },
            EegDoubt::FewForDensity { electrodes: 8 },
            EegDoubt::UnequalEpochs {
                most: text(),
                most_epochs: 60.0,
                fewest: text(),
                fewest_epochs: 12.5,
            },
        ] {
            assert!(!kind.to_string().is_empty());
            assert_eq!(Doubt::from(kind.clone()).kind(), Some(kind));
        }
    }
}
