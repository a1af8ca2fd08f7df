//! Chapter 3: vibrations of active and passive touch of the isotropic samples, by the reference participant.

use piezotact::compare::{
    Periods, Summary, active_against_passive, difference_db_rms, log_fit, spearman,
};
use piezotact::feature::{StrokeFeatures, band_power};
use piezotact::quantity::{Acceleration, Band, Hertz};
use piezotact::recording::Recording;
use piezotact::series::Series;

use super::claims::{Finding, Holds};
use super::figure::{Axis, Figure, Line, Mark, Shown, decibels};
use super::measured::{Taken, run, take};
use super::{Chapter, Replay, ReplayError};
use crate::traits::BenchError;
use crate::twin::{ActTouch, ActiveProtocol, Movement, Pace, Participant, Relief, TriboAir};

/// Speeds of passive touch, m/s.
const SPEEDS_M_S: [f64; 3] = [0.01, 0.02, 0.03];
/// Strokes of passive touch: at least 6 in the thesis, 10 for an average.
const PASSIVE_STROKES: usize = 12;
/// Strokes of active touch: at least 15.
const ACTIVE_STROKES: usize = 15;
/// Samples in a segment at each speed: a fingerprint's peak is as many lines wide at all of them.
const SEGMENTS: [usize; 3] = [4_096, 2_048, 1_024];
const SEGMENT: usize = SEGMENTS[2];
/// The samples on which the fingerprint shows.
const COARSE: [&str; 4] = ["S1", "S2", "S3", "S4"];

/// What was measured of one sample.
struct Touched {
    name: String,
    ra_m: f64,
    /// At the three speeds.
    passive: Vec<Summary>,
    active: Taken,
    active_summary: Summary,
    /// The recording of active touch, and of passive touch at each speed, where a figure shows them.
    shown: Option<(Recording, Vec<Series<Acceleration>>)>,
}

impl Touched {
    /// The level of passive touch at 30 mm/s, m/s².
    fn level(&self) -> f64 {
        self.passive[2].rms.mean
    }
}

/// Chapter 3 on the twin.
///
/// # Errors
/// [`ReplayError`] where the analysis refuses what the benches gave.
pub fn chapter3(replay: &Replay) -> Result<Chapter, ReplayError> {
    let samples = touched(replay)?;
    let findings = vec![
        broad_and_similar(&samples, band(10.0, 600.0)?),
        level_falls(&samples),
        close_levels(&samples),
        same_roughness(&samples),
        hard_samples(&samples),
        friction(&samples),
        speed(&samples),
        fingerprint(&samples),
        active_as_passive(&samples, band(20.0, 500.0)?),
        repeatable(&samples),
    ];
    let slipped = stick_slip(&samples);
    Ok(Chapter {
        number: 3,
        title: "Vibrations of active and passive touch",
        measured: vec![
            format!(
                "The reference participant (ridges {:.3} mm apart) touched the 14 isotropic samples at 0.2 N: passively {PASSIVE_STROKES} times at each of 10, 20 and 30 mm/s, actively in {ACTIVE_STROKES} proximal strokes at 30 mm/s.",
                replay.parameters.person.reference_ridge_m * 1e3
            ),
            slipped,
        ],
        findings,
        figures: figures(&samples)?,
        missing: Vec::new(),
    })
}

fn band(low_hz: f64, high_hz: f64) -> Result<Band, ReplayError> {
    Ok(Band::new(Hertz(low_hz), Hertz(high_hz))?)
}

