//! Impact tests as a laboratory records them: with a hand that trembles, a force that drifts or is high-passed, converters at
//! their limits, a loose cable, hits at another point, and channels that are exchanged.
#![allow(
    clippy::print_stdout,
    clippy::unwrap_used,
    reason = "a test stops where something is missing, and prints what it measured"
)]

use piezotact::warning::{Scatter, ScatterWarning};
use std::f64::consts::TAU;

use piezotact::quantity::{Acceleration, Force, Unit};
use piezotact::recording::{Channel, Condition, Provenance, Recording};
use piezotact::spectrum::WelchConfig;
use piezotact::transfer::{
    BetweenConfig, Estimator, Excitation, ExponentialWindow, HitFault, ImpactConfig, ImpactSegment,
    ImpactWarning, NotDecayed, Swapped, TransferFunction, TransferWarning, between_channels,
    estimate, transient,
};

use crate::structure::{Golden, Noise, NoiseLevels, Pulse, Recorded, db, golden};

/// The structure at 8192 Hz, where a pulse of 2 ms drives it up to 500 Hz.
fn slow() -> Golden {
    Golden {
        rate_hz: 8192.0,
        ..golden()
    }
}

const PULSE_S: f64 = 0.002;

/// Hits 1.3 s apart with peaks that differ, as those of a hand do.
fn hits(count: usize) -> Vec<Pulse> {
    (0..count)
        .map(|i| {
            let peak = 20.0 + 3.0 * (2.4 * i as f64).sin();
            (0.9 + 1.3 * i as f64 + 0.000_037 * i as f64, PULSE_S, peak)
        })
        .collect()
}

const LEVELS: NoiseLevels = NoiseLevels {
    force_n: 0.005,
    response_m_per_s2: 0.02,
};

fn recorded(count: usize) -> Recorded {
    let seconds = 0.9 + 1.3 * count as f64;
    Recorded::of(&slow(), &hits(count), seconds).noisy(LEVELS, &mut Noise(17))
}

fn evaluated(recorded: &Recorded) -> TransferFunction<Force, Acceleration> {
    recorded.evaluated(&ImpactConfig::usual()).unwrap().function
}

fn said(function: &TransferFunction<Force, Acceleration>) -> Vec<ImpactWarning> {
    let warnings = function.about.warnings.iter();
    warnings.filter_map(piezotact::Warning::kind).collect()
}

fn faults(function: &TransferFunction<Force, Acceleration>) -> Vec<Vec<HitFault>> {
    let hits = &function.impact.as_ref().unwrap().hits;
    hits.iter().map(|hit| hit.faults.clone()).collect()
}

/// The largest difference between two functions from 30 to 400 Hz, dB.
fn apart_db(
    a: &TransferFunction<Force, Acceleration>,
    b: &TransferFunction<Force, Acceleration>,
) -> f64 {
    (30..400)
        .map(f64::from)
        .map(|hz| db(a.at(hz), b.at(hz)).abs())
        .fold(0.0, f64::max)
}

/// A tremor at 9 Hz of 0.4 m/s², with an amplitude that wanders, and a finger that settles: every hit is used, and nothing is
/// said to remain.
#[test]
fn a_tremor_is_no_remainder_of_a_hit() {
    let steady = evaluated(&recorded(6));
    for settling in [0.0, 0.2] {
        let mut trembling = recorded(6);
        let rate_hz = trembling.rate_hz;
        for (i, a) in trembling.response.iter_mut().enumerate() {
            let t = i as f64 / rate_hz;
            let amplitude = 0.4 * (1.0 + 0.5 * (TAU * 0.31 * t).sin());
            *a += amplitude * (TAU * 9.0 * t + (TAU * 0.17 * t).sin()).sin();
            *a += settling * (-t / 3.0).exp();
        }
        let found = evaluated(&trembling);
        assert!(
            faults(&found).iter().all(Vec::is_empty),
            "{:?}",
            faults(&found)
        );
        let left = found.impact.as_ref().unwrap().left.unwrap();
        println!("left {left}, {:.3} dB apart", apart_db(&steady, &found));
        assert!(left < 0.01, "{left}");
        assert!(
            !said(&found).iter().any(|d| matches!(
                d,
                ImpactWarning::NotDecayed {
                    how: NotDecayed::End { .. }
                }
            )),
            "{:?}",
            said(&found)
        );
        assert!(apart_db(&steady, &found) < 0.5);
    }
}

