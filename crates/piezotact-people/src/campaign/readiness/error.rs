//! Why a session may not begin, a sentence for each reason: what was expected, what was found, what to do.

use piezotact::criterion::{Criterion, Limit, Outcome};
use piezotact::recording::BenchKind;
use piezotact::transfer::AtRestCriterion;

use super::{ANOTHER_DAY_HOURS, Part, SENSOR_HOURS};

/// Why a session may not begin.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NotReady {
    /// There is no drive for a stimulus.
    #[error("{stimulus}: there is no drive; prepare it from the strokes of this participant")]
    Missing { stimulus: String },
    /// Some files of a stimulus are there and others are not.
    #[error(
        "{stimulus}: expected {files} beside its other files, found nothing; put back what was removed, or prepare it again"
    )]
    Incomplete {
        stimulus: String,
        /// Those that are not there.
        files: String,
    },
    /// A drive made from somebody else's strokes.
    #[error(
        "{stimulus}: expected strokes of {participant}, found those of {found}; prepare the drives of {participant}"
    )]
    Strokes {
        stimulus: String,
        participant: String,
        /// Whose strokes they are.
        found: String,
    },
    /// A drive rendered with another transfer function than the protocol asks for.
    #[error(
        "{stimulus}: expected {expected}, found {found}; render it with that transfer function (an average made by an earlier version must be made again first)"
    )]
    TransferFunction {
        stimulus: String,
        /// What the protocol asks for.
        expected: String,
        found: String,
    },
    /// A drive that did not pass.
    #[error(
        "{stimulus}: its verification is {}; prepare it again, in a closed loop where the open one does not pass", .outcome.word()
    )]
    NotPassed { stimulus: String, outcome: Outcome },
    /// A measurement of another drive.
    #[error(
        "{stimulus}: the measurement beside it was made with another drive; play this drive, record it, and compare it with its target"
    )]
    Measured { stimulus: String },
    /// The drive of another stimulus.
    #[error(
        "{stimulus}: expected a drive of its own in {file}, found that of {other} in {other_file}; prepare both again as the protocol states them"
    )]
    SameDrive {
        stimulus: String,
        /// Its file.
        file: String,
        /// The stimulus with the same drive.
        other: String,
        /// The file of that one.
        other_file: String,
    },
    /// A drive that was not made as the protocol states it.
    #[error(
        "{stimulus}: expected {expected}, found {found} by {seen_in}; prepare it again as the protocol states it"
    )]
    Made {
        stimulus: String,
        /// What the protocol states.
        expected: String,
        found: String,
        /// Where it was found: the lineage of a drive, the samples of a target, a measurement.
        seen_in: String,
    },
    /// Another drive than the one that the session played before.
    #[error(
        "{stimulus}: expected the drive that this session played before, found another one in {file}; go on without giving drives: the session keeps its own"
    )]
    Exchanged {
        stimulus: String,
        /// Where the other one is.
        file: String,
    },
    /// The bench does not play the drive.
    #[error("{stimulus}: {why}")]
    Refused { stimulus: String, why: String },
    /// Something that was measured on another kind of bench.
    #[error(
        "{stimulus}: expected {} on {}, found {}; prepare it on the bench of the session", .part.words(), kind_words(*.expected), kind_words(*.found)
    )]
    OtherBench {
        stimulus: String,
        part: Part,
        /// The bench of the session.
        expected: BenchKind,
        found: BenchKind,
    },
    /// Something that was measured on a person of another twin.
    #[error(
        "{stimulus}: expected {} of the twin of seed {expected}, which is on the bench, found the twin of seed {found}; name that bench, or prepare it on this one", .part.words()
    )]
    TwinSeed {
        stimulus: String,
        part: Part,
        /// The seed of the bench.
        expected: u64,
        found: u64,
    },
    /// Something that was measured while the finger lay otherwise.
    #[error(
        "{stimulus}: expected {} with the finger at {expected} as in this session, found {found}; place the finger so, or prepare it again", .part.words()
    )]
    Placement {
        stimulus: String,
        part: Part,
        /// As the finger lies in the session.
        expected: String,
        found: String,
    },
    /// Something that is too old.
    #[error(
        "{stimulus}: expected {} of the last {most_hours} h, found an age of {hours:.1} h; measure the participant again", .part.words()
    )]
    TooOld {
        stimulus: String,
        part: Part,
        /// Its age, in hours.
        hours: f64,
        /// The largest age, in hours.
        most_hours: f64,
    },
    /// A measurement that is not dated, or something from the future.
    #[error(
        "{stimulus}: expected {} with its date, found {}; {}", .part.words(), found_date(*.ahead_hours), todo_date(*.ahead_hours)
    )]
    Undated {
        stimulus: String,
        part: Part,
        /// How far its date lies ahead, in hours; `None` where there is none.
        ahead_hours: Option<f64>,
    },
    /// A bench with nobody's finger on it.
    #[error(
        "expected a bench with a finger on it, found {}: nobody feels what it plays; name the bench of {participant}", bench_words(*.bench)
    )]
    NoFinger {
        participant: String,
        bench: BenchKind,
    },
    /// A bench with somebody else's finger on it.
    #[error(
        "expected the finger of {participant} on the bench, found that of {found}; name the bench of {participant}"
    )]
    OtherFinger {
        participant: String,
        /// Whose finger it is.
        found: String,
    },
    /// The sensor does not read as it did.
    #[error("expected the {} {}, found {}; {}", .0.what, limit_db(.0.limit), found_db(.0.found), sensor_todo(.0.what))]
    Sensor(Criterion<AtRestCriterion>),
    /// The sensor was not checked on the day of the session.
    #[error(
        "expected a response at rest of the last {SENSOR_HOURS} h, found {}; measure it again with nobody on the device", found_age(*.hours)
    )]
    SensorOld {
        /// Its age, in hours; `None` where it has no date.
        hours: Option<f64>,
    },
    /// An earlier session was not ended.
    #[error("session {session} comes before this one and was not ended; end it first")]
    Earlier { session: String },
    /// The sessions are on one day.
    #[error(
        "expected another day than that of session {session}, found {hours:.1} h between them; come back after {ANOTHER_DAY_HOURS} h"
    )]
    SameDay {
        session: String,
        /// The time between them, in hours.
        hours: f64,
    },
    /// The participant belongs to a panel that must not overlap.
    #[error(
        "{participant} belongs to the panel `{panel}`, from which this campaign is disjoint; choose another participant"
    )]
    Panel { participant: String, panel: String },
    /// Nobody said who belongs to a panel that must not overlap.
    #[error(
        "the campaign is disjoint from the panel `{panel}`, and who belongs to it is not stated; state it when the study is made"
    )]
    UnknownPanel { panel: String },
}

