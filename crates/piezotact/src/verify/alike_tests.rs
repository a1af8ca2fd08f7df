//! Signal pairs with a known true spectrum error: independent realisations, realisations with the target's own lines, and
//! a measurement that an output underrun delayed.

use num_complex::Complex;

use super::alike_tests::Kind::{Independent, SameLines};
use super::lines::{Lines, rms_error};
use super::verdict_tests::{Draws, RATE_HZ, band, recorded, series, usual};
use super::*;
use crate::criterion::Outcome;
use crate::fourier::RealTransform;
use crate::quantity::SampleRate;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Independent,
    SameLines,
}

const COUNT: usize = 50_000;
/// The ripple changes sign at multiples of this, Hz.
const RIPPLE_HZ: f64 = 40.0;

fn gain(hz: f64, ripple_db: f64) -> f64 {
    let sign = if ((hz / RIPPLE_HZ) as usize).is_multiple_of(2) {
        1.0
    } else {
        -1.0
    };
    10f64.powf(sign * ripple_db / 20.0)
}

/// Flat noise within the band, and the response of a device with a ripple to it or to another realisation.
fn pair(kind: Kind, ripple_db: f64, seed: u64) -> [Vec<f64>; 2] {
    let mut draws = Draws::new(seed);
    let mut transform = RealTransform::new(COUNT);
    let within = |k: usize| (25.0..=520.0).contains(&(k as f64 * RATE_HZ / COUNT as f64));
    let mut noise = |k: usize| {
        let drawn = Complex::new(draws.normal(), draws.normal());
        if within(k) {
            drawn * 40.0
        } else {
            Complex::default()
        }
    };
    let lines: Vec<Complex<f64>> = (0..=COUNT / 2).map(&mut noise).collect();
    let other = lines.iter().enumerate().map(|(k, line)| {
        let drawn = noise(k);
        let other = match kind {
            Independent => drawn,
            SameLines if within(k) => drawn / drawn.norm() * line.norm(),
            SameLines => drawn,
        };
        other * gain(k as f64 * RATE_HZ / COUNT as f64, ripple_db)
    });
    let other: Vec<Complex<f64>> = other.collect();
    [transform.inverse(lines), transform.inverse(other)]
}

/// The rms over the compared lines of the error caused by a ripple of `ripple_db`.
fn truth(ripple_db: f64) -> f64 {
    let welch = usual().welch;
    let step_hz = RATE_HZ / welch.segment as f64;
    let lines = (0..=welch.segment / 2).filter(|k| band().contains(*k as f64 * step_hz));
    rms_of(lines.map(|k| {
        let powers = (0..100).map(|i| {
            let hz = (k as f64 - 0.5 + (f64::from(i) + 0.5) / 100.0) * step_hz;
            gain(hz, ripple_db).powi(2)
        });
        10.0 * (powers.sum::<f64>() / 100.0).log10()
    }))
}

/// Same lines used to be taken for independent ones: 1.15 dB was found as 0.7 [0.4, 0.9], 0.5 dB as 0 [0, 0].
#[test]
fn the_interval_of_a_spectrum_error_covers_what_is_known() {
    const SEEDS: u64 = 10;
    for (kind, ripple_db, least) in [
        (Independent, 0.0, 9),
        (Independent, 1.15, 9),
        (SameLines, 0.5, 9),
        (SameLines, 1.15, 9),
    ] {
        let truth = truth(ripple_db);
        let (mut covered, mut met) = (0, 0);
        let mut found_all = Vec::new();
        for seed in 0..SEEDS {
            let [target, measured] = pair(kind, ripple_db, seed);
            let rate = SampleRate::new(RATE_HZ).unwrap();
            let pair = Pair::of(&target, &measured, &usual().welch, rate).unwrap();
            let lines = Lines::of(&pair, None, band());
            let (found, [low, high]) = rms_error(&lines.compared, |_| 1.0).unwrap();
            covered += usize::from((low - 0.01..=high + 0.01).contains(&truth));
            met += usize::from(high <= 1.0);
            found_all.push((found, low, high));
            assert!(high - low > 0.05, "{kind:?} {ripple_db}: [{low}, {high}]");
            assert!(high < 1.8, "{kind:?} {ripple_db}: [{low}, {high}]");
        }
        assert!(covered >= least, "{kind:?} {ripple_db}: {found_all:?}");
        if ripple_db > 1.0 {
            assert_eq!(met, 0, "{kind:?}: {found_all:?}");
        } else {
            assert!(met >= 9, "{kind:?} {ripple_db}: {found_all:?}");
        }
    }
}

#[test]
fn a_ripple_under_the_same_lines_does_not_pass() {
    let config = VerifyConfig {
        mode: Mode::Texture,
        ..usual()
    };
    let [target, measured] = pair(SameLines, 1.25, 1);
    let measured = recorded(&measured, 1);
    let v = verify(&series(target), Measured::alone(&measured), &config).unwrap();
    for what in [
        VerifyCriterion::SpectrumError,
        VerifyCriterion::PowerWeightedError,
    ] {
        let criterion = v.criterion(what).unwrap();
        assert_eq!(criterion.outcome, Outcome::NotMet, "{}", v.sentence());
        let [low, high] = criterion.interval.unwrap();
        assert!((low..=high).contains(&truth(1.25)), "[{low}, {high}]");
    }
}

/// An output that ran dry for 10.4 ms: what follows is late. The weighted errors used to be 0 [0, 0].
#[test]
fn what_an_underrun_leaves_of_the_spectrum_has_an_interval() {
    for seed in 0..4 {
        let [target, other] = pair(SameLines, 0.0, seed);
        let _ = other;
        let mut delivered = target[..18_000].to_vec();
        delivered.extend([0.0; 52]);
        delivered.extend(&target[18_000..]);
        let measured = recorded(&delivered, seed);
        let v = verify(&series(target), Measured::alone(&measured), &usual()).unwrap();
        // By the mean of short segments, to which the delay is nothing.
        let by_segments = v.error_db_rms;
        for what in [
            VerifyCriterion::SpectrumError,
            VerifyCriterion::PowerWeightedError,
        ] {
            let [low, high] = v.criterion(what).and_then(|c| c.interval).unwrap();
            assert!(
                low <= by_segments && by_segments <= high && high < 0.6,
                "{what}: {by_segments} [{low}, {high}]"
            );
        }
    }
}
