//! The report of `replay`: what the thesis claims, what the twin gave, and the counterparts of its figures.

use std::path::Path;

use maud::{Markup, PreEscaped, html};
use piezotact::criterion::Outcome as Judged;
use piezotact::figure::Drawn;
use piezotact_replay::{CLAIMS, Chapter, Claim, Figure, Finding, Replay, Verdict};

use piezotact_report::Draw as _;

use super::{broad_document, name};
use crate::advice::merged_text;
use crate::failure::Outcome;

/// What a report on a replay shows.
pub(crate) struct Page<'a> {
    pub(crate) replay: &'a Replay,
    /// The laboratory's own parameter file.
    pub(crate) twin: Option<&'a Path>,
    pub(crate) chapters: &'a [Chapter],
}

/// The height of a chart in the page.
const HEIGHT: u32 = 400;

fn draw(figure: &Figure) -> Outcome<String> {
    Ok(match figure.drawn()? {
        Drawn::Chart(chart) => chart.svg(HEIGHT)?,
        Drawn::Spectrograms(all) => piezotact_report::spectrogram::svg(&all)?,
        Drawn::Heatmap(map) => piezotact_report::heatmap::svg(&map)?,
    })
}

/// A verdict in words.
pub(crate) fn word(verdict: &Verdict) -> &'static str {
    match verdict {
        Verdict::Holds => "holds",
        Verdict::DoesNot { .. } => "does not hold",
        Verdict::NotYet { .. } => "not yet",
    }
}

/// How many claims hold, do not hold, and cannot be measured yet.
pub(crate) fn tally<'a>(findings: impl IntoIterator<Item = &'a Finding>) -> String {
    let words: Vec<&str> = findings.into_iter().map(|f| word(&f.verdict)).collect();
    let counts = ["holds", "does not hold", "not yet"].map(|verdict| {
        let same = words.iter().filter(|word| **word == verdict);
        format!("{verdict} {}", same.count())
    });
    format!("{}: {}", plural(words.len(), "claim"), counts.join(", "))
}

/// What a replay says of a claim.
#[derive(Clone, Copy)]
enum Standing<'a> {
    Found(&'a Finding),
    /// Nothing measures it yet.
    NotYet,
    /// It belongs to a chapter that was not asked for.
    NotAsked,
}

impl Standing<'_> {
    fn word(self) -> &'static str {
        match self {
            Self::Found(finding) => word(&finding.verdict),
            Self::NotYet => "not yet",
            Self::NotAsked => "not asked for",
        }
    }

    /// A sign that goes before the word, and its class.
    fn sign(self) -> (&'static str, &'static str) {
        match self {
            Self::Found(finding) => match finding.verdict {
                Verdict::Holds => ("✓", "holds"),
                Verdict::DoesNot { .. } => ("✗", "does-not"),
                Verdict::NotYet { .. } => ("…", "not-yet"),
            },
            Self::NotYet => ("…", "not-yet"),
            Self::NotAsked => ("–", "not-asked"),
        }
    }
}

impl<'a> Page<'a> {
    fn standing(&self, claim: &Claim) -> Standing<'a> {
        let mut findings = self.chapters.iter().flat_map(|chapter| &chapter.findings);
        let all_asked = self.chapters.len() == Replay::CHAPTERS.len();
        match findings.find(|finding| finding.claim == claim.number) {
            Some(finding) => Standing::Found(finding),
            None if all_asked => Standing::NotYet,
            None => Standing::NotAsked,
        }
    }
}

/// The report as HTML text.
pub(crate) fn render(page: &Page<'_>) -> Outcome<String> {
    let title = "The thesis, measured again";
    let mut chapters = Vec::new();
    for chapter in page.chapters {
        chapters.push(chapter_section(chapter)?);
    }
    let body = html! {
        h1 { (title) }
        p.soft { (bench_line(page)) }
        (overview(page))
        @for chapter in &chapters { (chapter) }
        (without_finding(page))
        (origin(page))
    };
    Ok(broad_document(title, &body))
}

fn bench_line(page: &Page<'_>) -> String {
    let numbers = match (page.replay.parameters.changes().len(), page.twin) {
        (changes, Some(file)) => {
            format!("{} changed by {}", plural(changes, "parameter"), name(file))
        }
        (_, None) => "built-in parameters".into(),
    };
    format!(
        "Digital twin: no hardware and no person took part. Seed {}, {numbers}.",
        page.replay.seed
    )
}

