//! The lines of height maps: their roughness, their spectrum against SciPy (`golden/lines.py`), and spectra that follow no law.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use std::f64::consts::TAU;

use crate::support::noise;
use piezotact::surface::HeightMap;
use piezotact_surface::{
    Cutoff, Form, LineDirection, LineRoughness, ProfileFilter, ProfileStandard, RoughnessError,
    RoughnessOptions, ShortWaves, line_roughness,
};

const STEP_M: f64 = 2e-6;
const COLUMNS: usize = 512;

const USUAL: RoughnessOptions = RoughnessOptions {
    standard: ProfileStandard::Iso4287,
    form: None,
    filter: None,
    cutoff: None,
    short_waves: None,
};
const UNFILTERED: RoughnessOptions = RoughnessOptions {
    form: Some(Form::Level),
    filter: Some(ProfileFilter::None),
    ..USUAL
};

/// Rows of waves of the powers `power`, each with a phase of its own, as in `golden/lines.py`.
fn rough_map(rows: usize, seed: u64, power: impl Fn(f64) -> f64) -> HeightMap {
    let mut state = seed;
    let mut heights = Vec::new();
    for _ in 0..rows {
        let mut row = vec![0.0; COLUMNS];
        for k in 1..=COLUMNS / 2 {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            let phase = (state >> 11) as f64 / (1u64 << 53) as f64 * TAU;
            let height_m = 1e-6 * power(k as f64).sqrt();
            for (x, z) in row.iter_mut().enumerate() {
                *z += height_m * ((x * k % COLUMNS) as f64 / COLUMNS as f64 * TAU + phase).cos();
            }
        }
        heights.extend(row);
    }
    HeightMap::new(heights, COLUMNS, STEP_M, 50.0 * STEP_M).unwrap()
}

#[track_caller]
fn check(what: &str, found: f64, expected: f64, share: f64) {
    assert!(
        (found / expected - 1.0).abs() <= share,
        "{what}: {found:e} for {expected:e}"
    );
}

fn value(lines: &LineRoughness, symbol: &str) -> (f64, f64) {
    let mut parameters = lines.parameters.iter();
    let found = parameters.find(|p| p.mean.symbol == symbol).unwrap();
    (found.mean.value.unwrap(), found.deviation.unwrap())
}

/// The map with rows for columns.
fn turned(map: &HeightMap) -> HeightMap {
    let (z, columns) = (map.heights_m(), map.columns());
    let heights = (0..z.len()).map(|i| z[i % map.rows() * columns + i / map.rows()]);
    HeightMap::new(heights.collect(), map.rows(), 50.0 * STEP_M, STEP_M).unwrap()
}

#[test]
fn spectrum_and_parameters_are_those_of_scipy() {
    let map = rough_map(24, 7, |k| k.powf(-2.4));
    for (map, along) in [
        (map.clone(), LineDirection::X),
        (turned(&map), LineDirection::Y),
    ] {
        let lines = line_roughness(&map, along, &UNFILTERED).unwrap();
        assert_eq!((lines.lines, lines.incomplete), (24, 0));
        for (frequency, power) in [
            (9.765625000e2, 3.008333754e-16),
            (9.732963803e3, 2.652678041e-18),
            (3.118881510e4, 1.355554902e-19),
            (9.841949816e4, 7.897574529e-21),
            (2.337127472e5, 1.062661791e-21),
        ] {
            let near = |a: &&(f64, f64)| (a.0 / frequency - 1.0).abs() < 1e-8;
            let found = lines.spectrum.iter().find(near).unwrap();
            check("power", found.1, power, 1e-7);
        }
        let (ra_um, spread_um) = value(&lines, "Ra");
        check("Ra", ra_um, 6.228547585e-1, 1e-8);
        check("deviation", spread_um, 1.018042295e-1, 1e-8);
        check("Rq", value(&lines, "Rq").0, 7.454688463e-1, 1e-8);
        check("Rz", value(&lines, "Rz").0, 2.988598364, 1e-8);
    }
}