fn touched(replay: &Replay) -> Result<Vec<Touched>, ReplayError> {
    let parameters = &replay.parameters;
    let person = || Participant::of(0, replay.seed, parameters);
    let periods = Periods {
        ridge_m: Some(parameters.person.reference_ridge_m),
        texture_m: None,
    };
    let run = run("chapter 3", Some(0.2));
    let names = (1..=13).map(|i| format!("S{i}")).chain(["NO".to_owned()]);
    names
        .map(|name| {
            let sample = parameters.sample(&name)?;
            let (mut passive, mut vibrations) = (Vec::new(), Vec::new());
            for (speed_m_s, segment) in SPEEDS_M_S.into_iter().zip(SEGMENTS) {
                let bench =
                    TriboAir::new(parameters, person(), sample, PASSIVE_STROKES, speed_m_s)?;
                let (taken, recording) = take(bench.into_acquirer(), &run, segment)?;
                passive.push(taken.summary(&name, periods)?);
                if name == "S1" {
                    vibrations.push(strokes_joined(&taken, &recording)?);
                }
            }
            let protocol = ActiveProtocol {
                strokes: ACTIVE_STROKES,
                movement: Movement::Proximal,
                pace: Pace::Metronome {
                    speed_m_s: 0.03,
                    stroke_s: None,
                },
            };
            let bench = ActTouch::new(parameters, person(), sample, protocol)?;
            let (active, recording) = take(bench.into_acquirer(), &run, SEGMENT)?;
            Ok(Touched {
                ra_m: match sample.relief {
                    Relief::Isotropic { ra_m, .. } => ra_m,
                    Relief::Dots { .. } | Relief::Ridges { .. } => 0.0,
                },
                active_summary: active.summary(&name, periods)?,
                shown: (name == "S1" || name == "S8").then_some((recording, vibrations)),
                passive,
                active,
                name,
            })
        })
        .collect()
}

/// The vibration of the steady parts of the first strokes, one after the other.
fn strokes_joined(
    taken: &Taken,
    recording: &Recording,
) -> Result<Series<Acceleration>, ReplayError> {
    const SHOWN: usize = 3;
    let vibration = recording
        .series::<Acceleration>(None)
        .map_err(BenchError::from)?;
    let strokes = taken.segmentation.strokes.iter().take(SHOWN);
    let joined = strokes
        .flat_map(|stroke| stroke.steady.of(vibration.samples()).iter().copied())
        .collect();
    Ok(Series::new(joined, recording.rate())?)
}

fn named<'a>(samples: &'a [Touched], name: &str) -> Option<&'a Touched> {
    samples.iter().find(|sample| sample.name == name)
}

fn level(samples: &[Touched], name: &str) -> f64 {
    named(samples, name).map_or(f64::NAN, Touched::level)
}

/// The rough samples, in order.
fn rough(samples: &[Touched]) -> Vec<&Touched> {
    samples.iter().filter(|s| s.name != "NO").collect()
}

/// A PSD of power 1 within `band`.
fn shape(summary: &Summary, band: Band) -> Vec<f64> {
    let power = band_power(&summary.psd.mean, summary.psd.resolution_hz, band);
    summary.psd.mean.iter().map(|v| v / power).collect()
}

fn broad_and_similar(samples: &[Touched], within: Band) -> Finding {
    let mut least = (1.0, "");
    let mut widest = (0.0, String::new());
    for (i, a) in samples.iter().enumerate() {
        let s = &a.active_summary;
        let (psd, step) = (&s.psd.mean, s.psd.resolution_hz);
        let share = band_power(psd, step, within) / (psd.iter().sum::<f64>() * step);
        if share < least.0 {
            least = (share, &a.name);
        }
        for b in &samples[..i] {
            let other = &b.active_summary;
            let (x, y) = (shape(s, within), shape(other, within));
            let apart = difference_db_rms(&x, &y, step, within).unwrap_or(f64::INFINITY);
            if apart > widest.0 {
                widest = (apart, format!("{} and {}", b.name, a.name));
            }
        }
    }
    Finding::of(
        10,
        Holds::all([
            (
                least.0 >= 0.9,
                "less than 90 % of the power lies within 10–600 Hz",
            ),
            (widest.0 <= 3.0, "two shapes differ by more than 3 dB rms"),
        ]),
        format!(
            "at least {:.1} % of the power within 10–600 Hz ({}); shapes at most {:.2} dB rms apart ({})",
            least.0 * 100.0,
            least.1,
            widest.0,
            widest.1
        ),
    )
}

