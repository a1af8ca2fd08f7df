//! Magnitudes of a transfer function in a file.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use serde_json::Value;

/// Magnitudes, dB, at `at_hz`, of the transfer function that `text` holds.
pub(crate) fn levels_db(text: &str, at_hz: &[f64]) -> Vec<f64> {
    let function: Value = serde_json::from_str(text).unwrap();
    let list = |name: &str| -> Vec<f64> {
        let values = function[name].as_array().unwrap().iter();
        values.map(|value| value.as_f64().unwrap()).collect()
    };
    let (hz, re, im) = (list("frequency_hz"), list("real"), list("imaginary"));
    let level = |wanted: &f64| {
        let above = hz.iter().position(|hz| hz >= wanted).unwrap();
        let of = |i: usize| 20.0 * re[i].hypot(im[i]).log10();
        let share = (wanted - hz[above - 1]) / (hz[above] - hz[above - 1]);
        of(above - 1) + share * (of(above) - of(above - 1))
    };
    at_hz.iter().map(level).collect()
}
