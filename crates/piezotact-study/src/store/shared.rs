//! What stations that share a study have in its database beside the answers: the campaign, and the plans of sessions. And what the
//! folder of a station keeps of its own: where the database is, and for whom its identities were erased.

use std::collections::BTreeSet;
use std::fmt;
use std::path::{Path, PathBuf};

use piezotact_people::campaign::chain::Sha;
use piezotact_people::campaign::plan::Plan;
use piezotact_people::campaign::store::{SessionKey, StoreError};

use super::DATABASE;
use super::campaign::write;
use super::database::{Database, Value};
use super::error::{Kept, StudyError, damaged};
use super::identity;
use super::postgres::DatabaseUrl;
use super::sessions::{has_withdrawn, withdrawn};
use super::study_store::StudyStore;
use piezotact_dataset::atomic::sync_folder;

/// The URL of the database, in one line. It is not in campaign.json: that file is the same at every station, and the way to the server
/// is not.
const URL: &str = "study.url";
/// Pseudonyms, one a line: who has withdrawn and is not in the identities of this station.
const ERASED: &str = "identity.erased";
/// More is no URL.
const MOST_BYTES: u64 = 4096;

/// What became of withdrawals when a study was opened that several stations share.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Notice {
    /// Files of a participant who has withdrawn at another station were erased here.
    FilesErased { participant: String, files: usize },
    /// The identities of this station may hold somebody who has withdrawn at another one.
    MayBeNamed { participant: String, path: PathBuf },
    /// The tables were not rewritten yet after a withdrawal.
    NotRewritten { why: String },
}

impl fmt::Display for Notice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::FilesErased { participant, files } => write!(
                f,
                "{participant} has withdrawn at another station: {} erased here",
                match files {
                    1 => "1 file was".to_owned(),
                    files => format!("{files} files were"),
                }
            ),
            Self::MayBeNamed { participant, path } => write!(
                f,
                "{participant} has withdrawn at another station, and {} may still hold who it is; withdraw {participant} here too, with the passphrase",
                path.display()
            ),
            Self::NotRewritten { why } => write!(
                f,
                "what was erased may stand in free space of the tables on the server, as {why}; have their owner open the study, or execute \
                 VACUUM FULL piezotact.events and VACUUM FULL piezotact.plans"
            ),
        }
    }
}

/// The URL of the study in `folder`; `None` where its database is in the folder.
pub(super) fn url_of(folder: &Path) -> Result<Option<DatabaseUrl>, StudyError> {
    use std::io::Read as _;
    let path = folder.join(URL);
    match std::fs::symlink_metadata(&path) {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(StudyError::io(&path)(error)),
        Ok(found) if !found.is_file() => {
            return Err(StudyError::NoStudy {
                path,
                found: "a link or no file",
            });
        }
        Ok(_) => {}
    }
    let mut text = String::new();
    let file = std::fs::File::open(&path).map_err(StudyError::io(&path))?;
    let read = file.take(MOST_BYTES).read_to_string(&mut text);
    read.map_err(StudyError::io(&path))?;
    let url = text.trim_end().parse();
    url.map(Some).map_err(|why| StudyError::Url {
        path,
        why: Box::new(why),
    })
}

/// Refuses a folder whose study is on a server.
pub(super) fn require_no_url(folder: &Path) -> Result<(), StudyError> {
    match url_of(folder)? {
        None => Ok(()),
        Some(url) => Err(StudyError::OtherPlace {
            folder: folder.to_owned(),
            url: url.to_string(),
            found: "a study in the folder that is to be made",
        }),
    }
}

/// Refuses a folder that has a database of its own, or belongs to another one than that at `url`.
pub(super) fn require_free(folder: &Path, url: &DatabaseUrl) -> Result<(), StudyError> {
    let other = |found| StudyError::OtherPlace {
        folder: folder.to_owned(),
        url: url.to_string(),
        found,
    };
    if folder.join(DATABASE).symlink_metadata().is_ok() {
        return Err(other("study.sqlite in the folder"));
    }
    match url_of(folder)? {
        Some(found) if found != *url => Err(other("the URL of another one in study.url")),
        _ => Ok(()),
    }
}

/// Notes in `folder` where the database is.
pub(super) fn write_url(folder: &Path, url: &DatabaseUrl) -> Result<(), StudyError> {
    let path = folder.join(URL);
    if path.exists() {
        return Ok(());
    }
    write(&path, format!("{url}\n").as_bytes()).map_err(|error| StudyError::Place {
        path: path.clone(),
        why: error.to_string(),
        advice: "make the folder writable, then do the same again",
    })?;
    sync_folder(&path);
    Ok(())
}

/// The campaign as it stands in the database: its file, its protocol and its consent text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct StoredCampaign {
    pub(super) file: String,
    pub(super) protocol: String,
    pub(super) consent: Option<String>,
}

impl StudyStore {
    /// What became of withdrawals when this study was opened, where several stations share it.
    #[must_use]
    pub fn notices(&self) -> &[Notice] {
        &self.notices
    }

    /// The campaign in the database of the server; `None` where it is not entered yet.
    pub(super) fn stored_campaign(&self) -> Result<Option<StoredCampaign>, StoreError> {
        self.read(async |database| stored_campaign(database).await)
    }