fn level_falls(samples: &[Touched]) -> Finding {
    let levels: Vec<f64> = rough(samples).iter().map(|s| s.level()).collect();
    // Pairs that the thesis finds close may change places by 8 %.
    let close = |i: usize| i == 1 || i == 7;
    let rising: Vec<String> = (0..8)
        .filter(|i| {
            let allowed = if close(*i) { 1.08 } else { 1.0 };
            levels[i + 1] >= allowed * levels[*i]
        })
        .map(|i| format!("S{} < S{}", i + 1, i + 2))
        .collect();
    let inversions = (9..12).filter(|i| levels[i + 1] > levels[*i]).count();
    let listed: Vec<String> = levels.iter().map(|v| format!("{v:.2}")).collect();
    Finding::of(
        11,
        Holds::all([
            (rising.is_empty(), rising.join(", ").as_str()),
            (inversions > 0, "no inversion in S10–S13"),
        ]),
        format!(
            "S1–S13: {} m/s²; {inversions} inversion{} in S10–S13",
            listed.join(", "),
            if inversions == 1 { "" } else { "s" }
        ),
    )
}

fn close_levels(samples: &[Touched]) -> Finding {
    let (s2, s3, s4) = (
        level(samples, "S2"),
        level(samples, "S3"),
        level(samples, "S4"),
    );
    Finding::of(
        12,
        Holds::all([
            (s2 / s4 <= 1.25, "S2 and S4 are further apart"),
            (s2 / s3 <= 1.05, "S2 and S3 are further apart"),
        ]),
        format!("S2/S4 {:.3}, S2/S3 {:.3}", s2 / s4, s2 / s3),
    )
}

fn same_roughness(samples: &[Touched]) -> Finding {
    let ratio = level(samples, "S7") / level(samples, "S8");
    Finding::of(
        13,
        Holds::all([(ratio >= 1.15, "the levels are closer")]),
        format!("S7/S8 {ratio:.3}"),
    )
}

fn hard_samples(samples: &[Touched]) -> Finding {
    let rough = rough(samples);
    let most = rough[9..].iter().map(|s| s.level()).fold(0.0, f64::max);
    let least = rough[..8]
        .iter()
        .map(|s| s.level())
        .fold(f64::MAX, f64::min);
    Finding::of(
        14,
        Holds::all([
            (most < 0.7, "one of S10–S13 is louder"),
            (least > 0.7, "one of S1–S8 is softer"),
        ]),
        format!("S10–S13 at most {most:.3} m/s², S1–S8 at least {least:.3} m/s²"),
    )
}

/// The friction coefficient of passive touch at 30 mm/s.
fn friction_of(sample: &Touched) -> f64 {
    sample.passive[2]
        .friction_coefficient
        .map_or(f64::NAN, |friction| friction.mean)
}

fn friction(samples: &[Touched]) -> Finding {
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
            (with_ra > 0.7, "friction does not follow Ra"),
            (with_level > 0.7, "friction does not follow the level"),
            (extreme, "NO is not at both extremes"),
        ]),
        format!(
            "Spearman with Ra {with_ra:.2}, with the level {with_level:.2}; NO: friction {:.2}, {:.2} m/s²",
            plain.map_or(f64::NAN, friction_of),
            level(samples, "NO")
        ),
    )
}

