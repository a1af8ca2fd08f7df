//! The report of a campaign's design: what is asked, what it can show, its faults and better plans.

use maud::{Markup, html};
use piezotact::criterion::Outcome;
use piezotact::figure::{Axis, Chart, Line, Tone};
use piezotact_people::campaign::design::{
    BetterPlan, Change, PairCoverage, PowerPoint, PowerStudy,
};
use piezotact_people::campaign::overview::CampaignDesign;
use piezotact_people::difference::Difference;

use crate::criteria::{found, outcome};
use crate::grid::{Grid, Shade, Square};
use crate::report::drawn_table;
use crate::{DrawError, chart, document, figure};

/// A page shows the matrix of pairs of up to so many samples; the table has all of them.
const MATRIX_SAMPLES: usize = 40;

/// The report as HTML.
///
/// # Errors
/// [`DrawError`] where a table cannot be drawn.
pub fn html(design: &CampaignDesign) -> Result<String, DrawError> {
    let title = format!("Design of {}", design.title);
    let class = match design.outcome() {
        Outcome::Met => "verdict",
        Outcome::NotMet => "verdict failed",
        Outcome::NotDecided => "verdict open",
    };
    let body = html! {
        h1 { (title) }
        p.soft { "Protocol " (design.protocol) ", from " (design.source) ". Seed of simulations: " (design.report.seed) "." }
        section class=(class) {
            p { strong { (design.sentence()) } }
            p { (design.asked_sentence()) " " (design.judged_sentence()) }
        }
        (faults(design))
        (time(design)?)
        (pairs(design)?)
        (chance(design)?)
        @if let Some(study) = &design.power { (power(study)?) }
        (rules(design))
        p.soft { (concat!("piezotact ", env!("CARGO_PKG_VERSION"))) }
    };
    Ok(document(&title, &body))
}

fn faults(design: &CampaignDesign) -> Markup {
    let faults = &design.report.faults;
    html! {
        @if !faults.is_empty() {
            section {
                h2 { "Faults and better plans" }
                table.faults {
                    tr { th { "fault" } th { "better plan" } th { "its cost" } }
                    @for found in faults {
                        tr {
                            td { (found.fault) }
                            @match &found.better {
                                None => { td { "none known" } td { "–" } },
                                Some(better) => {
                                    td { (sentence(&better.change.to_string())) }
                                    td { (sentence(&better.cost())) }
                                },
                            }
                        }
                    }
                }
                @for found in faults {
                    @if let Some(better) = &found.better { (details(design, better)) }
                }
            }
        }
    }
}

/// A text as a sentence.
fn sentence(text: &str) -> String {
    let mut letters = text.chars();
    let first = letters.next().map(|first| first.to_uppercase().to_string());
    format!("{}{}.", first.unwrap_or_default(), letters.as_str())
}

/// The sets or the orders of a better plan.
fn details(design: &CampaignDesign, better: &BetterPlan) -> Markup {
    let half_of = |set: usize, halves: &[Vec<usize>]| {
        let half = halves.iter().position(|half| half.contains(&set));
        half.map_or("–".to_owned(), |half| (half + 1).to_string())
    };
    match &better.change {
        Change::Sets { sets, halves, .. } => html! {
            details {
                summary { "The " (sets.len()) " sets" }
                div.wide {
                    table.sets {
                        tr { th { "set" } th { "samples" } th { "of participant, where two share the sets" } }
                        @for (i, set) in sets.iter().enumerate() {
                            tr { td { (i + 1) } td { (set.join(", ")) } td { (half_of(i, halves)) } }
                        }
                    }
                }
            }
        },
        Change::EarlierMeasurement { orders } => html! {
            details {
                summary { "The " (orders.len()) " orders of tasks" }
                ol { @for order in orders { li { (order.join(", ")) } } }
                p.soft { "Now: " (orders_now(design)) "." }
            }
        },
        _ => html! {},
    }
}

fn orders_now(design: &CampaignDesign) -> String {
    let orders = design.campaign.task_orders.iter();
    let orders: Vec<String> = orders.map(|order| order.join(", ")).collect();
    orders.join("; ")
}

fn time(design: &CampaignDesign) -> Result<Markup, DrawError> {
    Ok(html! {
        section {
            h2 { "Time of each participant" }
            p { strong { (design.time_sentence()) } }
            p.soft { "Trials are a mean where sequences have several lengths." }
            (drawn_table(&design.sessions_table())?)
        }
    })
}

fn pairs(design: &CampaignDesign) -> Result<Markup, DrawError> {
    let (Some(coverage), Some(sentence), Some(table)) = (
        &design.report.coverage,
        design.pairs_sentence(),
        design.pairs_table(),
    ) else {
        return Ok(html! {
            section {
                h2 { "Pairs of samples" }
                p { "No task uses sets: no pair of samples is presented in a set." }
            }
        });
    };
    let samples = &design.report.samples;
    let hatched = match coverage.never.is_empty() {
        true => "",
        false => " Hatched: never, so that this cell of an association matrix stays untested.",
    };
    Ok(html! {
        section {
            h2 { "Pairs of samples" }
            p { strong { (sentence) } }
            @if samples.len() <= MATRIX_SAMPLES {
                (figure(&coverage_grid(samples, coverage).svg(), &format!("In how many sets both samples are together.{hatched}")))
            }
            details {
                summary { "Sets of each sample, and the samples that it is never together with" }
                (drawn_table(&table)?)
            }
        }
    })
}

