//! What is found of the claims of chapter 3.

use piezotact::compare::{Summary, active_against_passive, difference_db_rms};
use piezotact::feature::{StrokeFeatures, band_power};
use piezotact::quantity::Band;
use piezotact::statistics::{log_fit, spearman};
use piezotact::stroke::Judging;

use super::{ACTIVE_STROKES, COARSE, Touched, level, named, rough, shape};
use crate::claims::{Finding, Holds, above, at_least, at_most, below, least, most, no_exception};

/// The least share of power within `within` and the widest difference of two shapes, dB, each with whose it is.
fn breadth(summaries: &[&Summary], within: Band) -> ((f64, String), (f64, String)) {
    let mut narrowest = (f64::INFINITY, String::new());
    let mut widest = (0.0, String::new());
    for (i, a) in summaries.iter().enumerate() {
        let (psd, step) = (&a.psd.mean, a.psd.resolution_hz);
        let share = band_power(psd, step, within) / (psd.iter().sum::<f64>() * step);
        if share < narrowest.0 || share.is_nan() {
            narrowest = (share, a.name.clone());
        }
        for b in &summaries[..i] {
            let (x, y) = (shape(a, within), shape(b, within));
            let apart = difference_db_rms(&x, &y, step, within).unwrap_or(f64::INFINITY);
            if apart > widest.0 {
                widest = (apart, format!("{} and {}", b.name, a.name));
            }
        }
    }
    (narrowest, widest)
}

/// Those that are listed, or what it would mean were there any.
fn named_or(listed: &[String], none: &str) -> String {
    if listed.is_empty() {
        none.into()
    } else {
        listed.join(", ")
    }
}

pub(super) fn broad_and_similar(samples: &[Touched], within: Band) -> Finding {
    let active: Vec<&Summary> = samples.iter().map(|s| &s.active_summary).collect();
    let passive: Vec<&Summary> = samples.iter().map(|s| &s.passive[2]).collect();
    let both = [breadth(&active, within), breadth(&passive, within)];
    let share = least(both.iter().map(|(narrowest, _)| narrowest.0));
    let apart = most(both.iter().map(|(_, widest)| widest.0));
    let told = ["active", "passive"].iter().zip(&both).map(
        |(touch, ((share, narrow), (apart, pair)))| {
            format!(
                "{touch}: at least {:.1} % of the power within 10–600 Hz ({narrow}), spectral shapes differ by at \
                    most {apart:.2} dB rms ({pair})",
                share * 100.0
            )
        },
    );
    Finding::of(
        10,
        Holds::all([
            at_least(
                share,
                0.9,
                "",
                "less than 90 % of the power is within 10–600 Hz",
            ),
            at_most(
                apart,
                3.0,
                "dB",
                "two spectral shapes differ by more than 3 dB rms",
            ),
        ]),
        told.collect::<Vec<String>>().join("; "),
    )
}

pub(super) fn level_falls(samples: &[Touched]) -> Finding {
    let levels: Vec<f64> = rough(samples).iter().map(|s| s.level()).collect();
    // Pairs that the thesis finds close may change places by 8 %.
    let close = |i: usize| i == 1 || i == 7;
    let rising: Vec<String> = (0..8)
        .filter(|i| {
            let allowed = if close(*i) { 1.08 } else { 1.0 };
            levels[i + 1].is_nan() || levels[i + 1] >= allowed * levels[*i]
        })
        .map(|i| format!("S{} < S{}", i + 1, i + 2))
        .collect();
    let inversions = (9..12).filter(|i| levels[i + 1] > levels[*i]).count();
    let listed: Vec<String> = levels.iter().map(|v| format!("{v:.2}")).collect();
    Finding::of(
        11,
        Holds::all([
            no_exception(
                rising.len(),
                &named_or(&rising, "the level rises from one of S1–S8 to the next"),
            ),
            no_exception(1 - usize::from(inversions > 0), "no inversion in S10–S13"),
        ]),
        format!(
            "S1–S13: {} m/s²; {inversions} inversion{} in S10–S13",
            listed.join(", "),
            if inversions == 1 { "" } else { "s" }
        ),
    )
}

pub(super) fn close_levels(samples: &[Touched]) -> Finding {
    let (s2, s3, s4) = (
        level(samples, "S2"),
        level(samples, "S3"),
        level(samples, "S4"),
    );
    Finding::of(
        12,
        Holds::all([
            at_most(s2 / s4, 1.25, "", "the levels of S2 and S4 differ by more"),
            at_most(s2 / s3, 1.05, "", "the levels of S2 and S3 differ by more"),
        ]),
        format!("S2/S4 {:.3}, S2/S3 {:.3}", s2 / s4, s2 / s3),
    )
}

