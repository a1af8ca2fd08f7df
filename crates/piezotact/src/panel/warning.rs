//! Warnings about a panel of people.

use std::fmt;

use crate::Warning;
use crate::number::rounded;
use crate::warning::words::first_of;
use crate::warning::{Advice, Example, Subject, WarningKind, warnings};

warnings! {
    /// Warnings about a panel of people.
    pub enum PanelWarning {
        /// A panel in which somebody was not measured in every cell.
        IncompletePanel("incomplete_panel") {
            /// Who and where.
            missing: Vec<String>,
            /// How many people are complete.
            complete: usize,
            /// Of how many.
            participants: usize,
        },
        /// Fewer people than a panel needs to estimate its uncertainty.
        FewPeople("few_people") {
            /// How many.
            participants: usize,
            /// What is recommended.
            recommended: usize,
        },
        /// A person whose transfer function is unlike everybody else's.
        OddOneOut("odd_one_out") of Participant(participant) {
            /// The pseudonym.
            participant: String,
            /// Load and angle.
            at: Example,
            /// How far it is from the mean curve, dB rms.
            db_rms: f64,
            /// The median distance of people from the mean curve, dB rms.
            usual_db_rms: f64,
        },
        /// Repeats of one person that differ as much as measurements of different people.
        MixedRepeats("mixed_repeats") of Participant(of) {
            /// Repeats or placements.
            what: String,
            /// Who and where.
            of: String,
            /// How far two of them are apart, dB rms.
            db_rms: f64,
            /// How far they usually are, dB rms.
            usual_db_rms: f64,
        },
        /// A measurement whose sign is opposite to most others' of the same load and angle.
        OppositeSign("opposite_sign") of Measurement(measurement) {
            /// Which.
            measurement: String,
            /// To how many of the others it is opposite.
            count: usize,
            /// How many others there are.
            of: usize,
            /// One of them.
            such_as: Example,
        },
        /// A measurement whose provenance names another participant.
        OtherParticipant("other_participant") of Measurement(measurement) {
            /// The filing of the measurement: participant, load, angle, placement, repeat.
            measurement: String,
            /// The participant named in its provenance.
            found: Example,
        },
        /// Measurements of digital twins of different seeds.
        SeveralTwins("several_twins") {
            /// One measurement.
            one: String,
            /// The seed of its twin.
            one_seed: String,
            /// Another measurement.
            other: String,
            /// The seed of its twin.
            other_seed: String,
        },
        /// Measurements that carry warnings of their own.
        OfMembers("of_members") {
            /// How many.
            count: usize,
            /// Of how many.
            of: usize,
            /// One of the measurements.
            measurement: Example,
            /// One of its warnings.
            example: Warning,
        },
        /// A transfer function that is an average over people.
        Averaged("averaged") {
            /// How many.
            participants: usize,
            /// The mean penalty for a new person, dB rms.
            penalty_db_rms: f64,
            /// The 95 % confidence interval of its mean, dB rms.
            interval_db_rms: Option<[f64; 2]>,
            /// The person with the largest penalty.
            worst: String,
            /// That penalty, dB rms.
            worst_db_rms: f64,
        },
        /// A control measurement with low coherence at the artefact.
        ControlIncoherent("control_incoherent") {
            /// The lowest coherence.
            lowest: f64,
            /// Where, Hz.
            at_hz: f64,
            /// The level asked for.
            asked: f64,
        },
        /// Transfer functions in the folder of a panel that its index does not list.
        NotListed("not_listed") {
            /// Their names.
            files: Vec<String>,
        },
        /// Measurements that a panel plans and lacks.
        NotMeasured("not_measured") {
            /// How many.
            count: usize,
            /// The first of them.
            first: String,
        },
    }
}

impl WarningKind for PanelWarning {
    fn of(warning: &Warning) -> Option<Self> {
        Self::of_warning(warning)
    }

