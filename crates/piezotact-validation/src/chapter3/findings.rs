//! What is found of the claims of chapter 3.

use std::f64::consts::SQRT_2;

use piezotact::compare::{Summary, active_against_passive, difference_db_rms};
use piezotact::feature::{StrokeSpectra, band_power};
use piezotact::number::plus;
use piezotact::quantity::Band;
use piezotact::statistics::{log_fit, mean, rms, spearman};
use piezotact::stroke::Judging;

use super::{ACTIVE_STROKES, COARSE, SPEEDS_M_S, Touched, level, named, rough, shape};
use crate::claims::{Finding, Holds, above, at_least, at_most, below, least, most, no_exception};
use crate::comb::band_peak;

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
                "less than 90 % of the power is within 10–600 Hz: the gesture of the hand, below 10 Hz, remains where a texture is faint",
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

/// How far two levels are apart, dB, whichever is higher.
fn apart_db(a: f64, b: f64) -> f64 {
    (20.0 * (a / b).log10()).abs()
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
            at_most(
                apart_db(s2, s3),
                1.0,
                "dB",
                "the levels of S2 and S3 differ by more",
            ),
            at_most(
                apart_db(s2, s4),
                2.0,
                "dB",
                "the levels of S2 and S4 differ by more",
            ),
        ]),
        format!(
            "S2 and S3 differ by {:.2} dB, S2 and S4 by {:.2} dB",
            apart_db(s2, s3),
            apart_db(s2, s4)
        ),
    )
}

