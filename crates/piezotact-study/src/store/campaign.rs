//! What a study is of: its protocol, seed, consent text and the panels that must not overlap with it, fixed when it is made; and the
//! plan of each session.

use std::collections::{BTreeMap, BTreeSet};
use std::io::Write as _;
use std::path::{Path, PathBuf};

use piezotact_people::campaign::chain::Sha;
use piezotact_people::campaign::plan::Plan;
use piezotact_people::campaign::protocol::{Protocol, read};
use piezotact_people::campaign::store::{SessionEntry, SessionKey, Store as _, StoreError};
use serde::{Deserialize, Serialize};

use super::DATABASE;
use super::error::{Kept, StudyError};
use super::postgres::DatabaseUrl;
use super::pseudonym::Pseudonym;
use super::shared::{StoredCampaign, stored_campaign};
use super::study_store::StudyStore;
use piezotact_dataset::WriteError;
use piezotact_dataset::atomic::{sync_folder, write_atomically};
use piezotact_dataset::read_input_text;

/// The folders in that of a session.
const PARTS: [&str; 4] = ["targets", "drives", "measured", "runs"];
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

/// The version of a campaign.json, whatever else stands in it.
#[derive(Deserialize)]
struct Form {
    form: u32,
}

const CAMPAIGN_OF_STUDY: &str = "the campaign of a study";

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

impl StudyCampaign {
    /// Makes the study of `new` in `folder`, which is made where it is not there, and opens it. A creation that was interrupted is
    /// completed: a study without a campaign and without sessions is no study yet.
    ///
    /// # Errors
    /// [`StudyError`]; a protocol that cannot be used, and a file that stands in the way, are refused before anything is written.
    pub fn create(folder: &Path, new: &NewCampaign<'_>) -> Result<StudyStore, StudyError> {
        require_new(folder, new)?;
        let store = match folder.join(DATABASE).symlink_metadata() {
            Ok(_) => match StudyStore::create(folder) {
                Err(StudyError::Exists { .. }) => StudyStore::open(folder)?,
                other => other?,
            },
            Err(_none) => StudyStore::create(folder)?,
        };
        require_no_session(&store)?;
        write_files(folder, &stored(folder, new)?)?;
        Ok(store)
    }

    /// Makes the study of `new` in the database at `url`, with this station's files in `folder`, and opens it. A creation that was
    /// interrupted is completed.
    ///
    /// # Errors
    /// As [`Self::create`]; [`StudyError::Taken`] where the database holds another study, or one with sessions.
    pub fn create_on(
        folder: &Path,
        url: &DatabaseUrl,
        new: &NewCampaign<'_>,
    ) -> Result<StudyStore, StudyError> {
        require_new(folder, new)?;
        let campaign = stored(folder, new)?;
        let mut store = match StudyStore::create_on(folder, url) {
            Ok(store) => store,
            Err(StudyError::Taken { url: taken }) => {
                if !is_unfinished(url, &campaign)? {
                    return Err(StudyError::Taken { url: taken });
                }
                StudyStore::join(folder, url)?
            }
            Err(error) => return Err(error),
        };
        if store.stored_campaign()?.is_none() {
            store.store_campaign(&campaign)?;
        }
        write_files(folder, &campaign)?;
        Ok(store)
    }

    /// Makes the folder of a further station of the study in the database at `url`, and opens it.
    ///
    /// # Errors
    /// [`StudyError`].
    pub fn join(folder: &Path, url: &DatabaseUrl) -> Result<StudyStore, StudyError> {
        if folder.join(CAMPAIGN).symlink_metadata().is_ok() {
            let folder = folder.to_owned();
            return Err(StudyError::Exists { folder });
        }
        let probed = StudyStore::probe(url, async |database| stored_campaign(database).await)?;
        let Some(campaign) = probed else {
            return Err(StudyError::Unfinished {
                url: url.to_string(),
            });
        };
        for (name, what, text) in campaign.texts() {
            free(&folder.join(name), what, text)?;
        }
        let store = StudyStore::join(folder, url)?;
        write_files(folder, &campaign)?;
        Ok(store)
    }

