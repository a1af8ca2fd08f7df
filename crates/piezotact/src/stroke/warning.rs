//! Warnings that arise from segmentation into strokes.

use std::fmt;

use crate::number::rounded;
use crate::warning::{Advice, Counts, Subject, WarningKind, warnings};

warnings! {
    /// Warnings about the segmentation into strokes.
    pub enum StrokeWarning {
        /// No channel says where strokes are: the whole recording is taken as one.
        NothingCut("nothing_cut"),
        /// Nothing touches in a recording.
        NoContact("no_contact") {
            /// The largest force above the baseline, N.
            largest_n: f64,
            /// The contact threshold, N.
            threshold_n: f64,
        },
        /// Neither vibration nor friction says whether the finger slides.
        SlidingAssumed("sliding_assumed"),
        /// No force says whether the finger touches.
        ContactAssumed("contact_assumed"),
        /// A force that is negative in contact was taken with its sign reversed.
        SignReversed("sign_reversed") of Channel(channel) {
            /// The channel.
            channel: String,
        },
        /// More friction than skin usually has.
        HighFriction("high_friction") {
            /// The median friction coefficient.
            coefficient: f64,
        },
        /// A stroke much longer than others: maybe two.
        LongStroke("long_stroke") {
            /// Where it begins, s.
            at_s: f64,
            /// How long it is, s.
            length_s: f64,
            /// How long the usual one is, s.
            usual_s: f64,
        },
        /// The speed differs from the requested one.
        SpeedOffTarget("speed_off_target") {
            /// The median speed of the plateaus, m/s.
            mean_m_s: f64,
            /// The speed asked for, m/s.
            target_m_s: f64,
        },
        /// Parts of a recording that looked like strokes were rejected.
        Rejected("rejected") {
            /// How many.
            count: usize,
            /// Of how many.
            of: usize,
            /// The reasons and how often each, by their codes.
            reasons: Counts,
        },
        /// A person's cuts that lie outside the recording.
        CutsNotApplied("cuts_not_applied") of File(file) {
            /// The file of cuts.
            file: String,
            /// How many.
            count: usize,
        },
    }
}

impl WarningKind for StrokeWarning {
    fn of(warning: &crate::Warning) -> Option<Self> {
        Self::of_warning(warning)
    }

    fn advice(&self) -> Vec<Advice> {
        use Advice::{Check, CutByHand};
        match self {
            Self::NothingCut => vec![CutByHand],
            Self::NoContact { .. } => vec![Check(Subject::ForceChannel), Advice::StateLoad],
            Self::SlidingAssumed => Vec::new(),
            Self::ContactAssumed => vec![Advice::MeasureForce],
            Self::SignReversed { .. } => vec![Check(Subject::Polarity)],
            Self::HighFriction { .. } => vec![Check(Subject::ForceAxes)],
            Self::LongStroke { .. } => vec![CutByHand],
            Self::SpeedOffTarget { .. } => Vec::new(),
            Self::Rejected { .. } => vec![Check(Subject::Strokes), CutByHand],
            Self::CutsNotApplied { .. } => vec![Check(Subject::CutTimes)],
        }
    }
}

impl fmt::Display for StrokeWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NothingCut => f.write_str(
                "no channel of force or speed was recorded: the whole recording is analysed as one stroke",
            ),
            Self::NoContact { largest_n, threshold_n } => write!(
                f,
                "no stroke: the force rises by {largest_n:.3} N at most and a contact needs {threshold_n} N", threshold_n = rounded(*threshold_n)),
            Self::SlidingAssumed => f.write_str(
                "every contact is analysed as a stroke: hesitations and stick-slip are not detected (because vibration and \
                    tangential force are missing, or as requested)",
            ),
            Self::ContactAssumed => f.write_str(
                "no normal force was recorded: the finger is assumed to touch whenever the surface moves",
            ),
            Self::SignReversed { channel } => write!(
                f,
                "{channel} is negative in contact and its sign was reversed"
            ),
            Self::HighFriction { coefficient } => write!(
                f,
                "the friction coefficient is {coefficient:.2}, more than skin usually has: an adhesive surface, or the force axes are swapped"
            ),
            Self::LongStroke { at_s, length_s, usual_s } => write!(
                f,
                "the stroke at {at_s:.2} s lasts {length_s:.1} s, a typical one {usual_s:.1} s: it may be two strokes, or a \
                    movement back and forth without lifting the finger"
            ),
            Self::SpeedOffTarget { mean_m_s, target_m_s } => write!(
                f,
                "the speed was {:.2} mm/s, but {:.2} mm/s was requested: frequencies and rms are those of the speed that was \
                    reached",
                mean_m_s * 1e3,
                target_m_s * 1e3
            ),
            Self::Rejected { count, of, reasons } => write!(
                f,
                "{count} of {of} parts that looked like strokes were rejected ({})",
                reasons.text(&|code| match code {
                    "stick_slip" => "stick-slip".into(),
                    "interrupted" => "interrupted sliding".into(),
                    "reversed" => "reversed direction".into(),
                    "cut_by_recording" => "cut by the recording's end".into(),
                    "by_person" => "excluded by hand".into(),
                    other => other.replace('_', " "),
                })
            ),
            Self::CutsNotApplied { file, count } => write!(
                f,
                "{count} cuts of {file} are outside the recording and were not applied"
            ),
        }
    }
}
