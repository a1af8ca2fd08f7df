//! Channels that are one signal.
#![allow(
    clippy::unwrap_used,
    reason = "a test stops where something is missing"
)]

use std::f64::consts::TAU;

use piezotact::integrity::copied;

use crate::integrity::Noise;

#[test]
fn a_copy_is_told_from_a_response() {
    let mut noise = Noise::new(3);
    let x = noise.white(30_000);
    // One signal through two converters, each with its noise.
    let other: Vec<f64> = x.iter().map(|v| 1.7 * v + 5e-4 * noise.next()).collect();
    assert!(copied(&x, &other).is_some_and(|c| (c.factor - 1.7).abs() < 1e-3));
    let sensor: Vec<f64> = x.iter().map(|v| 1.7 * v + 5e-3 * noise.next()).collect();
    assert_eq!(copied(&x, &sensor), None);
    for (factor, later) in [(1.0, 0_i64), (-3.7, 12), (0.02, -300)] {
        let at = |i: usize| {
            let i = i as i64 - later;
            usize::try_from(i)
                .ok()
                .and_then(|i| x.get(i))
                .copied()
                .unwrap_or(0.1)
        };
        let y: Vec<f64> = (0..x.len()).map(|i| factor * at(i)).collect();
        let found = copied(&x, &y).unwrap();
        assert_eq!(found.later, later);
        assert!((found.factor / factor - 1.0).abs() < 1e-9, "{found:?}");
        let rounded: Vec<f64> = y.iter().map(|v| (v / factor * 1e4).round()).collect();
        assert_eq!(copied(&x, &rounded).unwrap().later, later);
        // What a sensor adds 50 dB below is no rounding.
        let noisy: Vec<f64> = y
            .iter()
            .map(|v| v + 0.003 * factor * noise.next())
            .collect();
        assert_eq!(copied(&x, &noisy), None);
    }
    assert_eq!(copied(&x, &noise.white(30_000)), None);
    let heard: Vec<f64> = (2..x.len())
        .map(|i| x[i] + 0.5 * x[i - 1] - 0.1 * x[i - 2])
        .collect();
    assert_eq!(copied(&x[2..], &heard), None);
}

/// A tone is alike at every period, and at every half with the other sign.
#[test]
fn a_copy_of_a_periodic_signal_has_its_shortest_delay_and_its_sign() {
    let tone =
        |period: f64| move |i: f64| (TAU * i / period).sin() + 0.3 * (TAU * 2.0 * i / period).cos();
    for (period, factor, later) in [
        (40.0, 1.0, 0),
        (40.0, -2.0, 0),
        (36.4, 0.5, 3),
        (36.4, -1.0, -2),
    ] {
        let wave = tone(period);
        let at = |i: usize, later: i32| wave(i as f64 - f64::from(later));
        let x: Vec<f64> = (0..30_000).map(|i| at(i, 0)).collect();
        let y: Vec<f64> = (0..30_000).map(|i| factor * at(i, later)).collect();
        let found = copied(&x, &y).unwrap();
        assert_eq!(found.later, i64::from(later), "{found:?}");
        assert!((found.factor - factor).abs() < 1e-6, "{found:?}");
    }
}
