//! Filters, power, splines, regression and contrasts against the values of `golden/eeg.py` (MNE-Python 1.13.2, SciPy 1.17.1).

use std::f64::consts::TAU;

use piezotact::quantity::{Band, Hertz, SampleRate};
use piezotact_people::eeg::contrast;
use piezotact_people::eeg::epochs::Epochs;
use piezotact_people::eeg::erd::interval_over_epochs;
use piezotact_people::eeg::filter::{Fir, Pass};
use piezotact_people::eeg::reference::{Interpolation, Montage};
use piezotact_people::eeg::regression::EogRegression;
use piezotact_people::eeg::tfr::{TfrConfig, TfrPlan, Window};
use serde_json::Value;

use super::{assert_near, assert_relative, epochs, names};

/// Sums and transforms in another order: MNE and SciPy round in the last digits, and results are sums of up to 4000 terms.
const ROUNDING: f64 = 1e-12;
/// Inverses of a spline's matrix, whose condition is about 1e4 with the regularisation.
const SPLINE: f64 = 1e-9;
/// Wavelet power, relative, as for the other references of MNE.
const POWER: f64 = 1e-9;

fn golden() -> Value {
    serde_json::from_str(include_str!("../golden/eeg.json")).unwrap()
}

fn list(value: &Value) -> Vec<f64> {
    match value {
        Value::Array(values) => values.iter().flat_map(list).collect(),
        value => vec![value.as_f64().unwrap()],
    }
}

/// The noise of `golden/eeg.py`.
fn noise(n: usize, seed: u64) -> impl Iterator<Item = f64> {
    let mut state = seed;
    (0..n).map(move |_| {
        state = (1_664_525 * state + 1_013_904_223) % (1 << 32);
        state as f64 / 2f64.powi(31) - 1.0
    })
}

/// The signal of `golden/eeg.py`.
fn signal(n: usize, seed: u64) -> Vec<f64> {
    let of = |(i, noise): (usize, f64)| {
        let t = i as f64 / 500.0;
        let alpha = (TAU * 10.0 * t + seed as f64).sin();
        1e-6 * (8.0 * alpha + 3.0 * (TAU * 50.0 * t).sin() + 5.0 * noise + 20.0 * t)
    };
    noise(n, seed).enumerate().map(of).collect()
}

fn rate() -> SampleRate {
    SampleRate::new(500.0).unwrap()
}

fn every(step: usize, values: &[f64]) -> Vec<f64> {
    values.iter().copied().step_by(step).collect()
}

#[test]
fn filters_are_those_of_mne() {
    let golden = &golden()["filters"];
    let x = signal(4000, 1);
    for row in golden["rows"].as_array().unwrap() {
        let pass = match (row["low"].as_f64(), row["high"].as_f64()) {
            (Some(low), Some(high)) => Pass::Between(low, high),
            (Some(low), None) => Pass::Above(low),
            (None, Some(high)) => Pass::Below(high),
            (None, None) => panic!("a filter without an edge"),
        };
        let fir = Fir::plan(&pass, rate()).unwrap();
        assert_eq!(
            fir.taps().len() as u64,
            row["length"].as_u64().unwrap(),
            "{pass:?}"
        );
        let half = &fir.taps()[..fir.taps().len() / 2 + 1];
        assert_near(
            &format!("taps of {pass:?}"),
            &every(37, half),
            &list(&row["taps"]),
            ROUNDING,
        );
        let filtered = every(100, &fir.apply(&x));
        assert_near(&format!("{pass:?}"), &filtered, &list(&row["y"]), ROUNDING);
    }
    let notch = Fir::plan(&Pass::AllBut(vec![50.0, 100.0]), rate()).unwrap();
    assert_near(
        "notch",
        &every(100, &notch.apply(&x)),
        &list(&golden["notch"]),
        ROUNDING,
    );
    // Shorter than the filter: continued by what there is, and zeros.
    let fir = Fir::plan(&Pass::Between(1.0, 40.0), rate()).unwrap();
    assert_near(
        "short",
        &every(10, &fir.apply(&x[..400])),
        &list(&golden["short"]),
        ROUNDING,
    );
    assert_eq!(fir.warnings(400).len(), 1);
}

/// Three epochs of two channels.
fn given() -> Epochs {
    let volts = (0..2).flat_map(|c| (0..3).flat_map(move |e| signal(1000, 10 * c + e)));
    epochs(&names(&["C3", "C4"]), 3, 500.0, 0.0, volts.collect())
}

