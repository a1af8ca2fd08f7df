//! The tables of a report on a panel.

use maud::{Markup, html};
use piezotact::number::plus;
use piezotact::panel::{
    AverageCriterion, CellPenalties, LearningCurve, PairDistances, PanelAnalysis,
};
use piezotact::statistics::{Direction, PairedDifference};
use piezotact::transfer::BundleAverage;

use super::{averaging_word, percent};

fn test(paired: Option<PairedDifference>, mean_db: f64) -> String {
    paired.map_or(plus(mean_db, 2), |p| {
        let [low, high] = p.interval.map(|end| plus(end, 2));
        format!("{} ({low} to {high})", plus(p.mean, 2))
    })
}

/// Which way the mean goes, where its interval over people has a direction.
fn shown(paired: Option<PairedDifference>) -> &'static str {
    match paired.map(|p| Direction::of(Some(p.interval))) {
        Some(Direction::Rises) => "higher",
        Some(Direction::Falls) => "lower",
        Some(Direction::NotShown) => "no change shown",
        None => "not decided",
    }
}

fn p_value(p: Option<f64>) -> String {
    p.map_or("–".into(), |p| {
        if p < 0.001 {
            "< 0.001".into()
        } else {
            format!("{p:.3}")
        }
    })
}

/// How far people lie apart and what the average costs, by cell.
pub(super) fn cells(said: &PanelAnalysis) -> Markup {
    html! {
        div.wide {
            table.second.tight {
                tr { th { "angle, load" } th.n { "participants" } th.n { "maximum deviation, dB" } th.n { "at, Hz" } th.n { "SD \
                    over participants, dB rms" } th { "participant furthest from the mean" } }
                @for spread in &said.spreads {
                    @let furthest = spread.people.iter().max_by(|a, b| a.db_rms.total_cmp(&b.db_rms));
                    tr {
                        td { (spread.cell) }
                        td.n { (spread.bundle.count) }
                        td.n { (format!("{:.1}", spread.bundle.max_deviation_db)) }
                        td.n { (format!("{:.0}", spread.bundle.max_deviation_at_hz)) }
                        td.n { (format!("{:.2}", spread.spread_rms_db)) }
                        td { @if let Some(p) = furthest { (p.participant) (format!(": {:.1} dB rms, {} dB at {:.0} Hz", p.db_rms, plus(p.db_max, 1), p.at_hz)) } }
                    }
                }
            }
        }
    }
}

/// The same by bands.
pub(super) fn bands(said: &PanelAnalysis) -> Markup {
    let parts = said.spreads.first().map_or(&[][..], |s| &s.bands);
    html! {
        @if !parts.is_empty() {
            h3 { "By bands" }
            p.soft { "Maximum deviation / standard deviation over participants, rms / error of the average for a new \
                participant, rms; all in dB." }
            div.wide {
                table.tight {
                    tr { th { "angle, load" } @for part in parts { th.n { (part.band_hz) } } }
                    @for spread in &said.spreads {
                        tr {
                            td { (spread.cell) }
                            @for part in &spread.bands {
                                td.n { (format!("{:.1} / {:.1} / {:.1}", part.max_deviation_db, part.spread_rms_db, part.penalty_db_rms)) }
                            }
                        }
                    }
                }
            }
        }
    }
}

pub(super) fn loads(said: &PanelAnalysis) -> Markup {
    html! {
        div.wide {
            table.second.tight {
                tr { th { "angle" } th { "load" } th.n { "participants" } th.n { "gain rises for" } th.n { "mean step, dB (95 \
                    %)" } th { "gain" } th.n { "smallest step, dB" } th.n { "smallest share of rising \
                    lines" } th.n { "paired t, p" } th.n { "sign test, p" } }
                @for step in &said.load_steps {
                    @let least = step.people.iter().map(|p| p.mean_db).fold(f64::MAX, f64::min);
                    tr {
                        td { (step.angle_deg.0) "°" }
                        td { (step.from_n.0) " → " (step.to_n) }
                        td.n { (step.people.len()) }
                        td.n { (step.rising) }
                        td.n { (test(step.paired, step.mean_db)) }
                        td { (shown(step.paired)) }
                        td.n { (plus(least, 2)) }
                        td.n { (percent(step.least_rising_share)) }
                        td.n { (p_value(step.paired.map(|p| p.p_value))) }
                        td.n { (p_value(step.sign_test_p)) }
                    }
                }
            }
        }
    }
}