/// What does remain is found below a tremor too: a resonance that lasts for seconds.
#[test]
fn a_resonance_that_lasts_is_found_beside_strong_ones() {
    let mut ringing = slow();
    // A hundredth of the others in acceleration; it needs 6 s to fall by 40 dB in place of 0.3 s.
    ringing.modes[0] = (45.0, 0.003, 0.03);
    let recorded = Recorded::of(&ringing, &hits(6), 8.7).noisy(LEVELS, &mut Noise(18));
    let found = evaluated(&recorded);
    assert!(
        faults(&found).iter().all(Vec::is_empty),
        "{:?}",
        faults(&found)
    );
    println!("{:?}", said(&found));
    let octave = said(&found).into_iter().find_map(|d| match d {
        ImpactWarning::NotDecayed {
            how: NotDecayed::End {
                left, octave_hz, ..
            },
        } if left > 0.1 => octave_hz,
        _ => None,
    });
    let [low, high] = octave.unwrap();
    println!("{low} to {high} Hz");
    assert!(low < 45.0 && 45.0 < high);
}

/// A charge amplifier drifts by 0.1 N/s: the hits are found as before, and the function is the same.
#[test]
fn a_force_that_drifts_holds_its_hits() {
    let steady = recorded(12);
    let mut drifting = steady.clone();
    let rate_hz = drifting.rate_hz;
    for (i, f) in drifting.force.iter_mut().enumerate() {
        *f += 0.1 * i as f64 / rate_hz;
    }
    assert_eq!(
        transient(&drifting.force, drifting.rate()).map(|t| t.hits),
        Some(12)
    );
    let (a, b) = (evaluated(&steady), evaluated(&drifting));
    assert!(faults(&b).iter().all(Vec::is_empty));
    println!("{:.4} dB apart", apart_db(&a, &b));
    assert!(apart_db(&a, &b) < 0.02);
    assert!(said(&b).iter().any(
        |d| matches!(d, ImpactWarning::BaselineDrifts { signal, share } if signal == "force" && (0.02..0.06).contains(share))
    ));
    assert!(
        !said(&a).iter().any(
            |d| matches!(d, ImpactWarning::BaselineDrifts { signal, .. } if signal == "force")
        )
    );
    // A slow motion that dwarfs its clicks is no drift.
    let slow: Vec<f64> = (0..steady.force.len())
        .map(|i| 60.0 * (TAU * 0.05 * i as f64 / rate_hz).sin() + steady.force[i])
        .collect();
    assert!(transient(&slow, steady.rate()).is_none());
}

/// A high-pass of the force at 6.5 Hz drains each pulse: no double hit, and the band that is excited ends where it did.
#[test]
fn a_force_that_drains_drives_the_same_band() {
    let whole = recorded(6);
    let mut drained = whole.clone();
    let keeps = (-TAU * 6.5 / drained.rate_hz).exp();
    let (mut last, mut out) = (0.0, 0.0);
    for f in &mut drained.force {
        out = keeps * (out + *f - last);
        last = *f;
        *f = out;
    }
    let (a, b) = (evaluated(&whole), evaluated(&drained));
    assert!(faults(&b).iter().all(Vec::is_empty), "{:?}", faults(&b));
    let (a, b) = (a.excited.unwrap(), b.excited.unwrap());
    println!("{a}, {b}");
    assert!((b.high().0 / a.high().0 - 1.0).abs() < 0.05 && b.low().0 < 15.0);
}

