//! Segmentation on recordings whose cuts are known.
#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test fails where it cannot go on, and reports what it measured"
)]

mod known_cuts;

use std::collections::BTreeMap;

use known_cuts::{Kind, RATE_HZ, Recorded, active_touch};
use piezotact::quantity::{Newtons, SampleRate};
use piezotact::stroke::{ForceRule, Segmentation, Signals, segment_by_force};

fn segmented(made: &Recorded) -> Segmentation {
    let signals = Signals {
        rate: SampleRate::new(RATE_HZ).unwrap(),
        vibration: Some(&made.acceleration),
        normal_force_n: Some(&made.fz_n),
        tangential_force_n: vec![&made.fx_n, &made.fy_n],
        motion: None,
    };
    segment_by_force(&signals, &ForceRule::active(Some(Newtons(0.2)))).unwrap()
}

/// Every valid stroke of 200 recordings with hesitations, double touches, bounces, pauses, drift and stick-slip is
/// found within 20 ms, and nothing else is.
#[test]
fn every_stroke_is_found_within_20_ms_and_nothing_else_is() {
    let rule = ForceRule::active(Some(Newtons(0.2)));
    let (mut valid, mut found, mut right) = (0, 0, 0);
    let mut worst = (0.0f64, 0.0f64);
    let mut errors_ms = Vec::new();
    let mut fates: BTreeMap<(Kind, String), usize> = BTreeMap::new();
    let mut wrong = Vec::new();
    for seed in 0..200 {
        let made = active_touch(seed);
        let segmentation = segmented(&made);
        found += segmentation.strokes.len();
        for truth in &made.truths {
            let (on_s, off_s) = truth.contact_s;
            let here = |start: usize, end: usize| {
                let (start_s, end_s) = (start as f64 / RATE_HZ, end as f64 / RATE_HZ);
                start_s < off_s && on_s < end_s
            };
            let stroke = segmentation
                .strokes
                .iter()
                .find(|s| here(s.steady.start, s.steady.end));
            let fate = match stroke {
                Some(_) => "kept".into(),
                None => segmentation
                    .rejected
                    .iter()
                    .find(|r| here(r.interval.start, r.interval.end))
                    .map_or("missed".into(), |r| r.reason.name().to_owned()),
            };
            *fates.entry((truth.kind, fate.clone())).or_default() += 1;
            let Some(cut) = truth.cut_s(rule.landing_s.0, rule.take_off_s.0) else {
                continue;
            };
            valid += 1;
            let Some(stroke) = stroke else {
                wrong.push(format!("seed {seed}: {truth:?} was {fate}"));
                continue;
            };
            let start_s = stroke.steady.start as f64 / RATE_HZ - cut.0;
            let end_s = stroke.steady.end as f64 / RATE_HZ - cut.1;
            worst = (worst.0.max(start_s.abs()), worst.1.max(end_s.abs()));
            errors_ms.extend([start_s.abs() * 1e3, end_s.abs() * 1e3]);
            if start_s.abs() <= 0.02 && end_s.abs() <= 0.02 {
                right += 1;
            } else {
                wrong.push(format!(
                    "seed {seed}: {truth:?} starts {:.1} ms and ends {:.1} ms off",
                    start_s * 1e3,
                    end_s * 1e3
                ));
            }
        }
    }
    errors_ms.sort_by(f64::total_cmp);
    println!(
        "precision {:.4} ({right} of {found}), recall {:.4} ({right} of {valid}); start within {:.1} ms, end within {:.1} ms, median {:.1} ms",
        f64::from(right) / found as f64,
        f64::from(right) / f64::from(valid),
        worst.0 * 1e3,
        worst.1 * 1e3,
        errors_ms[errors_ms.len() / 2],
    );
    for ((kind, fate), count) in &fates {
        println!("  {kind:?}: {fate} {count}");
    }
    assert!(
        wrong.is_empty(),
        "{} wrong:\n{}",
        wrong.len(),
        wrong
            .iter()
            .take(20)
            .cloned()
            .collect::<Vec<_>>()
            .join("\n")
    );
    assert_eq!(found, right as usize, "a stroke was found where none is");
}
