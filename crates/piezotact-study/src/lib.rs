//! What a study adds to a laboratory: the store of a campaign, the runner of its sessions, tables of answers, and BIDS data sets.
//!
//! Recordings and transfer functions are files of `piezotact-dataset`; what people answer is computed in `piezotact-people`.

mod answers;
pub mod bids;
pub mod session;
pub mod store;

pub use answers::{AnswersFile, read_answers};