fn speed(samples: &[Touched]) -> Finding {
    let mut slopes = (f64::MAX, f64::MIN);
    let mut falls = Vec::new();
    for sample in samples {
        let of =
            |value: fn(&Summary) -> f64| -> Vec<f64> { sample.passive.iter().map(value).collect() };
        let (v, rms) = (
            of(|s| s.speed_m_s.map_or(f64::NAN, |speed| speed.mean)),
            of(|s| s.rms.mean),
        );
        if rms.windows(2).any(|pair| pair[1] <= pair[0]) {
            falls.push(sample.name.as_str());
        }
        let slope = log_fit(&v, &rms).map_or(f64::NAN, |fit| fit.slope);
        slopes = (slopes.0.min(slope), slopes.1.max(slope));
    }
    let at =
        |speed: usize| -> Vec<f64> { samples.iter().map(|s| s.passive[speed].rms.mean).collect() };
    let order = [(0, 1), (1, 2), (0, 2)]
        .iter()
        .map(|(a, b)| spearman(&at(*a), &at(*b)).unwrap_or(f64::NAN))
        .fold(1.0, f64::min);
    Finding::of(
        16,
        Holds::all([
            (falls.is_empty(), "the level does not rise for every sample"),
            (
                slopes.0 >= 0.8 && slopes.1 <= 1.2,
                "a slope lies outside 0.8–1.2",
            ),
            (order > 0.95, "the order of samples changes with speed"),
        ]),
        format!(
            "slopes {:.2} to {:.2}; Spearman between speeds at least {order:.3}",
            slopes.0, slopes.1
        ),
    )
}

fn fingerprint(samples: &[Touched]) -> Finding {
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
        Holds::all([(off.is_empty(), off.join(", ").as_str())]),
        format!("at 10/20/30 mm/s: {} Hz", told.join(", ")),
    )
}

fn active_as_passive(samples: &[Touched], within: Band) -> Finding {
    let shown: Vec<&Touched> = samples
        .iter()
        .filter(|s| s.name != "S1" && s.name != "NO")
        .collect();
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
    let order = both.rms_rank_correlation.unwrap_or(f64::NAN);
    Finding::of(
        18,
        Holds::all([
            (
                apart <= 3.0,
                "a sample's spectra differ by more than 3 dB rms",
            ),
            (order > 0.95, "the order of levels differs"),
        ]),
        format!("at most {apart:.2} dB rms apart ({name}); Spearman of the levels {order:.3}"),
    )
}

fn repeatable(samples: &[Touched]) -> Finding {
    let Some(sample) = named(samples, "S8") else {
        return Finding::of(19, Holds::No("S8 is missing".into()), "–".into());
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
            "; on S1, where the fingerprint stands out, of {near} of {of} around {usual_hz:.0} Hz"
        )
    });
    let centroid = sample.active_summary.centroid_hz;
    Finding::of(
        19,
        Holds::all([
            (
                near == of,
                "the highest line of one stroke over a broad spectrum is a matter of chance: a second and a half holds nine segments, whose lines scatter by a third; the centroid repeats",
            ),
            (variation <= 0.2, "the level varies by more than 20 %"),
        ]),
        format!(
            "S8: the highest line of {near} of {of} strokes lies within ± 10 % of {usual_hz:.0} Hz{s1}; centroid {:.0} ± {:.0} Hz; rms varies by {:.1} %",
            centroid.mean,
            centroid.sd,
            variation * 100.0
        ),
    )
}

/// How often active touch stuck and slipped, in a sentence.
fn stick_slip(samples: &[Touched]) -> String {
    let told: Vec<String> = samples
        .iter()
        .filter_map(|sample| {
            let count = sample.active.slipped;
            (count > 0).then(|| format!("{count} of {ACTIVE_STROKES} on {}", sample.name))
        })
        .collect();
    if told.is_empty() {
        "No active stroke stuck and slipped.".into()
    } else {
        format!(
            "Active strokes that stuck and slipped were left out: {}.",
            told.join(", ")
        )
    }
}

fn frequency() -> Axis {
    Axis::linear("frequency, Hz")
}

fn density() -> Axis {
    Axis::linear("PSD, dB re 1 (m/s²)²/Hz")
}

/// Mean PSDs in one frame.
fn spectra<'a>(
    number: &'static str,
    caption: &str,
    groups: impl Iterator<Item = (String, &'a Summary)>,
) -> Figure {
    Figure {
        number,
        caption: caption.into(),
        shown: Shown::Lines {
            x: frequency(),
            y: density(),
            lines: groups
                .map(|(label, s)| {
                    let points = decibels(&s.psd.mean, s.psd.resolution_hz, 10.0, 600.0);
                    Line::new(label, Mark::Line, points)
                })
                .collect(),
        },
    }
}

