//! What a data set says of itself, of its participants and sessions, and what it does not carry.

use std::fmt;

use piezotact::number::counted;
use piezotact_people::campaign::protocol::Protocol;
use serde::{Deserialize, Serialize};

/// What a data set says of itself.
#[derive(Clone, Debug)]
pub struct DatasetAbout<'a> {
    /// The name of the data set.
    pub name: &'a str,
    /// Who made it, as they want to be cited.
    pub authors: &'a [String],
    /// The licence under which others may use it.
    pub license: Option<&'a str>,
    /// The program and its version.
    pub program: &'a str,
    /// What the study is known by: files of two studies have two.
    pub study: &'a str,
    /// The protocol that was followed; absent for recordings of a laboratory without a campaign, which have no sessions.
    pub followed: Option<Followed<'a>>,
    /// How the study was simulated, in words; absent for one with people.
    pub simulated: Option<&'a str>,
    /// What a person should know before relying on it, in words.
    pub warnings: &'a [String],
}

/// The protocol of a study.
#[derive(Clone, Copy, Debug)]
pub struct Followed<'a> {
    /// What it says.
    pub protocol: &'a Protocol,
    /// As it is written.
    pub text: &'a str,
}

/// A participant.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Person {
    pub pseudonym: String,
    /// Whether nobody took part: simulated.
    pub is_virtual: bool,
    /// How a virtual volunteer judges; absent for a person, and where nothing was judged.
    pub judge: Option<String>,
    /// The age in years, as stated at the first session that states it.
    pub age_years: Option<u32>,
    /// The sex as stated.
    pub sex: Option<String>,
    /// The handedness as stated.
    pub handedness: Option<String>,
    /// When the first session or recording was begun, in ms since 1970-01-01 00:00 UTC.
    pub first_ms: i64,
}

/// A session of a participant.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SessionFacts {
    /// Its name in the protocol.
    pub session: String,
    /// When it was begun, in ms since 1970-01-01 00:00 UTC.
    pub began_ms: Option<i64>,
    /// Whether it came to its end: "complete", "ended", "stopped" or "open".
    pub ended: &'static str,
    /// How many trials are confirmed.
    pub confirmed: usize,
    /// How many were planned.
    pub planned: usize,
    /// The sex as stated.
    pub sex: Option<String>,
    /// The age in years.
    pub age_years: Option<u32>,
    /// The handedness as stated.
    pub handedness: Option<String>,
    /// The finger that touches.
    pub finger: Option<String>,
    /// The language of the instructions.
    pub language: Option<String>,
}

/// What a study holds and a data set does not carry.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(tag = "what", rename_all = "snake_case")]
pub enum NotCarried {
    /// The true dates.
    Dates,
    /// Texts that somebody typed.
    TypedTexts,
    /// Consents and identities.
    Identities,
    /// Checklists, pauses and each answer between the first and the confirmed one.
    Steps,
    /// The plans.
    Plans {
        /// How many planned trials were never presented.
        unpresented: usize,
    },
    /// Attempts that were void or cut off.
    VoidAttempts {
        /// How many.
        attempts: u32,
    },
    /// Ages of more than 89.
    Ages {
        /// Of how many people.
        people: usize,
    },
    /// Rehearsals.
    Rehearsals {
        /// How many sessions.
        sessions: usize,
    },
    /// Participants who withdrew.
    Withdrawn {
        /// How many sessions.
        sessions: usize,
    },
    /// Files that state a date, and so have no copy as they are.
    DatedFiles {
        /// How many.
        files: usize,
    },
    /// Recordings of playings that are no longer there.
    MissingRuns {
        /// How many.
        runs: usize,
    },
    /// No recording was given for a sample that somebody touched.
    Unrecorded {
        /// How many trials.
        trials: usize,
    },
    /// Recordings of whose strokes nothing is known.
    Uncut {
        /// How many.
        recordings: usize,
    },
    /// What virtual volunteers judged by.
    Cues,
    /// What of EEG is not in its files.
    EegOriginals {
        /// How many recordings.
        recordings: usize,
    },
    /// Pseudonyms that are no codes, which stand in the names of files: they may be names, dates or numbers of telephones.
    Wordlike {
        /// Which, and names of channels and events that other programs wrote.
        words: Vec<String>,
    },
    /// How drives were rendered, the device, and cuts by hand as a file.
    Rendering,
}

impl fmt::Display for NotCarried {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Dates => f.write_str(
                "true dates: the first day of each participant is 1900-01-01; times of day and times between sessions are kept; a time that ends in Z is UTC, any other is local time",
            ),
            Self::TypedTexts => f.write_str(
                "texts that somebody typed (notes, reasons of corrections, stops and void trials; labels of recordings; words for sex, finger and language that are not common ones), events of other programs by their names (numbers, codes of markers, words of amplifiers and kinds that are single words in small letters stay; other kinds are called `event`), units that are none, and the tag of the experimenter",
            ),
            Self::Identities => f.write_str("consents and identities"),
            Self::Steps => f.write_str(
                "checklists, pauses, and answers between the first and the confirmed one",
            ),
            Self::Plans { unpresented: 0 } => f.write_str("the plans of the sessions"),
            Self::Plans { unpresented } => write!(
                f,
                "the plans of the sessions, with {} that {} never presented",
                counted(*unpresented, "trial"),
                if *unpresented == 1 { "was" } else { "were" }
            ),
            Self::VoidAttempts { attempts } => write!(
                f,
                "what was presented in {} that were void or cut off; their number is in the events",
                counted(*attempts as usize, "attempt")
            ),
            Self::Ages { people } => write!(
                f,
                "the age of {} of more than 89 years: it is written as 89",
                counted(*people, "participant")
            ),
            Self::Rehearsals { sessions } => write!(f, "{}", counted(*sessions, "rehearsal")),
            Self::Withdrawn { sessions } => write!(
                f,
                "{} of participants who withdrew",
                counted(*sessions, "session")
            ),
            Self::DatedFiles { files } => write!(
                f,
                "the original files of {}: they state a date or a typed label, or were written by another program (their samples are in the tables)",
                counted(*files, "recording")
            ),
            Self::MissingRuns { runs } => write!(
                f,
                "{} of playings that are not in the folder of the study",
                counted(*runs, "recording")
            ),
            Self::Unrecorded { trials } => write!(
                f,
                "recordings of {} of touching, for which none was given",
                counted(*trials, "trial")
            ),
            Self::Uncut { recordings } => write!(
                f,
                "strokes of {}, in which none could be cut (`piezotact strokes` says why)",
                counted(*recordings, "recording")
            ),
            Self::Rendering => f.write_str(
                "how drives were rendered and with which device (recordings in sourcedata say it); cuts by hand as a file (their strokes are events); names of files of other programs, and notes in them",
            ),
            Self::EegOriginals { recordings } => write!(
                f,
                "the original files of {} and samples in more than 32 bits",
                counted(*recordings, "EEG recording")
            ),
            Self::Wordlike { words } => write!(
                f,
                "names of people, as far as this program knows them; these words are carried as they are, so look whether one tells who somebody is: {}",
                words.join(", ")
            ),
            Self::Cues => f.write_str("the cues that virtual volunteers judged by"),
        }
    }
}
