//! Answers: among those that were offered, right where they are called right, and each order an order.

use std::collections::{BTreeMap, BTreeSet};

use piezotact_people::association::BETWEEN;

use super::super::NOTHING;
use super::super::physio::number_in;
use super::{Found, ProblemKind};

/// What an order needs.
#[derive(Default)]
struct Order {
    line: u64,
    ranks: Vec<u64>,
    responses: Vec<String>,
    offered: BTreeSet<String>,
}

/// The answers of one table.
pub(super) struct Answers {
    names: Vec<String>,
    /// By the trial and the repetition, or whatever makes a row one of an order.
    orders: BTreeMap<String, Order>,
}

impl Answers {
    /// Those of a table with this heading.
    pub(super) fn of(heading: &str) -> Self {
        Self {
            names: heading.split('\t').map(str::to_owned).collect(),
            orders: BTreeMap::new(),
        }
    }

    fn cell<'a>(&self, cells: &[&'a str], name: &str) -> Option<&'a str> {
        let at = self.names.iter().position(|known| known == name)?;
        cells
            .get(at)
            .copied()
            .filter(|cell| *cell != NOTHING && !cell.is_empty())
    }

    pub(super) fn row(&mut self, file: &str, number: u64, cells: &[&str], found: &mut Found) {
        let Some(response) = self.cell(cells, "response") else {
            let has_column = self.names.iter().any(|name| name == "response");
            if let (true, Some(correct)) = (has_column, self.cell(cells, "correct")) {
                let why = format!(
                    "expected n/a for `correct` where there is no response, found `{correct}`; correct one of them"
                );
                found.add(ProblemKind::Correct, file, number, why);
            }
            return;
        };
        let offered: BTreeSet<&str> = self
            .cell(cells, "offered")
            .into_iter()
            .flat_map(|names| names.split(BETWEEN))
            .collect();
        if !offered.is_empty() {
            for one in response.split(BETWEEN).filter(|one| !offered.contains(one)) {
                let offered: Vec<&str> = offered.iter().copied().collect();
                let why = format!(
                    "expected a response among those that were offered ({}), found `{one}`; correct the response, or what was offered",
                    offered.join(", ")
                );
                found.add(ProblemKind::Response, file, number, why);
            }
        }
        let is_order = self.names.iter().any(|name| name == "rank");
        let right = self.cell(cells, "expected").or_else(|| match is_order {
            true => None,
            false => self.cell(cells, "presented"),
        });
        if let (Some(right), Some(correct)) = (right, self.cell(cells, "correct")) {
            let stated = match correct.to_lowercase().as_str() {
                "1" | "1.0" | "true" | "yes" | "correct" => Some(true),
                "0" | "0.0" | "false" | "no" | "incorrect" => Some(false),
                _ => None,
            };
            let is = response == right;
            if stated.is_some_and(|stated| stated != is) {
                let should = if is { "right" } else { "wrong" };
                let why = format!(
                    "expected `correct` to say that the response {response} to {right} is {should}, found `{correct}`; correct the cell"
                );
                found.add(ProblemKind::Correct, file, number, why);
            }
        }
        if is_order {
            let key =
                ["trial", "set", "repetition"].map(|name| self.cell(cells, name).unwrap_or(""));
            let rank = self.cell(cells, "rank").and_then(number_in);
            let order = self.orders.entry(key.join("\t")).or_insert_with(|| Order {
                line: number,
                ..Order::default()
            });
            // A rank that is no whole number is none.
            order.ranks.push(
                rank.filter(|rank| rank.fract() == 0.0 && *rank >= 1.0)
                    .map_or(0, |rank| rank as u64),
            );
            order.responses.push(response.to_owned());
            order.offered.extend(offered.into_iter().map(str::to_owned));
        }
    }

    /// What can be said when all rows are read.
    pub(super) fn end(self, file: &str, found: &mut Found) {
        for order in self.orders.into_values() {
            let count = order.ranks.len() as u64;
            let ranks: BTreeSet<u64> = order.ranks.iter().copied().collect();
            if ranks != (1..=count).collect() {
                let why = format!(
                    "expected the ranks 1 to {count} of this order, each once, found {}; correct them",
                    listed(&order.ranks)
                );
                found.add(ProblemKind::Ranking, file, order.line, why);
            }
            let once: BTreeSet<&String> = order.responses.iter().collect();
            let is_whole = order.offered.is_empty() || once == order.offered.iter().collect();
            if once.len() != order.responses.len() || !is_whole {
                let of = match order.offered.is_empty() {
                    true => "its samples".to_owned(),
                    false => order.offered.iter().cloned().collect::<Vec<_>>().join(", "),
                };
                let why = format!(
                    "expected an order of {of}, each once, found {}; correct it",
                    order.responses.join(", ")
                );
                found.add(ProblemKind::Ranking, file, order.line, why);
            }
        }
    }
}

fn listed(numbers: &[u64]) -> String {
    let texts: Vec<String> = numbers.iter().map(u64::to_string).collect();
    texts.join(", ")
}
