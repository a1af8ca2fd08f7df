//! The report of `replay`: what the thesis claims, what the twin gave, and the counterparts of its figures.

use maud::{Markup, PreEscaped, html};
use piezotact::criterion::{Criterion, Outcome};
use piezotact::document::Words;
use piezotact::figure::Figure;
use piezotact::warning::Merged;

use piezotact_report::{DrawError, broad_document, criteria, origin, svg};

/// What a report on a replay shows.
#[derive(Clone, Debug)]
pub(super) struct Page<'a> {
    /// What everything was drawn with.
    pub(super) seed: u64,
    /// The name of the laboratory's own parameter file; absent without one.
    pub(super) twin: Option<String>,
    pub(super) changes: &'a [String],
    /// Every claim of the thesis.
    pub(super) claims: Vec<ClaimRow<'a>>,
    /// How many panels meet each claim; absent where one panel alone was measured.
    pub(super) panels: Option<PanelPart<'a>>,
    /// The chapters that were measured again.
    pub(super) chapters: Vec<ChapterPart<'a>>,
}

/// What a replay says of a claim.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Standing {
    /// It holds.
    Holds,
    /// It does not, or in part.
    DoesNot,
    /// Nothing measures it yet.
    NotYet,
    /// It belongs to a chapter that was not asked for.
    NotAsked,
}

impl Standing {
    /// The standing in words.
    #[must_use]
    pub(super) fn word(self) -> &'static str {
        match self {
            Self::Holds => "holds",
            Self::DoesNot => "does not hold",
            Self::NotYet => "not yet",
            Self::NotAsked => "not selected",
        }
    }

    /// A sign that goes before the word, and its class.
    fn sign(self) -> (&'static str, &'static str) {
        match self {
            Self::Holds => ("✓", "holds"),
            Self::DoesNot => ("✗", "does-not"),
            Self::NotYet => ("…", "not-yet"),
            Self::NotAsked => ("–", "not-asked"),
        }
    }
}

/// A claim of the thesis with what was found of it.
#[derive(Clone, Debug)]
pub(super) struct ClaimRow<'a> {
    pub(super) number: u8,
    /// The chapter of the thesis.
    pub(super) chapter: u8,
    /// Where it stands there.
    pub(super) at: &'a str,
    pub(super) says: &'a str,
    /// The sentence of the thesis that the criterion follows, where it is quoted.
    pub(super) quote: Option<&'a str>,
    /// What holds it, in numbers.
    pub(super) holds_if: &'a str,
    /// What the replay says of it.
    pub(super) standing: Standing,
    /// Whether the replay measured or mentions it.
    pub(super) is_found: bool,
    /// What was measured; empty where nothing was.
    pub(super) measured: &'a str,
    /// Why it does not hold, or what brings it; empty where nothing is to say.
    pub(super) why: String,
    /// What the verdict follows from, each named by what the measurements would say were it not met.
    pub(super) criteria: Vec<Criterion<String>>,
}

/// How many panels meet each claim.
#[derive(Clone, Debug)]
pub(super) struct PanelPart<'a> {
    /// How many were counted.
    pub(super) panels: usize,
    /// The seed of the first; the others follow it.
    pub(super) first_seed: u64,
    pub(super) rows: Vec<PanelRow<'a>>,
}

/// How many panels meet a claim.
#[derive(Clone, Debug)]
pub(super) struct PanelRow<'a> {
    pub(super) number: u8,
    pub(super) says: &'a str,
    /// In how many panels it holds.
    pub(super) held: usize,
    /// In how many it was measured.
    pub(super) of: usize,
    /// The 95 % interval of the share, 0–1.
    pub(super) interval: Option<[f64; 2]>,
    /// Whether that is enough; not decided by a few panels.
    pub(super) enough: Outcome,
    /// How its criteria are counted where that is not all of them in one panel, in words.
    pub(super) decided: Option<&'a str>,
    /// What some panels miss.
    pub(super) misses: Vec<PanelMiss<'a>>,
}

/// What some panels miss.
#[derive(Clone, Debug)]
pub(super) struct PanelMiss<'a> {
    /// How many panels, the limit and the distances from it, in words.
    pub(super) by: String,
    /// What is the case in them, and why.
    pub(super) why: &'a str,
}

/// A chapter that was measured again.
#[derive(Clone, Debug)]
pub(super) struct ChapterPart<'a> {
    /// Its number in the thesis.
    pub(super) number: u8,
    /// What it is about.
    pub(super) title: &'a str,
    /// What was measured, in sentences.
    pub(super) measured: &'a [String],
    /// How many of its claims hold, in words.
    pub(super) tally: String,
    pub(super) claims: Vec<ClaimRow<'a>>,
    /// The counterparts of its figures, each with its number.
    pub(super) figures: Vec<(&'a str, &'a Figure)>,
    pub(super) warnings: &'a [Merged],
    /// What is not there yet.
    pub(super) missing: &'a [String],
}