    /// Enters the campaign in the database of the server, for the other stations.
    pub(super) fn store_campaign(&mut self, campaign: &StoredCampaign) -> Result<(), StoreError> {
        self.change(async |database| {
            let values = [
                Value::from(&campaign.file),
                (&campaign.protocol).into(),
                Value::Text(campaign.consent.as_deref()),
            ];
            let row = "INSERT INTO campaign VALUES (1, $1, $2, $3)";
            database.execute(row, &values).await.map(|_| ())
        })
    }

    /// The plan of a session in the database of the server.
    pub(super) fn stored_plan(&self, key: &SessionKey) -> Result<Option<String>, StoreError> {
        self.read(async |database| plan_of(database, key).await)
    }

    /// Stores the plan of a session in the database of the server, unless the session has another one; gives the plan that it has.
    pub(super) fn store_plan(&mut self, plan: &Plan) -> Result<String, StudyError> {
        let key = SessionKey::new(&plan.participant, &plan.session);
        let text = String::from_utf8(plan.bytes()).map_err(|error| damaged(error.to_string()))?;
        let stored = self.change(async |database| {
            if has_withdrawn(database, &key.participant).await? {
                return Err(withdrawn(&key.participant));
            }
            let begun =
                "SELECT EXISTS (SELECT 1 FROM sessions WHERE participant = $1 AND session = $2)";
            let names = [Value::from(&key.participant), (&key.session).into()];
            if let (true,) = database.one(begun, &names).await?
                && let Some(written) = plan_of(database, &key).await?
            {
                return Ok(written);
            }
            let sha = Sha::of(text.as_bytes());
            let values = [
                Value::from(&key.participant),
                (&key.session).into(),
                (&text).into(),
                sha.bytes()[..].into(),
            ];
            let written = "INSERT INTO plans VALUES ($1, $2, $3, $4) \
                ON CONFLICT (participant, session) DO UPDATE SET plan = $3, sha = $4";
            database.execute(written, &values).await?;
            Ok(text.clone())
        });
        Ok(stored?)
    }

    /// Who has withdrawn.
    pub(super) fn withdrawn(&self) -> Result<Vec<String>, StoreError> {
        self.read(async |database| {
            let names = "SELECT participant FROM withdrawals ORDER BY participant";
            let names: Vec<(String,)> = database.rows(names, &[]).await?;
            Ok(names.into_iter().map(|(name,)| name).collect())
        })
    }

    /// Who withdrew at another station, and may still be in the identities of this one.
    pub(super) fn may_be_named(&self) -> Result<Vec<String>, StudyError> {
        if self.kept() == Kept::InFolder || !self.folder.join(identity::IDENTITY).is_file() {
            return Ok(Vec::new());
        }
        let erased = erased(&self.folder)?;
        let mut named = self.withdrawn().map_err(|error| StudyError::Place {
            path: self.folder.clone(),
            why: error.to_string(),
            advice: "open the study again",
        })?;
        named.retain(|name| !erased.contains(name));
        Ok(named)
    }

    /// Notes that none of `names` is in the identities of this station.
    pub(super) fn note_erased(&self, names: &[String]) -> Result<(), StudyError> {
        let mut erased = erased(&self.folder)?;
        let before = erased.len();
        erased.extend(names.iter().cloned());
        if self.kept() == Kept::InFolder || erased.len() == before {
            return Ok(());
        }
        let path = self.folder.join(ERASED);
        let lines: Vec<String> = erased.into_iter().map(|name| name + "\n").collect();
        write(&path, lines.concat().as_bytes()).map_err(|error| StudyError::Place {
            path: path.clone(),
            why: error.to_string(),
            advice: "make the folder writable, then do the same again",
        })
    }
}

pub(super) async fn stored_campaign(
    database: &mut Database,
) -> Result<Option<StoredCampaign>, StoreError> {
    let row = "SELECT file, protocol, consent FROM campaign";
    let row: Option<(String, String, Option<String>)> = database.row(row, &[]).await?;
    Ok(row.map(|(file, protocol, consent)| StoredCampaign {
        file,
        protocol,
        consent,
    }))
}

/// For whom the identities of the station in `folder` were looked through.
fn erased(folder: &Path) -> Result<BTreeSet<String>, StudyError> {
    let path = folder.join(ERASED);
    match std::fs::read_to_string(&path) {
        Ok(text) => Ok(text.lines().map(str::to_owned).collect()),
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(BTreeSet::new()),
        Err(error) => Err(StudyError::io(&path)(error)),
    }
}

async fn plan_of(database: &mut Database, key: &SessionKey) -> Result<Option<String>, StoreError> {
    let plan = "SELECT plan, sha FROM plans WHERE participant = $1 AND session = $2";
    let names = [Value::from(&key.participant), (&key.session).into()];
    let plan: Option<(String, Vec<u8>)> = database.row(plan, &names).await?;
    let Some((plan, sha)) = plan else {
        return Ok(None);
    };
    match Sha::of(plan.as_bytes()).bytes()[..] == sha[..] {
        true => Ok(Some(plan)),
        false => Err(damaged(format!(
            "the plan of session {} of {} is not the one whose checksum was stored",
            key.session, key.participant
        ))),
    }
}
