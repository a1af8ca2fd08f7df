//! What a sound device does to a signal, against SciPy and NumPy (`golden/sound.py`).
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use piezotact::quantity::{Hertz, SampleRate, Seconds};
use piezotact::sound::{LatencyRun, LatencySummary, delay, tone};
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