#[test]
fn a_power_law_is_found_where_there_is_one() {
    for (hurst, seed) in [(0.3, 1), (0.7, 2), (0.9, 3)] {
        let map = rough_map(40, seed, |k| k.powf(-1.0 - 2.0 * hurst));
        let law = line_roughness(&map, LineDirection::X, &USUAL)
            .unwrap()
            .law
            .unwrap();
        assert!(
            (law.hurst.unwrap() - hurst).abs() < 0.03,
            "{hurst}: {law:?}"
        );
        let [shortest_m, longest_m] = law.wavelengths_m;
        check("shortest", shortest_m, 4.0 * STEP_M, 0.2);
        check("longest", longest_m, 512e-6, 0.2);
    }
    // Below a plateau from 102 µm (the tenth wave) on.
    let map = rough_map(40, 4, |k| 1.0 / (1.0 + (k / 10.0).powi(4)).powf(0.6));
    let law = line_roughness(&map, LineDirection::X, &USUAL)
        .unwrap()
        .law
        .unwrap();
    assert!((law.hurst.unwrap() - 0.7).abs() < 0.1, "{law:?}");
    assert!(law.wavelengths_m[1] < 140e-6, "{law:?}");
    // White noise has a slope, and no Hurst exponent.
    let white = noise(5).take(40 * COLUMNS).map(|w| 1e-7 * w).collect();
    let white = HeightMap::new(white, COLUMNS, STEP_M, 50.0 * STEP_M).unwrap();
    let law = line_roughness(&white, LineDirection::X, &USUAL)
        .unwrap()
        .law
        .unwrap();
    assert!(law.slope.abs() < 0.1 && law.hurst.is_none(), "{law:?}");
}

#[test]
fn spectra_that_follow_no_law_have_no_slope() {
    // Curved all along, with a period, and with a bend in the middle.
    let curved = |k: f64| (-(k.ln() - 2.0).powi(2)).exp();
    let periodic = |k: f64| k.powf(-2.0) * if (k - 30.0).abs() < 0.5 { 300.0 } else { 1.0 };
    let bent = |k: f64| {
        if k < 22.0 {
            k.powf(-1.2)
        } else {
            22f64.powf(1.8) * k.powi(-3)
        }
    };
    let law_of = |power: &dyn Fn(f64) -> f64| {
        line_roughness(&rough_map(40, 6, power), LineDirection::X, &USUAL)
            .unwrap()
            .law
    };
    assert!(law_of(&curved).is_none(), "{:?}", law_of(&curved));
    // The period of 34 µm is in no range.
    let law = law_of(&periodic);
    let holds = |[low, high]: [f64; 2]| low < 34e-6 && high > 34e-6;
    assert!(law.is_none_or(|law| !holds(law.wavelengths_m)), "{law:?}");
    let law = law_of(&bent);
    assert!(
        law.is_none_or(|law| law.slope < -2.7 || law.slope > -1.4),
        "{law:?}"
    );
    // A flat map has no spectrum at all.
    let flat = HeightMap::new(vec![1e-6; 40 * COLUMNS], COLUMNS, STEP_M, STEP_M).unwrap();
    assert!(
        line_roughness(&flat, LineDirection::X, &USUAL)
            .unwrap()
            .law
            .is_none()
    );
}

#[test]
fn lines_have_one_cut_off_and_are_complete() {
    let map = rough_map(40, 8, |k| {
        if (10.0..=100.0).contains(&k) {
            0.01
        } else {
            0.0
        }
    });
    let lines = line_roughness(&map, LineDirection::X, &USUAL).unwrap();
    // Ra is 0.5 µm: the cut-off of 0.8 mm holds once in 1.02 mm.
    assert_eq!(lines.example.cutoff_m, Some(0.8e-3));
    assert_eq!(lines.example.config.cutoff, Cutoff::Iso4288);
    assert_eq!(lines.warnings.len(), 1, "{:?}", lines.warnings);
    let stated = RoughnessOptions {
        cutoff: Some(Cutoff::Stated(0.16e-3)),
        short_waves: Some(ShortWaves::Kept),
        ..USUAL
    };
    let before = line_roughness(&map, LineDirection::X, &stated).unwrap();
    assert!(before.warnings.is_empty());
    // Three rows with a gap are left out; along y no line is whole.
    let mut gaps = map.heights_m().to_vec();
    for column in 0..COLUMNS {
        gaps[(column % 3) * COLUMNS + column] = f64::NAN;
    }
    let holed = map.with_heights(gaps);
    let found = line_roughness(&holed, LineDirection::X, &stated).unwrap();
    assert_eq!((found.lines, found.incomplete), (37, 3));
    check("Ra", value(&found, "Ra").0, value(&before, "Ra").0, 0.05);
    let none = line_roughness(&holed, LineDirection::Y, &stated).unwrap_err();
    assert!(
        matches!(none, RoughnessError::NoLine { points: 40, .. }),
        "{none}"
    );
}
