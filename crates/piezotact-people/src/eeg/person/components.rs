//! Independent components beside eye movements, in a table and on the scalp.

use piezotact::figure::Maps;
use piezotact::number::{digits, rounded, signed};
use piezotact::page::{Block, Cell, Column, Table};

use super::{Electrode, head_map};
use crate::eeg::clean::{EyeComponent, EyeComponents};

/// So many components are drawn, those that follow the eyes most.
const DRAWN: usize = 6;

impl EyeComponents {
    /// The components that were taken out, in one sentence.
    #[must_use]
    pub fn sentence(&self) -> String {
        let out = self.taken_out();
        let all = self.components.len();
        let share: f64 = out.iter().map(|at| self.components[*at].share).sum();
        format!(
            "{} of {all} independent components taken out as eye movements, {} % of the variance of the electrodes (iterations: {})",
            out.len(),
            digits(100.0 * share),
            self.iterations
        )
    }

    /// Each component with its correlation.
    #[must_use]
    pub fn table(&self) -> Table {
        let mut table = Table::new([
            Column::new("component", "component"),
            Column::new("variance, %", "variance_percent"),
            Column::new("EOG channel", "eog"),
            Column::new("correlation", "correlation"),
            Column::new("taken out", "taken_out"),
        ]);
        let row = |(at, one): (usize, &EyeComponent)| {
            vec![
                Cell::Text((at + 1).to_string()),
                Cell::from(100.0 * one.share),
                Cell::from(one.eog.as_str()),
                Cell::from(one.correlation),
                Cell::from(if one.taken_out { "yes" } else { "no" }),
            ]
        };
        table.rows = self.components.iter().enumerate().map(row).collect();
        table
    }

    /// What a report shows of them; `positions` are those of their electrodes that are known.
    pub(in crate::eeg) fn blocks(&self, positions: &[Electrode]) -> Vec<Block> {
        let text = self.sentence();
        let mut blocks = vec![Block::Text { text }, Block::Table(self.table())];
        let mut order: Vec<usize> = (0..self.components.len()).collect();
        let follows = |at: &usize| self.components[*at].correlation.abs();
        order.sort_by(|a, b| follows(b).total_cmp(&follows(a)));
        let known: Vec<(usize, Electrode)> = (self.channels.iter().enumerate())
            .filter_map(|(at, name)| {
                let own = positions.iter().find(|one| one.name == *name)?;
                Some((at, own.clone()))
            })
            .collect();
        let electrodes: Vec<Electrode> = known.iter().map(|(_, one)| one.clone()).collect();
        let panel = |at: &usize| {
            let one = &self.components[*at];
            let values: Vec<f64> = known
                .iter()
                .map(|(at, _)| 1e6 * one.weights_v[*at])
                .collect();
            let out = if one.taken_out { "taken out" } else { "kept" };
            let title = format!("{}: r = {}, {out}", at + 1, signed(one.correlation, 2));
            head_map(title, &electrodes, &values).map(|(panel, _)| panel)
        };
        let panels: Option<Vec<_>> = order.iter().take(DRAWN).map(panel).collect();
        if let Some(panels) = panels.filter(|panels| !panels.is_empty()) {
            let maps = Maps::around_zero("weight, µV", panels);
            let reach = rounded(maps.reach);
            blocks.push(Block::Figure(maps.captioned(format!(
                "What components of unit variance add to each electrode, seen from above, nose up: those that follow an EOG channel most, with their \
                 correlation. One scale, ±{reach} µV. A blink is largest at the front and falls off to the back; a horizontal movement has \
                 opposite signs on the two sides."
            ))));
        }
        blocks
    }
}
