//! The gesture filter, the features of a stroke and the statistics of comparisons against SciPy; made by
//! `golden/touch.py`.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use piezotact::feature::{FeatureConfig, analyse, stroke_forces};
use piezotact::filter::{HighPass, ZeroPhase};
use piezotact::panel::share_interval;
use piezotact::quantity::{Hertz, SampleRate, Unit};
use piezotact::recording::{Channel, Condition, Provenance, Recording};
use piezotact::roles::Roles;
use piezotact::statistics::{log_fit, mean, paired_difference, rank_correlation, spearman};
use piezotact::stroke::{CutBy, Interval, Rule, Segmentation, Signals, Stroke};
use serde::Deserialize;

#[derive(Deserialize)]
struct Golden {
    high_passed: BTreeMap<String, Vec<f64>>,
    rms: f64,
    peak: f64,
    kurtosis: f64,
    level_spread_db: f64,
    centroid_hz: f64,
    spread_hz: f64,
    receptor_power: [f64; 4],
    receptor_level_db: [f64; 2],
    friction: [f64; 3],
    force: [f64; 2],
    fft_55_hz: f64,
    psd_every_40: Vec<f64>,
    a: Vec<f64>,
    b: Vec<f64>,
    spearman: f64,
    paired: [f64; 5],
    spearman_p: f64,
    long_a: Vec<f64>,
    long_b: Vec<f64>,
    long_spearman: [f64; 2],
    slope_p: f64,
    share_intervals: Vec<[f64; 4]>,
    slope: f64,
    slope_interval: [f64; 2],
    intercept: f64,
    r_squared: f64,
}

fn golden() -> Golden {
    serde_json::from_str(include_str!("golden/touch.json")).unwrap()
}

const RATE_HZ: f64 = 5000.0;
const N: u64 = 6000;

fn over_time(value: impl Fn(u64, f64) -> f64) -> Vec<f64> {
    (0..N).map(|i| value(i, i as f64 / RATE_HZ)).collect()
}

fn vibration() -> Vec<f64> {
    over_time(|i, t| {
        (TAU * 55.0 * t).sin()
            + 0.5 * (TAU * 180.0 * t + 1.0).sin()
            + 0.3 * ((i * i * 7919 % 1000) as f64 / 1000.0 - 0.5)
            + 2.0 * (TAU * 1.2 * t).sin()
            + 0.7
    })
}

#[track_caller]
fn check(what: &str, found: f64, expected: f64, tolerance: f64) {
    let off = (found - expected).abs() / expected.abs().max(1e-12);
    assert!(
        off <= tolerance,
        "{what}: {found} for {expected}, off by {off:e}"
    );
}

/// sosfiltfilt of a Butterworth of the same order, to rounding: poles close to 1 lose some digits.
#[test]
fn the_gesture_filter_is_scipys() {
    let x = vibration();
    let rate = SampleRate::new(RATE_HZ).unwrap();
    for (setting, expected) in golden().high_passed {
        let (order, cutoff) = setting.split_once(' ').unwrap();
        let high_pass = HighPass {
            order: order.parse().unwrap(),
            cutoff_hz: Hertz(cutoff.parse().unwrap()),
        };
        let y = ZeroPhase::high_pass(high_pass, rate).unwrap().apply(&x);
        assert_eq!(y.len(), x.len());
        for (found, expected) in y.iter().step_by(250).zip(expected) {
            assert!(
                (found - expected).abs() < 1e-9,
                "{setting}: {found} for {expected}"
            );
        }
    }
}