pub(super) fn same_roughness(samples: &[Touched]) -> Finding {
    let ratio = level(samples, "S7") / level(samples, "S8");
    Finding::of(
        13,
        Holds::all([at_least(ratio, 1.15, "", "the levels differ by less")]),
        format!("S7/S8 {ratio:.3}"),
    )
}

pub(super) fn hard_samples(samples: &[Touched]) -> Finding {
    let rough = rough(samples);
    let loudest = most(rough[9..].iter().map(|s| s.level()));
    let softest = least(rough[..8].iter().map(|s| s.level()));
    Finding::of(
        14,
        Holds::all([
            below(loudest, 0.7, "m/s²", "one of S10–S13 has a higher level"),
            above(softest, 0.7, "m/s²", "one of S1–S8 has a lower level"),
        ]),
        format!("S10–S13 at most {loudest:.3} m/s², S1–S8 at least {softest:.3} m/s²"),
    )
}

/// The friction coefficient of passive touch at 30 mm/s.
pub(super) fn friction_of(sample: &Touched) -> f64 {
    sample.passive[2]
        .friction_coefficient
        .map_or(f64::NAN, |friction| friction.mean)
}

pub(super) fn friction(samples: &[Touched]) -> Finding {
    let rough = rough(samples);
    let of = |value: fn(&Touched) -> f64| -> Vec<f64> { rough.iter().map(|s| value(s)).collect() };
    let (ra, friction, levels) = (of(|s| s.ra_m), of(friction_of), of(Touched::level));
    let with_ra = spearman(&ra, &friction).unwrap_or(f64::NAN);
    let with_level = spearman(&levels, &friction).unwrap_or(f64::NAN);
    let plain = named(samples, "NO");
    let extreme = plain.is_some_and(|no| {
        friction.iter().all(|f| friction_of(no) > *f) && levels.iter().all(|l| no.level() < *l)
    });
    Finding::of(
        15,
        Holds::all([
            above(with_ra, 0.7, "", "friction does not follow Ra"),
            above(with_level, 0.7, "", "friction does not follow the level"),
            no_exception(
                1 - usize::from(extreme),
                "the plate without texture (NO) does not have the highest friction and the \
                lowest level",
            ),
        ]),
        format!(
            "Spearman with Ra {with_ra:.2}, with the level {with_level:.2}; NO: friction {:.2}, {:.2} m/s²",
            plain.map_or(f64::NAN, friction_of),
            level(samples, "NO")
        ),
    )
}

pub(super) fn speed(samples: &[Touched]) -> Finding {
    let mut slopes = Vec::new();
    let mut falls = Vec::new();
    for sample in samples {
        let of =
            |value: fn(&Summary) -> f64| -> Vec<f64> { sample.passive.iter().map(value).collect() };
        let (v, rms) = (
            of(|s| s.speed_m_s.map_or(f64::NAN, |speed| speed.mean)),
            of(|s| s.rms.mean),
        );
        if !rms.windows(2).all(|pair| pair[1] > pair[0]) {
            falls.push(sample.name.as_str());
        }
        let slope = log_fit(&v, &rms).map_or(f64::NAN, |fit| fit.slope);
        slopes.push(slope);
    }
    let at =
        |speed: usize| -> Vec<f64> { samples.iter().map(|s| s.passive[speed].rms.mean).collect() };
    let pairs = [(0, 1), (1, 2), (0, 2)];
    let order = least(pairs.map(|(a, b)| spearman(&at(a), &at(b)).unwrap_or(f64::NAN)));
    let slopes = (least(slopes.iter().copied()), most(slopes));
    Finding::of(
        16,
        Holds::all([
            no_exception(falls.len(), "the level does not rise for every sample"),
            no_exception(
                1 - usize::from(slopes.0 >= 0.8 && slopes.1 <= 1.2),
                "a slope is outside 0.8–1.2",
            ),
            above(order, 0.95, "", "the order of samples changes with speed"),
        ]),
        format!(
            "slopes {:.2} to {:.2}; Spearman between speeds at least {order:.3}",
            slopes.0, slopes.1
        ),
    )
}