/// Two samples of a pulse at the limit of the converter are no peak of a hand, since other hits share them.
#[test]
fn a_limit_that_hits_share_is_an_overload() {
    let golden = Golden {
        rate_hz: 4096.0,
        ..golden()
    };
    let short: Vec<Pulse> = hits(7).iter().map(|h| (h.0, 0.001, h.2)).collect();
    let whole = Recorded::of(&golden, &short, 10.0).noisy(LEVELS, &mut Noise(19));
    let fine = evaluated(&whole);
    assert!(
        faults(&fine).iter().all(Vec::is_empty),
        "{:?}",
        faults(&fine)
    );
    let mut clipped = whole.clone();
    clipped.force.iter_mut().for_each(|f| *f = f.min(13.0));
    let error = clipped.evaluated(&ImpactConfig::usual()).unwrap_err();
    assert!(error.to_string().contains("force overloaded"), "{error}");
    // The response: two samples of it.
    let mut largest: Vec<f64> = whole.response.clone();
    largest.sort_by(|a, b| b.total_cmp(a));
    let limit = largest[8];
    let mut limited = whole.clone();
    limited.response.iter_mut().for_each(|a| *a = a.min(limit));
    let found = evaluated(&limited);
    let overloaded = faults(&found);
    println!("{overloaded:?}");
    let count = overloaded
        .iter()
        .filter(|f| matches!(f[..], [HitFault::ResponseOverload { .. }]))
        .count();
    assert!(
        count >= 2 && overloaded.iter().any(Vec::is_empty),
        "{overloaded:?}"
    );
    // Equal hits of a simulation without noise share their peaks and are none.
    let equal: Vec<Pulse> = (0..4)
        .map(|i| (0.5 + 2.0 * f64::from(i), 0.001, 20.0))
        .collect();
    let found = evaluated(&Recorded::of(&golden, &equal, 8.5));
    assert!(
        faults(&found).iter().all(Vec::is_empty),
        "{:?}",
        faults(&found)
    );
}

/// An amplifier that saturates before the converter's noise: pulses with a flat top of five samples of nine, and responses that end
/// at one level although the hits differ.
#[test]
fn saturation_under_noise_is_an_overload() {
    let golden = Golden {
        rate_hz: 10_000.0,
        ..golden()
    };
    let pulses: Vec<Pulse> = (0..7)
        .map(|i| {
            let i = f64::from(i);
            (
                0.9 + 1.3 * i + 0.000_037 * i,
                0.001,
                20.0 + 3.0 * (2.4 * i).sin(),
            )
        })
        .collect();
    let whole = Recorded::of(&golden, &pulses, 10.0);
    let levels = LEVELS;
    let clean = evaluated(&whole.clone().noisy(levels, &mut Noise(41)));
    assert!(
        faults(&clean).iter().all(Vec::is_empty),
        "{:?}",
        faults(&clean)
    );
    let mut saturated = whole.clone();
    saturated.force.iter_mut().for_each(|f| *f = f.min(14.0));
    let saturated = saturated.noisy(levels, &mut Noise(41));
    let error = saturated.evaluated(&ImpactConfig::usual()).unwrap_err();
    assert!(error.to_string().contains("force overloaded"), "{error}");
    let largest = whole.response.iter().copied().fold(0.0, f64::max);
    let mut saturated = whole.clone();
    saturated
        .response
        .iter_mut()
        .for_each(|a| *a = a.min(0.6 * largest));
    let saturated = saturated.noisy(levels, &mut Noise(41));
    let found = saturated.evaluated(&ImpactConfig::usual());
    let error = found.map(|found| found.function.impact).unwrap_err();
    assert!(error.to_string().contains("response overloaded"), "{error}");
}

