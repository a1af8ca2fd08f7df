//! Warnings about the analysis of EEG.

mod words;

use piezotact::Warning;
use piezotact::warning::{Advice, FieldValue, WarningKind};

/// Declares kinds of warnings with their codes and typed fields.
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
            fn of_warning(warning: &Warning) -> Option<Self> {
                match warning.code.as_ref() {
                    $( $code => Some(Self::$variant { $(
                        $field: warning.field(stringify!($field), None)?
                    ),* }), )*
                    _ => None,
                }
            }
        }

        impl From<$name> for Warning {
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
    pub enum EegWarning {
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
        /// What some of the documents of a study warning.
        OfPeople("eeg_of_people") {
            /// Whose: participants and tasks.
            names: String,
            /// Their warning.
            example: Warning,
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

impl WarningKind for EegWarning {
    fn of(warning: &Warning) -> Option<Self> {
        Self::of_warning(warning)
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_warning_comes_back() {
        let text = || "C3".to_owned();
        for kind in [
            EegWarning::ManyRejected {
                condition: text(),
                rejected: 3,
                of: 4,
            },
            EegWarning::UnevenlyRejected {
                most: text(),
                most_share: 0.5,
                least: text(),
                least_share: 0.1,
            },
            EegWarning::FilterLongerThanSignal {
                filter_s: 3.3,
                signal_s: 2.0,
            },
            EegWarning::WindowAtEdge {
                window: text(),
                touched_share: 0.2,
                reach_s: 0.3,
            },
            EegWarning::BaselineNearWindow {
                gap_s: 0.1,
                reach_s: 0.3,
            },
            EegWarning::RatioBias {
                channel: text(),
                bias_points: 2.0,
                epochs: 10,
            },
            EegWarning::PerEpochBaseline {
                channel: text(),
                bias_points: 28.0,
                epochs: 60,
            },
            EegWarning::FewPeople {
                people: 4,
                flips: 8,
                smallest_p: 0.125,
                tests: 3,
            },
            EegWarning::NotConverged {
                iterations: 200,
                change: 1e-3,
                wanted: 1e-4,
            },
            EegWarning::FewSamplesForIca {
                samples: 100,
                wanted: 1000,
                components: 6,
            },
            EegWarning::SlowForIca { wanted_hz: 1.0 },
            EegWarning::Noisy {
                names: text(),
                middle_v: 8e-6,
            },
            EegWarning::Quiet {
                names: text(),
                middle_v: 8e-6,
            },
            EegWarning::Bridged { pairs: text() },
            EegWarning::Amplitude { median_v: 8e-12 },
            EegWarning::EventsDiffer {
                table: text(),
                without: 3,
                of: 60,
                markers: 57,
            },
            EegWarning::OfPeople {
                names: text(),
                example: EegWarning::Simulated {}.into(),
            },
            EegWarning::NoEyeComponent {
                eog: text(),
                correlation: 0.3,
                wanted: 0.7,
            },
            EegWarning::Interpolated {
                names: text(),
                from: 60,
                share: 0.2,
            },
            EegWarning::FarFromElectrodes {
                positions: 1,
                angle_deg: 40.0,
            },
            EegWarning::PeopleWithoutAllTasks {
                people: 1,
                of: 10,
                names: text(),
            },
            EegWarning::ElectrodesNotCommon {
                names: text(),
                kept: 60,
            },
            EegWarning::NoNeighbours { electrodes: 3 },
            EegWarning::SomeSaturated {
                channel: text(),
                share: 0.004,
            },
            EegWarning::PulsesPeriodic {
                matched: 50,
                shift_s: -1.0,
            },
            EegWarning::Simulated {},
            EegWarning::UnknownInReference { names: text() },
            EegWarning::WithoutPosition { names: text() },
            EegWarning::SurfacesNotCommon { names: text() },
            EegWarning::Bursts {
                channel: text(),
                scatter: 20.0,
                epochs: 12,
            },
            EegWarning::TooAlike {
                tasks: text(),
                d_z: -500.0,
            },
            EegWarning::BadLeftOut { names: text() },
            EegWarning::BadUsed { names: text() },
            EegWarning::EpochsOverlap {
                overlapping: 3,
                of: 20,
                shortest_s: 0.4,
                needed_s: 2.3,
            },
            EegWarning::MarkersTwice { count: 4 },
            EegWarning::FilterInBand {
                band: text(),
                filter: text(),
            },
            EegWarning::FewForDensity { electrodes: 8 },
            EegWarning::UnequalEpochs {
                most: text(),
                most_epochs: 60.0,
                fewest: text(),
                fewest_epochs: 12.5,
            },
        ] {
            assert!(!kind.to_string().is_empty());
            assert_eq!(Warning::from(kind.clone()).kind(), Some(kind));
        }
    }
}