    /// The campaign of the study in `folder`.
    ///
    /// # Errors
    /// [`StudyError::Changed`] where protocol or consent text are not those it was made with, and other [`StudyError`]s.
    pub fn read(folder: &Path) -> Result<Self, StudyError> {
        let path = folder.join(CAMPAIGN);
        // A later form may have other fields.
        let Form { form } = parsed(&path, CAMPAIGN_OF_STUDY)?;
        if form > FORM {
            return Err(StudyError::Newer {
                path,
                known: FORM.into(),
                found: form.into(),
            });
        }
        let file: CampaignFile = parsed(&path, CAMPAIGN_OF_STUDY)?;
        if file.form != FORM {
            return Err(StudyError::Form {
                path,
                expected: "form 1",
                why: format!("form {form}"),
            });
        }
        let path = folder.join(PROTOCOL);
        let text = own_text(&path)?;
        same(&path, "protocol", file.protocol_sha, &text)?;
        let consent = match file.consent_sha {
            Some(expected) => {
                let path = folder.join(CONSENT);
                let text = own_text(&path)?;
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

impl StudyStore {
    /// The campaign of this study. Where several stations share it, the files of this station are those that the others have.
    ///
    /// # Errors
    /// As [`StudyCampaign::read`]; [`StudyError::NotShared`] where they are not.
    pub fn campaign(&self) -> Result<StudyCampaign, StudyError> {
        if self.kept() == Kept::OnServer {
            let path = self.folder().join(CAMPAIGN);
            let file = own_text(&path)?;
            if self
                .stored_campaign()?
                .is_none_or(|stored| stored.file != file)
            {
                return Err(StudyError::NotShared { path });
            }
        }
        StudyCampaign::read(self.folder())
    }

    /// The folder of the files of one session of a participant: its plan, drives and journals. A withdrawal erases it.
    ///
    /// # Errors
    /// [`StudyError::Pseudonym`] where the session has no name that can be a folder, [`StudyError::Linked`] where the folder leads
    /// elsewhere.
    pub fn session_folder(
        &self,
        participant: &Pseudonym,
        session: &str,
    ) -> Result<PathBuf, StudyError> {
        let session = Pseudonym::new(session)?;
        let of_participant = self.participant_folder(participant);
        let folder = of_participant.join(session.as_str());
        let parts = PARTS.map(|part| folder.join(part));
        for path in [&of_participant, &folder].into_iter().chain(&parts) {
            if path.is_symlink() {
                return Err(StudyError::Linked { path: path.clone() });
            }
        }
        Ok(folder)
    }

    /// The plan that was written for a session; `None` where there is none yet.
    ///
    /// # Errors
    /// [`StudyError`].
    pub fn plan(&self, participant: &Pseudonym, session: &str) -> Result<Option<Plan>, StudyError> {
        let path = self.session_folder(participant, session)?.join(PLAN);
        let text = match self.kept() {
            Kept::InFolder if !piezotact_dataset::reads::is_there(&path) => None,
            Kept::InFolder => Some(own_text(&path)?),
            Kept::OnServer => self.stored_plan(&SessionKey::new(participant.as_str(), session))?,
        };
        let Some(text) = text else {
            return Ok(None);
        };
        let plan: Plan = parsed_text(&path, &text, "the plan of a session")?;
        // A folder that was copied or renamed: its session would go on under another name.
        if (plan.participant.as_str(), plan.session.as_str()) != (participant.as_str(), session) {
            return Err(StudyError::Form {
                path,
                expected: "the plan of this participant and session",
                why: format!("that of session {} of {}", plan.session, plan.participant),
            });
        }
        Ok(Some(plan))
    }

    /// Writes the plan of a session, before it begins: it is on the disk when this returns. The plan of a session that was entered
    /// in the store stays; the same one is accepted again.
    ///
    /// # Errors
    /// [`StudyError::Planned`] for another plan of a session that was begun, [`StudyError::Store`] for a participant who
    /// has withdrawn, of whom nothing is written any more, and other [`StudyError`]s.
    pub fn write_plan(&mut self, plan: &Plan) -> Result<(), StudyError> {
        let participant = Pseudonym::new(&plan.participant)?;
        let folder = self.session_folder(&participant, &plan.session)?;
        let path = folder.join(PLAN);
        let sessions = self.sessions()?;
        let known = sessions.iter().map(|entry| entry.key.participant.as_str());
        participant.check_among(known)?;
        if self.is_withdrawn(&participant)? {
            return Err(StudyError::Store(StoreError::Withdrawn {
                participant: plan.participant.clone(),
            }));
        }
        let is_it = |entry: &SessionEntry| {
            entry.key.names() == (plan.participant.as_str(), plan.session.as_str())
        };
        let other = |written: &Plan| StudyError::Planned {
            path: path.clone(),
            participant: plan.participant.clone(),
            session: plan.session.clone(),
            shas: Box::new([written.sha(), plan.sha()]),
        };
        if sessions.iter().any(is_it)
            && let Some(written) = self.plan(&participant, &plan.session)?
        {
            return match written == *plan {
                true => Ok(()),
                false => Err(other(&written)),
            };
        }
        std::fs::create_dir_all(&folder).map_err(WriteError::io(&folder))?;
        if self.kept() == Kept::OnServer {
            let text = self.store_plan(plan)?;
            // Another station may have begun it in the meantime.
            let written: Plan = parsed_text(&path, &text, "the plan of a session")?;
            return match written == *plan {
                true => Ok(()),
                false => Err(other(&written)),
            };
        }
        write(&path, &plan.bytes())?;
        // The file, its folder, and that of the participant: the journal that names the plan is never there without it.
        for made in [&path, &folder, &self.participant_folder(&participant)] {
            sync_folder(made);
        }
        Ok(())
    }
}

/// Refuses a protocol that cannot be used, and a folder in which the study cannot be made.
fn require_new(folder: &Path, new: &NewCampaign<'_>) -> Result<(), StudyError> {
    let protocol = read(new.protocol)?;
    for session in &protocol.sessions {
        Pseudonym::new(&session.name)?;
    }
    if folder.join(CAMPAIGN).symlink_metadata().is_ok() {
        let folder = folder.to_owned();
        return Err(StudyError::Exists { folder });
    }
    free(&folder.join(PROTOCOL), "protocol", Some(new.protocol))?;
    free(&folder.join(CONSENT), "consent text", new.consent)
}

fn require_no_session(store: &StudyStore) -> Result<(), StudyError> {
    let path = store.folder().join(CAMPAIGN);
    match store.sessions()?.len() {
        0 => Ok(()),
        sessions => Err(StudyError::Incomplete { path, sessions }),
    }
}

/// Whether the study in the database at `url` is what a creation of `campaign` has left that was interrupted.
fn is_unfinished(url: &DatabaseUrl, campaign: &StoredCampaign) -> Result<bool, StudyError> {
    let (found, changes) = StudyStore::probe(url, async |database| {
        let changes: (i64,) = database.one("SELECT changes FROM study", &[]).await?;
        Ok((stored_campaign(database).await?, changes.0))
    })?;
    // The campaign is the first change.
    Ok(changes <= 1 && found.is_none_or(|found| found == *campaign))
}

/// The files of `new`, as they are written.
fn stored(folder: &Path, new: &NewCampaign<'_>) -> Result<StoredCampaign, StudyError> {
    let file = CampaignFile {
        form: FORM,
        protocol_sha: Sha::of(new.protocol.as_bytes()),
        seed: new.seed,
        consent_sha: new.consent.map(|text| Sha::of(text.as_bytes())),
        panels: new.panels.clone(),
        program: new.program.to_owned(),
    };
    let text = serde_json::to_string_pretty(&file).map_err(|error| StudyError::Form {
        path: folder.join(CAMPAIGN),
        expected: "a campaign",
        why: error.to_string(),
    })?;
    Ok(StoredCampaign {
        file: text + "\n",
        protocol: new.protocol.to_owned(),
        consent: new.consent.map(str::to_owned),
    })
}

impl StoredCampaign {
    /// The texts with the names of their files, and what they are.
    fn texts(&self) -> [(&'static str, &'static str, Option<&str>); 2] {
        [
            (PROTOCOL, "protocol", Some(&self.protocol)),
            (CONSENT, "consent text", self.consent.as_deref()),
        ]
    }
}

/// Writes the files of a campaign into the folder of its study.
fn write_files(folder: &Path, campaign: &StoredCampaign) -> Result<(), StudyError> {
    for (name, _, text) in campaign.texts() {
        if let Some(text) = text {
            write(&folder.join(name), text.as_bytes())?;
        }
    }
    let path = folder.join(CAMPAIGN);
    // Last, as it vouches for the others: they are on the disk before it.
    sync_folder(&path);
    write(&path, campaign.file.as_bytes())?;
    sync_folder(&path);
    Ok(())
}

/// Refuses another file in the place of one of a study that is to be made.
fn free(path: &Path, what: &'static str, text: Option<&str>) -> Result<(), StudyError> {
    let same = match path.symlink_metadata() {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => true,
        // Nothing else is opened: a pipe would wait for ever.
        Ok(found) if found.is_file() => {
            text.is_some() && std::fs::read(path).ok().as_deref() == text.map(str::as_bytes)
        }
        _ => false,
    };
    match same {
        true => Ok(()),
        false => Err(StudyError::InTheWay {
            path: path.to_owned(),
            what,
        }),
    }
}

pub(super) fn write(path: &Path, bytes: &[u8]) -> Result<(), WriteError> {
    write_atomically(path, |file| {
        file.write_all(bytes).map_err(WriteError::io(path))
    })
}

/// The text of a file of the study, which is no link: one leads out of the study, where a withdrawal erases nothing.
fn own_text(path: &Path) -> Result<String, StudyError> {
    if path.is_symlink() {
        return Err(StudyError::Form {
            path: path.to_owned(),
            expected: "a file of the study",
            why: "a link".into(),
        });
    }
    Ok(read_input_text(path)?)
}

pub(super) fn parsed<T: for<'de> Deserialize<'de>>(
    path: &Path,
    expected: &'static str,
) -> Result<T, StudyError> {
    parsed_text(path, &own_text(path)?, expected)
}

fn parsed_text<T: for<'de> Deserialize<'de>>(
    path: &Path,
    text: &str,
    expected: &'static str,
) -> Result<T, StudyError> {
    serde_json::from_str(text).map_err(|error| StudyError::Form {
        path: path.to_owned(),
        expected,
        why: error.to_string(),
    })
}

fn same(path: &Path, what: &'static str, expected: Sha, text: &str) -> Result<(), StudyError> {
    let found = Sha::of(text.as_bytes());
    match found == expected {
        true => Ok(()),
        false => Err(StudyError::Changed {
            path: path.to_owned(),
            what,
            expected,
            found,
        }),
    }
}
