//! The report of a score: whether a finger could tell, and where.

use maud::{Markup, html};
use piezotact::criterion::Outcome as Judged;
use piezotact::document::Words;
use piezotact::page::limit_text;
use piezotact::quantity::{Decibels, Hertz};
use piezotact::recording::Recording;
use piezotact::score::{BandScore, Difference, Extent, Score, Verdict};

use crate::chart::HEIGHT;
use crate::report::doubts_section;
use crate::{Draw, DrawError};
use crate::{document, figure};
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
    /// Their recordings.
    pub recordings: [&'a Recording; 2],
    /// The score.
    pub score: &'a Score,
}

/// The report as HTML, with doubts in `words`.
///
/// # Errors
/// [`DrawError`] where a figure cannot be drawn.
pub fn html(page: &Page<'_>, words: &dyn Words) -> Result<String, DrawError> {
    let s = page.score;
    let title = format!("Score of {} against {}", page.names[1], page.names[0]);
    let body = html! {
        h1 { (title) }
        p.soft { "A, the reference: " (page.names[0]) ". B, what is compared with it: " (page.names[1]) "." }
        (verdict(s))
        (criteria(s))
        (doubts_section(&s.doubts.merged(), words))
        section {
            h2 { "What both hold, and what of it is felt" }
            (figure(&levels(s)?, "Levels of third octaves, rms; the first and the last are cut at the ends of the band. Dashed: the detection threshold of a tone at that frequency."))
            (figure(&differences(s)?, &format!("Differences of what is felt, B over A, with their 95 % limits. Shaded: below one JND of {} dB; nothing is decided up to {} dB. Grey: not felt.", s.config.level_jnd.0, s.config.level_jnd_high.0.max(s.config.level_jnd.0))))
        }
        (table(s))
        (beside(s))
        (method(s))
        (origin(page))
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
            strong { (s.sentence()) }
            div.numbers {
                (jnd(s.score, "score: the largest of the three"))
                (jnd(s.spectrum, "mean of the bands, by what they excite"))
                (jnd(s.level, "overall level over threshold"))
                (jnd(s.balance, "balance of low and high"))
                (number(format!("{:.1} and {:.1} dB", s.reference_sensation_db, s.test_sensation_db).replace('-', "−"), "A and B over the detection threshold"))
                (number(format!("{:.0} and {:.0} Hz", s.reference_centroid_hz, s.test_centroid_hz), "mean frequency of what A and B excite"))
            }
        }
    }
}

fn criteria(s: &Score) -> Markup {
    html! {
        section {
            h2 { "What decides" }
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
            p.soft { "Below the just-noticeable difference: the first criterion is met, and those of short-time levels are not broken. Distinguishable: neither the first nor that of the halves is met, by all that the recordings allow. Else not decided. The score does not see how a vibration swells and fades, and nothing of its waveform." }
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
                        b.felt_jnd - b.reach_jnd,
                        b.felt_jnd + b.reach_jnd,
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
        colour(of(&|b| b.share > 0.0 && much(b)), "counts much", TEST),
        colour(
            of(&|b| b.share > 0.0 && !much(b)),
            "counts little",
            THRESHOLD,
        ),
        colour(of(&|b| b.share <= 0.0), "not felt", UNFELT),
    ];
    let reach = s
        .bands
        .iter()
        .map(|b| b.felt_jnd.abs() + b.reach_jnd)
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
                tr { th { "band" } th.n { "A, dB" } th.n { "B, dB" } th.n { "threshold, dB" } th.n { "B − A, dB" } th.n { "felt, dB" } th.n { "felt, JND" } th.n { "counts" } }
                @for b in &s.bands {
                    tr {
                        td { (b.band_hz) }
                        td.n { (minus(b.reference_db, 1)) }
                        td.n { (minus(b.test_db, 1)) }
                        td.n { (minus(b.threshold_db, 1)) }
                        td.n { (minus(b.difference_db, 2)) }
                        @if b.share > 0.0 {
                            td.n { (minus(b.felt_db, 2)) }
                            td.n { (format!("{} ± {:.2}", minus(b.felt_jnd, 2), b.reach_jnd)) }
                            td.n { (format!("{:.1} %", b.share * 100.0)) }
                        } @else {
                            td.n.soft { "–" } td.n.soft { "not felt" } td.n.soft { "–" }
                        }
                    }
                }
            } }
            p.soft { "Levels in dB re 1 m/s² rms. Felt: the same over the detection threshold, spread over neighbouring bands as far as frequencies cannot be told apart." }
        }
    }
}

fn minus(value: f64, decimals: usize) -> String {
    format!("{value:.decimals$}").replace('-', "−")
}