#[test]
fn features_are_those_of_scipy() {
    let golden = golden();
    let channel = |name: &str, unit, samples| Channel {
        name: name.into(),
        unit,
        samples,
    };
    let fz = over_time(|_, t| 0.2 + 0.02 * (TAU * 0.9 * t).sin());
    let fx = over_time(|_, t| 0.03 * (TAU * 2.1 * t).cos());
    let fy = over_time(|_, t| 0.12 + 0.01 * (TAU * 3.3 * t).sin());
    let rate = SampleRate::new(RATE_HZ).unwrap();
    let recording = Recording::new(
        vec![
            channel("acc", Unit::MetrePerSecondSquared, vibration()),
            channel("fx", Unit::Newton, fx),
            channel("fy", Unit::Newton, fy),
            channel("fz", Unit::Newton, fz),
        ],
        rate,
        Condition::default(),
        Provenance::default(),
    )
    .unwrap();
    let all = Interval {
        start: 0,
        end: N as usize,
    };
    let segmentation = Segmentation {
        strokes: vec![Stroke {
            steady: all,
            contact: all,
            cut_by: CutBy::Person,
            criteria: Vec::new(),
        }],
        rejected: Vec::new(),
        rule: Rule::Whole,
        roles: Roles::guess(&recording).0,
        force_zeros: None,
        cuts: None,
        untouched: None,
        warnings: Vec::new(),
    };
    let config = FeatureConfig::usual(rate, &[all.len()], Some(HighPass::gesture())).unwrap();
    let analysis = analyse(&recording, &segmentation, &config).unwrap();
    let stroke = &analysis.strokes[0];
    // The filter leaves 1e-10 of the signal; everything else is the same arithmetic.
    check("rms", stroke.rms, golden.rms, 1e-9);
    check("peak", stroke.peak, golden.peak, 1e-9);
    check(
        "crest factor",
        stroke.crest_factor,
        golden.peak / golden.rms,
        1e-9,
    );
    check("kurtosis", stroke.kurtosis, golden.kurtosis, 1e-9);
    let spread_db = stroke.level_spread_db.unwrap();
    check("spread of levels", spread_db, golden.level_spread_db, 1e-7);
    check("centroid", stroke.centroid_hz, golden.centroid_hz, 1e-9);
    check("spread", stroke.spread_hz, golden.spread_hz, 1e-9);
    for (found, expected) in stroke
        .receptor_power
        .iter()
        .flatten()
        .zip(golden.receptor_power)
    {
        check("receptor power", *found, expected, 1e-8);
    }
    let levels = [stroke.meissner_level_db, stroke.pacini_level_db];
    for (found, expected) in levels.into_iter().zip(golden.receptor_level_db) {
        check("level re threshold", found.unwrap(), expected, 1e-8);
    }
    let friction = stroke.friction_coefficient.unwrap();
    check("friction, mean", friction.mean, golden.friction[0], 1e-12);
    check("friction, sd", friction.sd, golden.friction[1], 1e-10);
    check(
        "friction, median",
        friction.median,
        golden.friction[2],
        1e-12,
    );
    let force = stroke.normal_force_n.unwrap();
    check("force, mean", force.mean, golden.force[0], 1e-12);
    check("force, sd", force.sd, golden.force[1], 1e-10);
    // What is drawn of the stroke is what the features are of.
    let signals = Signals::of(&recording, &segmentation.roles).unwrap();
    let drawn = stroke_forces(&signals, &segmentation, all).unwrap();
    let means = [&drawn.friction_coefficient, &drawn.normal_n].map(|samples| mean(samples));
    check("friction drawn, mean", means[0], golden.friction[0], 1e-12);
    check("force drawn, mean", means[1], golden.force[0], 1e-12);
    for (i, tangential_n) in drawn.tangential_n.iter().enumerate() {
        let [x, y] = [0, 1].map(|axis| signals.tangential_force_n[axis][i]);
        let expected = x.hypot(y);
        check("tangential force drawn", *tangential_n, expected, 1e-12);
    }
    let line = (55.0 * N as f64 / RATE_HZ).round() as usize;
    check("FFT", analysis.fft.mean[line], golden.fft_55_hz, 1e-9);
    for (found, expected) in analysis
        .psd
        .mean
        .iter()
        .step_by(40)
        .zip(golden.psd_every_40)
    {
        check("PSD", *found, expected, 1e-8);
    }
    let strongest = &stroke.peaks[0];
    assert!(
        (strongest.frequency_hz - 55.0).abs() < 2.0,
        "{:?}",
        stroke.peaks
    );
    assert!(stroke.pacinian_power.unwrap() > 1.0);
}

#[test]
fn statistics_are_those_of_scipy() {
    let golden = golden();
    check(
        "Spearman",
        spearman(&golden.a, &golden.b).unwrap(),
        golden.spearman,
        1e-12,
    );
    // Every one of 40320 orders, with ties.
    let ranked = rank_correlation(&golden.a, &golden.b).unwrap();
    check("Spearman's p", ranked.p_value, golden.spearman_p, 1e-12);
    let long = rank_correlation(&golden.long_a, &golden.long_b).unwrap();
    check("Spearman of 12", long.rho, golden.long_spearman[0], 1e-12);
    check("its p", long.p_value, golden.long_spearman[1], 1e-9);
    for [k, n, low, high] in golden.share_intervals {
        let found = share_interval(k as usize, n as usize);
        // Quantiles of the beta distribution are iterated.
        assert!(
            (found[0] - low).abs() < 1e-6 && (found[1] - high).abs() < 1e-6,
            "{k} of {n}: {found:?}"
        );
    }
    let fit = log_fit(&golden.a, &golden.b).unwrap();
    check("slope's p", fit.p_value.unwrap(), golden.slope_p, 1e-9);
    check("slope", fit.slope, golden.slope, 1e-12);
    check("intercept", fit.intercept, golden.intercept, 1e-11);
    check("R²", fit.r_squared, golden.r_squared, 1e-12);
    let paired = paired_difference(&golden.a, &golden.b).unwrap();
    let [mean, from, to, t, p_value] = golden.paired;
    check("paired mean", paired.mean, mean, 1e-12);
    check("paired t", paired.t, t, 1e-12);
    check("paired from", paired.interval[0], from, 1e-7);
    check("paired to", paired.interval[1], to, 1e-7);
    check("paired p", paired.p_value, p_value, 1e-9);
    let [low, high] = fit.slope_interval.unwrap();
    // The quantile of Student's t is iterated to 1e-9.
    check("lower end", low, golden.slope_interval[0], 1e-7);
    check("upper end", high, golden.slope_interval[1], 1e-7);
}
