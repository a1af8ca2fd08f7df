//! The tables of a report on a panel.

use super::sentences::percent;
use super::{
    AverageCriterion, CellPenalties, LearningCurve, PairDistances, PanelAnalysis, Repeatability,
};
use crate::number::plus;
use crate::page::{Block, Cell, Column, Table, fixed};
use crate::statistics::{Direction, PairedDifference};
use crate::transfer::BundleAverage;

/// A table of columns, each with its heading and its name, and rows.
pub(super) fn table<const N: usize>(
    columns: [(&str, &str); N],
    rows: impl IntoIterator<Item = [Cell; N]>,
) -> Table {
    let mut table = Table::new(columns.map(|(heading, name)| Column::new(heading, name)));
    table.rows = rows.into_iter().map(Vec::from).collect();
    table
}

/// A mean difference over people with its interval.
fn mean_step(paired: Option<PairedDifference>, mean_db: f64) -> Cell {
    let text = paired.map_or(plus(mean_db, 2), |p| {
        let [low, high] = p.interval.map(|end| plus(end, 2));
        format!("{} ({low} to {high})", plus(p.mean, 2))
    });
    Cell::Rounded {
        value: mean_db,
        text,
    }
}

/// A value with its sign.
fn with_sign(value: f64, decimals: usize) -> Cell {
    Cell::Rounded {
        value,
        text: plus(value, decimals),
    }
}

