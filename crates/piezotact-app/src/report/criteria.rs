//! Lists of criteria in reports: what was looked at, what was found, the limit, and whether it is met.

use std::fmt::Display;

use maud::{Markup, html};
use piezotact::criterion::{Criterion, Limit, Outcome};

/// A number with as many digits as tell it from its limit.
pub(super) fn number(value: f64, unit: &str) -> String {
    let size = value.abs();
    let digits = match size {
        _ if value.fract() == 0.0 && size < 1e6 => 0,
        _ if size >= 100.0 => 1,
        _ if size >= 10.0 => 2,
        _ if size >= 0.01 => 3,
        _ => return format!("{value:.1e}{}{unit}", space(unit)).replace('-', "−"),
    };
    format!("{value:.digits$}{}{unit}", space(unit)).replace('-', "−")
}

fn space(unit: &str) -> &'static str {
    if unit.is_empty() || unit == "°" {
        ""
    } else {
        "\u{a0}"
    }
}

/// A limit in words.
pub(super) fn limit_text(limit: Limit, unit: &str) -> String {
    let value = number(limit.value(), unit);
    let other = limit.not_met_from();
    match limit {
        Limit::AtMost { met, not_met } if met < not_met => {
            format!("at most {value}; not met above {}", number(other, unit))
        }
        Limit::AtLeast { met, not_met } if not_met < met => {
            format!("at least {value}; not met below {}", number(other, unit))
        }
        Limit::AtMost { .. } => format!("at most {value}"),
        Limit::AtLeast { .. } => format!("at least {value}"),
        Limit::Within { .. } => format!("within ±{value}"),
    }
}

/// The outcome, in a cell: what is not met stands out.
pub(super) fn outcome(outcome: Outcome) -> Markup {
    html! {
        @match outcome {
            Outcome::Met => { (outcome.word()) }
            Outcome::NotMet => { strong { (outcome.word()) } }
            Outcome::NotDecided => { em { (outcome.word()) } }
        }
    }
}

/// What was found.
pub(super) fn found<W>(criterion: &Criterion<W>) -> String {
    criterion.found.map_or_else(
        || "not measured".into(),
        |found| number(found, &criterion.unit),
    )
}

/// A list of criteria, one a line, as it stands in a cell of a table.
pub(super) fn list<'a, W: 'a>(
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
pub(super) fn named_list<'a, W: Display + 'a>(
    criteria: impl IntoIterator<Item = &'a Criterion<W>>,
) -> Markup {
    list(criteria, W::to_string)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_say_where_they_are_met_and_where_not() {
        let range = Limit::AtMost {
            met: 1.5,
            not_met: 2.5,
        };
        assert_eq!(
            limit_text(range, "dB"),
            "at most 1.500\u{a0}dB; not met above 2.500\u{a0}dB"
        );
        assert_eq!(limit_text(Limit::at_least(0.9), ""), "at least 0.900");
        assert_eq!(
            limit_text(Limit::Within { reach: 1e-9 }, "°"),
            "within ±1.0e−9°"
        );
        assert_eq!(number(15.0, ""), "15");
    }
}
