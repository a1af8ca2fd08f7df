//! Every test of the program as a black box.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

mod replay;
#[path = "../../piezotact-app/tests/same_numbers/rows.rs"]
#[allow(dead_code, reason = "the tests of the command use all of it")]
mod rows;
mod same_numbers;
mod support;
