//! `piezotact serve`: a session with a participant on pages of a browser.

mod console;
mod led;
mod network;
mod study;

pub(crate) use led::{Arguments, run};
