//! The study on disk: the store of a campaign in SQLite, the encrypted identities beside it, and withdrawal from both.
//!
//! A study is a folder. `study.sqlite` holds sessions and events, `study.seal` how many changes were acknowledged, `identity.age` who
//! the participants are, and `participants/PSEUDONYM/` the files of each. What a kill and a power cut leave is in decision 0066.

mod campaign;
mod error;
mod identity;
mod opening;
mod pseudonym;
mod running;
mod schema;
mod seal;
mod simulated;
mod store;
#[cfg(test)]
mod tests;
mod withdrawal;

pub use campaign::{CampaignError, NewCampaign, StudyCampaign};
pub use error::StudyError;
pub use identity::{ConsentStored, IdentityError, Passphrase, PersonalData, SignedConsent};
pub use pseudonym::{Pseudonym, PseudonymError};
pub use running::{RunningError, SessionLock};
pub use store::SqliteStore;
pub use withdrawal::{WithdrawError, Withdrawn};

/// The database.
const DATABASE: &str = "study.sqlite";
/// The folder of the participants' files.
const PARTICIPANTS: &str = "participants";
