//! The report of association matrices: what was presented, and what it was declared to be.

use maud::{Markup, html};
use piezotact::criterion::Outcome;
use piezotact::document::Words;
use piezotact::number::signed;
use piezotact::warning::merged;
use piezotact_people::association::{
    Asked, Association, AssociationMatrix, Cell, Ordering, PairOutcome, Row,
};
use piezotact_people::difference::Difference;

use crate::felt::felt_section;
use crate::grid::{Grid, Shade, Square};
use crate::report::{drawn_table, warnings_section};
use crate::{DrawError, bars, document, figure};

/// As many pairs stand in a report; the table of pairs has all of them.
const PAIRS: usize = 40;

/// The report as HTML, with warnings in `words`; `name` says whose answers they are.
///
/// # Errors
/// [`DrawError`] where a figure or a table cannot be drawn.
pub fn html(name: &str, found: &Association, words: &dyn Words) -> Result<String, DrawError> {
    let title = format!("Association matrices of {name}");
    let mut sections = Vec::new();
    for group in &found.matrices {
        let by = found.config.by.map_or("", |by| by.name());
        let heading = match group.group.as_str() {
            "all" => "Association matrix of all answers".to_owned(),
            group => format!("Association matrix of {by} {group}"),
        };
        let share = group
            .expected
            .as_ref()
            .map(|share| format!("{} answers: {}.", share.answers, share.words()));
        sections.push(matrix_section(
            found,
            &heading,
            share.as_deref(),
            &group.matrix,
        )?);
    }
    let body = html! {
        h1 { (title) }
        section class=(class(found)) {
            p { strong { (found.sentence()) } }
            @for sentence in found.asked.iter().flat_map(|asked| asked.sentences()) { p { (sentence) } }
            p.soft {
                "A percentage is how often an association was declared, over how often the stimulus was presented. \
                 Intervals are 95 %, of Clopper and Pearson, with the effective number of answers of Korn and Graubard (1998): they \
                 allow for participants who differ. Chance: one over the number of samples that could be answered."
            }
        }
        (warnings_section(&merged(&found.warnings), words))
        @if let Some(asked) = &found.asked { (tasks(asked)?) }
        (comparisons(found))
        @for section in &sections { (section) }
        (pairs(found)?)
        @if let Some(felt) = &found.felt { (felt_section(felt)?) }
        @for ordering in &found.orderings { (ordering_section(ordering)?) }
        p.soft { (concat!("piezotact ", env!("CARGO_PKG_VERSION"))) }
    };
    Ok(document(&title, &body))
}

/// What was found in each task of a study, and which judge the answers of virtual volunteers show.
fn tasks(asked: &Asked) -> Result<Markup, DrawError> {
    Ok(html! {
        section {
            h2 { "What was found, task by task" }
            (drawn_table(&asked.table())?)
            @if let Some(sentence) = &asked.which_sentence {
                h3 { "Which judge the answers show" }
                p { (sentence) "." }
            }
            @if let Some(table) = asked.judges_table() {
                (drawn_table(&table)?)
                p.soft {
                    "Judges are ways of answering by what was delivered to the nail; noise, weight and lapses of each are fitted. AICc: \
                     Akaike's criterion for small samples. A judge is named where its weight is at least 0.99, it predicts participants who \
                     were held out best, and its fit is not refuted; fewer than four participants decide nothing. An order counts as one \
                     answer."
                }
            }
        }
    })
}

/// The differences that were asked for.
fn comparisons(found: &Association) -> Markup {
    let mut differences = found.comparisons.iter().map(|one| &one.difference);
    let of_samples = differences.any(|of| matches!(of, Difference::Samples(_)));
    html! {
        @if !found.comparisons.is_empty() {
            section {
                h2 { "Differences" }
                ul { @for one in &found.comparisons { li { (one.sentence()) } } }
                p.soft {
                    "Each participant is one number; signs of paired differences, or groups of people, are exchanged in all ways, or in \
                     99 999. That nothing is decided does not show that two are alike."
                    @if of_samples {
                        " Told apart better than by guessing: right answers are more frequent than the other's name, over both samples \
                         together. A pair can be that and still be confused: one of the two may often be called the other."
                    }
                }
            }
        }
    }
}