fn share(value: f64) -> Cell {
    Cell::Rounded {
        value,
        text: percent(value),
    }
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

fn p_value(p: Option<f64>) -> Cell {
    let Some(value) = p else {
        return Cell::Missing(());
    };
    let text = match value {
        p if p < 0.001 => "< 0.001".into(),
        p => format!("{p:.3}"),
    };
    Cell::Rounded { value, text }
}

fn count(count: usize) -> Cell {
    Cell::rounded(count as f64, 0)
}

/// How far people lie apart, by cell.
pub(super) fn cells(said: &PanelAnalysis) -> Table {
    let columns = [
        ("angle, load", "condition"),
        ("participants", "participants"),
        ("maximum deviation, dB", "max_deviation_db"),
        ("at, Hz", "at_hz"),
        ("SD over participants, dB rms", "spread_rms_db"),
        ("participant furthest from the mean", "furthest"),
    ];
    let rows = said.spreads.iter().map(|spread| {
        let people = spread.people.iter();
        let furthest = people.max_by(|a, b| a.db_rms.total_cmp(&b.db_rms));
        let furthest = furthest.map(|p| {
            format!(
                "{}: {:.1} dB rms, {} dB at {:.0} Hz",
                p.participant,
                p.db_rms,
                plus(p.db_max, 1),
                p.at_hz
            )
        });
        [
            Cell::from(spread.cell.to_string()),
            count(spread.bundle.count),
            Cell::rounded(spread.bundle.max_deviation_db, 1),
            Cell::rounded(spread.bundle.max_deviation_at_hz, 0),
            Cell::rounded(spread.spread_rms_db, 2),
            furthest.map_or(Cell::Missing(()), Cell::from),
        ]
    });
    table(columns, rows)
}

/// The same by bands, with what the average costs; nothing without bands.
pub(super) fn bands(said: &PanelAnalysis) -> Option<Block> {
    let columns = [
        ("angle, load", "condition"),
        ("band", "band"),
        ("maximum deviation, dB", "max_deviation_db"),
        ("SD over participants, dB rms", "spread_rms_db"),
        (
            "error of the average for a new participant, dB rms",
            "penalty_db_rms",
        ),
    ];
    let rows = said.spreads.iter().flat_map(|spread| {
        spread.bands.iter().map(move |part| {
            [
                Cell::from(spread.cell.to_string()),
                Cell::from(part.band_hz.to_string()),
                Cell::rounded(part.max_deviation_db, 1),
                Cell::rounded(part.spread_rms_db, 1),
                Cell::rounded(part.penalty_db_rms, 1),
            ]
        })
    });
    let table = table(columns, rows);
    (!table.rows.is_empty()).then(|| Block::folded("By bands", [table.into()]))
}

pub(super) fn loads(said: &PanelAnalysis) -> Table {
    let columns = [
        ("angle, °", "angle_deg"),
        ("load", "load"),
        ("participants", "participants"),
        ("gain rises for", "rising"),
        ("mean step, dB (95 %)", "mean_step_db"),
        ("gain", "gain"),
        ("smallest step, dB", "smallest_step_db"),
        ("smallest share of rising lines", "least_rising_share"),
        ("paired t, p", "paired_t_p"),
        ("sign test, p", "sign_test_p"),
    ];
    let rows = said.load_steps.iter().map(|step| {
        let people = step.people.iter();
        let least = people.map(|p| p.mean_db).fold(f64::MAX, f64::min);
        [
            Cell::from(step.angle_deg.0),
            Cell::from(format!("{} → {}", step.from_n.0, step.to_n)),
            count(step.people.len()),
            count(step.rising),
            mean_step(step.paired, step.mean_db),
            Cell::from(shown(step.paired)),
            with_sign(least, 2),
            share(step.least_rising_share),
            p_value(step.paired.map(|p| p.p_value)),
            p_value(step.sign_test_p),
        ]
    });
    table(columns, rows)
}

pub(super) fn angles(said: &PanelAnalysis) -> [Block; 2] {
    let columns = [
        ("angle", "angle"),
        ("load", "load"),
        ("participants", "participants"),
        ("difference, dB rms, median", "median_db_rms"),
        ("largest", "largest_db_rms"),
        ("participant", "largest_of"),
        ("higher gain when steeper", "higher_when_steeper"),
        ("mean step, dB (95 %)", "mean_step_db"),
        ("gain", "gain"),
        ("paired t, p", "paired_t_p"),
        ("sign test, p", "sign_test_p"),
    ];
    let rows = said.angle_effects.iter().map(|effect| {
        let load = effect.load_n.map(|load| load.to_string());
        [
            Cell::from(format!("{}° → {}°", effect.from_deg.0, effect.to_deg.0)),
            Cell::from(load.unwrap_or_else(|| "all loads".into())),
            count(effect.people.len()),
            Cell::rounded(effect.median_db_rms, 2),
            Cell::rounded(effect.largest_db_rms, 2),
            Cell::from(effect.largest_of.as_str()),
            count(effect.louder),
            mean_step(effect.paired, effect.mean_db),
            Cell::from(shown(effect.paired)),
            p_value(effect.paired.map(|p| p.p_value)),
            p_value(effect.sign_test_p),
        ]
    });
    let note =
        "All loads: the mean of the steps of each participant, and the largest of the differences.";
    [table(columns, rows).into(), Block::note(note)]
}

pub(super) fn repeats(found: &Repeatability) -> Vec<Block> {
    let mut blocks = Vec::new();
    let pairs = [
        ("finger not moved", &found.lying),
        ("finger repositioned in between", &found.put_back),
    ];
    let pairs: Vec<(&str, &PairDistances)> = pairs
        .into_iter()
        .filter_map(|(what, pairs)| Some((what, pairs.as_ref()?)))
        .collect();
    if !pairs.is_empty() {
        let columns = [
            ("two measurements of one participant", "measurements"),
            ("groups", "groups"),
            ("pairs", "pairs"),
            ("difference, dB rms, median", "median_db_rms"),
            ("largest", "largest_db_rms"),
            ("largest in", "largest_in"),
            ("SD, dB rms", "spread_rms_db"),
        ];
        let rows = pairs.into_iter().map(|(what, pairs)| {
            [
                Cell::from(what),
                count(pairs.groups),
                count(pairs.pairs),
                Cell::rounded(pairs.median_db_rms, 2),
                Cell::rounded(pairs.largest_db_rms, 2),
                Cell::from(pairs.largest_in.as_str()),
                Cell::rounded(pairs.spread_rms_db, 2),
            ]
        });
        blocks.push(table(columns, rows).into());
    }
    if !found.components.is_empty() {
        let columns = [
            ("band", "band"),
            ("between participants, dB", "participants_db"),
            ("between placements, dB", "placements_db"),
            ("between repeats, dB", "repeats_db"),
            (
                "share of the variance between participants",
                "participants_share",
            ),
        ];
        let db = |value: Option<f64>| value.map_or(Cell::Missing(()), |db| Cell::rounded(db, 2));
        let rows = found.components.iter().map(|part| {
            [
                Cell::from(part.band_hz.to_string()),
                Cell::rounded(part.persons_db, 2),
                db(part.placements_db),
                db(part.repeats_db),
                part.persons_share.map_or(Cell::Missing(()), share),
            ]
        });
        blocks.extend([
            Block::heading("Components of variance at one load and angle"),
            table(columns, rows).into(),
            Block::note(
                "Standard deviations. –: every participant placed the finger only once, so the variation between placements is \
                 included in that between participants, and a share cannot be stated where nothing was measured twice.",
            ),
        ]);
    }
    blocks
}

/// How many people are enough, as a range.
fn enough(curve: &LearningCurve) -> Option<Cell> {
    let (value, [low, high]) = (curve.enough.found?, curve.enough.interval?);
    let text = format!("{value:.0} ({low:.0} to {high:.0})");
    Some(Cell::Rounded { value, text })
}

/// The share of people within the criterion, with its interval.
fn within(costs: &CellPenalties) -> Cell {
    let rule = costs.criterion(AverageCriterion::ShareWithin);
    let value = costs.verdict.share_within;
    let text = match rule.and_then(|rule| rule.interval) {
        Some([low, high]) => {
            format!("{} ({} to {})", percent(value), percent(low), percent(high))
        }
        None => percent(value),
    };
    Cell::Rounded { value, text }
}

pub(super) fn averages(said: &PanelAnalysis) -> Table {
    let limit = said.config.criterion.db_rms;
    let within_heading = format!("participants within {limit} dB");
    let columns = [
        ("angle, load", "condition"),
        ("average", "average"),
        (
            "error for a new participant, dB rms, mean (95 % for one)",
            "error_db_rms",
        ),
        (
            "largest error of a participant, mean, dB",
            "largest_error_db",
        ),
        ("largest for", "largest_for"),
        (within_heading.as_str(), "share_within"),
        ("sufficient", "sufficient"),
        ("participants to decide", "participants_to_decide"),
        ("participants needed (95 %)", "participants_needed"),
    ];
    let both = [BundleAverage::LogMagnitude, BundleAverage::Complex];
    let rows = said.averages.iter().flat_map(|average| {
        both.map(|averaging| {
            let costs = average.penalties_of(averaging);
            let interval = costs
                .new_person_db_rms
                .map_or(String::new(), |[low, high]| {
                    format!(" ({} to {})", fixed(low, 2), fixed(high, 2))
                });
            let mut curves = said.learning.iter();
            let curve = curves.find(|c| c.cell.is(average.cell) && c.averaging == averaging);
            [
                Cell::from(average.cell.to_string()),
                Cell::from(averaging.name()),
                Cell::Rounded {
                    value: costs.mean_db_rms,
                    text: fixed(costs.mean_db_rms, 2) + &interval,
                },
                Cell::rounded(costs.mean_db_max, 1),
                Cell::from(format!(
                    "{}: {:.1} dB rms",
                    costs.worst.participant, costs.worst.db_rms
                )),
                within(costs),
                Cell::from(costs.verdict.outcome.answer()),
                costs.verdict.people_needed.map_or(Cell::Missing(()), count),
                curve.and_then(enough).unwrap_or(Cell::Missing(())),
            ]
        })
    });
    table(columns, rows)
}
