//! Lists of criteria in reports: what was looked at, what was found, the limit, and whether it is met.

use std::fmt::Display;

use maud::{Markup, html};
use piezotact::criterion::{Criterion, Outcome};
use piezotact::page::{limit_number, limit_text};

/// The outcome, in a cell: what is not met stands out.
pub fn outcome(outcome: Outcome) -> Markup {
    html! {
        @match outcome {
            Outcome::Met => { (outcome.word()) }
            Outcome::NotMet => { strong { (outcome.word()) } }
            Outcome::NotDecided => { em { (outcome.word()) } }
        }
    }
}

/// What was found.
pub fn found<W>(criterion: &Criterion<W>) -> String {
    criterion.found.map_or_else(
        || "not measured".into(),
        |found| limit_number(found, &criterion.unit),
    )
}

/// A list of criteria, one a line, as it stands in a cell of a table.
pub fn list<'a, W: 'a>(
    criteria: impl IntoIterator<Item = &'a Criterion<W>>,
    name: impl Fn(&W) -> String,
) -> Markup {
    html! {
        ul.criteria {
            @for criterion in criteria {
                li {
                    (name(&criterion.what)) ": " (found(criterion)) " (" (limit_text(criterion.limit, &criterion.unit)) "), "
                    (outcome(criterion.outcome))
                }
            }
        }
    }
}

/// As [`list`], of rules that name themselves.
pub fn named_list<'a, W: Display + 'a>(
    criteria: impl IntoIterator<Item = &'a Criterion<W>>,
) -> Markup {
    list(criteria, W::to_string)
}
