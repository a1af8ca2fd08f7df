//! What a page may ask for, by its role.

use piezotact_people::campaign::chain::Sha;
use piezotact_people::campaign::session::{Command, UNKNOWN, letters};
use serde::Deserialize;

use crate::access::Role;
use crate::words::{Language, Word};

/// A request as a page sends it.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub(crate) struct Asked {
    /// An id that the page made.
    pub(crate) id: String,
    /// The mark of the step that the page showed.
    pub(crate) at: String,
    /// How many events were stored when the page showed it.
    #[serde(default)]
    pub(crate) seen: Option<u64>,
    #[serde(flatten)]
    pub(crate) what: What,
}

/// What is asked.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(tag = "do", rename_all = "snake_case")]
pub(crate) enum What {
    /// The participant gives consent.
    Consent,
    /// The participant does not.
    RefuseConsent,
    /// An item of the checklist.
    Check,
    /// The trial was presented, or is to be played.
    Present,
    /// Others were presented.
    PresentInstead {
        names: Vec<String>,
    },
    /// An element once more, from 1.
    Play {
        element: usize,
    },
    Answer {
        words: Vec<String>,
    },
    Confirm,
    /// Corrects the trial with this number, from 1.
    Correct {
        trial: String,
        words: Vec<String>,
        why: String,
    },
    /// What is played ends at once; its trial is void, and is presented again.
    Silence,
    /// A pause, which ends what is played.
    Pause,
    GoOn,
    Note {
        text: String,
    },
    Stop {
        why: String,
    },
    Withdraw,
    End,
}

/// As it is stored: journals have one language.
fn own(word: Word) -> &'static str {
    word.in_language(Language::English)
}

impl What {
    /// Whether `role` may ask for it.
    pub(crate) fn is_for(&self, role: Role) -> bool {
        match role {
            Role::Experimenter => true,
            Role::Participant => {
                matches!(
                    self,
                    Self::Consent
                        | Self::RefuseConsent
                        | Self::Answer { .. }
                        | Self::Confirm
                        | Self::Play { .. }
                        | Self::Pause
                )
            }
            Role::Viewer => false,
        }
    }

    /// Whether nothing that it needs is empty.
    pub(crate) fn is_whole(&self) -> bool {
        match self {
            Self::Note { text } => !text.trim().is_empty(),
            _ => true,
        }
    }

    /// Whether it fits any step, so that another one does not make it late.
    pub(crate) fn fits_any_step(&self) -> bool {
        matches!(
            self,
            Self::Note { .. }
                | Self::Correct { .. }
                | Self::Pause
                | Self::Withdraw
                | Self::Stop { .. }
        )
    }

    /// Why what is played ends at once when `role` asks for it; none where it goes on.
    pub(crate) fn silences(&self, role: Role) -> Option<&'static str> {
        match (self, role) {
            (Self::Pause, Role::Participant) => Some(own(Word::StoppedByParticipant)),
            (Self::Silence | Self::Pause, _) => Some(own(Word::StoppedOnPage)),
            (Self::Stop { .. }, _) => Some("the session was stopped"),
            (Self::Withdraw, _) => Some("the participant withdrew"),
            _ => None,
        }
    }

    /// The samples that lie in `places`, instead of their letters, which a participant answers with.
    pub(crate) fn name_places(&mut self, places: &[String]) {
        let Self::Answer { words } = self else {
            return;
        };
        if places.is_empty() {
            return;
        }
        if *words == [UNKNOWN] {
            return;
        }
        for word in words {
            let at = letters().take(places.len()).position(|one| one == *word);
            // A name that is typed past the page is not taken.
            *word = at.map_or_else(String::new, |at| places[at].clone());
        }
    }

    /// As a command; `consent` is the checksum of the text that consent is given to.
    pub(crate) fn command(self, consent: Sha) -> Command {
        match self {
            Self::Consent => Command::Consent { text: consent },
            Self::RefuseConsent => Command::RefuseConsent,
            Self::Check => Command::Check,
            Self::Present => Command::Present {
                evidence: Vec::new(),
            },
            Self::PresentInstead { names } => Command::PresentInstead {
                names,
                evidence: Vec::new(),
            },
            Self::Play { element } => Command::Play {
                // 0 is no element; the session refuses it.
                element: element.checked_sub(1).unwrap_or(usize::MAX - 1),
                evidence: None,
            },
            Self::Answer { words } => Command::Answer { words },
            Self::Confirm => Command::Confirm,
            Self::Correct { trial, words, why } => Command::Correct { trial, words, why },
            Self::Silence | Self::Pause => Command::Pause,
            Self::GoOn => Command::GoOn,
            Self::Note { text } => Command::Note { text },
            // A stop is never refused for want of a reason.
            Self::Stop { why } if why.trim().is_empty() => Command::Stop {
                why: "no reason was stated".to_owned(),
            },
            Self::Stop { why } => Command::Stop { why },
            Self::Withdraw => Command::Withdraw,
            Self::End => Command::End,
        }
    }
}
