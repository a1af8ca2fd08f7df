//! The analysis of EEG: against MNE-Python, and against simulations whose truth is known.
#![allow(
    clippy::disallowed_types,
    clippy::print_stdout,
    clippy::unwrap_used,
    reason = "tests that read reference values, and say how near they came"
)]

mod desynchronisation;
mod golden;
mod null;
mod reference;
mod speed;

use piezotact::quantity::SampleRate;
use piezotact_people::eeg::epochs::Epochs;

/// Epochs of channels × epochs × samples with one condition.
fn epochs(
    channels: &[String],
    count: usize,
    rate_hz: f64,
    first_s: f64,
    volts: Vec<f64>,
) -> Epochs {
    let rate = SampleRate::new(rate_hz).unwrap();
    let conditions = vec!["task".to_owned(); count];
    Epochs::new(channels.to_vec(), conditions, rate, first_s, volts).unwrap()
}

fn names(names: &[&str]) -> Vec<String> {
    names.iter().map(|name| (*name).to_owned()).collect()
}

/// Asserts that each value is within `tolerance` of the largest expected one.
fn assert_near(what: &str, got: &[f64], expected: &[f64], tolerance: f64) {
    assert_eq!(got.len(), expected.len(), "{what}");
    let largest = expected.iter().fold(0.0f64, |most, v| most.max(v.abs()));
    let worst = got
        .iter()
        .zip(expected)
        .map(|(a, b)| (a - b).abs() / largest)
        .fold(0.0, f64::max);
    println!("{what}: {worst:.1e} of the largest value");
    assert!(
        worst <= tolerance,
        "{what}: {worst:.2e} above {tolerance:.0e}"
    );
}

/// Asserts that each value is within `tolerance` of the expected one, relative to it.
fn assert_relative(what: &str, got: &[f64], expected: &[f64], tolerance: f64) {
    assert_eq!(got.len(), expected.len(), "{what}");
    let worst = got
        .iter()
        .zip(expected)
        .map(|(a, b)| (a - b).abs() / b.abs())
        .fold(0.0, f64::max);
    println!("{what}: {worst:.1e} relative");
    assert!(
        worst <= tolerance,
        "{what}: {worst:.2e} above {tolerance:.0e}"
    );
}
