//! Epochs in sentences, tables and a report.

use piezotact::number::{counted, rounded};
use piezotact::page::{Block, Cell, Column, Page, Shown, Table};

use super::EegEpochs;
use crate::eeg::prepare::{EpochCounts, PrepareConfig};

impl PrepareConfig {
    /// How epochs were made, one step a line.
    #[must_use]
    pub fn steps(&self) -> Vec<String> {
        let mut steps: Vec<String> = self.filters.iter().map(ToString::to_string).collect();
        steps.push(format!(
            "Epochs from {} s to {} s around each marker, none across a gap",
            signed(self.extent.start_s),
            signed(self.extent.end_s)
        ));
        if !self.eog.is_empty() {
            let eog = self.eog.join(", ");
            steps.push(format!("Eye movements: regression on {eog}"));
        }
        if !self.interpolated.is_empty() {
            steps.push(format!(
                "Interpolated by spherical splines: {}",
                self.interpolated.join(", ")
            ));
        }
        steps.push(format!("Reference: {}", self.reference));
        let criteria: Vec<String> = self.criteria.iter().map(ToString::to_string).collect();
        steps.push(match criteria.is_empty() {
            true => "No epoch was rejected".to_owned(),
            false => format!(
                "Epochs rejected in which a channel has {}",
                criteria.join(" or ")
            ),
        });
        steps
    }
}

fn signed(value: f64) -> String {
    rounded(value).replace('-', "−")
}

impl EpochCounts {
    /// How many epochs of each condition are kept, in one sentence.
    #[must_use]
    pub fn sentence(&self) -> String {
        let each = self.conditions.iter().map(|count| {
            format!(
                "{} {} of {} (rejected {}, not whole {})",
                count.condition, count.kept, count.markers, count.rejected, count.left_out
            )
        });
        format!("Epochs kept: {}", each.collect::<Vec<_>>().join("; "))
    }

    /// Epochs by condition.
    #[must_use]
    pub fn table(&self) -> Table {
        let mut table = Table::new([
            Column::new("condition", "condition"),
            Column::new("markers", "markers"),
            Column::new("kept", "kept"),
            Column::new("rejected", "rejected"),
            Column::new("not whole", "not_whole"),
        ]);
        table.rows = self
            .conditions
            .iter()
            .map(|count| {
                let numbers = [count.markers, count.kept, count.rejected, count.left_out];
                let mut row = vec![Cell::from(count.condition.as_str())];
                row.extend(numbers.map(|number| Cell::Text(number.to_string())));
                row
            })
            .collect();
        table
    }

    /// Markers without an epoch that counts, with a sentence above them; nothing where there is none.
    pub(in crate::eeg) fn refused_blocks(&self) -> Vec<Block> {
        let text = "Markers without an epoch, and epochs that were rejected:".to_owned();
        let table = self.refused_table();
        let blocks = table.map(|table| [Block::Text { text }, Block::Table(table)]);
        blocks.into_iter().flatten().collect()
    }

    /// Markers without an epoch that counts, with the reason; `None` where there is none.
    #[must_use]
    pub fn refused_table(&self) -> Option<Table> {
        let mut table = Table::new([
            Column::new("marker at, s", "onset_s"),
            Column::new("condition", "condition"),
            Column::new("channel", "channel"),
            Column::new("reason", "reason"),
            Column::new("found, µV", "found_uv"),
        ]);
        let whole = self.not_whole.iter().map(|one| {
            let reason = one.reason.to_string();
            let row = vec![
                Cell::Text(rounded(one.onset_s)),
                Cell::from(one.condition.as_str()),
                Cell::from(None),
                Cell::from(reason),
                Cell::from(None),
            ];
            (one.onset_s, row)
        });
        let rejected = self.rejected.iter().map(|one| {
            let row = vec![
                Cell::Text(rounded(one.onset_s)),
                Cell::from(one.condition.as_str()),
                Cell::Text(match one.channels {
                    0 | 1 => one.channel.clone(),
                    several => format!("{} and {} more", one.channel, several - 1),
                }),
                Cell::from(one.criterion.to_string()),
                Cell::from(1e6 * one.found_v),
            ];
            (one.onset_s, row)
        });
        let mut rows: Vec<(f64, Vec<Cell>)> = whole.chain(rejected).collect();
        rows.sort_by(|a, b| a.0.total_cmp(&b.0));
        table.rows = rows.into_iter().map(|(_, row)| row).collect();
        (!table.rows.is_empty()).then_some(table)
    }
}

impl EegEpochs {
    /// How many epochs there are, in one sentence.
    #[must_use]
    pub fn sentence(&self) -> String {
        let kept: usize = self.counts.conditions.iter().map(|count| count.kept).sum();
        format!(
            "{} of {} kept of {}, {} at {} Hz",
            kept,
            counted(
                self.counts.conditions.iter().map(|c| c.markers).sum(),
                "epoch"
            ),
            self.subject,
            counted(self.channels.len(), "electrode"),
            rounded(self.rate_hz.hz())
        )
    }
}

impl Shown for EegEpochs {
    fn page(&self) -> Page {
        let steps = Block::Steps {
            steps: self.config.steps(),
        };
        let mut counts = vec![Block::Table(self.counts.table())];
        counts.extend(self.counts.refused_blocks());
        Page::new(
            format!("EEG epochs: {}", self.file),
            self.subject.to_string(),
        )
        .section("", [Block::conclusion(self.sentence(), None)])
        .section("Epochs by condition", counts)
        .section("How epochs were made", [steps])
        .warnings(&self.warnings)
    }
}
