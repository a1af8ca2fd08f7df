//! Warnings about a transfer function.

use std::fmt;

use crate::number::rounded;
use crate::quantity::Band;
use crate::warning::words::{bands as list, percent};
use crate::warning::{Advice, Subject, WarningKind, warnings};

warnings! {
    /// Warnings about a transfer function.
    pub enum TransferWarning {
        /// Coherence is below what the estimate needs in part of the band.
        LowCoherence("low_coherence") {
            /// The level asked for.
            asked: f64,
            /// The lowest coherence in the band.
            lowest: f64,
            /// Where it is lowest, in Hz.
            at_hz: f64,
            /// The share of the band's lines below the level, 0–1.
            share: f64,
        },
        /// A coherence outside 0–1, which no pair of signals can have.
        ImpossibleCoherence("impossible_coherence") {
            /// The frequency of the worst line, Hz.
            at_hz: f64,
            /// The value found there.
            found: f64,
            /// The number of such lines.
            lines: usize,
        },
        /// Few averages: the estimate scatters.
        FewAverages("few_averages") {
            /// The number of segments averaged.
            averages: usize,
            /// The number recommended.
            recommended: usize,
        },
        /// The response comes so late after the drive that segments no longer hold the same event.
        LateResponse("late_response") {
            /// The delay in s.
            delay_s: f64,
            /// The length of a segment in s.
            segment_s: f64,
            /// How far the delay may be off, s.
            reach_s: f64,
        },
        /// The response comes before the drive.
        Acausal("acausal") {
            /// How much before, s.
            lead_s: f64,
            /// How far that may be off, s.
            reach_s: f64,
        },
        /// Every line is real and positive: the phase is missing.
        NoPhase("no_phase") {
            /// How many lines.
            lines: usize,
        },
        /// The drive has the unit of a response, and the response has the unit of a drive.
        SwappedUnits("swapped_units") {
            /// The drive's unit.
            drive: String,
            /// The response's unit.
            response: String,
        },
        /// Part of the band was not driven.
        NotDriven("not_driven") {
            /// The parts.
            bands: Vec<Band>,
            /// Their share of the band, 0–1.
            share: f64,
        },
        /// A resonance that is narrower than segments of this length resolve.
        UnresolvedResonance("unresolved_resonance") {
            /// Where, Hz.
            at_hz: f64,
            /// The lines within its half-power bandwidth.
            lines: f64,
            /// The step between lines, Hz.
            resolution_hz: f64,
        },
        /// Repeats of one measurement differ.
        RepeatsScatter("repeats_scatter") {
            /// How far the two that differ most lie apart, dB rms.
            db_rms: f64,
        },
        /// The device distorts.
        Nonlinear("nonlinear") {
            /// Distortion re the response, dB.
            level_db: f64,
            /// Where it is loudest.
            band_hz: Band,
        },
        /// The force takes power out of the finger: one of two channels has the wrong sign.
        PolarityInverted("polarity_inverted"),
        /// Drive and response were sampled with two clocks; the response was corrected to the clock of the drive.
        ClocksDiffer("clocks_differ") {
            /// How much faster the clock of the response runs, parts per million: its delay grows by it.
            ppm: f64,
            /// The standard error of that, parts per million.
            uncertainty: f64,
        },
        /// Samples of the response are missing without having been reported; the following samples were shifted back into place.
        SamplesMissing("samples_missing") {
            /// How many; below zero where samples of the drive are missing, or those of the response were repeated.
            count: f64,
            /// Where, s, within a segment.
            at_s: f64,
        },
        /// Segments that touch samples which were lost are left out of the estimate.
        SegmentsLeftOut("segments_left_out") {
            /// How many.
            left_out: usize,
            /// Of how many.
            of: usize,
        },
        /// Limits that were stored do not follow from coherence and averages.
        LimitsDiffer("limits_differ") {
            /// The stored limits as a multiple of those that follow, at the median line.
            ratio: f64,
        },
        /// A stored transfer function does not follow from the spectra stored beside it.
        StoredDiffers("stored_differs") {
            /// The largest difference, as a share of the value.
            difference: f64,
            /// Where, Hz.
            at_hz: f64,
            /// The largest difference of the coherence.
            coherence_difference: f64,
        },
        /// Drive and response are no more coherent than two unrelated signals.
        Unrelated("unrelated") {
            /// The mean coherence of the lines that are driven.
            coherence: f64,
            /// The value exceeded in 5 % of unrelated pairs; 0 if a file does not state it.
            limit: f64,
            /// Independent averages; 0 where a file does not say.
            averages: f64,
        },
    }
}

impl WarningKind for TransferWarning {
    fn of(warning: &crate::Warning) -> Option<Self> {
        Self::of_warning(warning)
    }