fn coverage_grid(samples: &[String], coverage: &PairCoverage) -> Grid {
    let most = coverage.counts.iter().flatten().max().copied().unwrap_or(1);
    let squares = coverage.counts.iter().enumerate().map(|(i, row)| {
        let row = row.iter().enumerate();
        row.map(|(j, count)| Square {
            shade: match count {
                _ if i == j => Shade::Blank,
                0 => Shade::Untested,
                count => Shade::Count(*count, most),
            },
            outlined: false,
            dotted: false,
        })
        .collect()
    });
    Grid {
        rows: samples.to_vec(),
        columns: samples.to_vec(),
        squares: squares.collect(),
        row_label: "sample".into(),
        column_label: "together with".into(),
        scale_label: "sets".into(),
        hatched_label: "never".into(),
    }
}

fn chance(design: &CampaignDesign) -> Result<Markup, DrawError> {
    let precision = design.precision_sentences();
    Ok(html! {
        section {
            h2 { "Chance and precision" }
            @if design.report.chance.is_empty() {
                p { "No task has answers that are right or wrong." }
            } @else {
                (drawn_table(&design.chance_table())?)
                p.soft { (design.chance_note()) }
            }
            @if !precision.is_empty() {
                h3 { "With the planned number of participants" }
                ul { @for sentence in &precision { li { (sentence) } } }
            }
        }
    })
}

/// How often a stated difference is found, with its curves and those of the precision of a cell.
fn power(study: &PowerStudy) -> Result<Markup, DrawError> {
    let most = study.curves.iter().flatten();
    let most = most
        .map(|point| point.found.participants)
        .max()
        .unwrap_or(1) as f64;
    let lines = |of: fn(&PowerPoint) -> f64| {
        let curves = study.curves.iter().enumerate();
        let lines = curves.map(|(index, curve)| {
            let label = match curve.first().map_or(1, |point| point.found.times) {
                1 => "as designed".to_owned(),
                times => format!("{times} times the presentations"),
            };
            let points = curve.iter();
            let points = points.map(|point| (point.found.participants as f64, 100.0 * of(point)));
            let tone = Tone::Of {
                index,
                count: study.curves.len(),
            };
            Line::new(label, tone, points.collect())
        });
        lines.collect::<Vec<_>>()
    };
    let each = match study.question.difference {
        Difference::People(_) => "participants in each group",
        _ => "participants",
    };
    let found = Chart {
        levels: vec![100.0 * study.wanted_share],
        ..Chart::new(
            Axis::new(each, 0.0, most),
            Axis::new("campaigns that find it, %", 0.0, 100.0),
            lines(|point| point.found.power_share),
        )
    };
    let widest = study.curves.iter().flatten();
    let widest = widest.map(|point| 100.0 * point.half_width_share);
    let precision = Chart::new(
        Axis::new(each, 0.0, most),
        Axis::new(
            "half-width of a cell, points",
            0.0,
            widest.fold(10.0, f64::max),
        ),
        lines(|point| point.half_width_share),
    );
    Ok(html! {
        section {
            h2 { "Power" }
            @for sentence in study.sentences() { p { (sentence) } }
            (figure(&chart::svg(&found, 320)?, "How often the difference is found, over the number of participants. Line: what is wanted."))
            (figure(&chart::svg(&precision, 320)?, "The mean half-width of the 95 % interval of a cell of the association matrix, for the first of the two shares."))
            p.soft { "Each point: " (study.planned.campaigns) " simulated campaigns." }
            details {
                summary { "The same as a table" }
                (drawn_table(&study.table())?)
            }
        }
    })
}

fn rules(design: &CampaignDesign) -> Markup {
    let criteria = &design.report.criteria;
    html! {
        @if !criteria.is_empty() {
            section {
                h2 { "Rules" }
                table.judged {
                    tr { th { "rule" } th.n { "found" } th { "95 % interval" } th { "limit" } th { "outcome" } }
                    @for rule in criteria {
                        tr {
                            td { (rule.what) }
                            td.n { (found(rule)) }
                            td {
                                @match rule.interval {
                                    Some([low, high]) => { (format!("{low:.3} to {high:.3}")) },
                                    None => { "–" },
                                }
                            }
                            td { (piezotact::page::limit_text(rule.limit, &rule.unit)) }
                            td { (outcome(rule.outcome)) }
                        }
                    }
                }
                p.soft { "The 95 % interval is that of the simulation. A rule is not decided where it contains the limit." }
            }
        }
    }
}
