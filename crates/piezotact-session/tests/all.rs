//! All tests of the runner.

mod adaptive;
mod bench;
mod failures;
mod reopening;
mod session;
mod support;
