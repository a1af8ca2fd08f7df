//! The study on disk: the store of a campaign in SQLite or PostgreSQL, the encrypted identities beside it, and withdrawal from both.
//!
//! A study is a folder. `study.sqlite` holds sessions and events, `study.seal` how many changes were acknowledged, `identity.age` who
//! the participants are, and `participants/PSEUDONYM/` the files of each. What a kill and a power cut leave is in docs/decisions/store.md. Where
//! several stations share a study, each has a folder, and `study.url` names the database in the place of `study.sqlite` (docs/decisions/store.md).

mod campaign;
mod database;
mod error;
mod identity;
mod opening;
mod postgres;
mod pseudonym;
mod running;
mod schema;
mod seal;
mod sessions;
mod shared;
mod simulated;
mod study_store;
#[cfg(test)]
mod tests;
mod withdrawal;

pub use campaign::{NewCampaign, StudyCampaign};
pub use database::Remains;
pub use error::{Kept, StudyError};
pub use identity::{ConsentStored, Passphrase, PersonalData, SignedConsent};
pub use postgres::DatabaseUrl;
pub use pseudonym::Pseudonym;
pub use running::SessionLock;
pub use shared::Notice;
pub use study_store::StudyStore;
pub use withdrawal::Withdrawn;

/// The database.
const DATABASE: &str = "study.sqlite";
/// The folder of the participants' files.
const PARTICIPANTS: &str = "participants";
