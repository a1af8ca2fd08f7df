//! Answers: among those that were offered, right where they are called right, and each order an order.

use std::collections::{BTreeMap, BTreeSet};

use piezotact_people::association::BETWEEN;
use piezotact_people::campaign::protocol::Protocol;

use super::super::NOTHING;
use super::super::physio::number_in;
use super::{Found, Origin, ProblemKind};

/// What an order needs.
#[derive(Default)]
struct Order {
    line: u64,
    ranks: Vec<u64>,
    responses: Vec<String>,
    offered: BTreeSet<String>,
}

/// The answers of one table.
pub(super) struct Answers<'a> {
    names: Vec<String>,
    origin: Origin,
    /// Which declarations count as right.
    protocol: Option<&'a Protocol>,
    /// By the trial and the repetition, or whatever makes a row one of an order.
    orders: BTreeMap<String, Order>,
    /// The positions of each trial, with its first line.
    positions: BTreeMap<String, (u64, Vec<String>)>,
    /// The rows that there are, by what tells them apart.
    rows: BTreeSet<String>,
}

impl<'a> Answers<'a> {
    /// Those of a table with this heading.
    pub(super) fn of(heading: &str, origin: Origin, protocol: Option<&'a Protocol>) -> Self {
        Self {
            names: heading.split('\t').map(str::to_owned).collect(),
            origin,
            protocol,
            orders: BTreeMap::new(),
            positions: BTreeMap::new(),
            rows: BTreeSet::new(),
        }
    }

    fn has(&self, name: &str) -> bool {
        self.names.iter().any(|known| known == name)
    }