/// The height of a chart in the page.
const HEIGHT: u32 = 400;

/// The report as HTML, with warnings in `words`.
///
/// # Errors
/// [`DrawError`] where a figure cannot be drawn.
pub(super) fn html(page: &Page<'_>, words: &dyn Words) -> Result<String, DrawError> {
    let title = "The thesis, measured again";
    let chapters = page.chapters.iter();
    let chapters: Vec<Markup> = chapters
        .map(|chapter| chapter_section(chapter, words))
        .collect::<Result<_, _>>()?;
    let body = html! {
        h1 { (title) }
        p.soft { (bench_line(page)) }
        (overview(page))
        @if let Some(panels) = &page.panels { (panel_section(panels)) }
        @for chapter in &chapters { (chapter) }
        (without_finding(page))
        (origin_of(page))
    };
    Ok(broad_document(title, &body))
}

fn bench_line(page: &Page<'_>) -> String {
    let numbers = match (page.changes.len(), &page.twin) {
        (changes, Some(file)) => format!("{} changed by {file}", plural(changes, "parameter")),
        (_, None) => "built-in parameters".into(),
    };
    format!(
        "Digital twin: no hardware and no person took part. Seed {}, {numbers}.",
        page.seed
    )
}

fn plural(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

fn overview(page: &Page<'_>) -> Markup {
    let counted = |standing: Standing| {
        let same = page.claims.iter().filter(|row| row.standing == standing);
        same.count()
    };
    let number = |count: usize, what: &str| html! { div { b { (count) } span { (what) } } };
    let not_asked = counted(Standing::NotAsked);
    html! {
        section {
            h2 { "Claims" }
            p { "The statements of the thesis on its measurements are written here as " (page.claims.len()) " claims, each with a numerical criterion, and with the sentence that the criterion follows where it is quoted. The measurements were repeated on the digital twin and analysed like any other recording." }
            p { "Levels, friction, and their dependence on speed and force are inputs of the twin, set within the values of the \
                thesis: claims about them test the analysis, not the physics. The results are those of one panel; where a claim \
                has little margin, another seed can give a different result." }
            div.numbers {
                (number(counted(Standing::Holds), "✓ holds"))
                (number(counted(Standing::DoesNot), "✗ does not hold"))
                (number(counted(Standing::NotYet), "… not yet: no measurement exists"))
                @if not_asked > 0 { (number(not_asked, "– not selected: another chapter")) }
            }
            @for chapter in 2..=6 {
                @let of_chapter = page.claims.iter().filter(|row| row.chapter == chapter);
                div.claims {
                    span.soft { "Chapter " (chapter) }
                    div {
                        @for claim in of_chapter {
                            @let (sign, class) = claim.standing.sign();
                            a.(class) href=(format!("#claim-{}", claim.number)) title=(claim.says) {
                                b { (claim.number) } " " (sign) " " (claim.standing.word())
                            }
                        }
                    }
                }
            }
        }
    }
}

/// How many panels meet each claim, and what is missed by how much, and why.
fn panel_section(part: &PanelPart<'_>) -> Markup {
    let enough = part
        .rows
        .iter()
        .filter(|row| row.enough == Outcome::Met)
        .count();
    let interval = |row: &PanelRow<'_>| {
        let percent = |share: f64| format!("{:.0}", share * 100.0);
        row.interval
            .map(|[low, high]| format!("{}–{} %", percent(low), percent(high)))
    };
    html! {
        section {
            h2 { "Panels" }
            p { "Everything was drawn again with " (plural(part.panels, "seed")) ", from seed " (part.first_seed) " on: other people, \
                surfaces, movements and noise. A claim is met here when all its criteria are met together in nine of ten panels, which fewer than 20 do not decide; " (enough) " of "
                (plural(part.rows.len(), "claim")) " are. The interval says what other panels may give (95 %). Where a panel misses a \
                criterion, the last column has the distance from its limit, and the mean and standard deviation over all panels." }
            table.panel-table {
                tr { th.n { "claim" } th { "the thesis says" } th { "panels that hold" } th { "nine in ten" } th { "what the others miss, by how much, and why" } }
                @for row in &part.rows {
                    @let (sign, class) = match row.enough {
                        Outcome::Met => Standing::Holds.sign(),
                        Outcome::NotMet => Standing::DoesNot.sign(),
                        Outcome::NotDecided => Standing::NotYet.sign(),
                    };
                    tr {
                        td.n { a href=(format!("#claim-{}", row.number)) { (row.number) } }
                        td { (row.says) }
                        td {
                            (row.held) " of " (row.of)
                            @if let Some(interval) = interval(row) { br; span.soft { (interval) } }
                            @if let Some(decided) = row.decided { p.why { (decided) } }
                        }
                        td { span.state.(class) { (sign) " " (match row.enough { Outcome::Met => "yes", Outcome::NotMet => "no", Outcome::NotDecided => "not decided" }) } }
                        td { @if row.misses.is_empty() { "–" } @else { @for miss in &row.misses { p.miss { (miss.by) br; span.why { (miss.why) } } } } }
                    }
                }
            }
        }
    }
}

