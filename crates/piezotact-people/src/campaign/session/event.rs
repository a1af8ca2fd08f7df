//! What happens in a session.

use serde::{Deserialize, Serialize};

use super::super::chain::Sha;
use super::Answer;

/// What was measured while a stimulus was played.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Evidence {
    /// The SHA-256 of the drive.
    pub drive: Sha,
    /// The name of the amplifier's gain.
    pub gain: String,
    /// Whether the drive passed its verification: the outcome of its criteria.
    pub verified: piezotact::criterion::Outcome,
    /// The level on the fingernail while it played, in dB re the target; absent where it was not measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub level_re_target_db: Option<f64>,
    /// The mean normal force while it played, in N.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub normal_force_n: Option<f64>,
    /// The onset after the request, in seconds.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub onset_s: Option<f64>,
    /// The uncertainty of the onset, in seconds.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub onset_uncertainty_s: Option<f64>,
    /// The journal of the run.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub journal: Option<String>,
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
        /// What the answers so far chose, where the plan leaves it to them.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        chosen: Option<Vec<String>>,
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