impl NotReady {
    /// The stimulus that it is about; `None` where it is about the participant.
    #[must_use]
    pub fn stimulus(&self) -> Option<&str> {
        match self {
            Self::Missing { stimulus }
            | Self::Incomplete { stimulus, .. }
            | Self::Strokes { stimulus, .. }
            | Self::TransferFunction { stimulus, .. }
            | Self::NotPassed { stimulus, .. }
            | Self::Measured { stimulus }
            | Self::SameDrive { stimulus, .. }
            | Self::Made { stimulus, .. }
            | Self::Exchanged { stimulus, .. }
            | Self::Refused { stimulus, .. }
            | Self::OtherBench { stimulus, .. }
            | Self::TwinSeed { stimulus, .. }
            | Self::Placement { stimulus, .. }
            | Self::TooOld { stimulus, .. }
            | Self::Undated { stimulus, .. } => Some(stimulus),
            Self::NoFinger { .. }
            | Self::OtherFinger { .. }
            | Self::Sensor(_)
            | Self::SensorOld { .. }
            | Self::Earlier { .. }
            | Self::SameDay { .. }
            | Self::Panel { .. }
            | Self::UnknownPanel { .. } => None,
        }
    }
}

fn bench_words(bench: BenchKind) -> &'static str {
    match bench {
        BenchKind::Twin => "the digital twin of nobody",
        _ => kind_words(bench),
    }
}

fn kind_words(bench: BenchKind) -> &'static str {
    match bench {
        BenchKind::Twin => "the digital twin",
        BenchKind::Hardware => "real devices",
        BenchKind::Measured => "a measured transfer function",
        BenchKind::Scripted => "a scripted fake",
    }
}

fn found_date(ahead_hours: Option<f64>) -> String {
    match ahead_hours {
        Some(hours) => format!("a date {hours:.1} h ahead of this computer's clock"),
        None => "none".to_owned(),
    }
}

fn todo_date(ahead_hours: Option<f64>) -> &'static str {
    match ahead_hours {
        Some(_) => "set the clock, or prepare it again",
        None => "prepare it again",
    }
}

fn found_age(hours: Option<f64>) -> String {
    hours.map_or("one without a date".to_owned(), |hours| {
        format!("an age of {hours:.1} h")
    })
}

fn limit_db(limit: Limit) -> String {
    match limit {
        Limit::Within { reach } => format!("within ±{reach:.1} dB"),
        other => format!("of at most {:.1} dB", other.value()),
    }
}

fn found_db(found: Option<f64>) -> String {
    found.map_or("too few lines that both drove".to_owned(), |db| {
        format!("{db:+.1} dB")
    })
}

fn sensor_todo(what: AtRestCriterion) -> &'static str {
    match what {
        AtRestCriterion::Level => {
            "set its amplifier back, or calibrate it and measure the stored response again"
        }
        AtRestCriterion::Shape => {
            "take the finger off the device, fasten the sensor, and measure it again"
        }
    }
}
