//! Lists of criteria in reports: what was looked at, what was found, the limit, and whether it is met.

use std::fmt::Display;

use maud::{Markup, html};
use piezotact::criterion::{Criterion, Limit, Outcome};

/// A number with as many digits as tell it from its limit.
pub(super) fn number(value: f64, unit: &str) -> String {
    let size = value.abs();
    let digits = match size {
        _ if size >= 100.0 => 1,
        _ if size >= 10.0 => 2,
        _ if size >= 0.01 || value == 0.0 => 3,
        _ => return format!("{value:.1e}{}{unit}", space(unit)).replace('-', "−"),
    };
    let text = format!("{value:.digits$}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    format!("{text}{}{unit}", space(unit)).replace('-', "−")
}

fn space(unit: &str) -> &'static str {
    if unit.is_empty() || unit == "°" {
        ""
    } else {
        "\u{a0}"
    }
}

/// What differs by less is equal but for rounding.
const ROUNDING: f64 = 1e-6;

/// A limit in words, with the range in which nothing is decided.
pub(super) fn limit_text(limit: Limit, unit: &str) -> String {
    let value = number(limit.value(), unit);
    let other = number(limit.not_met_from(), unit);
    match limit {
        Limit::AtMost { met, not_met } if met < not_met => {
            format!("at most {value}; from there to {other} not decided")
        }
        Limit::AtLeast { met, not_met } if not_met < met => {
            format!("at least {value}; from there to {other} not decided")
        }
        Limit::AtMost { met: 0.0, .. } => "none".into(),
        Limit::AtMost { .. } => format!("at most {value}"),
        Limit::AtLeast { .. } => format!("at least {value}"),
        Limit::Within { reach } if reach < ROUNDING => "no difference".into(),
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
        let nb = |text: &str| text.replace(" dB", "\u{a0}dB");
        assert_eq!(
            limit_text(range, "dB"),
            nb("at most 1.5 dB; from there to 2.5 dB not decided")
        );
        assert_eq!(limit_text(Limit::at_least(0.9), ""), "at least 0.9");
        assert_eq!(limit_text(Limit::at_most(0.0), ""), "none");
        assert_eq!(
            limit_text(Limit::Within { reach: 1e-9 }, "°"),
            "no difference"
        );
        let numbers = [15.0, -0.25, 0.0, 120.04, 0.000_05].map(|value| number(value, ""));
        assert_eq!(numbers, ["15", "−0.25", "0", "120", "5.0e−5"]);
    }
}
