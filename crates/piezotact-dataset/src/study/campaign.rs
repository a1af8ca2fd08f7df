//! What a study is of: its protocol, seed, consent text and the panels that must not overlap with it, fixed when it is made; and the
//! plan of each session.

use std::collections::{BTreeMap, BTreeSet};
use std::io::Write as _;
use std::path::{Path, PathBuf};

use piezotact_people::campaign::chain::Sha;
use piezotact_people::campaign::plan::Plan;
use piezotact_people::campaign::protocol::{Protocol, ProtocolError, read};
use serde::{Deserialize, Serialize};

use super::pseudonym::{Pseudonym, PseudonymError};
use super::store::SqliteStore;
use crate::atomic::write_atomically;
use crate::error::{ReadError, WriteError};
use crate::input::read_input_text;

const CAMPAIGN: &str = "campaign.json";
const PROTOCOL: &str = "protocol.toml";
const CONSENT: &str = "consent.txt";
const PLAN: &str = "plan.json";
/// The version of the form of campaign.json.
const FORM: u32 = 1;

/// What is fixed when a study is made.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct CampaignFile {
    form: u32,
    protocol_sha: Sha,
    seed: u64,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    consent_sha: Option<Sha>,
    #[serde(default)]
    panels: BTreeMap<String, BTreeSet<String>>,
    /// The program that made it.
    program: String,
}

/// What a study is made of.
#[derive(Clone, Debug)]
pub struct NewCampaign<'a> {
    /// The protocol as it is written.
    pub protocol: &'a str,
    /// The seed of all draws.
    pub seed: u64,
    /// The text that participants consent to.
    pub consent: Option<&'a str>,
    /// The panels that must not overlap, with their members.
    pub panels: BTreeMap<String, BTreeSet<String>>,
    /// The program and its version.
    pub program: &'a str,
}

/// The campaign of a study.
#[derive(Clone, Debug)]
pub struct StudyCampaign {
    /// The protocol.
    pub protocol: Protocol,
    /// The SHA-256 of its file.
    pub protocol_sha: Sha,
    /// The seed of all draws.
    pub seed: u64,
    /// The text that participants consent to.
    pub consent: Option<String>,
    /// The panels that must not overlap, with their members.
    pub panels: Vec<(String, BTreeSet<String>)>,
}

/// Why the campaign of a study cannot be made or read.
#[derive(Debug, thiserror::Error)]
pub enum CampaignError {
    /// A file cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// A file cannot be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// The protocol cannot be used.
    #[error(transparent)]
    Protocol(#[from] ProtocolError),
    /// The name of a session or participant cannot be a folder.
    #[error(transparent)]
    Name(#[from] PseudonymError),
    /// A file was changed after the study was made.
    #[error(
        "{}: expected the {what} that the study was made with (SHA-256 {expected}), found another one ({found}); restore it from a copy, or make a new study with the changed one: a running study keeps its {what}", path.display()
    )]
    Changed {
        /// The file.
        path: PathBuf,
        /// "protocol" or "consent text".
        what: &'static str,
        /// Its checksum when the study was made.
        expected: Sha,
        /// Its checksum now.
        found: Sha,
    },
    /// A file is not what it must be.
    #[error("{}: expected {expected}, found {why}; restore it from a copy of the study", path.display())]
    Form {
        /// The file.
        path: PathBuf,
        /// What it should hold.
        expected: &'static str,
        /// What is wrong.
        why: String,
    },
}

impl StudyCampaign {
    /// Fixes `new` in the study in `folder`.
    ///
    /// # Errors
    /// [`CampaignError`]; a protocol that cannot be used is refused before anything is written.
    pub fn create(folder: &Path, new: &NewCampaign<'_>) -> Result<(), CampaignError> {
        let protocol = read(new.protocol)?;
        for session in &protocol.sessions {
            Pseudonym::new(&session.name)?;
        }
        let file = CampaignFile {
            form: FORM,
            protocol_sha: Sha::of(new.protocol.as_bytes()),
            seed: new.seed,
            consent_sha: new.consent.map(|text| Sha::of(text.as_bytes())),
            panels: new.panels.clone(),
            program: new.program.to_owned(),
        };
        write(&folder.join(PROTOCOL), new.protocol.as_bytes())?;
        if let Some(consent) = new.consent {
            write(&folder.join(CONSENT), consent.as_bytes())?;
        }
        // Last, as it vouches for the others.
        let path = folder.join(CAMPAIGN);
        let mut bytes = serde_json::to_vec_pretty(&file).map_err(|error| CampaignError::Form {
            path: path.clone(),
            expected: "a campaign",
            why: error.to_string(),
        })?;
        bytes.push(b'\n');
        Ok(write(&path, &bytes)?)
    }

