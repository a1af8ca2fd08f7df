//! What happens in a session.

use std::collections::BTreeMap;

use piezotact::criterion::Outcome;
use piezotact::recording::BenchKind;
use serde::{Deserialize, Serialize};

use super::super::chain::Sha;
use super::super::store::Purpose;
use super::Answer;
use crate::judge::Judge;

/// What was measured while a stimulus was played.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Evidence {
    /// The stimulus.
    pub stimulus: String,
    /// The SHA-256 of the drive's file.
    pub drive: Sha,
    /// The name of the amplifier's gain; absent where the device is not described.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gain: Option<String>,
    /// Whether the drive passed its verification when it was prepared.
    pub verified: Outcome,
    /// How close this playing came to the target: what is so of more than half of its strokes, else not decided.
    pub reached: Outcome,
    /// The criteria of this playing, by name, as for all of it.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub criteria: BTreeMap<String, Outcome>,
    /// The felt difference from the target, the mean over strokes, in JND; absent where it was not measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub score_jnd: Option<f64>,
    /// The level on the fingernail while it played, the mean over strokes, in dB re the target at the level that it was rendered
    /// at; absent where it was not measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub level_re_target_db: Option<f64>,
    /// The level at which it was intentionally rendered, in dB re the recorded stroke.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rendered_at_db: Option<f64>,
    /// The mean normal force while it played, in N.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub normal_force_n: Option<f64>,
    /// The onset on the fingernail after the start of the run, in seconds.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub onset_s: Option<f64>,
    /// The uncertainty of the onset, in seconds.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub onset_uncertainty_s: Option<f64>,
    /// How often the stroke was played in a row.
    pub strokes: u32,
    /// The kind of bench on which it was played; absent where the recording does not say it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bench: Option<BenchKind>,
    /// The SHA-256 of the acceleration that was recorded while it played, by [`sha_of_samples`]; absent where none was recorded.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub recorded: Option<Sha>,
    /// The journal of the run, re the participant's folder.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub journal: Option<String>,
}

/// The SHA-256 of `samples` as 32-bit floating point, little-endian: a file that keeps seven digits keeps it too.
///
/// Source: docs/decisions/campaigns.md.
#[must_use]
pub fn sha_of_samples(samples: &[f64]) -> Sha {
    let bytes = samples
        .iter()
        .flat_map(|sample| (*sample as f32).to_le_bytes());
    Sha::of(&bytes.collect::<Vec<u8>>())
}

impl Evidence {
    /// Whether the stimulus missed its target: the drive had not passed, or this playing did not reach it.
    #[must_use]
    pub fn missed(&self) -> bool {
        self.verified != Outcome::Met || self.reached == Outcome::NotMet
    }

    /// Whether it is not known that the stimulus reached its target, and not that it missed it.
    #[must_use]
    pub fn is_open(&self) -> bool {
        !self.missed() && self.reached != Outcome::Met
    }

    /// Whether it was played on a bench that is not real: no person felt it.
    #[must_use]
    pub fn is_simulated(&self) -> bool {
        self.bench.is_some_and(|bench| bench != BenchKind::Hardware)
    }
}

/// How a sample was touched in a trial of touch, where the session has a bench with sensors.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct TouchRecord {
    /// What was recorded, in parts: a pause ends one, and the next begins after it.
    pub recordings: Vec<TouchRecording>,
    /// The strokes that were found in them; absent where neither force nor motion was recorded all the time.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub strokes: Option<u32>,
    /// Why the vibration was not recorded, or not all of it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub not_recorded: Option<String>,
}

/// A recording of a touch.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct TouchRecording {
    /// Its file, re the folder of the session.
    pub journal: String,
    /// The SHA-256 of its acceleration, by [`sha_of_samples`]; absent where none was recorded.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub recorded: Option<Sha>,
}

/// Who takes part, beside the pseudonym. It is erased with the session when consent is withdrawn.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Participant {
    /// The sex as the participant states it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sex: Option<String>,
    /// The age in whole years.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub age_years: Option<u32>,
    /// The handedness: `right`, `left` or `both`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub handedness: Option<String>,
    /// The finger that touches: `right index`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub finger: Option<String>,
    /// The language of the instructions, as in BCP 47: `fr`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub language: Option<String>,
    /// The model by which a virtual volunteer judges; absent for a person.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub judge: Option<Judge>,
}

/// An event. Only the experimenter's program makes them, by [`super::State::decide`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(tag = "event", rename_all = "snake_case", deny_unknown_fields)]
pub enum Event {
    /// The session began.
    Begun {
        /// The SHA-256 of the plan.
        plan: Sha,
        /// The SHA-256 of the protocol.
        protocol: Sha,
        /// The tag of the experimenter.
        experimenter: String,
        /// The program and its version.
        program: String,
        /// With a volunteer, or a rehearsal.
        purpose: Purpose,
        /// Who takes part.
        participant: Participant,
    },
    /// The participant gave consent to this text.
    ConsentGiven {
        /// The SHA-256 of the text.
        text: Sha,
    },
    /// The participant did not give consent.
    ConsentRefused,
    /// An item of a checklist was confirmed.
    Checked {
        /// Block, task and set.
        place: String,
        /// The item.
        item: String,
    },
    /// A trial was presented.
    Presented {
        /// The trial.
        trial: String,
        /// What was presented where it is not what was planned: the wrong sample was handed over.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        instead: Option<Vec<String>>,
        /// What was measured while each element was played; empty for what is not rendered.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        evidence: Vec<Evidence>,
        /// What the answers so far chose, where the plan leaves it to them.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        chosen: Option<Vec<String>>,
    },
    /// An element begins to be played: stored before its sound, so that one that was cut off counts as felt.
    PlayBegan {
        /// The trial.
        trial: String,
        /// The element, from 0.
        element: usize,
    },
    /// The trial is void, as a device failed while it ran or it was stopped; it is repeated.
    Voided {
        /// The trial.
        trial: String,
        /// What failed, or who stopped it.
        why: String,
    },
    /// An element was felt once more.
    Played {
        /// The trial.
        trial: String,
        /// The element, from 0.
        element: usize,
        /// What was measured.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        evidence: Option<Evidence>,
    },
    /// The participant answered, or revised the answer.
    Answered {
        /// The trial.
        trial: String,
        /// The answer.
        answer: Answer,
    },
    /// The participant confirmed the answer.
    Confirmed {
        /// The trial.
        trial: String,
        /// How the sample was touched, in a trial of touch on a bench with sensors.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        touched: Option<TouchRecord>,
    },
    /// The experimenter corrected what was noted.
    Corrected {
        /// The trial.
        trial: String,
        /// The correct answer.
        answer: Answer,
        /// Why.
        why: String,
    },
    /// A pause began.
    Paused,
    /// The pause ended.
    WentOn,
    /// The session goes on after it was cut off.
    Resumed {
        /// The tag of the experimenter.
        experimenter: String,
    },
    /// The session was not allowed to go on.
    ResumeRefused {
        /// How long it was cut off, in hours.
        after_hours: f64,
    },
    /// A note.
    Note {
        /// The text.
        text: String,
    },
    /// The participant or the experimenter stopped before the end.
    Stopped {
        /// Why.
        why: String,
    },
    /// The participant withdrew consent: everything is to be erased.
    ConsentWithdrawn,
    /// The session ended with all trials confirmed.
    Ended,
    /// A command that had no effect, with the reason.
    Ignored {
        /// What was commanded, in words.
        command: String,
        /// Why it had no effect.
        why: String,
    },
}
