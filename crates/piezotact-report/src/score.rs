//! The report of a score: whether a finger could tell, and where.

use maud::{Markup, html};
use piezotact::criterion::Outcome as Judged;
use piezotact::document::Words;
use piezotact::number::signed;
use piezotact::page::limit_text;
use piezotact::quantity::{Decibels, Hertz};
use piezotact::recording::Recording;
use piezotact::score::{BandScore, Difference, Extent, Score, Verdict};

use crate::chart::HEIGHT;
use crate::report::warnings_section;
use crate::{Draw, DrawError};
use crate::{document, figure, origin};
use piezotact::figure::{Axis, Chart, Line, Mark, Tone, range};

const REFERENCE: Tone = Tone::Reference;
const TEST: Tone = Tone::Main;
const THRESHOLD: Tone = Tone::Second;
const UNFELT: Tone = Tone::Pale;

/// What a report of a score shows.
#[derive(Clone, Copy, Debug)]
pub struct Page<'a> {
    /// The names of A, the reference, and of B.
    pub names: [&'a str; 2],
    pub recordings: [&'a Recording; 2],
    pub score: &'a Score,
}

/// The report as HTML, with warnings in `words`.
///
/// # Errors
/// [`DrawError`] where a figure cannot be drawn.
pub fn html(page: &Page<'_>, words: &dyn Words) -> Result<String, DrawError> {
    let s = page.score;
    let title = format!("Score of {} against {}", page.names[1], page.names[0]);
    let body = html! {
        h1 { (title) }
        p.soft { "A, the reference: " (page.names[0]) ". B, the test: " (page.names[1]) "." }
        (verdict(s))
        (criteria(s))
        (warnings_section(&s.warnings.merged(), words))
        section {
            h2 { "Third-octave levels and perceptual differences" }
            (figure(&levels(s)?, "Levels of third octaves, rms; the first and the last are cut at the ends of the band. Dashed: the detection threshold of a tone at that frequency."))
            (figure(&differences(s)?, &format!("Perceptual differences, B relative to A, with their 95 % limits. Shaded: below \
                one JND of {} dB; differences up to {} dB are not decided. Grey: below the detection \
                threshold.", s.config.level_jnd.0, s.config.level_jnd_high.0.max(s.config.level_jnd.0))))
        }
        (table(s))
        (beside(s))
        (method(s))
        (origin_of(page))
    };
    Ok(document(&title, &body))
}

fn limits(d: Difference) -> String {
    format!("{:.2}–{:.2}", d.low_jnd, d.high_jnd)
}

fn verdict(s: &Score) -> Markup {
    let number = |value: String, what: &str| html! { div { b { (value) } span { (what) } } };
    let class = match s.verdict {
        Verdict::BelowJnd => "verdict",
        Verdict::Distinguishable { .. } => "verdict failed",
        Verdict::NotDecided { .. } => "verdict open",
    };
    let jnd = |d: Difference, what: &str| {
        number(
            format!("{:.2} JND", d.jnd),
            &format!("{what} (95 %: {})", limits(d)),
        )
    };
    html! {
        section class=(class) {
            strong { (s.sentence) }
            div.numbers {
                (jnd(s.score, "score: the largest of the next three"))
                (jnd(s.spectrum, "mean over the bands, weighted by excitation"))
                (jnd(s.level, "overall sensation level"))
                (jnd(s.balance, "balance of low and high frequencies"))
                (number(format!("{:.1} and {:.1} dB", s.reference_sensation_db, s.test_sensation_db).replace('-', "−"), "sensation levels of A and B (re the detection threshold)"))
                (number(format!("{:.0} and {:.0} Hz", s.reference_centroid_hz, s.test_centroid_hz), "mean frequencies of the excitation by A and B"))
            }
        }
    }
}

fn criteria(s: &Score) -> Markup {
    html! {
        section {
            h2 { "Criteria" }
            table {
                tr { th { "criterion" } th.n { "found" } th.n { "95 %" } th { "limit" } th { "outcome" } }
                @for c in &s.criteria {
                    tr {
                        td { (c.what) }
                        td.n { (c.found.map_or("–".into(), |v| format!("{v:.2} {}", c.unit))) }
                        td.n { (c.interval.map_or("–".into(), |[low, high]| format!("{low:.2}–{high:.2}"))) }
                        td { (limit_text(c.limit, &c.unit)) }
                        td { @if c.outcome == Judged::Met { b { (c.outcome.word()) } } @else { (c.outcome.word()) } }
                    }
                }
            }
            p.soft { "“Below the just-noticeable difference”: the first criterion is met, and no criterion on short-time levels \
                is violated. “Distinguishable”: neither the first criterion nor that on the halves is met anywhere within the \
                95 % limits. Otherwise “not decided”. The score takes account neither of changes of level over time nor of the \
                waveform." }
        }
    }
}

fn span(s: &Score) -> (f64, f64) {
    (s.config.band.low().0 * 0.8, s.config.band.high().0 * 1.25)
}

fn levels(s: &Score) -> Result<String, DrawError> {
    let (from, to) = span(s);
    let of = |level: &dyn Fn(&BandScore) -> f64| -> Vec<(f64, f64)> {
        s.bands.iter().map(|b| (b.centre_hz, level(b))).collect()
    };
    let (a, b) = (of(&|b| b.reference_db), of(&|b| b.test_db));
    let threshold: Vec<(f64, f64)> = (0..=240)
        .map(|i| from * (to / from).powf(f64::from(i) / 240.0))
        .map(|f| {
            let threshold_m_s2 = s.config.weighting.threshold_m_s2(Hertz(f));
            (f, Decibels::from_amplitude_ratio(threshold_m_s2).0)
        })
        .collect();
    let (low, high) = range(&[&a, &b], from, to, 10.0, 70.0);
    // As much of the threshold as there is room for: it rises far above what anything here reaches.
    let lowest = threshold.iter().map(|(_, db)| *db).fold(f64::MAX, f64::min);
    let high = (high + 10.0).max((lowest / 10.0).ceil() * 10.0 + 10.0);
    let low = low.min((lowest / 10.0).floor() * 10.0);
    let shown = threshold.into_iter().filter(|(_, db)| *db <= high);
    let lines = vec![
        Line::new("A", REFERENCE, a).marked(Mark::Joined),
        Line::new("B", TEST, b).marked(Mark::Joined),
        Line::new("threshold", THRESHOLD, shown.collect()).marked(Mark::Dashed),
    ];
    Chart::new(
        Axis::log("frequency, Hz", from, to),
        Axis::new("level, dB re 1 m/s² rms", low, high),
        lines,
    )
    .beside()
    .svg(HEIGHT + 60)
}

fn differences(s: &Score) -> Result<String, DrawError> {
    let (from, to) = span(s);
    // Half of what counts most counts much.
    let most = s.bands.iter().map(|b| b.share).fold(0.0, f64::max);
    let of = |felt: &dyn Fn(&BandScore) -> bool| -> Line {
        let chosen: Vec<&BandScore> = s.bands.iter().filter(|b| felt(b)).collect();
        Line::new(
            "",
            TEST,
            chosen.iter().map(|b| (b.centre_hz, b.felt_jnd)).collect(),
        )
        .marked(Mark::Dots)
        .spread(
            chosen
                .iter()
                .map(|b| {
                    (
                        b.centre_hz,
                        b.felt_jnd - b.ci_half_width_jnd,
                        b.felt_jnd + b.ci_half_width_jnd,
                    )
                })
                .collect(),
        )
    };
    let colour = |mut line: Line, label: &str, colour: Tone| {
        label.clone_into(&mut line.label);
        line.tone = colour;
        line
    };
    let much = |b: &BandScore| b.share >= 0.25 * most;
    let zone = Line::new("", TEST, Vec::new()).ribbon(vec![(from, -1.0, 1.0), (to, -1.0, 1.0)]);
    let lines = vec![
        zone,
        colour(of(&|b| b.share > 0.0 && much(b)), "large weight", TEST),
        colour(
            of(&|b| b.share > 0.0 && !much(b)),
            "small weight",
            THRESHOLD,
        ),
        colour(of(&|b| b.share <= 0.0), "below threshold", UNFELT),
    ];
    let reach = s
        .bands
        .iter()
        .map(|b| b.felt_jnd.abs() + b.ci_half_width_jnd)
        .fold(1.5, f64::max)
        .min(20.0)
        * 1.1;
    Chart {
        levels: vec![0.0],
        ..Chart::new(
            Axis::log("frequency, Hz", from, to),
            Axis::new("B over A, JND", -reach, reach),
            lines,
        )
        .beside()
    }
    .svg(HEIGHT)
}

fn table(s: &Score) -> Markup {
    html! {
        section {
            h2 { "Third octaves" }
            div.wide { table {
                tr { th { "band" } th.n { "A, dB" } th.n { "B, dB" } th.n { "threshold, dB" } th.n { "B − A, dB" } th.n { "sensation, dB" } th.n { "sensation, JND" } th.n { "weight" } }
                @for b in &s.bands {
                    tr {
                        td { (b.band_hz) }
                        td.n { (minus(b.reference_db, 1)) }
                        td.n { (minus(b.test_db, 1)) }
                        td.n { (minus(b.threshold_db, 1)) }
                        td.n { (minus(b.difference_db, 2)) }
                        @if b.share > 0.0 {
                            td.n { (minus(b.felt_db, 2)) }
                            td.n { (format!("{} ± {:.2}", minus(b.felt_jnd, 2), b.ci_half_width_jnd)) }
                            td.n { (format!("{:.1} %", b.share * 100.0)) }
                        } @else {
                            td.n.soft { "–" } td.n.soft { "below threshold" } td.n.soft { "–" }
                        }
                    }
                }
            } }
            p.soft { "Levels in dB re 1 m/s² rms. Sensation: the difference B − A of the sensation levels (levels above the \
                detection threshold), spread over neighbouring bands whose frequencies cannot be distinguished." }
        }
    }
}

fn minus(value: f64, decimals: usize) -> String {
    signed(value, decimals)
}

/// What is no part of the score.
fn beside(s: &Score) -> Markup {
    let e = &s.spectrum_error;
    html! {
        section {
            h2 { "Other measures, not part of the score" }
            table {
                tr { th { "spectrum error" } td { (format!("{:.2} dB rms over {}, {:.2} dB at most, at {:.0} Hz; lines {:.2} Hz apart", e.rms_db, s.config.band, e.max_db, e.max_at_hz, e.resolution_hz)) } }
                tr { th { "level error" } td { (minus(s.level_error_db, 2)) " dB, rms in the band" } }
                @if let Some(w) = &s.waveform {
                    tr { th { "waveform" } td { (format!("correlation {}, error {} dB re A (NMSE), B {} by {:.2} ms, over {:.1} s", minus(w.correlation, 3), minus(w.nmse_db, 1), if w.delay_s < 0.0 { "earlier" } else { "later" }, w.delay_s.abs() * 1e3, w.compared_s)) } }
                }
                @if let Some([a_db, b_db]) = s.modulation_db {
                    tr { th { "level over time" } td { (format!("spread of the levels of 0.1 s: {a_db:.1} dB in A and {b_db:.1} dB in B")) } }
                }
                @if let Some(l) = &s.literature {
                    tr { th { "ST-SIM" } td {
                        @if let Some(value) = l.st_sim.value { (format!("{value:.3}")) } @else { "no real value" }
                        (format!(" (temporal {}, spectral {})", minus(l.st_sim.temporal, 3), minus(l.st_sim.spectral, 3)))
                    } }
                    tr { th { "SPQI" } td { (format!("{:.3}", l.spqi)) } }
                }
            }
            p.soft { "Two realisations of one texture have different waveforms but feel the same: a low correlation, ST-SIM or \
                SPQI does not mean that a finger could distinguish them. ST-SIM and SPQI are for comparison with the \
                literature." }
            @if let Some(l) = &s.literature {
                p.soft { (format!("Their thresholds are in dB re full scale, not in m/s²: {} m/s² was used as full scale, with \
                    the curve of {}; at 8 kHz, in blocks of \
                    512, {}.", l.config.full_scale_m_s2, match l.config.curve { piezotact::score::literature::LevelCurve::Vibromaf => "vibromaf 0.0.8", piezotact::score::literature::LevelCurve::Mpeg => "MPEG haptic coding" }, match s.extent { Extent::SharedPart => "aligned, since one waveform follows the other", Extent::WholeOfEach => "not aligned, since neither waveform follows the other" })) }
            }
        }
    }
}

fn method(s: &Score) -> Markup {
    let c = &s.config;
    let model = c.model();
    html! {
        section {
            h2 { "Methods" }
            p { (format!("One JND is {} dB of level (a fifth in amplitude is 1.58 dB) and {:.0} % of frequency; differences up \
                to {} dB are not decided. The excitation is the power divided by the squared detection threshold, spread over \
                third octaves by {:.2} in ln f; values below threshold are set to the threshold. The score is the largest of \
                three differences: the mean over the bands weighted by their excitation, the overall sensation level, and the \
                mean frequency of the excitation.", c.level_jnd.0, c.frequency_jnd_share * 100.0, c.level_jnd_high.0.max(c.level_jnd.0), c.spreading())) }
            p.soft { (format!("Thresholds: {}. PSDs by Welch's method at {} Hz: {} window, segments of {} samples ({:.2} Hz), {:.0} % overlap, {} segments of the shorter one. 95 % limits: from the differences between segments, or between quarters and halves of the recording where these are larger; with fewer than ten segments, from the scatter of noise with this spectrum; {}.", c.weighting.source(), s.rate_hz, c.welch.window.name(), c.welch.segment, s.rate_hz / c.welch.segment as f64, c.welch.overlap * 100.0, s.segments, match s.extent { Extent::SharedPart => "since B follows A, from their differences at the same instants", Extent::WholeOfEach => "A and B are assumed to be independent" })) }
            p.soft { (model.jnd_source()) "." }
            p.soft { @match &c.contact {
                Some(map) => { "Nail-to-skin map: " (map.source()) "." },
                None => "The thresholds are for skin displacement. No nail-to-skin map was given, so the skin is assumed to \
                    move with the nail.",
            } }
        }
    }
}

fn origin_of(page: &Page<'_>) -> Markup {
    let rows = html! {
        @for (what, recording) in ["A", "B"].iter().zip(page.recordings) {
            @let provenance = &recording.about.provenance;
            (origin::traced(what, &provenance.source, &provenance.steps))
        }
    };
    origin::section("Origin of the data", &rows)
}