    fn advice(&self) -> Vec<Advice> {
        use Advice::{Check, LongerSegments, MeasureAgain, MeasureLonger, NarrowBand, RaiseLevel};
        match self {
            Self::LowCoherence { .. } => vec![MeasureLonger, RaiseLevel, NarrowBand],
            Self::ImpossibleCoherence { .. } => vec![Advice::LeaveOut, Advice::AskExporter],
            Self::FewAverages { .. } => {
                vec![MeasureLonger, Advice::ShorterSegments { to_s: None }]
            }
            Self::LateResponse { .. } => vec![LongerSegments, Advice::AlignChannels],
            Self::LimitsDiffer { .. } => vec![Check(Subject::WhichIsRight), MeasureAgain],
            Self::Acausal { .. } => vec![Check(Subject::Channels)],
            Self::NoPhase { .. } => vec![Advice::AskExporter, MeasureAgain],
            Self::SwappedUnits { .. } => vec![Advice::ExchangeDriveAndResponse],
            Self::NotDriven { .. } => vec![Advice::DriveWholeBand, NarrowBand],
            Self::UnresolvedResonance { .. } => vec![LongerSegments],
            Self::RepeatsScatter { .. } => vec![MeasureAgain],
            Self::Nonlinear { .. } => vec![Advice::CharacteriseAtLevel],
            Self::PolarityInverted => vec![Check(Subject::Polarity)],
            Self::ClocksDiffer { .. } => vec![Advice::OneClock],
            Self::SamplesMissing { .. } => vec![Advice::CloseOtherPrograms, MeasureAgain],
            Self::SegmentsLeftOut { .. } => vec![MeasureAgain],
            Self::StoredDiffers { .. } => vec![Advice::AskExporter],
            Self::Unrelated { .. } => vec![Check(Subject::ChannelsAndSensor), MeasureLonger],
        }
    }
}

impl fmt::Display for TransferWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::LowCoherence { asked, lowest, at_hz, share } => write!(
                f,
                "coherence is below {asked} on {} of the band (lowest {lowest:.3} at {at_hz:.0} Hz)",
                percent(*share), asked = rounded(*asked)),
            Self::ImpossibleCoherence { at_hz, found, lines } => write!(
                f,
                "coherence is {found:.3} at {at_hz:.1} Hz ({lines} lines in all), which is impossible for any pair of signals"
            ),
            Self::FewAverages { averages, recommended } => write!(
                f,
                "only {averages} segments were averaged, {recommended} or more are recommended: the estimate is uncertain"
            ),
            Self::LateResponse { delay_s, segment_s, reach_s } => write!(
                f,
                "the response comes {:.1} ± {:.1} ms after the drive, {} of a segment: the magnitude is underestimated",
                delay_s * 1e3,
                reach_s * 1e3,
                percent(delay_s / segment_s)
            ),
            Self::LimitsDiffer { ratio } => write!(
                f,
                "the limits stored with the transfer function are {ratio:.3} times those that follow from its coherence and averages: \
                    one of them was changed after the measurement"
            ),
            Self::NoPhase { lines } => write!(
                f,
                "all {lines} lines are real and positive: the phase is missing, so that waveforms are not reproduced, and a drive \
                 begins before its texture"
            ),
            Self::Acausal { lead_s, reach_s } => write!(
                f,
                "the response comes {:.2} ± {:.2} ms before the drive, which is impossible: drive and response are swapped, or their channels are out of step",
                lead_s * 1e3,
                reach_s * 1e3
            ),
            Self::SwappedUnits { drive, response } => write!(
                f,
                "the drive is in {drive} and the response in {response}: they are probably swapped"
            ),
            Self::NotDriven { bands, share } => write!(
                f,
                "{} of the band ({}) is not driven: the transfer function has no meaning there",
                percent(*share),
                list(bands)
            ),
            Self::UnresolvedResonance { at_hz, lines, resolution_hz } => write!(
                f,
                "the resonance at {at_hz:.1} Hz has {lines:.1} lines of {resolution_hz:.2} Hz within its half-power bandwidth, and 6 or more are needed: its height is underestimated"
            ),
            Self::RepeatsScatter { db_rms } => write!(
                f,
                "repeats differ by up to {db_rms:.1} dB rms: the finger moved or its force changed, or a repeat is from another \
                    participant"
            ),
            Self::Nonlinear { level_db, band_hz } => write!(
                f,
                "distortion reaches {level_db:.0} dB of the response at {band_hz}: the transfer function is valid only for this \
                    level of drive"
            ),
            Self::PolarityInverted => f.write_str(
                "the force seems to extract power from the finger: force or acceleration has the wrong sign",
            ),
            Self::ClocksDiffer { ppm, uncertainty } => write!(
                f,
                "the clock of the response runs {ppm:.1} ± {uncertainty:.1} parts per million faster than that of the drive: \
                    the response was resampled to the clock of the drive"
            ),
            Self::SamplesMissing { count, at_s } => write!(
                f,
                "{:.0} samples of the {} are missing at about {at_s:.2} s and were not reported as lost: the later samples were \
                    shifted to their correct times",
                count.abs(),
                if *count < 0.0 { "drive" } else { "response" }
            ),
            Self::SegmentsLeftOut { left_out, of } => write!(
                f,
                "{left_out} of {of} segments contain lost samples, and were left out"
            ),
            Self::StoredDiffers { difference, at_hz, coherence_difference } => write!(
                f,
                "the stored transfer function differs from the ratio of the stored spectra by up to {difference:.1e} of its value (at \
                    {at_hz:.1} Hz), and the stored coherence from theirs by up to {coherence_difference:.1e}: they were estimated \
                    by other methods, or the file was changed"
            ),
            Self::Unrelated { coherence, limit, averages } => write!(
                f,
                "the mean coherence of the driven lines is {coherence:.3}, and unrelated signals reach {limit:.3} \
                    with {averages:.0} averages: no relation between drive and response is shown"
            ),
        }
    }
}