fn passive_at<'a>(
    samples: &'a [Touched],
    names: &'a [&'a str],
    speed: usize,
) -> impl Iterator<Item = (String, &'a Summary)> {
    samples
        .iter()
        .filter(|s| names.contains(&s.name.as_str()))
        .map(move |s| (s.name.clone(), &s.passive[speed]))
}

fn active_of<'a>(
    samples: &'a [Touched],
    names: &'a [&'a str],
) -> impl Iterator<Item = (String, &'a Summary)> {
    samples
        .iter()
        .filter(|s| names.contains(&s.name.as_str()))
        .map(|s| (s.name.clone(), &s.active_summary))
}

/// Values of all samples by name.
fn by_sample(
    number: &'static str,
    caption: &str,
    label: &str,
    samples: &[Touched],
    lines: Vec<Line>,
) -> Figure {
    Figure {
        number,
        caption: caption.into(),
        shown: Shown::Lines {
            x: Axis::names("sample", samples.iter().map(|s| s.name.clone())),
            y: Axis::log(label),
            lines,
        },
    }
}

fn figures(samples: &[Touched]) -> Result<Vec<Figure>, ReplayError> {
    let all: Vec<&str> = samples.iter().map(|s| s.name.as_str()).collect();
    let values = |value: fn(&Touched) -> f64| samples.iter().map(value);
    let mut figures = Vec::new();
    if let Some(s8) = named(samples, "S8") {
        figures.extend(strokes_of(s8)?);
    }
    figures.push(spectra(
        "31",
        "Active touch of the 14 isotropic samples: mean PSDs.",
        active_of(samples, &all),
    ));
    figures.push(spectra(
        "32",
        "Passive touch of the 14 isotropic samples at 30 mm/s and 0.2 N: mean PSDs.",
        passive_at(samples, &all, 2),
    ));
    figures.push(by_sample(
        "33",
        "Roughness and level of passive touch at 30 mm/s.",
        "Ra, µm; rms, m/s²",
        samples,
        vec![
            Line::over_names("Ra, µm", values(|s| s.ra_m * 1e6)),
            Line::over_names("rms, m/s²", values(Touched::level)),
        ],
    ));
    figures.push(by_sample(
        "34",
        "Level and friction coefficient of passive touch at 30 mm/s.",
        "rms, m/s²; friction coefficient",
        samples,
        vec![
            Line::over_names("rms, m/s²", values(Touched::level)),
            Line::over_names("friction coefficient", values(friction_of)),
        ],
    ));
    for (number, name) in [("35a", "S1"), ("35b", "S2"), ("35c", "S3")] {
        if let Some(sample) = named(samples, name) {
            let speeds = ["10 mm/s", "20 mm/s", "30 mm/s"];
            let groups = speeds.map(str::to_owned).into_iter().zip(&sample.passive);
            figures.push(spectra(number, &format!("{name} at three speeds."), groups));
        }
    }
    if let Some((_, vibrations)) = named(samples, "S1").and_then(|s| s.shown.as_ref()) {
        let titles = ["S1, 10 mm/s", "S1, 20 mm/s", "S1, 30 mm/s"].map(str::to_owned);
        figures.push(Figure {
            number: "35",
            caption: "The same in time: three strokes over S1 at each speed, one after the other. The fingerprint's comb moves with speed.".into(),
            shown: Shown::Spectrograms(titles.into_iter().zip(vibrations.iter().cloned()).collect()),
        });
    }
    let coarse = ["S1", "S2", "S3"];
    for (number, speed, text) in [
        ("36a", 0, "10 mm/s"),
        ("36b", 1, "20 mm/s"),
        ("36c", 2, "30 mm/s"),
    ] {
        let caption = format!("S1, S2 and S3 at {text}.");
        figures.push(spectra(
            number,
            &caption,
            passive_at(samples, &coarse, speed),
        ));
    }
    figures.push(by_sample(
        "37",
        "Level of passive touch at three speeds.",
        "rms, m/s²",
        samples,
        vec![
            Line::over_names("10 mm/s", values(|s| s.passive[0].rms.mean)),
            Line::over_names("20 mm/s", values(|s| s.passive[1].rms.mean)),
            Line::over_names("30 mm/s", values(|s| s.passive[2].rms.mean)),
        ],
    ));
    let sets: [(&str, &str, &[&str]); 3] = [
        ("38a", "38b", &["S4", "S5", "S6", "S7", "S8"]),
        ("39a", "39b", &["S2", "S3"]),
        ("40a", "40b", &["S9", "S10", "S11", "S12", "S13"]),
    ];
    for (passive, active, names) in sets {
        let listed = names.join(", ");
        figures.push(spectra(
            passive,
            &format!("Passive touch: {listed}."),
            passive_at(samples, names, 2),
        ));
        figures.push(spectra(
            active,
            &format!("Active touch: {listed}."),
            active_of(samples, names),
        ));
    }
    Ok(figures)
}