/// What is no part of the score.
fn beside(s: &Score) -> Markup {
    let e = &s.spectrum_error;
    html! {
        section {
            h2 { "Beside the score" }
            table {
                tr { th { "spectrum error" } td { (format!("{:.2} dB rms over {}, {:.2} dB at most, at {:.0} Hz; lines {:.2} Hz apart", e.rms_db, s.config.band, e.max_db, e.max_at_hz, e.resolution_hz)) } }
                tr { th { "level error" } td { (minus(s.level_error_db, 2)) " dB, rms in the band" } }
                @if let Some(w) = &s.waveform {
                    tr { th { "waveform" } td { (format!("correlation {}, error {} dB re A (NMSE), B {} by {:.2} ms, over {:.1} s", minus(w.correlation, 3), minus(w.nmse_db, 1), if w.delay_s < 0.0 { "earlier" } else { "later" }, w.delay_s.abs() * 1e3, w.compared_s)) } }
                }
                @if let Some([a_db, b_db]) = s.modulation_db {
                    tr { th { "swelling and fading" } td { (format!("levels of 0.1 s spread by {a_db:.1} dB in A and {b_db:.1} dB in B")) } }
                }
                @if let Some(l) = &s.literature {
                    tr { th { "ST-SIM" } td {
                        @if let Some(value) = l.st_sim.value { (format!("{value:.3}")) } @else { "no real value" }
                        (format!(" (temporal {}, spectral {})", minus(l.st_sim.temporal, 3), minus(l.st_sim.spectral, 3)))
                    } }
                    tr { th { "SPQI" } td { (format!("{:.3}", l.spqi)) } }
                }
            }
            p.soft { "Realisations of one texture have other waveforms and feel the same: a low correlation, ST-SIM or SPQI does not say that a finger could tell. ST-SIM and SPQI are for comparison with the literature." }
            @if let Some(l) = &s.literature {
                p.soft { (format!("Their thresholds are in dB re full scale, not in m/s²: {} m/s² was taken for full scale, with the curve of {}; at 8 kHz, in blocks of 512, {}.", l.config.full_scale_m_s2, match l.config.curve { piezotact::score::literature::LevelCurve::Vibromaf => "vibromaf 0.0.8", piezotact::score::literature::LevelCurve::Mpeg => "MPEG haptic coding" }, match s.extent { Extent::SharedPart => "aligned, since one waveform follows the other", Extent::WholeOfEach => "not aligned, since neither waveform follows the other" })) }
            }
        }
    }
}

fn method(s: &Score) -> Markup {
    let c = &s.config;
    let model = c.model();
    html! {
        section {
            h2 { "How it is computed" }
            p { (format!("One JND is {} dB of level (a fifth in amplitude is 1.58 dB) and {:.0} % of frequency; up to {} dB nothing is decided. Power over the squared detection threshold, spread over third octaves by {:.2} in ln f; what lies below threshold is lifted to it. The score is the largest of three differences: the mean of the bands weighed by what they excite, the overall level, and the mean frequency of what is excited.", c.level_jnd.0, c.frequency_jnd_share * 100.0, c.level_jnd_high.0.max(c.level_jnd.0), c.spreading())) }
            p.soft { (format!("Thresholds: {}. PSDs by Welch's method at {} Hz: {} window, segments of {} samples ({:.2} Hz), {:.0} % overlap, {} segments of the shorter one. Limits: 95 %, from how the segments differ, or its quarters and halves where those differ by more; from what noise of this spectrum would do where segments are fewer than ten; {}.", c.weighting.source(), s.rate_hz, c.welch.window.name(), c.welch.segment, s.rate_hz / c.welch.segment as f64, c.welch.overlap * 100.0, s.segments, match s.extent { Extent::SharedPart => "since B follows A, from their differences at the same time", Extent::WholeOfEach => "A and B are taken for independent" })) }
            p.soft { (model.jnd_source()) "." }
            p.soft { @match &c.contact {
                Some(map) => { "Nail-to-skin map: " (map.source()) "." },
                None => "The thresholds are of skin displacement; no nail-to-skin map was given, so skin is taken to move as the nail does.",
            } }
        }
    }
}

fn origin(page: &Page<'_>) -> Markup {
    html! {
        section {
            h2 { "Where it comes from" }
            table {
                @for (what, recording) in ["A", "B"].iter().zip(page.recordings) {
                    tr { th { (what) } td { (recording.about.provenance.source) ol { @for step in &recording.about.provenance.steps { li { (step) } } } } }
                }
                tr { th { "program" } td { (concat!("piezotact ", env!("CARGO_PKG_VERSION"))) } }
            }
        }
    }
}