/// Hum on the force holds more of its energy than five short pulses: whether they are hits is not decided, and said.
#[test]
fn hits_in_hum_are_not_averaged_silently() {
    let mut hum = recorded(5);
    let rate_hz = hum.rate_hz;
    for (i, f) in hum.force.iter_mut().enumerate() {
        *f += 0.85 * (TAU * 50.0 * i as f64 / rate_hz).sin();
    }
    let (force, response) = hum.series();
    let found = estimate(&force, &response, &WelchConfig::hann(2048), Estimator::H1).unwrap();
    let warnings = said(&found);
    assert!(
        warnings.iter().any(
            |d| matches!(d, ImpactWarning::PulsesInDrive { hits: 5, share, as_impact: false } if *share < 0.5)
        ),
        "{warnings:?}"
    );
    assert!(faults(&evaluated(&hum)).iter().all(Vec::is_empty));
}

/// A response that is early by less than a millisecond, one whose baseline drifts, a click in a random drive, and damping that leaves
/// nothing.
#[test]
fn early_drifting_and_overdamped_responses_are_named() {
    let steady = recorded(6);
    let mut early = steady.clone();
    let lead = (0.000_9 * early.rate_hz) as usize;
    early.response.rotate_left(lead);
    let error = early.evaluated(&ImpactConfig::usual()).unwrap_err();
    assert!(error.to_string().contains("begins"), "{error}");
    let mut drifting = steady.clone();
    let rate_hz = drifting.rate_hz;
    for (i, a) in drifting.response.iter_mut().enumerate() {
        *a += 1.0 * i as f64 / rate_hz;
    }
    let (a, b) = (evaluated(&steady), evaluated(&drifting));
    assert!(faults(&b).iter().all(Vec::is_empty), "{:?}", faults(&b));
    println!("{:.3} dB apart", apart_db(&a, &b));
    assert!(apart_db(&a, &b) < 0.3);
    let drifts = |d: &ImpactWarning| matches!(d, ImpactWarning::BaselineDrifts { signal, .. } if signal == "response");
    assert!(said(&b).iter().any(drifts) && !said(&a).iter().any(drifts));
    let mut noise = Noise(31);
    let mut random: Vec<f64> = (0..50_000).map(|_| noise.normal()).collect();
    random[20_000] = 400.0;
    assert!(transient(&random, steady.rate()).is_none());
    let config = ImpactConfig {
        exponential: ExponentialWindow::Damping(1e4),
        ..ImpactConfig::usual()
    };
    let error = steady.evaluated(&config).unwrap_err();
    assert!(
        error.to_string().contains("added damping of at most"),
        "{error}"
    );
}

/// What is left is that of the resonance, whatever the length of the blocks: one mode whose decay is known.
#[test]
fn what_is_left_is_what_the_damping_leaves() {
    for (hz, damping, segment_s) in [
        (40.0, 0.02, 0.7),
        (113.0, 0.006, 0.7),
        (180.0, 0.002, 1.2),
        (300.0, 0.001, 1.2),
    ] {
        let mut one = slow();
        one.modes = vec![(hz, damping, 1.0)];
        let recorded = Recorded::of(&one, &hits(4), 6.2).noisy(
            NoiseLevels {
                response_m_per_s2: 0.002,
                ..LEVELS
            },
            &mut Noise(37),
        );
        let samples = (segment_s * recorded.rate_hz) as usize;
        let config = ImpactConfig {
            segment: ImpactSegment::Samples(samples),
            ..ImpactConfig::usual()
        };
        let test = recorded
            .evaluated(&config)
            .unwrap()
            .function
            .impact
            .unwrap();
        let expected = (-TAU * hz * damping * (segment_s - test.pretrigger_s)).exp();
        let left = test.left.unwrap();
        println!("{hz} Hz: {left:.4}, {expected:.4} expected");
        assert!(
            left > 0.6 * expected && left < 1.6 * expected,
            "{hz}: {left} {expected}"
        );
    }
}

#[test]
fn a_response_that_drops_out_is_named() {
    let mut loose = recorded(5);
    let from = ((0.9 + 1.3 + 0.02) * loose.rate_hz) as usize;
    let lasts = (0.049 * loose.rate_hz) as usize;
    loose.response[from..from + lasts].fill(0.0);
    let found = evaluated(&loose);
    let faults = faults(&found);
    println!("{faults:?}");
    assert!(
        matches!(faults[1][..], [HitFault::ResponseStops { after_s, lasts_s }] if (after_s - 0.02).abs() < 0.001 && (lasts_s - 0.049).abs() < 0.001)
    );
    assert_eq!(faults.iter().filter(|f| f.is_empty()).count(), 4);
}