fn plural(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

fn overview(page: &Page<'_>) -> Markup {
    let standings = CLAIMS.map(|claim| (claim, page.standing(&claim)));
    let counted = |class: &str| {
        let same = standings.iter().filter(|(_, s)| s.sign().1 == class);
        same.count()
    };
    let number = |count: usize, what: &str| html! { div { b { (count) } span { (what) } } };
    let not_asked = counted("not-asked");
    html! {
        section {
            h2 { "Claims" }
            p { "The thesis says of its measurements what can be put as " (CLAIMS.len()) " claims, each with a criterion in numbers. The measurements were made again on the twin and analysed as any recording is." }
            p { "Levels, friction, and how they follow speed and force are put into the twin, within what the thesis says: claims on them test the analysis, not the physics. What is found belongs to one panel; where a claim has little margin another seed finds otherwise." }
            div.numbers {
                (number(counted("holds"), "✓ holds"))
                (number(counted("does-not"), "✗ does not hold"))
                (number(counted("not-yet"), "… not yet: nothing measures it"))
                @if not_asked > 0 { (number(not_asked, "– not asked for: another chapter")) }
            }
            @for chapter in 2..=6 {
                @let of_chapter = standings.iter().filter(|(claim, _)| claim.chapter == chapter);
                div.claims {
                    span.soft { "Chapter " (chapter) }
                    div {
                        @for (claim, standing) in of_chapter {
                            @let (sign, class) = standing.sign();
                            a.(class) href=(format!("#claim-{}", claim.number)) title=(claim.says) {
                                b { (claim.number) } " " (sign) " " (standing.word())
                            }
                        }
                    }
                }
            }
        }
    }
}

fn claim_heading() -> Markup {
    html! { tr { th.n { "claim" } th { "the thesis says" } th { "holds if" } th { "measured on the twin" } th { "verdict" } } }
}

fn claim_row(claim: &Claim, standing: Standing<'_>) -> Markup {
    let (sign, class) = standing.sign();
    let (measured, why) = match standing {
        Standing::Found(finding) => (
            finding.measured.as_str(),
            match &finding.verdict {
                Verdict::Holds => String::new(),
                Verdict::DoesNot { reason } => reason.clone(),
                Verdict::NotYet { with } => format!("comes with {with}"),
            },
        ),
        Standing::NotYet | Standing::NotAsked => ("–", String::new()),
    };
    html! {
        tr id=(format!("claim-{}", claim.number)) {
            td.n { (claim.number) }
            td { (claim.says) " " span.soft { "(" (claim.at) ")" } }
            td { (claim.holds_if) }
            td { (measured) }
            td { span.state.(class) { (sign) " " (standing.word()) } @if !why.is_empty() { p.why { (why) } } (criteria_of(standing)) }
        }
    }
}

/// What the verdict follows from.
fn criteria_of(standing: Standing<'_>) -> Markup {
    let criteria = match standing {
        Standing::Found(finding) => finding.criteria.as_slice(),
        Standing::NotYet | Standing::NotAsked => &[],
    };
    let not_met = criteria.iter().filter(|c| c.outcome != Judged::Met).count();
    let of = criteria.len();
    html! {
        @if !criteria.is_empty() {
            details {
                summary.why {
                    @if not_met == 0 { (plural(of, "criterion").replace("criterions", "criteria")) " met" }
                    @else { (not_met) " of " (plural(of, "criterion").replace("criterions", "criteria")) " not met" }
                }
                p.why { "Each is named by what the measurements would say were it not met." }
                (super::criteria::list(criteria, |rule| format!("“{}”", rule.unless_met)))
            }
        }
    }
}

fn chapter_section(chapter: &Chapter) -> Outcome<Markup> {
    let mut drawn = Vec::new();
    for figure in &chapter.figures {
        drawn.push((figure, draw(figure)?));
    }
    Ok(html! {
        section {
            h2 { "Chapter " (chapter.number) ": " (chapter.title) }
            @for sentence in &chapter.measured { p { (sentence) } }
            p.soft { (tally(&chapter.findings)) "." }
            table.claim-table {
                (claim_heading())
                @for finding in &chapter.findings {
                    @if let Some(claim) = CLAIMS.iter().find(|claim| claim.number == finding.claim) {
                        (claim_row(claim, Standing::Found(finding)))
                    }
                }
            }
            @if !chapter.doubts.is_empty() {
                h3 { "Doubts" }
                ul.doubts { @for doubt in &chapter.doubts { li { (merged_text(doubt)) } } }
            }
            @if !chapter.missing.is_empty() {
                h3 { "Not there yet" }
                ul { @for missing in &chapter.missing { li { (missing) } } }
            }
            div.counterparts {
                @for (i, (figure, svg)) in drawn.iter().enumerate() {
                    figure.first[begins_family(&chapter.figures, i)] {
                        h3 { "Counterpart of figure " (figure.number) }
                        (PreEscaped(svg))
                        figcaption { (figure.caption) }
                    }
                }
            }
        }
    })
}

/// Whether figure `i` is the first of several with one number, such as 38a before 38b: they stand side by side.
fn begins_family(figures: &[Figure], i: usize) -> bool {
    let family = |i: usize| {
        let figure = figures.get(i)?;
        Some(
            figure
                .number
                .trim_end_matches(|c: char| c.is_ascii_alphabetic()),
        )
    };
    family(i + 1) == family(i) && (i == 0 || family(i - 1) != family(i))
}

/// Claims that no chapter of this replay speaks of.
fn without_finding(page: &Page<'_>) -> Markup {
    let standings = CLAIMS.map(|claim| (claim, page.standing(&claim)));
    let none: Vec<_> = standings
        .iter()
        .filter(|(_, standing)| !matches!(standing, Standing::Found(_)))
        .collect();
    html! {
        @if !none.is_empty() {
            section {
                h2 { "Claims that were not measured" }
                table.claim-table {
                    (claim_heading())
                    @for (claim, standing) in none { (claim_row(claim, *standing)) }
                }
            }
        }
    }
}

fn origin(page: &Page<'_>) -> Markup {
    let changes = page.replay.parameters.changes();
    html! {
        section {
            h2 { "Where it comes from" }
            table {
                tr { th { "thesis" } td { "L. Felicetti, " i { "Analysis and rendering of contact vibrational stimuli for tactile perception" } ", INSA Lyon and Sapienza Università di Roma, 2024" } }
                tr { th { "bench" } td { "digital twin, seed " (page.replay.seed) } }
                tr {
                    th { "parameters" }
                    td {
                        @if changes.is_empty() { "built-in" } @else {
                            "changed" @if let Some(file) = page.twin { " by " (name(file)) } ":"
                            ol { @for change in changes { li { (change) } } }
                        }
                    }
                }
                tr { th { "program" } td { (concat!("piezotact ", env!("CARGO_PKG_VERSION"))) } }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezotact::Doubt;
    use piezotact::doubt::merged_of;
    use piezotact::recording::RecordingDoubt;
    use piezotact_replay::{Axis, Line, Mark, Scale, Shown};
    use piezotact_twin::TwinParameters;

    fn finding(claim: u8, verdict: Verdict) -> Finding {
        Finding {
            claim,
            measured: format!("measured of {claim}"),
            verdict,
            criteria: Vec::new(),
        }
    }

    fn figure(number: &'static str) -> Figure {
        let axis = |scale| Axis {
            label: "Ra & rms".into(),
            scale,
        };
        let line = |mark| Line {
            label: format!("{mark:?}"),
            points: vec![(0.0, 0.0), (1.0, 2.0)],
            mark,
        };
        let marks = [
            Mark::Dots,
            Mark::Line,
            Mark::Thin,
            Mark::Dashed,
            Mark::Joined,
        ];
        Figure {
            number,
            caption: "A caption.".into(),
            shown: Shown::Lines {
                x: axis(Scale::Names(vec!["S1".into(), "NO".into()])),
                y: axis(Scale::Logarithmic),
                lines: marks.map(line).into(),
            },
        }
    }

    /// Every claim has a row that the overview leads to, whatever became of it.
    #[test]
    fn every_claim_has_its_row() {
        let replay = Replay {
            parameters: TwinParameters::built_in(),
            seed: 7,
        };
        let does_not = Verdict::DoesNot {
            reason: "too loud".into(),
        };
        // Advice names the command line's option, as everywhere.
        let uncalibrated = Doubt::from(RecordingDoubt::Uncalibrated {
            channel: "a".into(),
        });
        let doubt = merged_of([(Some("S8"), &uncalibrated)]).remove(0);
        let chapter = Chapter {
            number: 4,
            title: "Rendering",
            measured: vec!["Somebody touched.".into()],
            findings: vec![
                finding(20, Verdict::Holds),
                finding(21, does_not),
                finding(24, Verdict::NotYet { with: "people" }),
                finding(34, Verdict::Holds),
            ],
            figures: vec![figure("47a"), figure("47b"), figure("48")],
            doubts: vec![doubt],
            missing: vec!["figure 51".into()],
        };
        let page = Page {
            replay: &replay,
            twin: None,
            chapters: &[chapter],
        };
        let html = render(&page).ok().unwrap();
        for claim in CLAIMS {
            let (row, link) = (
                format!("id=\"claim-{}\"", claim.number),
                format!("#claim-{}\"", claim.number),
            );
            assert_eq!(html.matches(&row).count(), 1, "{row}");
            assert_eq!(html.matches(&link).count(), 1, "{link}");
        }
        for part in [
            "4 claims: holds 2, does not hold 1, not yet 1.",
            "too loud",
            "comes with people",
            "<li>S8: ",
            "(--scale)",
            "<li>figure 51</li>",
            "Counterpart of figure 47b",
            "Seed 7, built-in parameters.",
        ] {
            assert!(html.contains(part), "{part}");
        }
        // Neither was asked for.
        let standing = |number: u8| page.standing(&CLAIMS[usize::from(number) - 1]).word();
        assert_eq!(
            [standing(33), standing(1)],
            ["not asked for", "not asked for"]
        );
        // 47a begins a row of two; 48 stands alone.
        assert_eq!(html.matches("<figure class=\"first\">").count(), 1);
    }
}
