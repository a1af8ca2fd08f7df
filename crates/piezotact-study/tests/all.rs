//! All tests of the runner.

mod adaptive;
mod bench;
mod failures;
mod reopening;
mod session;
mod session_answers;
#[path = "../../piezotact-people/tests/sitting/mod.rs"]
mod sitting;
mod support;
mod touching;