/// Green only where the answers are shown to be better than guesses.
fn class(found: &Association) -> &'static str {
    match found.expected.first().map(|share| share.criterion.outcome) {
        Some(Outcome::Met) => "verdict",
        Some(Outcome::NotMet) => "verdict failed",
        Some(Outcome::NotDecided) | None => "verdict open",
    }
}

/// The heat map of the matrix of all answers as SVG text for a file of its own.
///
/// # Errors
/// [`DrawError`] where there is no matrix.
pub fn svg(found: &Association) -> Result<String, DrawError> {
    let matrix = found.all().ok_or_else(|| DrawError::Drawing {
        reason: "expected a matrix, found none".into(),
    })?;
    Ok(grid_of(found, matrix).single())
}

fn matrix_section(
    found: &Association,
    heading: &str,
    share: Option<&str>,
    matrix: &AssociationMatrix,
) -> Result<Markup, DrawError> {
    let untested = matrix.rows.iter().flat_map(|row| &row.cells);
    let untested = untested.filter(|cell| !cell.is_tested()).count();
    let hatched = match untested {
        0 => String::new(),
        count => format!(
            " Hatched: untested, as the stimulus was never presented while this sample could be answered ({count} cells); this is not 0 %."
        ),
    };
    let flagged = match matrix.rows.iter().any(|row| row.flagged > 0) {
        true => " Dot: some of these answers are of flagged trials.",
        false => "",
    };
    Ok(html! {
        section {
            h2 { (heading) }
            @if let Some(share) = share { p { strong { (share) } } }
            (figure(&grid_of(found, matrix).svg(), &format!(
                "Rows: the stimulus that was presented. Columns: the sample that it was declared to be. Numbers: %. Outlined: the \
                 expected association.{hatched}{flagged}"
            )))
            (figure(&bars::svg(matrix), "The same as bars. Dark: the expected associations; red: the others. Grey tiles: untested. Bars can hide others: the numbers are those above."))
            (values(matrix))
        }
    })
}

fn grid_of(found: &Association, matrix: &AssociationMatrix) -> Grid {
    let square = |row: &Row, cell: &Cell| Square {
        shade: cell.percent.map_or(Shade::Untested, Shade::Percent),
        outlined: cell.answered == row.stimulus.expected,
        dotted: cell.flagged > 0,
    };
    Grid {
        rows: matrix
            .rows
            .iter()
            .map(|r| r.stimulus.name.clone())
            .collect(),
        columns: matrix.samples.clone(),
        squares: matrix
            .rows
            .iter()
            .map(|row| row.cells.iter().map(|cell| square(row, cell)).collect())
            .collect(),
        row_label: match found.virtual_answers {
            0 => "presented".into(),
            all if all == found.answers => "presented to virtual volunteers".into(),
            _ => "presented, in part to virtual volunteers".into(),
        },
        column_label: "declared as".into(),
        scale_label: "association, %".into(),
        hatched_label: "untested".into(),
    }
}

/// The matrix as numbers: percentages with counts and intervals.
fn values(matrix: &AssociationMatrix) -> Markup {
    html! {
        details {
            summary { "Counts and 95 % intervals" }
            div.wide tabindex="0" role="region" aria-label="Table" {
                table.association {
                    tr {
                        th scope="col" { "presented" } th.n scope="col" { "times" }
                        @for sample in &matrix.samples { th.n scope="col" { (sample) } }
                    }
                    @for row in &matrix.rows {
                        tr {
                            td { b { (row.stimulus.name) } }
                            td.n { (row.presented) }
                            @for cell in &row.cells { (value(row, cell)) }
                        }
                    }
                }
            }
            p.soft { "Each cell: %, its interval, and declared / presented. n/a: untested. No interval: too few participants." }
        }
    }
}

fn value(row: &Row, cell: &Cell) -> Markup {
    let exact = cell.percent.map_or("n/a".into(), |value| value.to_string());
    html! {
        td.n data-presented=(row.stimulus.name) data-answered=(cell.answered) data-value=(exact) {
            @match cell.percent {
                None => { "n/a" },
                Some(percent) => {
                    b { (format!("{percent:.1}")) }
                    @if let Some([low, high]) = cell.interval_percent {
                        br; span.soft { (format!("{low:.0}–{high:.0}")) }
                    }
                    br; span.soft { (format!("{}/{}", cell.declared, row.presented)) }
                },
            }
        }
    }
}

