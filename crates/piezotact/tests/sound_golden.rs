//! What a sound device does to a signal, against SciPy and NumPy (`golden/sound.py`).
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use piezotact::quantity::{Hertz, SampleRate, Seconds};
use piezotact::sound::{LatencyRun, LatencySummary, burst_delay, delay, tone, tone_near};
use serde_json::Value;

fn golden() -> Value {
    serde_json::from_str(include_str!("golden/sound.json")).unwrap()
}

fn list(value: &Value) -> Vec<f64> {
    value
        .as_array()
        .unwrap()
        .iter()
        .map(|v| v.as_f64().unwrap())
        .collect()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

#[test]
fn a_tone_is_that_of_least_squares() {
    let golden = golden();
    let (of, rate) = (
        &golden["tone"],
        SampleRate::new(number(&golden["rate_hz"])).unwrap(),
    );
    let found = tone(&list(&of["samples"]), rate, Hertz(number(&of["hz"]))).unwrap();
    // An iteration to 1e-15 beside one step of elimination.
    for (name, value) in [
        ("rms", found.rms),
        ("phase_rad", found.phase_rad),
        ("mean", found.mean),
        ("residual_rms", found.residual_rms),
    ] {
        let expected = number(&of[name]);
        assert!(
            (value - expected).abs() < 1e-9,
            "{name}: {value} {expected}"
        );
    }
}

#[test]
fn a_tone_of_another_frequency_is_that_of_least_squares() {
    let golden = golden();
    let (of, rate) = (
        &golden["near"],
        SampleRate::new(number(&golden["rate_hz"])).unwrap(),
    );
    let stated = Hertz(number(&golden["tone"]["hz"]));
    let (hz, found) = tone_near(&list(&of["samples"]), rate, stated, 0.03).unwrap();
    // The section ends at 1e-5 of the resolution of 3.3 Hz, where the residual is flat to rounding: 1e-8 of it.
    assert!((hz.0 - number(&of["hz"])).abs() < 2e-5, "{hz:?}");
    for (name, value) in [("rms", found.rms), ("residual_rms", found.residual_rms)] {
        let expected = number(&of[name]);
        assert!(
            (value - expected).abs() < 1e-9,
            "{name}: {value} {expected}"
        );
    }
}

#[test]
fn a_burst_is_placed_by_the_phases_of_its_spectrum() {
    let golden = golden();
    let of = &golden["burst"];
    let found = burst_delay(&list(&of["drive"]), &list(&of["recorded"])).unwrap();
    assert_eq!(found.samples, of["lag"].as_i64().unwrap());
    for (name, value) in [("fraction", found.fraction), ("gain", found.gain)] {
        let expected = number(&of[name]);
        // Another transform of another length of zeros.
        assert!(
            (value - expected).abs() < 1e-9,
            "{name}: {value} {expected}"
        );
        let truth = number(&of[&format!("true_{name}")]);
        assert!((value - truth).abs() < 0.01, "{name}: {value} {truth}");
    }
}

#[test]
fn a_delay_is_that_of_the_correlation() {
    let golden = golden();
    let of = &golden["loopback"];
    let found = delay(&list(&of["drive"]), &list(&of["recorded"])).unwrap();
    assert_eq!(found.samples, of["lag"].as_i64().unwrap());
    assert!(
        (found.gain - number(&of["gain"])).abs() < 1e-12,
        "{found:?}"
    );
}

#[test]
fn percentiles_are_those_of_the_inverted_distribution() {
    let golden = golden();
    let run = |s: f64| LatencyRun {
        latency_s: Some(Seconds(s)),
        gain: 1.0,
        drop_outs: 0,
    };
    let runs = list(&golden["latencies_s"]).into_iter().map(run).collect();
    let rate = SampleRate::new(48_000.0).unwrap();
    let found = LatencySummary::of("loop", "2026-01-01", rate, 256, runs)
        .latency
        .unwrap();
    let found = [found.median_s, found.p95_s, found.p99_s].map(|s| s.0);
    assert_eq!(found.to_vec(), list(&golden["percentiles_s"]));
}