pub(super) fn fingerprint(samples: &[Touched]) -> Finding {
    // 55 ± 3 Hz, and as much in proportion.
    let expected = [(18.3, 1.0), (36.7, 2.0), (55.0, 3.0)];
    let (mut told, mut off) = (Vec::new(), Vec::new());
    for name in COARSE {
        let Some(sample) = named(samples, name) else {
            continue;
        };
        let mut found = Vec::new();
        for (summary, (hz, within_hz)) in sample.passive.iter().zip(expected) {
            let peak = summary.fingerprint.and_then(|f| f.found_hz);
            found.push(peak.map_or("none".into(), |peak| format!("{peak:.1}")));
            if peak.is_none_or(|peak| (peak - hz).abs() > within_hz) {
                off.push(format!("{name} at {hz} Hz"));
            }
        }
        told.push(format!("{name} {}", found.join("/")));
    }
    Finding::of(
        17,
        Holds::all([no_exception(
            off.len(),
            &named_or(&off, "a fingerprint peak is at another frequency"),
        )]),
        format!("at 10/20/30 mm/s: {} Hz", told.join(", ")),
    )
}

pub(super) fn active_as_passive(samples: &[Touched], within: Band) -> Finding {
    let shown: Vec<&Touched> = samples.iter().filter(|s| s.name != "NO").collect();
    let active: Vec<&Summary> = shown.iter().map(|s| &s.active_summary).collect();
    let passive: Vec<&Summary> = shown.iter().map(|s| &s.passive[2]).collect();
    let both = active_against_passive(&active, &passive, within);
    let worst = both.pairs.iter().max_by(|a, b| {
        let of =
            |p: &piezotact::compare::ActivePassivePair| p.difference_db_rms.unwrap_or(f64::MAX);
        of(a).total_cmp(&of(b))
    });
    let (apart, name) = worst.map_or((f64::MAX, ""), |pair| {
        (
            pair.difference_db_rms.unwrap_or(f64::MAX),
            pair.sample.as_str(),
        )
    });
    let order = both
        .rms_rank_correlation
        .map_or(f64::NAN, |ranks| ranks.rho);
    Finding::of(
        18,
        Holds::all([
            at_most(
                apart,
                3.0,
                "dB",
                "a sample's spectra differ by more than 3 dB rms",
            ),
            above(order, 0.95, "", "the order of levels differs"),
        ]),
        format!(
            "difference of at most {apart:.2} dB rms ({name}); Spearman of the levels {order:.3}"
        ),
    )
}

pub(super) fn repeatable(samples: &[Touched]) -> Finding {
    let Some(sample) = named(samples, "S8") else {
        return Finding::of(
            19,
            Holds::all([no_exception(1, "S8 is missing")]),
            "–".into(),
        );
    };
    let rms = sample.active_summary.rms;
    let variation = rms.sd / rms.mean;
    let repeats = |touched: &Touched| {
        let usual_hz = touched.active_summary.strongest_hz;
        let strokes = &touched.active.analysis.strokes;
        let near = |s: &&StrokeFeatures| (s.strongest_hz / usual_hz - 1.0).abs() <= 0.1;
        (strokes.iter().filter(near).count(), strokes.len(), usual_hz)
    };
    let (near, of, usual_hz) = repeats(sample);
    let s1 = named(samples, "S1").map_or(String::new(), |s1| {
        let (near, of, usual_hz) = repeats(s1);
        format!(
            "; on S1, where the fingerprint peak is clear, {near} of {of} around {usual_hz:.0} Hz"
        )
    });
    let centroid = sample.active_summary.centroid_hz;
    Finding::of(
        19,
        Holds::all([
            no_exception(
                1 - usize::from(near == of),
                "in a broad spectrum, the highest line of a single stroke is probably random: a stroke has about nine segments, \
                    so its lines scatter by a third; the centroid is repeatable",
            ),
            at_most(variation, 0.2, "", "the level varies by more than 20 %"),
        ]),
        format!(
            "S8: the highest line of {near} of {of} strokes lies within ± 10 % of {usual_hz:.0} Hz{s1}; centroid {:.0} ± {:.0} Hz; rms varies by {:.1} %",
            centroid.mean,
            centroid.sd,
            variation * 100.0
        ),
    )
}

/// How often active touch stuck and slipped, and what became of it, in sentences.
pub(super) fn stick_slip(samples: &[Touched]) -> String {
    let of = |judging: Judging| -> Vec<String> {
        let theirs = samples.iter().filter(|s| s.active.judging == judging);
        theirs
            .filter(|s| s.active.slipped > 0)
            .map(|s| format!("{} of {ACTIVE_STROKES} on {}", s.active.slipped, s.name))
            .collect()
    };
    let mut told = Vec::new();
    for (judging, became) in [
        (Judging::Sliding, "were excluded"),
        (
            Judging::ContactOnly,
            "were analysed nevertheless, since no other strokes remained",
        ),
    ] {
        let listed = of(judging);
        if !listed.is_empty() {
            told.push(format!(
                "Active strokes with stick-slip {became}: {}.",
                listed.join(", ")
            ));
        }
    }
    if told.is_empty() {
        told.push("No active stroke had stick-slip.".into());
    }
    told.join(" ")
}