pub(super) fn same_roughness(samples: &[Touched]) -> Finding {
    let ratio = level(samples, "S7") / level(samples, "S8");
    Finding::of(
        13,
        Holds::all([at_least(
            ratio,
            1.2,
            "",
            "the levels differ by less than 1.6 dB, a just noticeable difference",
        )]),
        format!("S7/S8 {ratio:.3}, {:.2} dB", apart_db(ratio, 1.0)),
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
            above(
                softest,
                0.7,
                "m/s²",
                "one of S1–S8 has a lower level: S8, the lowest, has a margin of about one standard deviation between panels",
            ),
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

/// The fingerprint's peak over v/λ; NaN where there is none. It is looked for up to half an octave from v/λ, four times as far as the claim
/// allows, and stands out by 3 dB.
fn peak_ratio(summary: &Summary, expected_hz: f64) -> f64 {
    let around = [expected_hz / SQRT_2, expected_hz * SQRT_2];
    let found = band_peak(&summary.psd, around).filter(|peak| peak.prominence_db >= 3.0);
    found.map_or(f64::NAN, |peak| peak.at_hz / expected_hz)
}

pub(super) fn fingerprint(samples: &[Touched], ridge_m: f64) -> Finding {
    let (mut told, mut slopes) = (Vec::new(), Vec::new());
    let (mut passive, mut active) = (Vec::new(), Vec::new());
    for name in COARSE {
        let Some(sample) = named(samples, name) else {
            continue;
        };
        let expected = SPEEDS_M_S.map(|v| v / ridge_m);
        let at_speeds: Vec<f64> = sample
            .passive
            .iter()
            .zip(expected)
            .map(|(summary, hz)| peak_ratio(summary, hz))
            .collect();
        let touched = peak_ratio(&sample.active_summary, expected[2]);
        // At 10 and 20 mm/s the thesis shows S1 to S3.
        if name == COARSE[3] {
            passive.push(at_speeds[2]);
        } else {
            let peaks_hz: Vec<f64> = at_speeds
                .iter()
                .zip(expected)
                .map(|(r, hz)| r * hz)
                .collect();
            slopes.push(log_fit(&SPEEDS_M_S, &peaks_hz).map_or(f64::NAN, |fit| fit.slope));
            passive.extend(&at_speeds);
        }
        active.push(touched);
        let hz = |(ratio, hz): (&f64, f64)| match ratio.is_nan() {
            true => "none".into(),
            false => format!("{:.1}", ratio * hz),
        };
        let found: Vec<String> = at_speeds.iter().zip(expected).map(hz).collect();
        told.push(format!(
            "{name} {} ({})",
            found.join("/"),
            hz((&touched, expected[2]))
        ));
    }
    let off = |ratios: &[f64]| most(ratios.iter().map(|ratio| (ratio - 1.0).abs()));
    let slope_off = most(slopes.iter().map(|slope| (slope - 1.0).abs()));
    Finding::of(
        17,
        Holds::all([
            at_most(
                off(&passive),
                0.1,
                "",
                "in passive touch, a fingerprint peak is missing or more than 10 % off v/λ",
            ),
            at_most(
                slope_off,
                0.1,
                "",
                "the frequency of a peak is not proportional to speed",
            ),
            at_most(
                off(&active),
                0.1,
                "",
                "in active touch, a fingerprint peak is missing or more than 10 % off v/λ",
            ),
        ]),
        format!(
            "passive at 10/20/30 mm/s (active at 30): {} Hz; at most {:.1} % off v/λ in passive touch (S4 at 30 mm/s only), \
                {:.1} % in active touch; log-log slopes on speed at most {slope_off:.3} from 1",
            told.join(", "),
            off(&passive) * 100.0,
            off(&active) * 100.0
        ),
    )
}

pub(super) fn active_as_passive(samples: &[Touched], within: Band) -> Finding {
    let shown: Vec<&Touched> = samples.iter().filter(|s| s.name != "NO").collect();
    let active: Vec<&Summary> = shown.iter().map(|s| &s.active_summary).collect();
    let passive: Vec<&Summary> = shown.iter().map(|s| &s.passive[2]).collect();
    let both = active_against_passive(&active, &passive, |_| [None, None], within);
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

/// How far the third octaves of the strokes' PSDs, each of power 1 over all, lie from their mean: the largest rms of a stroke, dB.
fn departure_db(spectra: &StrokeSpectra, bands: &[Band]) -> f64 {
    let shape = |psd: &Vec<f64>| -> Vec<f64> {
        let powers = bands
            .iter()
            .map(|band| band_power(psd, spectra.resolution_hz, *band));
        let powers: Vec<f64> = powers.collect();
        let all: f64 = powers.iter().sum();
        powers.iter().map(|power| power / all).collect()
    };
    let shapes: Vec<Vec<f64>> = spectra.each.iter().map(shape).collect();
    let usual: Vec<f64> = (0..bands.len())
        .map(|k| mean(&shapes.iter().map(|shape| shape[k]).collect::<Vec<f64>>()))
        .collect();
    most(shapes.iter().map(|shape| {
        let off = shape.iter().zip(&usual);
        let off: Vec<f64> = off
            .map(|(own, usual)| 10.0 * (own / usual).log10())
            .collect();
        rms(&off)
    }))
}

pub(super) fn repeatable(samples: &[Touched], within: Band) -> Finding {
    let bands = within.third_octaves();
    let largest = |value: fn(&Touched, &[Band]) -> f64| {
        let all = samples.iter().map(|s| (value(s, &bands), s.name.as_str()));
        all.fold((f64::NEG_INFINITY, ""), |worst, one| {
            if one.0 > worst.0 || one.0.is_nan() {
                one
            } else {
                worst
            }
        })
    };
    let (off_db, least_alike) = largest(|s, bands| departure_db(&s.active.analysis.psd, bands));
    let (variation, least_even) = largest(|s, _| {
        let rms = s.active_summary.rms;
        rms.sd / rms.mean
    });
    let fewest = samples
        .iter()
        .map(|s| s.active.analysis.strokes.len())
        .min();
    Finding::of(
        19,
        Holds::all([
            at_most(
                off_db,
                3.0,
                "dB",
                "the spectral shape of some stroke is more than 3 dB rms from the mean of its sample",
            ),
            at_most(
                variation,
                0.2,
                "",
                "the level of some sample varies by more than 20 % from stroke to stroke",
            ),
            at_least(
                fewest.map_or(f64::NAN, |count| count as f64),
                10.0,
                "",
                "some sample has fewer than ten strokes",
            ),
        ]),
        format!(
            "over all {} samples and at least {} strokes of each: third octaves of a stroke at most {off_db:.2} dB rms from the \
                mean of its sample ({least_alike}); rms varies by at most {:.1} % ({least_even})",
            samples.len(),
            fewest.unwrap_or(0),
            variation * 100.0
        ),
    )
}

/// The width of the peak near `near_hz` as a share of its frequency: where the mean PSD stands above the middle between the peak and
/// the higher of the lowest points beside it. NaN where there is no peak.
fn peak_width(psd: &StrokeSpectra, near_hz: f64) -> f64 {
    let line = |hz: f64| (hz / psd.resolution_hz).round() as usize;
    let power = |k: usize| psd.mean.get(k).copied().unwrap_or(f64::NAN);
    let inside = line(0.6 * near_hz)..=line(1.5 * near_hz);
    let Some(top) = inside
        .clone()
        .max_by(|a, b| power(*a).total_cmp(&power(*b)))
    else {
        return f64::NAN;
    };
    let lowest = |lines: std::ops::RangeInclusive<usize>| lines.map(power).fold(f64::NAN, f64::min);
    let (below, beyond) = (line(0.35 * near_hz), line(2.0 * near_hz));
    let floor = lowest(below..=top).max(lowest(top..=beyond));
    let half = 0.5 * (power(top) + floor);
    // Between the lines, where the PSD crosses the middle.
    let crossing = |outer: usize, inner: usize| {
        let share = (power(inner) - half) / (power(inner) - power(outer));
        (outer as f64 - inner as f64).abs() * share
    };
    let (mut left, mut right) = (top, top);
    while left > below && power(left - 1) > half {
        left -= 1;
    }
    while right < beyond && power(right + 1) > half {
        right += 1;
    }
    if left == below || right == beyond {
        return f64::NAN;
    }
    let lines = (right - left) as f64 + crossing(left - 1, left) + crossing(right + 1, right);
    lines / top as f64
}

/// What transversal touch of a coarse sample is beside proximal touch of it.
struct Across<'a> {
    name: &'a str,
    level_db: f64,
    /// Strokes with stick-slip: transversal, proximal.
    slipped: [usize; 2],
    /// The width of the fingerprint's peak: transversal, proximal.
    width: [f64; 2],
}

pub(super) fn transversal_touch(samples: &[Touched], ridge_m: f64) -> Finding {
    let near_hz = SPEEDS_M_S[2] / ridge_m;
    let across = samples.iter().filter_map(|s| {
        let (taken, summary) = s.transversal.as_ref()?;
        Some(Across {
            name: &s.name,
            level_db: 20.0 * (summary.rms.mean / s.active_summary.rms.mean).log10(),
            slipped: [taken.slipped, s.active.slipped],
            width: [&taken.analysis.psd, &s.active.analysis.psd]
                .map(|psd| peak_width(psd, near_hz)),
        })
    });
    let across: Vec<Across<'_>> = across.collect();
    let more_slips = |one: &Across<'_>| {
        let [transversal, proximal] = one.slipped.map(|count| count as f64);
        (transversal - proximal) / ACTIVE_STROKES as f64
    };
    let told = across.iter().map(|one| {
        let [transversal, proximal] = one.width.map(|share| match share.is_finite() {
            true => format!("{:.0} % wide", share * 100.0),
            false => "none".to_owned(),
        });
        format!(
            "{}: level {} dB re proximal, stick-slip in {} of {ACTIVE_STROKES} strokes ({} proximal), peak of the fingerprint: \
                {transversal} ({proximal} proximal)",
            one.name,
            plus(one.level_db, 1),
            one.slipped[0],
            one.slipped[1],
        )
    });
    Finding::of(
        35,
        Holds::all([
            below(
                most(across.iter().map(|one| one.level_db)),
                0.0,
                "dB",
                "a coarse sample has no lower level in transversal touch",
            ),
            above(
                least(across.iter().map(more_slips)),
                0.0,
                "",
                "a coarse sample has no more strokes with stick-slip in transversal touch",
            ),
            above(
                least(across.iter().map(|one| one.width[0] / one.width[1])),
                1.0,
                "",
                "a coarse sample has no wider peak in transversal touch: where all strokes stick and slip no peak is left",
            ),
        ]),
        told.collect::<Vec<String>>().join("; "),
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
