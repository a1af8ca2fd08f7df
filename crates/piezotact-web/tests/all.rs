//! All tests of the pages.

mod access;
mod client;
mod console;
#[cfg(target_os = "linux")]
mod flood;
mod pages;
mod session;
mod stopping;
#[path = "../../piezotact-study/tests/support/mod.rs"]
#[allow(dead_code, reason = "a part of it is for the tests of the runner")]
mod support;