fn pairs(found: &Association) -> Result<Markup, DrawError> {
    let confused = found.pairs.iter();
    let confused = confused.filter(|pair| pair.outcome == PairOutcome::Confused);
    let names: Vec<String> = confused.map(|pair| pair.pair.join(" – ")).collect();
    let text = match names.len() {
        0 => "No pair is shown to be confused.".to_owned(),
        _ => format!("Confused: {}.", names.join(", ")),
    };
    let mut table = found.pairs_table();
    let all = table.rows.len();
    table.rows.truncate(PAIRS);
    let shown = if all > PAIRS {
        format!(" The first {PAIRS} of {all} tested pairs.")
    } else {
        String::new()
    };
    Ok(html! {
        section {
            h2 { "Confused pairs" }
            p { strong { (text) } }
            p.soft {
                "A pair is confused where, of the presentations of both together, a quarter or more are declared to be the other: two \
                 samples that feel the same are confused half of the time, and who guesses among three names the other in a third. Not confused: the whole 95 % interval lies below that, and right answers are shown to be more frequent than the other's name. Not decided: anything else; more participants narrow it. Of a hundred such intervals \
                 about five do not hold the true share."
                (shown)
            }
            @if all > 0 { (drawn_table(&table)?) }
        }
    })
}

fn ordering_section(ordering: &Ordering) -> Result<Markup, DrawError> {
    let tau_text = |tau: Option<f64>| tau.map_or("–".into(), |tau| signed(tau, 3));
    Ok(html! {
        section {
            h2 { "Orders of task " (ordering.task) }
            p { strong { (ordering.sentence()) } }
            p.soft {
                "One sample in the wrong place shifts all others: the places then say that nothing is right, while most pairs are in \
                 order. τ counts pairs: 1 all in order, 0 none more than by chance, −1 all reversed."
            }
            (figure(&places(ordering).svg(), "How often each sample (row) was put in each place (column) of its set, % of its orders. Outlined: its declared place, where all samples are ordered together."))
            (figure(&dominance(ordering).svg(), "How often the sample of the row was put before that of the column, % of the orders of both. In the declared order all above the diagonal is 100 %. Hatched: never ordered together."))
            div.wide tabindex="0" role="region" aria-label="Table" {
                table {
                    tr { th scope="col" { "participant" } th scope="col" { "session" } th scope="col" { "set" } th.n scope="col" { "τ" } th.n scope="col" { "in place" } th scope="col" { "order" } }
                    @for repetition in &ordering.repetitions {
                        tr {
                            td { (repetition.participant) }
                            td { (repetition.session) }
                            td { (repetition.set) }
                            td.n { (tau_text(repetition.tau)) }
                            td.n { (repetition.in_place) " of " (repetition.order.len()) }
                            td { (repetition.order.join(" ")) }
                        }
                    }
                }
            }
        }
    })
}

fn places(ordering: &Ordering) -> Grid {
    let widest = ordering.repetitions.iter().map(|r| r.order.len()).max();
    let widest = widest.unwrap_or(0);
    let squares = ordering.places.iter().enumerate().map(|(i, row)| {
        let all: usize = row.iter().sum();
        let row = row.iter().take(widest).enumerate();
        row.map(|(place, count)| Square {
            shade: match all {
                0 => Shade::Untested,
                all => Shade::Percent(100.0 * *count as f64 / all as f64),
            },
            outlined: place == i && widest == ordering.samples.len(),
            dotted: false,
        })
        .collect()
    });
    Grid {
        rows: ordering.samples.clone(),
        columns: (1..=widest).map(|place| place.to_string()).collect(),
        squares: squares.collect(),
        row_label: "sample".into(),
        column_label: "place".into(),
        scale_label: "orders, %".into(),
        hatched_label: "untested".into(),
    }
}

fn dominance(ordering: &Ordering) -> Grid {
    let squares = ordering.dominance.iter().enumerate().map(|(i, row)| {
        let row = row.iter().enumerate();
        row.map(|(j, pair)| Square {
            shade: match pair.together {
                _ if i == j => Shade::Blank,
                0 => Shade::Untested,
                together => Shade::Percent(100.0 * pair.before as f64 / together as f64),
            },
            outlined: false,
            dotted: false,
        })
        .collect()
    });
    Grid {
        rows: ordering.samples.clone(),
        columns: ordering.samples.clone(),
        squares: squares.collect(),
        row_label: "put before".into(),
        column_label: "the other".into(),
        scale_label: "orders, %".into(),
        hatched_label: "untested".into(),
    }
}