    /// The campaign of the study in `folder`.
    ///
    /// # Errors
    /// [`CampaignError::Changed`] where protocol or consent text are not those it was made with, and other [`CampaignError`]s.
    pub fn read(folder: &Path) -> Result<Self, CampaignError> {
        let path = folder.join(CAMPAIGN);
        let file: CampaignFile = parsed(&path, "the campaign of a study")?;
        if file.form != FORM {
            return Err(CampaignError::Form {
                path,
                expected: "form 1",
                why: format!("form {}", file.form),
            });
        }
        let path = folder.join(PROTOCOL);
        let text = read_input_text(&path)?;
        same(&path, "protocol", file.protocol_sha, &text)?;
        let consent = match file.consent_sha {
            Some(expected) => {
                let path = folder.join(CONSENT);
                let text = read_input_text(&path)?;
                same(&path, "consent text", expected, &text)?;
                Some(text)
            }
            None => None,
        };
        Ok(Self {
            protocol: read(&text)?,
            protocol_sha: file.protocol_sha,
            seed: file.seed,
            consent,
            panels: file.panels.into_iter().collect(),
        })
    }
}

impl SqliteStore {
    /// The folder of the files of one session of a participant: its plan, drives and journals. A withdrawal erases it.
    ///
    /// # Errors
    /// [`CampaignError::Name`] where the session has no name that can be a folder.
    pub fn session_folder(
        &self,
        participant: &Pseudonym,
        session: &str,
    ) -> Result<PathBuf, CampaignError> {
        let session = Pseudonym::new(session)?;
        Ok(self.participant_folder(participant).join(session.as_str()))
    }

    /// The plan that was written for a session; `None` where there is none yet.
    ///
    /// # Errors
    /// [`CampaignError`].
    pub fn plan(
        &self,
        participant: &Pseudonym,
        session: &str,
    ) -> Result<Option<Plan>, CampaignError> {
        let path = self.session_folder(participant, session)?.join(PLAN);
        match crate::reads::is_there(&path) {
            true => Ok(Some(parsed(&path, "the plan of a session")?)),
            false => Ok(None),
        }
    }

    /// Writes the plan of a session, before it begins.
    ///
    /// # Errors
    /// [`CampaignError`].
    pub fn write_plan(&self, plan: &Plan) -> Result<(), CampaignError> {
        let participant = Pseudonym::new(&plan.participant)?;
        let folder = self.session_folder(&participant, &plan.session)?;
        std::fs::create_dir_all(&folder).map_err(WriteError::io(&folder))?;
        Ok(write(&folder.join(PLAN), &plan.bytes())?)
    }
}

fn write(path: &Path, bytes: &[u8]) -> Result<(), WriteError> {
    write_atomically(path, |file| {
        file.write_all(bytes).map_err(WriteError::io(path))
    })
}

fn parsed<T: for<'de> Deserialize<'de>>(
    path: &Path,
    expected: &'static str,
) -> Result<T, CampaignError> {
    let text = read_input_text(path)?;
    serde_json::from_str(&text).map_err(|error| CampaignError::Form {
        path: path.to_owned(),
        expected,
        why: error.to_string(),
    })
}

fn same(path: &Path, what: &'static str, expected: Sha, text: &str) -> Result<(), CampaignError> {
    let found = Sha::of(text.as_bytes());
    match found == expected {
        true => Ok(()),
        false => Err(CampaignError::Changed {
            path: path.to_owned(),
            what,
            expected,
            found,
        }),
    }
}
