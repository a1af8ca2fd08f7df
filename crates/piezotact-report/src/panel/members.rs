//! Which measurements are members of a panel and its averages, and which were asked for again, in the report.

use std::cmp::Ordering;

use maud::{Markup, html};
use piezotact::criterion::{Criterion, Limit, Outcome as Judged};
use piezotact::page::limit_text;
use piezotact::panel::{FiledMeasurement, Member, MemberCriterion};
use piezotact::run::{Attempt, RunCriterion};

use super::{Page, plural};
use crate::criteria::{found, named_list, outcome};

/// As many measurements are listed one by one.
const LISTED: usize = 12;

pub(super) fn section(page: &Page<'_>) -> Markup {
    let said = page.analysed.analysis;
    let reported: Vec<&Member> = said
        .members
        .iter()
        .filter(|member| member.outcome() != Judged::Met)
        .collect();
    let partly: Vec<_> = said
        .attendances
        .iter()
        .filter(|one| one.outcome() != Judged::Met)
        .collect();
    html! {
        section {
            h2 { "Measurements included" }
            p {
                (plural(said.members.len(), "measurement")) " in the averages, "
                (said.members.len() - reported.len()) " of them with all criteria met. "
                "A measurement that does not meet a criterion is refused. A measurement with a criterion that is not decided is \
                    included, with a warning."
            }
            (by_rule(&said.members))
            @if !reported.is_empty() {
                h3 { "Included with a criterion not decided" }
                table {
                    tr { th { "measurement" } th { "not decided" } }
                    @for member in reported.iter().take(LISTED) {
                        tr { td { (member.filing) } td { (named_list(open(member))) } }
                    }
                }
                @if reported.len() > LISTED { p.soft { "And " (reported.len() - LISTED) " more, listed by the command with the option --json." } }
            }
            @if !partly.is_empty() {
                h3 { "Participants without every load and angle: left out of the comparisons concerned" }
                table {
                    tr { th { "participant" } th { "criterion" } }
                    @for one in &partly { tr { td { (one.participant) } td { (named_list(&one.criteria)) } } }
                }
            }
            (accepted(&page.analysed.accepted))
        }
    }
}

fn open(member: &Member) -> impl Iterator<Item = &Criterion<MemberCriterion>> {
    let criteria = member.criteria.iter();
    criteria.filter(|criterion| criterion.outcome != Judged::Met)
}

/// How far what was found lies towards not meeting the limit.
fn beyond<W>(criterion: &Criterion<W>) -> f64 {
    let found = criterion.found.unwrap_or(f64::NEG_INFINITY);
    match criterion.limit {
        Limit::AtMost { .. } => found,
        Limit::AtLeast { .. } => -found,
        Limit::Within { .. } => found.abs(),
    }
}

/// Every rule with its limit and the measurement that comes nearest to not meeting it.
fn by_rule(members: &[Member]) -> Markup {
    let rules: Vec<MemberCriterion> = members.first().map_or(Vec::new(), |member| {
        member.criteria.iter().map(|c| c.what).collect()
    });
    let of = |rule: MemberCriterion| {
        let all = members.iter();
        all.filter_map(move |member| Some((member, member.criterion(rule)?)))
    };
    let order = |a: f64, b: f64| a.partial_cmp(&b).unwrap_or(Ordering::Equal);
    html! {
        table {
            tr { th { "criterion" } th { "limit" } th.n { "met" } th.n { "not decided" } th.n { "worst \
                value" } th { "measurement" } }
            @for rule in rules {
                @let met = of(rule).filter(|(_, c)| c.outcome == Judged::Met).count();
                @let first = of(rule).next().and_then(|(_, first)| first.found);
                @let alike = of(rule).all(|(_, c)| c.found == first);
                @let worst = of(rule).max_by(|(_, a), (_, b)| order(beyond(a), beyond(b)));
                @if let Some((member, worst)) = worst {
                    tr {
                        td { (rule) }
                        td { (limit_text(worst.limit, &worst.unit)) }
                        td.n { (met) }
                        td.n { (of(rule).count() - met) }
                        td.n { (found(worst)) }
                        td { @if alike { "same for all" } @else { (member.filing) } }
                    }
                }
            }
        }
    }
}

/// What was judged while measuring: every rule at its worst among the accepted, and what was asked for again.
fn accepted(entries: &[&FiledMeasurement]) -> Markup {
    if entries.is_empty() {
        return html! {};
    }
    let attempts = |taken: bool| {
        entries.iter().flat_map(move |entry| {
            let own = entry.attempts.iter();
            own.filter(move |attempt| (attempt.judged.outcome() != Judged::NotMet) == taken)
                .map(move |attempt| (*entry, attempt))
        })
    };
    let refused: Vec<(&FiledMeasurement, &Attempt)> = attempts(false).collect();
    let rules = [
        RunCriterion::Force,
        RunCriterion::Coherence,
        RunCriterion::Polarity,
    ];
    let worst = |rule: RunCriterion| {
        attempts(true)
            .filter_map(|(entry, attempt)| {
                let own = attempt.judged.criteria.iter().find(|c| c.what == rule)?;
                Some((entry, own))
            })
            .max_by(|(_, a), (_, b)| {
                beyond(*a)
                    .partial_cmp(&beyond(*b))
                    .unwrap_or(Ordering::Equal)
            })
    };
    html! {
        h3 { "Checks during the measurement" }
        p {
            (plural(entries.len(), "measurement")) " were checked window by window while they ran; "
            (plural(refused.len(), "attempt")) (if refused.len() == 1 { " was" } else { " were" }) " refused and repeated."
        }
        table {
            tr { th { "criterion" } th { "limit" } th.n { "worst accepted window" } th { "outcome" } th { "measurement" } }
            @for rule in rules {
                @if let Some((entry, own)) = worst(rule) {
                    tr {
                        td { (rule) }
                        td { (limit_text(own.limit, &own.unit)) }
                        td.n { (found(own)) }
                        td { (outcome(own.outcome)) }
                        td { (entry.filing) }
                    }
                }
            }
        }
        @if !refused.is_empty() {
            h3 { "Refused attempts" }
            table {
                tr { th { "measurement" } th.n { "attempt" } th.n { "from, s" } th.n { "to, s" } th { "criteria" } }
                @for (entry, attempt) in refused.iter().take(LISTED) {
                    tr {
                        td { (entry.filing) }
                        td.n { (attempt.attempt) }
                        td.n { (format!("{:.0}", attempt.judged.window_s[0])) }
                        td.n { (format!("{:.0}", attempt.judged.window_s[1])) }
                        td { (named_list(&attempt.judged.criteria)) }
                    }
                }
            }
            @if refused.len() > LISTED { p.soft { "And " (refused.len() - LISTED) " more." } }
        }
    }
}