    fn cell<'c>(&self, cells: &[&'c str], name: &str) -> Option<&'c str> {
        let at = self.names.iter().position(|known| known == name)?;
        cells
            .get(at)
            .copied()
            .filter(|cell| *cell != NOTHING && !cell.is_empty())
    }

    /// The row of an answer.
    pub(super) fn row(&mut self, file: &str, number: u64, cells: &[&str], found: &mut Found) {
        if !self.has("response") {
            return;
        }
        // Of other programs a column `rank` may hold anything.
        let is_order = self.origin == Origin::Ours && self.has("rank");
        self.once(file, number, cells, found);
        let Some(response) = self.cell(cells, "response") else {
            if let (Origin::Ours, Some(correct)) = (self.origin, self.cell(cells, "correct")) {
                let why = format!(
                    "expected n/a for `correct` where there is no response, found `{correct}`; correct one of them"
                );
                found.add(ProblemKind::Correct, file, number, why);
            } else if is_order {
                let why = "expected a sample at every rank of an order, found none; correct the response, or remove the order";
                found.add(ProblemKind::Ranking, file, number, why);
            }
            return;
        };
        let offered: BTreeSet<&str> = self
            .cell(cells, "offered")
            .into_iter()
            .flat_map(|names| names.split(BETWEEN))
            .collect();
        self.among(file, number, (response, &offered), found);
        if let (Origin::Ours, Some(position)) = (self.origin, self.cell(cells, "position")) {
            let trial = self.cell(cells, "trial").unwrap_or_default().to_owned();
            let of = self.positions.entry(trial).or_insert((number, Vec::new()));
            of.1.push(position.to_owned());
        }
        self.judged(file, number, (response, cells), found);
        if is_order {
            self.place(number, response, cells, &offered);
        }
    }

    /// A row of our own that stands there twice.
    fn once(&mut self, file: &str, number: u64, cells: &[&str], found: &mut Found) {
        if self.origin != Origin::Ours || !file.ends_with("_beh.tsv") {
            return;
        }
        let key = ["trial", "set", "repetition", "position", "rank"];
        let key = key.map(|name| self.cell(cells, name).unwrap_or_default());
        if !self.rows.insert(key.join("\t")) {
            let why = "expected each answer once, found a line of the same trial and place before it; remove one of them";
            found.add(ProblemKind::Twice, file, number, why);
        }
    }

    /// A response that was not offered.
    fn among(
        &self,
        file: &str,
        number: u64,
        (response, offered): (&str, &BTreeSet<&str>),
        found: &mut Found,
    ) {
        if offered.is_empty() {
            // Numbers of a rating are not offered one by one.
            let is_number = number_in(response).is_some();
            if self.origin == Origin::Ours && self.has("offered") && !is_number {
                let why = format!(
                    "expected what was offered beside the response {response}, found n/a; complete the cell"
                );
                found.add(ProblemKind::Response, file, number, why);
            }
            return;
        }
        // Of others only what is separated as it is here.
        if self.origin == Origin::Foreign && offered.len() < 2 {
            return;
        }
        for one in response.split(BETWEEN).filter(|one| !offered.contains(one)) {
            let offered: Vec<&str> = offered.iter().copied().collect();
            let why = format!(
                "expected a response among those that were offered ({}), found `{one}`; correct the response, or what was offered",
                offered.join(", ")
            );
            found.add(ProblemKind::Response, file, number, why);
        }
    }

    /// A response that is called right and is wrong, or the other way round.
    fn judged(
        &self,
        file: &str,
        number: u64,
        (response, cells): (&str, &[&str]),
        found: &mut Found,
    ) {
        // What was presented is the right answer only where nothing else is known of it: in tables of this program.
        let presented = match (self.origin, self.has("expected") || self.has("rank")) {
            (Origin::Ours, false) => self.cell(cells, "presented"),
            _ => None,
        };
        let of_protocol = (self.protocol.zip(self.cell(cells, "presented")))
            .and_then(|(protocol, presented)| protocol.expected(presented));
        if let (Some(of_protocol), Some(expected)) = (of_protocol, self.cell(cells, "expected"))
            && of_protocol != expected
        {
            let why = format!(
                "expected {of_protocol} as the right answer, as the protocol says, found `{expected}`; correct the cell"
            );
            found.add(ProblemKind::Correct, file, number, why);
        }
        let right = self.cell(cells, "expected").or(presented);
        let (Some(right), Some(correct)) = (right, self.cell(cells, "correct")) else {
            return;
        };
        let stated = match correct.to_lowercase().as_str() {
            "1" | "1.0" | "true" | "yes" | "correct" => true,
            "0" | "0.0" | "false" | "no" | "incorrect" => false,
            _ => return,
        };
        let is = are_same(response, right);
        if stated == is {
            return;
        }
        let should = if is { "right" } else { "wrong" };
        let why = format!(
            "expected `correct` to say that the response {response} to {right} is {should}, found `{correct}`; correct the cell"
        );
        found.add(ProblemKind::Correct, file, number, why);
    }

    fn place(&mut self, number: u64, response: &str, cells: &[&str], offered: &BTreeSet<&str>) {
        let key = ["trial", "set", "repetition"].map(|name| self.cell(cells, name).unwrap_or(""));
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
        order
            .offered
            .extend(offered.iter().map(|one| (*one).to_owned()));
    }

    /// What can be said when all rows are read.
    pub(super) fn end(self, file: &str, found: &mut Found) {
        for order in self.orders.into_values() {
            order.check(file, found);
        }
        for (trial, (line, positions)) in self.positions {
            let found_here: BTreeSet<&str> = positions.iter().map(String::as_str).collect();
            let all: Vec<String> = (1..=positions.len()).map(|at| at.to_string()).collect();
            if found_here != all.iter().map(String::as_str).collect() {
                let why = format!(
                    "expected the positions 1 to {} of trial {trial}, each once, found {}; correct them",
                    positions.len(),
                    positions.join(", ")
                );
                found.add(ProblemKind::Number, file, line, why);
            }
        }
    }
}

impl Order {
    fn check(self, file: &str, found: &mut Found) {
        let count = self.ranks.len() as u64;
        let ranks: BTreeSet<u64> = self.ranks.iter().copied().collect();
        if ranks != (1..=count).collect() {
            let why = format!(
                "expected the ranks 1 to {count} of this order, each once, found {}; correct them",
                listed(&self.ranks)
            );
            found.add(ProblemKind::Ranking, file, self.line, why);
        }
        let once: BTreeSet<&String> = self.responses.iter().collect();
        let is_whole = self.offered.is_empty() || once == self.offered.iter().collect();
        if once.len() != self.responses.len() || !is_whole {
            let of = match self.offered.is_empty() {
                true => "its samples".to_owned(),
                false => self.offered.iter().cloned().collect::<Vec<_>>().join(", "),
            };
            let why = format!(
                "expected an order of {of}, each once, found {}; correct it",
                self.responses.join(", ")
            );
            found.add(ProblemKind::Ranking, file, self.line, why);
        }
    }
}

/// Whether two cells say the same: as texts, or as numbers.
fn are_same(one: &str, other: &str) -> bool {
    one == other || number_in(one).is_some_and(|one| number_in(other) == Some(one))
}

fn listed(numbers: &[u64]) -> String {
    let texts: Vec<String> = numbers.iter().map(u64::to_string).collect();
    texts.join(", ")
}
