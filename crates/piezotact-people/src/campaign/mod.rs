//! A campaign with volunteers: its protocol, the check of its design, the plan of each person, and the session.

pub mod adaptive;
pub mod chain;
pub mod describe;
pub mod design;
pub mod dictionary;
pub mod overview;
pub mod plan;
pub mod protocol;
mod random;
pub mod readiness;
pub mod session;
pub mod store;
pub mod text;
