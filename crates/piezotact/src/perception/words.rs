//! A perceived difference in words and as parts of a page.

use super::{Contribution, Limitation, PerceivedDifference, Sensitivity};
use crate::criterion::Outcome;
use crate::page::{Block, Cell, Column, Number, Table, fixed};

/// Features with a smaller share of the difference are not named.
const NAMED_SHARE: f64 = 0.1;
/// Those of a smaller difference neither, JND.
const NAMED_JND: f64 = 0.3;
/// At most so many are named.
const NAMED: usize = 3;

impl PerceivedDifference {
    /// The features that make most of the difference, the largest first: those with a tenth of it or more, three at most; none below 0.3
    /// JND.
    #[must_use]
    pub fn main_contributions(&self) -> Vec<Contribution> {
        let large = self
            .contributions
            .iter()
            .filter(|one| self.jnd.value >= NAMED_JND && one.share >= NAMED_SHARE);
        large.take(NAMED).copied().collect()
    }

    /// "1.32 JND (0.90–1.80), 86 % right of two intervals".
    pub(crate) fn range(&self) -> String {
        let jnd = self.jnd;
        format!(
            "{:.2} JND ({:.2}–{:.2}), {:.0} % right of two intervals",
            jnd.value, jnd.low, jnd.high, self.percent_correct.value
        )
    }

    /// One sentence that says whether people feel the difference, by how much, and in what.
    #[must_use]
    pub fn sentence(&self) -> String {
        let range = self.range();
        let named: Vec<String> = self
            .main_contributions()
            .iter()
            .map(|one| format!("{one}, {:.0} %", 100.0 * one.share))
            .collect();
        match self.criterion.outcome {
            _ if self.sensation_level.iter().all(|level| level.0 <= 0.0) => {
                "below the just-noticeable difference: neither reaches the detection threshold"
                    .into()
            }
            Outcome::Met => {
                // What an excerpt as short as this cannot show.
                let short = |one: &&Limitation| matches!(one, Limitation::ShortExcerpt { .. });
                let but = self.limitations.iter().find(short);
                let but = but.map_or_else(String::new, |one| format!("; {one}"));
                format!("below the just-noticeable difference: {range}{but}")
            }
            Outcome::NotMet => format!("distinguishable: {range}; felt in {}", named.join("; ")),
            Outcome::NotDecided if self.may_hide_more() && self.jnd.high <= 1.0 => {
                let mut all = self.limitations.iter();
                let why = all.find(|one| one.hides_a_difference());
                let why = why.map_or_else(String::new, ToString::to_string);
                format!("not decided: {range}; {why}")
            }
            Outcome::NotDecided if named.is_empty() => {
                format!("not decided: {range}; record longer")
            }
            Outcome::NotDecided => format!("not decided: {range}; felt in {}", named.join("; ")),
        }
    }

    /// The sentence, the numbers, the features and what limits them, as parts of a page.
    #[must_use]
    pub fn blocks(&self) -> Vec<Block> {
        let [a, b] = self.sensation_level.map(|level| fixed(level.0, 1));
        let numbers = [
            Number::new(
                format!("{:.2} JND", self.jnd.value),
                format!(
                    "perceived difference ({:.2}–{:.2})",
                    self.jnd.low, self.jnd.high
                ),
            ),
            Number::new(
                format!("{:.0} %", self.percent_correct.value),
                format!("right of two intervals; d′ {:.2}", self.d_prime.value),
            ),
            Number::new(
                format!("{} dB", fixed(self.felt_level.0, 1)),
                "felt level of B over A: the stronger channel and half the weaker",
            ),
            Number::new(
                format!("{a} and {b} dB"),
                "levels of A and B over threshold in the stronger channel",
            ),
        ];
        let mut blocks = vec![
            Block::conclusion(self.sentence(), self.criterion.outcome),
            Block::numbers(numbers),
        ];
        let table = self.table();
        if !table.rows.is_empty() {
            blocks.push(table.into());
        }
        blocks.extend(
            self.limitations
                .iter()
                .map(|one| Block::note(one.to_string())),
        );
        blocks
    }

    fn table(&self) -> Table {
        let mut table = Table::new([
            Column::new("felt in", "feature"),
            Column::new("channel", "channel"),
            Column::new("modulation, Hz", "modulation_hz"),
            Column::new("difference, JND", "jnd"),
            Column::new("share, %", "share_percent"),
        ]);
        let felt = self.contributions.iter().filter(|one| one.jnd > 0.0);
        let rows = felt.map(|one| {
            vec![
                Cell::Text(one.feature.name().into()),
                one.channel
                    .map_or(Cell::Missing(()), |c| Cell::Text(c.name().into())),
                one.modulation_hz
                    .map_or(Cell::Missing(()), |hz| Cell::rounded(hz.0, 1)),
                Cell::rounded(one.jnd, 2),
                Cell::rounded(100.0 * one.share, 1),
            ]
        });
        table.rows = rows.collect();
        table
    }
}

impl Sensitivity {
    /// What a difference depends on, as a table: JND with each parameter at the ends of its range.
    #[must_use]
    pub fn table(all: &[Self]) -> Table {
        let mut table = Table::new([
            Column::new("parameter", "parameter"),
            Column::new("from", "low"),
            Column::new("to", "high"),
            Column::new("JND at the low end", "jnd_low"),
            Column::new("JND at the high end", "jnd_high"),
        ]);
        let rows = all.iter().map(|one| {
            let [low, high] = one.range;
            let mut row = vec![Cell::Text(one.parameter.into())];
            row.extend([low, high].map(|value| Cell::rounded(value, 3)));
            row.extend(one.jnd.map(|value| Cell::rounded(value, 2)));
            row
        });
        table.rows = rows.collect();
        table
    }
}