/// Figures 27–30: the signals of active strokes over one sample, one of them, and all spectra with their mean.
fn strokes_of(sample: &Touched) -> Result<Vec<Figure>, ReplayError> {
    const SHOWN_S: f64 = 9.0;
    let Some((recording, _)) = &sample.shown else {
        return Ok(Vec::new());
    };
    let rate_hz = recording.rate().hz();
    let shown = (SHOWN_S * rate_hz) as usize;
    let mut figures = Vec::new();
    for (number, label, names) in [
        ("27a", "acceleration, m/s²", &["acceleration"][..]),
        ("27b", "force, N", &["force_x", "force_y", "force_z"][..]),
    ] {
        let channels = recording
            .channels()
            .iter()
            .filter(|c| names.contains(&c.name.as_str()));
        let lines = channels
            .map(|channel| {
                let points = channel.samples.iter().take(shown).step_by(4).enumerate();
                let points = points
                    .map(|(i, v)| (4.0 * i as f64 / rate_hz, *v))
                    .collect();
                let label = if names.len() > 1 {
                    channel.name.as_str()
                } else {
                    ""
                };
                Line::new(label, Mark::Thin, points)
            })
            .collect();
        figures.push(Figure {
            number,
            caption: format!(
                "The first strokes over {} as they were recorded.",
                sample.name
            ),
            shown: Shown::Lines {
                x: Axis::linear("time, s"),
                y: Axis::linear(label),
                lines,
            },
        });
    }
    if let Some(stroke) = sample.active.segmentation.strokes.first() {
        let vibration = recording
            .series::<Acceleration>(None)
            .map_err(BenchError::from)?;
        let points = stroke.steady.of(vibration.samples()).iter().enumerate();
        figures.push(Figure {
            number: "29a",
            caption: format!("The steady part of one stroke over {}.", sample.name),
            shown: Shown::Lines {
                x: Axis::linear("time, s"),
                y: Axis::linear("acceleration, m/s²"),
                lines: vec![Line::new(
                    "",
                    Mark::Thin,
                    points.map(|(i, v)| (i as f64 / rate_hz, *v)).collect(),
                )],
            },
        });
    }
    let analysis = &sample.active.analysis;
    let psd = &analysis.psd;
    let step = psd.resolution_hz;
    let mut lines: Vec<Line> = psd
        .each
        .iter()
        .map(|each| Line::new("", Mark::Thin, decibels(each, step, 10.0, 600.0)))
        .collect();
    let mean = decibels(&psd.mean, step, 10.0, 600.0);
    let label = format!("mean of {} strokes", psd.each.len());
    lines.push(Line::new(label, Mark::Line, mean));
    figures.push(Figure {
        number: "30",
        caption: format!("PSDs of all strokes over {} and their mean.", sample.name),
        shown: Shown::Lines {
            x: frequency(),
            y: density(),
            lines,
        },
    });
    Ok(figures)
}