fn plan(decimation: usize) -> TfrPlan {
    let config = TfrConfig {
        frequencies_hz: vec![8.0, 10.0, 12.5, 20.0],
        cycles: vec![4.0, 5.0, 5.0, 7.0],
        decimation,
    };
    TfrPlan::plan(&config, rate(), 1000).unwrap()
}

#[test]
fn power_is_that_of_mne() {
    let golden = &golden()["power"];
    let epochs = given();
    let morlet = plan(40);
    let found = morlet.average(&epochs).unwrap();
    assert_relative("Morlet", &found.values, &list(&golden["morlet"]), POWER);
}

#[test]
fn power_of_single_epochs_is_that_of_mne() {
    let window = Window {
        band: Band::new(Hertz(8.0), Hertz(12.5)).unwrap(),
        extent_s: [0.2, 0.6],
    };
    let found = plan(1).trials(&given(), &[window]).unwrap();
    let expected = list(&golden()["power"]["window"]);
    assert_relative("single epochs", &found.values, &expected, POWER);
}

#[test]
fn maps_are_those_of_mne() {
    let golden = &golden()["splines"];
    let all = names(&Montage::names());
    let volts: Vec<f64> = (0..64).flat_map(|c| signal(50, 100 + c)).collect();
    let given = epochs(&all, 1, 500.0, 0.0, volts);
    let montage = Montage::ten_ten(&all).unwrap();
    let whole = list(&golden["where"]);
    let positions: Vec<[f64; 3]> = whole.chunks(3).map(|p| [p[0], p[1], p[2]]).collect();
    let map = Interpolation::plan(&montage, &positions).unwrap();
    let mut found = vec![0.0; 20];
    for (column, sample) in (0..50).step_by(10).enumerate() {
        let values: Vec<f64> = (0..64).map(|c| given.signal(c, 0)[sample]).collect();
        for (row, value) in map.apply(&values).unwrap().into_iter().enumerate() {
            found[row * 5 + column] = value;
        }
    }
    assert_near(
        "interpolation",
        &found,
        &list(&golden["interpolated"]),
        SPLINE,
    );
}

#[test]
fn regression_is_that_of_mne() {
    let golden = &golden()["regression"];
    let of = |c: u64, e: u64| signal(400, 30 + 10 * c + e);
    let mut volts = Vec::new();
    for c in 0..4 {
        for e in 0..3 {
            let mut one = of(c, e);
            if c == 0 {
                let eyes = of(2, e).into_iter().zip(of(3, e));
                for (value, (vertical, horizontal)) in one.iter_mut().zip(eyes) {
                    *value += 0.4 * vertical - 0.1 * horizontal;
                }
            }
            volts.extend(one);
        }
    }
    let given = epochs(&names(&["Fz", "Cz", "VEOG", "HEOG"]), 3, 500.0, 0.0, volts);
    let fit = EogRegression::fit(&given, &["VEOG", "HEOG"], &["Fz", "Cz"]).unwrap();
    assert_near(
        "coefficients",
        fit.coefficients(),
        &list(&golden["coefficients"]),
        1e-10,
    );
    let clean = fit.apply(&given).unwrap();
    let found: Vec<f64> = (0..2)
        .flat_map(|c| (0..3).map(move |e| (c, e)))
        .flat_map(|(c, e)| every(40, clean.signal(c, e)))
        .collect();
    assert_near("without eyes", &found, &list(&golden["clean"]), 1e-10);
}

#[test]
fn contrasts_are_those_of_scipy() {
    let golden = &golden()["contrast"];
    let found = contrast::paired(&list(&golden["a"]), &list(&golden["b"])).unwrap();
    let values = [
        found.difference.t,
        found.d_z,
        found.d_z_interval[0],
        found.d_z_interval[1],
    ];
    let mut expected = vec![
        golden["t"].as_f64().unwrap(),
        golden["d_z"].as_f64().unwrap(),
    ];
    expected.extend(list(&golden["interval"]));
    // The integral over the variance has 600 steps.
    assert_relative("contrast", &values, &expected, 1e-7);
}

/// Sums in another order.
#[test]
fn the_interval_of_a_change_is_that_of_numpy_and_scipy() {
    let golden = &golden()["interval"];
    let shares = |name: &str| -> Vec<f64> {
        let percent = list(&golden[name]).into_iter();
        percent.map(|percent| percent / 100.0).collect()
    };
    let found = interval_over_epochs(shares("percent")[0], &shares("without_each"));
    assert_relative("interval", &found.unwrap(), &shares("ends"), 1e-9);
}