pub(super) fn angles(said: &PanelAnalysis) -> Markup {
    html! {
        div.wide {
            table.second.tight {
                tr { th { "angle" } th { "load" } th.n { "participants" } th.n { "difference, dB rms, \
                    median" } th.n { "largest" } th { "participant" } th.n { "higher gain when steeper" } th.n { "mean step, dB \
                    (95 %)" } th { "gain" } th.n { "paired t, p" } th.n { "sign test, p" } }
                @for effect in &said.angle_effects {
                    tr {
                        td { (effect.from_deg.0) "° → " (effect.to_deg.0) "°" }
                        td { @if let Some(load) = effect.load_n { (load) } @else { "all loads" } }
                        td.n { (effect.people.len()) }
                        td.n { (format!("{:.2}", effect.median_db_rms)) }
                        td.n { (format!("{:.2}", effect.largest_db_rms)) }
                        td { (effect.largest_of) }
                        td.n { (effect.louder) }
                        td.n { (test(effect.paired, effect.mean_db)) }
                        td { (shown(effect.paired)) }
                        td.n { (p_value(effect.paired.map(|p| p.p_value))) }
                        td.n { (p_value(effect.sign_test_p)) }
                    }
                }
            }
        }
        p.soft { "All loads: the mean of the steps of each participant, and the largest of the differences." }
    }
}

pub(super) fn repeats(said: &PanelAnalysis) -> Markup {
    let found = &said.repeatability;
    let row = |what: &str, pairs: &PairDistances| {
        html! {
            tr {
                td { (what) }
                td.n { (pairs.groups) }
                td.n { (pairs.pairs) }
                td.n { (format!("{:.2}", pairs.median_db_rms)) }
                td.n { (format!("{:.2}", pairs.largest_db_rms)) }
                td { (pairs.largest_in) }
                td.n { (format!("{:.2}", pairs.spread_rms_db)) }
            }
        }
    };
    let db = |value: Option<f64>| value.map_or("–".into(), |db| format!("{db:.2}"));
    html! {
        @if found.lying.is_some() || found.put_back.is_some() {
            div.wide {
                table.second.tight {
                    tr { th { "two measurements of one participant" } th.n { "groups" } th.n { "pairs" } th.n { "difference, dB \
                        rms, median" } th.n { "largest" } th { "largest in" } th.n { "SD, dB rms" } }
                    @if let Some(pairs) = &found.lying { (row("finger not moved", pairs)) }
                    @if let Some(pairs) = &found.put_back { (row("finger repositioned in between", pairs)) }
                }
            }
        }
        @if !found.components.is_empty() {
            h3 { "Components of variance at one load and angle" }
            div.wide {
                table.tight {
                    tr { th { "band" } th.n { "between participants, dB" } th.n { "between placements, dB" } th.n { "between repeats, dB" } th.n { "share of the variance between participants" } }
                    @for part in &found.components {
                        tr {
                            td { (part.band_hz) }
                            td.n { (format!("{:.2}", part.persons_db)) }
                            td.n { (db(part.placements_db)) }
                            td.n { (db(part.repeats_db)) }
                            td.n { (percent(part.persons_share)) }
                        }
                    }
                }
            }
            p.soft { "Standard deviations. –: every participant placed the finger only once, so the variation between \
                placements is included in that between participants." }
        }
    }
}

/// How many people are enough, as a range.
fn enough(curve: &LearningCurve) -> Option<String> {
    let (found, [low, high]) = (curve.enough.found?, curve.enough.interval?);
    Some(format!("{found:.0} ({low:.0} to {high:.0})"))
}

/// The share of people within the criterion, with its interval.
fn within(costs: &CellPenalties) -> String {
    let rule = costs
        .verdict
        .criteria
        .iter()
        .find(|c| c.what == AverageCriterion::ShareWithin);
    let share = percent(costs.verdict.share_within);
    match rule.and_then(|rule| rule.interval) {
        Some([low, high]) => format!("{share} ({} to {})", percent(low), percent(high)),
        None => share,
    }
}

pub(super) fn averages(said: &PanelAnalysis) -> Markup {
    html! {
        div.wide {
            table.second.tight {
                tr { th { "angle, load" } th { "average" } th.n { "error for a new participant, dB rms (95 \
                    %)" } th.n { "largest error of a participant, mean, dB" } th { "largest for" } th.n { "participants \
                    within " (said.config.criterion.db_rms) " dB" } th { "sufficient" } th.n { "participants to \
                    decide" } th.n { "participants needed (95 %)" } }
                @for average in &said.averages {
                    @let curve = said.learning.iter().find(|c| c.cell.is(average.cell));
                    @for averaging in [BundleAverage::LogMagnitude, BundleAverage::Complex] {
                        @let costs = average.penalties_of(averaging);
                        @let range = costs.interval_db_rms.map_or(String::new(), |[low, high]| format!(" ({low:.2} to {high:.2})"));
                        tr {
                            td { (average.cell) }
                            td { (averaging_word(averaging)) }
                            td.n { (format!("{:.2}", costs.mean_db_rms)) (range) }
                            td.n { (format!("{:.1}", costs.mean_db_max)) }
                            td { (costs.worst.participant) (format!(": {:.1} dB rms", costs.worst.db_rms)) }
                            td.n { (within(costs)) }
                            td { (costs.verdict.outcome.answer()) }
                            td.n { (costs.verdict.people_needed.map_or("–".to_owned(), |n| n.to_string())) }
                            td.n { (curve.filter(|c| c.averaging == averaging).and_then(enough).unwrap_or("–".to_owned())) }
                        }
                    }
                }
            }
        }
    }
}
