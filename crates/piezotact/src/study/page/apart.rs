//! Which samples are distinguishable: a matrix of distances for each setting, and the rules that decide.

use crate::compare::{AcrossSamples, Distinguishability, Groups, Pair, PairCriterion, SampleUnit};
use crate::criterion::Outcome;
use crate::page::{Block, Cell, Column, Table};
use crate::study::Discrimination;

/// A matrix of more samples is a list of pairs.
const MOST_SAMPLES: usize = 24;

pub(super) fn blocks(discrimination: &Discrimination) -> Vec<Block> {
    let found = match discrimination {
        Discrimination::Withheld { sentence, .. } => {
            return vec![Block::text(format!("{sentence}."))];
        }
        Discrimination::Found(found) => found,
    };
    let mut blocks = rules(found);
    for groups in &found.settings {
        if !groups.setting.is_empty() {
            blocks.push(Block::heading(groups.setting.as_str()));
        }
        if groups.names.len() <= MOST_SAMPLES {
            blocks.push(matrix(groups).into());
        }
    }
    blocks.push(Block::note(
        "In brackets after a name: its number of strokes or recordings.",
    ));
    blocks.push(Block::folded(
        format!("The criteria of {}", found.family_text()),
        [pairs(found).into()],
    ));
    blocks
}

fn rules(found: &AcrossSamples) -> Vec<Block> {
    let model = &found.config.model;
    let noticed = model.noticed_jnd();
    let mut blocks = vec![
        Block::text(format!(
            "Distances in just-noticeable differences (JND) of {:.2} dB, with 95 % limits; on the diagonal, in brackets, the \
             distance between two halves of the {} of a sample. Distance, JND and threshold are defined as for the command `score`, \
             over {}.",
            model.level_jnd.0,
            found.units.word(),
            model.band
        )),
        Block::text(format!(
            "● distinguishable: the 95 % limits are above {noticed:.2} JND ({:.1} dB, the upper end of the published range) and above \
             the distance between the halves of either sample, and a permutation test over {} shows a difference, with a family-wise \
             error of {:.0} % over {}; or the same holds of the difference over time and channels (modulation, dips, pitch), above 1 JND. \
             ○ below the just-noticeable difference (75 % correct): the limits of both differences are below 1 JND. No mark: not decided.",
            model.level_jnd_high.0.max(model.level_jnd.0),
            found.units.word(),
            found.config.alpha * 100.0,
            found.family_text()
        )),
    ];
    if found.units == SampleUnit::Recordings {
        blocks.push(Block::text(
            "Recordings of one sample differ by more than their strokes do, so recordings are compared instead of strokes.",
        ));
    }
    blocks.push(Block::note(format!(
        "{}. Random divisions of the data: ChaCha8, seed {}.",
        model.jnd_source(),
        found.config.seed
    )));
    blocks
}

fn matrix(groups: &Groups) -> Table {
    let names = groups.names.iter();
    let columns = names.map(|name| Column::new(name, name));
    let mut table = Table::new([Column::new("JND", "sample")].into_iter().chain(columns));
    let count = groups.names.len();
    for i in 0..count {
        let name = format!("{} ({})", groups.names[i], groups.units[i]);
        let mut row = vec![Cell::from(name)];
        row.extend((0..count).map(|j| {
            if i == j {
                return groups.within_jnd[i].map_or(Cell::Missing(()), |value| Cell::Rounded {
                    value,
                    text: format!("({value:.1})"),
                });
            }
            let pair = groups.pair(i, j);
            pair.map_or(Cell::Missing(()), distance)
        }));
        table.rows.push(row);
    }
    table
}

/// The distance of a pair with its limits and the mark of its outcome.
fn distance(pair: &Pair) -> Cell {
    let mark = match pair.outcome {
        Distinguishability::ToldApart => "● ",
        Distinguishability::BelowJnd => "○ ",
        Distinguishability::NotDecided => "",
    };
    let limits = pair.interval_jnd;
    let limits = limits.map_or(String::new(), |[low, high]| {
        format!(" ({low:.1}–{high:.1})")
    });
    Cell::Rounded {
        value: pair.distance_jnd,
        text: format!("{mark}{:.1}{limits}", pair.distance_jnd),
    }
}

/// The difference over time and channels with its range.
fn over_time(pair: &Pair) -> Cell {
    let mut criteria = pair.criteria.iter();
    let criterion = criteria.find(|c| c.what == PairCriterion::OverTime);
    let found = criterion.and_then(|c| c.found.zip(c.interval));
    found.map_or(Cell::Missing(()), |(value, [low, high])| Cell::Rounded {
        value,
        text: format!("{value:.1} ({low:.1}–{high:.1})"),
    })
}

/// The criteria of every pair, for the reader who wants to know why.
fn pairs(found: &AcrossSamples) -> Table {
    let of = |pair: &Pair, what: PairCriterion| -> Cell {
        let criterion = pair.criteria.iter().find(|c| c.what == what);
        let outcome = criterion.map(|c| c.outcome);
        outcome.map_or(Cell::Missing(()), |outcome: Outcome| {
            Cell::from(outcome.word())
        })
    };
    let several = found.settings.len() > 1;
    let setting = several.then_some(("setting", "setting"));
    let columns = setting.into_iter().chain([
        ("pair", "pair"),
        ("distance, JND", "distance_jnd"),
        ("spectrum, level, balance, JND", "parts_jnd"),
        ("below the JND", "below_jnd"),
        ("below the distance between halves", "within"),
        ("permutation test", "chance"),
        ("over time, JND", "over_time_jnd"),
        ("felt in", "felt_in"),
        ("p", "p"),
        ("p, adjusted", "p_adjusted"),
        ("outcome", "outcome"),
    ]);
    let mut table = Table::new(columns.map(|(heading, name)| Column::new(heading, name)));
    let rounded = |value: Option<f64>, decimals: usize| {
        value.map_or(Cell::Missing(()), |value| Cell::rounded(value, decimals))
    };
    for groups in &found.settings {
        table.rows.extend(groups.pairs.iter().map(|pair| {
            let [spectrum, level, balance] = pair.parts_jnd;
            let setting = several.then(|| Cell::from(groups.setting.as_str()));
            let cells = [
                Cell::from(format!(
                    "{} and {}",
                    groups.names[pair.a], groups.names[pair.b]
                )),
                distance(pair),
                Cell::from(format!("{spectrum:.2}, {level:.2}, {balance:.2}")),
                of(pair, PairCriterion::JustNoticeableDifference),
                of(pair, PairCriterion::DistanceWithin),
                of(pair, PairCriterion::Chance),
                over_time(pair),
                Cell::from(pair.felt_in_words()),
                rounded(pair.permuted.as_ref().map(|p| p.p_value), 4),
                rounded(pair.p_adjusted, 3),
                Cell::from(pair.outcome.word()),
            ];
            setting.into_iter().chain(cells).collect()
        }));
    }
    table
}
