//! The sentences of warnings about EEG.

use std::fmt;

use piezotact::number::digits;

use super::EegWarning;

/// A larger share of interpolated electrodes is unusual.
const MOST_INTERPOLATED: f64 = 0.1;

impl fmt::Display for EegWarning {
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
        }
    }
}
