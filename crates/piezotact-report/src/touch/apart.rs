//! Which samples are distinguishable: a matrix of distances for each setting, and the rules that decide.

use maud::{Markup, html};
use piezotact::compare::{AcrossSamples, Distinguishability, Groups, PairCriterion, SampleUnit};

use piezotact::study::Discrimination;

pub(super) fn section(discrimination: &Discrimination) -> Markup {
    html! {
        section {
            h2 { "Distinguishable samples" }
            @match discrimination {
                Discrimination::Withheld { sentence, .. } => p { (sentence) "." },
                Discrimination::Found(found) => {
                    (rules(found))
                    @for groups in &found.settings {
                        @if !groups.setting.is_empty() { h3 { (groups.setting) } }
                        (matrix(groups))
                        ul { @for sentence in groups.sentences() { li { (sentence) } } }
                    }
                    (pairs(found))
                }
            }
        }
    }
}

fn rules(found: &AcrossSamples) -> Markup {
    let model = &found.config.model;
    let noticed = model.noticed_jnd();
    html! {
        p { (format!(
            "Distances in just-noticeable differences (JND) of {:.2} dB, with 95 % limits; on the diagonal, in brackets, the \
                distance between two halves of the {} of a sample. Distance, JND and threshold are defined as for the command \
                `score`, over {}.",
            model.level_jnd.0, found.units.word(), model.band
        )) }
        p { b { "Bold" } (format!(": distinguishable. The 95 % limits are above {noticed:.2} JND ({:.1} dB, the upper end of \
            the published range) and above the distance between the halves of either sample, and a permutation test over {} \
            shows a difference, with a family-wise error of {:.0} % \
            over {}. ", model.level_jnd_high.0.max(model.level_jnd.0), found.units.word(), found.config.alpha * 100.0, found.family_text()))
            span.near { " Shaded " } ": below the just-noticeable difference (75 % correct): the 95 % limits are below 1 JND. \
                Grey: not decided." }
        @if found.units == SampleUnit::Recordings { p.warning { "Recordings of one sample differ by more than their strokes do, so \
            recordings are compared instead of strokes." } }
        p.soft { (model.jnd_source()) ". " (format!("Random divisions of the data: ChaCha8, seed {}.", found.config.seed)) }
    }
}

fn matrix(groups: &Groups) -> Markup {
    let count = groups.names.len();
    html! {
        div.wide tabindex="0" role="region" aria-label="Table" { table.matrix {
            tr { th scope="col" { "JND" } @for name in &groups.names { th.n scope="col" { (name) } } }
            @for i in 0..count {
                tr {
                    th scope="row" { (groups.names[i]) (format!(" ({})", groups.units[i])) }
                    @for j in 0..count {
                        @if i == j {
                            td.n.soft { (groups.within_jnd[i].map_or("–".into(), |v| format!("({v:.1})"))) }
                        } @else if let Some(pair) = groups.pair(i, j) {
                            td.n.near[pair.outcome == Distinguishability::BelowJnd].apart[pair.outcome == Distinguishability::ToldApart].soft[pair.outcome == Distinguishability::NotDecided] {
                                (format!("{:.1}", pair.distance_jnd))
                                @if let Some([low, high]) = pair.interval_jnd { br; small { (format!("{low:.1}–{high:.1}")) } }
                            }
                        }
                    }
                }
            }
        } }
        p.soft { "In brackets after a name: its number of strokes or recordings." }
    }
}

/// The criteria of every pair, for the reader who wants to know why.
fn pairs(found: &AcrossSamples) -> Markup {
    let of = |pair: &piezotact::compare::Pair, what: PairCriterion| -> &'static str {
        let mut all = pair.criteria.iter().filter(|c| c.what == what);
        all.next().map_or("–", |c| c.outcome.word())
    };
    let several = found.settings.len() > 1;
    html! {
        details {
            summary { (format!("The criteria of {}", found.family_text())) }
            div.wide tabindex="0" role="region" aria-label="Table" { table {
                tr {
                    @if several { th scope="col" { "setting" } }
                    th scope="col" { "pair" } th.n scope="col" { "spectrum, level, balance, JND" } th scope="col" { "below the JND" } th scope="col" { "below the distance between halves" } th scope="col" { "permutation test" } th.n scope="col" { "p" } th.n scope="col" { "p, adjusted" } th scope="col" { "outcome" }
                }
                @for groups in &found.settings {
                    @for pair in &groups.pairs {
                        tr {
                            @if several { td { (groups.setting) } }
                            td { (groups.names[pair.a]) " and " (groups.names[pair.b]) }
                            td.n { (format!("{:.2}, {:.2}, {:.2}", pair.parts_jnd[0], pair.parts_jnd[1], pair.parts_jnd[2])) }
                            td { (of(pair, PairCriterion::JustNoticeableDifference)) }
                            td { (of(pair, PairCriterion::DistanceWithin)) }
                            td { (of(pair, PairCriterion::Chance)) }
                            td.n { (pair.permuted.map_or("–".into(), |p| format!("{:.4}", p.p_value))) }
                            td.n { (pair.p_adjusted.map_or("–".into(), |p| format!("{p:.3}"))) }
                            td { (pair.outcome.word()) }
                        }
                    }
                }
            } }
        }
    }
}