fn claim_heading() -> Markup {
    html! { tr { th.n { "claim" } th { "the thesis says" } th { "holds if" } th { "measured on the twin" } th { "verdict" } } }
}

fn claim_row(claim: &ClaimRow<'_>) -> Markup {
    let (sign, class) = claim.standing.sign();
    let (why, measured) = match claim.measured {
        "" => (&claim.why, "–"),
        measured => (&claim.why, measured),
    };
    html! {
        tr id=(format!("claim-{}", claim.number)) {
            td.n { (claim.number) }
            td {
                (claim.says) " " span.soft { "(" (claim.at) ")" }
                @if let Some(quote) = claim.quote { p.why { "“" (quote) "”" } }
            }
            td { (claim.holds_if) }
            td { (measured) }
            td { span.state.(class) { (sign) " " (claim.standing.word()) } @if !why.is_empty() { p.why { (why) } } (criteria_of(&claim.criteria)) }
        }
    }
}

/// What the verdict follows from.
fn criteria_of(criteria: &[Criterion<String>]) -> Markup {
    let not_met = criteria
        .iter()
        .filter(|c| c.outcome != Outcome::Met)
        .count();
    let of = criteria.len();
    html! {
        @if !criteria.is_empty() {
            details {
                summary.why {
                    @if not_met == 0 { (plural(of, "criterion").replace("criterions", "criteria")) " met" }
                    @else { (not_met) " of " (plural(of, "criterion").replace("criterions", "criteria")) " not met" }
                }
                p.why { "Each criterion is named by the statement that would be true if it were not met." }
                (criteria::list(criteria, |unless_met| format!("“{unless_met}”")))
            }
        }
    }
}

fn chapter_section(chapter: &ChapterPart<'_>, words: &dyn Words) -> Result<Markup, DrawError> {
    let mut drawn = Vec::new();
    for (number, figure) in &chapter.figures {
        drawn.push((number, figure, svg(figure, HEIGHT)?));
    }
    Ok(html! {
        section {
            h2 { "Chapter " (chapter.number) ": " (chapter.title) }
            @for sentence in chapter.measured { p { (sentence) } }
            p.soft { (chapter.tally) "." }
            table.claim-table {
                (claim_heading())
                @for claim in &chapter.claims { (claim_row(claim)) }
            }
            @if !chapter.warnings.is_empty() {
                h3 { "Warnings" }
                ul.warnings { @for warning in chapter.warnings { li { (words.merged(warning)) } } }
            }
            @if !chapter.missing.is_empty() {
                h3 { "Figures that are not repeated here" }
                ul { @for missing in chapter.missing { li { (missing) } } }
            }
            div.counterparts {
                @for (i, (number, figure, svg)) in drawn.iter().enumerate() {
                    figure.first[begins_family(&chapter.figures, i)] {
                        h3 { "Counterpart of figure " (number) }
                        (PreEscaped(svg))
                        figcaption { (figure.caption) }
                    }
                }
            }
        }
    })
}

/// Whether figure `i` is the first of several with one number, such as 38a before 38b: they stand side by side.
fn begins_family(figures: &[(&str, &Figure)], i: usize) -> bool {
    let family = |i: usize| {
        let (number, _) = figures.get(i)?;
        Some(number.trim_end_matches(|c: char| c.is_ascii_alphabetic()))
    };
    family(i + 1) == family(i) && (i == 0 || family(i - 1) != family(i))
}

/// Claims that no chapter of this replay speaks of.
fn without_finding(page: &Page<'_>) -> Markup {
    let none: Vec<_> = page.claims.iter().filter(|claim| !claim.is_found).collect();
    html! {
        @if !none.is_empty() {
            section {
                h2 { "Claims that were not measured" }
                table.claim-table {
                    (claim_heading())
                    @for claim in none { (claim_row(claim)) }
                }
            }
        }
    }
}

fn origin_of(page: &Page<'_>) -> Markup {
    let changes = page.changes;
    let parameters = html! {
        @if changes.is_empty() { "built-in" } @else {
            "changed" @if let Some(file) = &page.twin { " by " (file) } ":"
            (origin::steps(changes))
        }
    };
    let rows = html! {
        (origin::row("thesis", &html! { "L. Felicetti, " i { "Analysis and rendering of contact vibrational stimuli for tactile perception" } ", INSA Lyon and Sapienza Università di Roma, 2024" }))
        (origin::row("bench", &format!("digital twin, seed {}", page.seed)))
        (origin::row("parameters", &parameters))
    };
    origin::section("Origin of the data", &rows)
}