    fn advice(&self) -> Vec<Advice> {
        use Advice::{Check, MeasureAgain};
        match self {
            Self::IncompletePanel { .. } => vec![Advice::MeasureOthers],
            Self::FewPeople { recommended, .. } => vec![Advice::MeasureParticipants {
                count: *recommended,
            }],
            Self::OddOneOut { .. } | Self::MixedRepeats { .. } => {
                vec![Check(Subject::Measurement), MeasureAgain]
            }
            Self::OppositeSign { .. } => vec![Advice::InvertChannel],
            Self::OtherParticipant { found, .. } => vec![Advice::FileUnder {
                participant: found.0.clone(),
            }],
            Self::SeveralTwins { .. } => vec![Advice::SeparatePanels],
            Self::OfMembers { .. } => Vec::new(),
            Self::Averaged { .. } => vec![Advice::CharacterisePerson],
            Self::ControlIncoherent { .. } => vec![Advice::MeasureControl],
            Self::NotListed { .. } | Self::NotMeasured { .. } => vec![Advice::ContinueCampaign],
        }
    }
}

impl fmt::Display for PanelWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::IncompletePanel {
                missing,
                complete,
                participants,
            } => write!(
                f,
                "{complete} of {participants} participants were measured at every load and angle; missing: {}; each comparison \
                    uses only the participants measured in both conditions",
                first_of(missing, "; ")
            ),
            Self::FewPeople { participants, .. } => write!(
                f,
                "{participants} participants are too few to predict the result of another panel: the confidence in the worst \
                    case is not known"
            ),
            Self::OddOneOut {
                participant,
                at,
                db_rms,
                usual_db_rms,
            } => write!(
                f,
                "{participant} at {at} differs from the mean curve by {db_rms:.1} dB rms, a typical participant \
                    by {usual_db_rms:.1} dB"
            ),
            Self::MixedRepeats {
                what,
                of,
                db_rms,
                usual_db_rms,
            } => write!(
                f,
                "{what} of {of} differ by up to {db_rms:.1} dB rms, typically by {usual_db_rms:.1} dB: they may be from \
                    different participants, or the sensor became loose"
            ),
            Self::OppositeSign {
                measurement,
                count,
                of,
                such_as,
            } => write!(
                f,
                "{measurement} has the opposite sign to {count} of the {of} others at this load and angle, such as {such_as}: \
                    one of its channels may be inverted"
            ),
            Self::OtherParticipant { measurement, found } => write!(
                f,
                "{measurement} comes from a measurement of participant {found}"
            ),
            Self::SeveralTwins {
                one,
                one_seed,
                other,
                other_seed,
            } => write!(
                f,
                "the measurements are of digital twins of different seeds: {one} is of seed {one_seed}, {other} is of seed {other_seed}"
            ),
            Self::OfMembers {
                count,
                of,
                measurement,
                example,
            } => write!(
                f,
                "{count} of {of} measurements have warnings of their own, such as {measurement}: {example}"
            ),
            Self::Averaged {
                participants,
                penalty_db_rms,
                interval_db_rms,
                worst,
                worst_db_rms,
            } => {
                write!(
                    f,
                    "the average of {participants} participants: for a participant who is not in it, its error \
                        is {penalty_db_rms:.1} dB rms"
                )?;
                if let Some([low, high]) = interval_db_rms {
                    write!(f, " (95 %: {low:.1} to {high:.1})")?;
                }
                write!(f, ", for {worst} {worst_db_rms:.1} dB")
            }
            Self::ControlIncoherent {
                lowest,
                at_hz,
                asked,
            } => write!(
                f,
                "the control's coherence falls to {lowest:.2} at {at_hz:.0} Hz, below {asked}: the compensation at this \
                    frequency is partly noise",
                asked = rounded(*asked)
            ),
            Self::NotListed { files } => write!(
                f,
                "the folder contains transfer functions that panel.json does not list; they are left out: {}",
                first_of(files, ", ")
            ),
            Self::NotMeasured { count, first } => write!(
                f,
                "{count} planned measurements are missing, the first is {first}"
            ),
        }
    }
}