#[test]
fn hits_at_another_point_are_named() {
    let hits = hits(7);
    let mut other = slow();
    for (k, mode) in other.modes.iter_mut().enumerate() {
        mode.2 *= [-1.0, 0.3, -1.4, 0.8, -0.5, 1.0][k];
    }
    let (there, here): (Vec<Pulse>, Vec<Pulse>) = (
        hits.iter()
            .enumerate()
            .filter(|(i, _)| *i == 2 || *i == 5)
            .map(|(_, h)| *h)
            .collect(),
        hits.iter()
            .enumerate()
            .filter(|(i, _)| *i != 2 && *i != 5)
            .map(|(_, h)| *h)
            .collect(),
    );
    let mut both = Recorded::of(&slow(), &here, 10.0);
    let moved = Recorded::of(&other, &there, 10.0);
    for (v, w) in both.force.iter_mut().zip(&moved.force) {
        *v += w;
    }
    for (v, w) in both.response.iter_mut().zip(&moved.response) {
        *v += w;
    }
    let found = evaluated(&both.noisy(LEVELS, &mut Noise(23)));
    let mut warnings = found.about.warnings.iter();
    let named = warnings.find_map(|d| match d.kind() {
        Some(ScatterWarning::Scatter {
            of: Scatter::Hits { at_s, share, .. },
        }) => Some((at_s, share)),
        _ => None,
    });
    let (at_s, share) = named.unwrap();
    println!("{at_s:?} {share}");
    assert!(
        at_s.len() == 2
            && (at_s[0] - there[0].0).abs() < 0.01
            && (at_s[1] - there[1].0).abs() < 0.01
    );
    let alike = evaluated(&recorded(7));
    let differs = |d: &piezotact::Warning| {
        matches!(
            d.kind(),
            Some(ScatterWarning::Scatter {
                of: Scatter::Hits { .. }
            })
        )
    };
    assert!(!alike.about.warnings.iter().any(differs));
    // Noise on the response alone sets no hit apart.
    let loud = NoiseLevels {
        response_m_per_s2: 3.0,
        ..LEVELS
    };
    let noisy = evaluated(&recorded(7).noisy(loud, &mut Noise(29)));
    assert!(!noisy.about.warnings.iter().any(differs));
}

/// Force and acceleration exchanged: nobody said which is which, and the estimate of a lasting drive says what it looks like.
#[test]
fn exchanged_channels_are_named() {
    let recorded = recorded(5);
    let exchanged = |drive: &[f64], response: &[f64]| {
        let channel = |name: &str, samples: &[f64]| Channel {
            name: name.into(),
            unit: Unit::Volt,
            samples: samples.to_vec(),
        };
        let channels = vec![channel("drive", drive), channel("response", response)];
        let (condition, provenance) = (Condition::default(), Provenance::default());
        let recording = Recording::new(channels, recorded.rate(), condition, provenance).unwrap();
        let config = BetweenConfig {
            drive: "drive",
            response: "response",
            welch: WelchConfig::hann(2048),
            excitation: Excitation::Found,
            impact: ImpactConfig::usual(),
            estimator: Estimator::H1,
            known_input: false,
            volts_per_full_scale: None,
            setup: None,
            lost_s: Vec::new(),
        };
        let found = between_channels(&recording, &config).unwrap().function;
        let kinds: Vec<TransferWarning> = found
            .about
            .warnings
            .iter()
            .filter_map(piezotact::Warning::kind)
            .collect();
        kinds.iter().any(|d| {
            matches!(
                d,
                TransferWarning::Swapped {
                    by: Swapped::Pulses { hits: 5 }
                }
            )
        })
    };
    assert!(exchanged(&recorded.response, &recorded.force));
    assert!(!exchanged(&recorded.force, &recorded.response));
}
