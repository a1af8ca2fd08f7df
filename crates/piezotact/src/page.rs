//! Reports as data: sections of text, numbers, tables and figures. Whoever draws them computes nothing.
//!
//! A value that has a report is [`Shown`]: it makes a [`Page`], which `piezotact-report` draws as HTML and as text, and whose
//! tables it writes as CSV.

use std::fmt::Display;

use serde::{Deserialize, Serialize};

use crate::criterion::{Criterion, Limit, Outcome};
use crate::document::Kept;
use crate::figure::Figure;
use crate::number::digits;
use crate::warning::{Merged, Warning, merged};

/// A result with a report.
pub trait Shown {
    /// The report: its conclusion, its numbers, its tables and figures, its warnings.
    fn page(&self) -> Page;

    /// How a command ends that hands it out: most results decide nothing by a limit.
    fn ending(&self) -> Ending {
        Ending::Done
    }
}

impl<T: Shown> Shown for Kept<'_, T> {
    fn page(&self) -> Page {
        self.value.page()
    }

    fn ending(&self) -> Ending {
        self.value.ending()
    }
}

/// How a command ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// A result, or a verification that passed.
    Done,
    /// A verification that did not pass.
    NotPassed,
    /// A verification that passed over part of its target.
    PassedInPart,
    /// A verification that could not be decided.
    NotDecided,
}

/// A report.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Page {
    /// What it is a report of.
    pub title: String,
    /// One line below the title: which bench and which recording it comes from; may be empty.
    pub origin: String,
    /// That no person or no device took part, in a sentence, which stands before everything else; absent where they did, or where it is not known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub simulated: Option<String>,
    /// Its sections, in order.
    pub sections: Vec<Section>,
    /// What a CSV file of it holds, with a row for each item; if absent, the first table.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rows: Option<Table>,
}

/// A part of a report.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Section {
    /// Its heading; empty for a part without one.
    pub heading: String,
    /// What stands in it, in order.
    pub blocks: Vec<Block>,
}

/// A piece of a section.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(tag = "kind", rename_all = "snake_case")]
#[allow(
    clippy::large_enum_variant,
    reason = "a page has few blocks, and most of what is large in it are figures"
)]
pub enum Block {
    /// A conclusion, with its outcome as a colour.
    Conclusion {
        /// The conclusion in one sentence.
        text: String,
        /// How it came out; absent where nothing is decided by a limit.
        outcome: Option<Outcome>,
    },
    /// A heading within a section.
    Heading {
        /// The heading.
        text: String,
    },
    /// A paragraph.
    Text {
        /// The paragraph.
        text: String,
    },
    /// A remark in a softer colour: methods, sources.
    Note {
        /// The remark.
        text: String,
    },
    /// Numbers side by side.
    Numbers {
        /// The numbers.
        numbers: Vec<Number>,
    },
    /// A list in order.
    Steps {
        /// The items.
        steps: Vec<String>,
    },
    /// A table.
    Table(Table),
    /// A figure.
    Figure(Figure),
    /// What is known of something, such as where data come from: names with their values.
    Facts {
        /// The facts.
        facts: Vec<Fact>,
    },
    /// Blocks side by side, where the screen is wide enough.
    Beside {
        /// The blocks.
        blocks: Vec<Self>,
    },
    /// Blocks that are shown when their summary is opened.
    Folded {
        /// What they are, in a few words.
        summary: String,
        /// The blocks.
        blocks: Vec<Self>,
    },
    /// Warnings, those of one kind as one; the words are those of whoever draws them.
    Warnings {
        /// Which part of the result they are about; empty for all of it.
        #[serde(default, skip_serializing_if = "String::is_empty")]
        about: String,
        /// The warnings.
        warnings: Vec<Merged>,
    },
}

/// A number with its name.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Number {
    /// The number with its unit.
    pub value: String,
    /// What it is.
    pub name: String,
}

/// A fact.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Fact {
    /// What it is.
    pub name: String,
    pub value: String,
    /// What was done to it, in order.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub steps: Vec<String>,
}

/// A table.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Table {
    /// Its columns.
    pub columns: Vec<Column>,
    /// Its rows; each has one cell for every column.
    pub rows: Vec<Vec<Cell>>,
}

/// A column of a table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Column {
    /// Its heading in a report.
    pub heading: String,
    /// Its name in a CSV file, with its unit: `rms_m_s2`.
    pub name: String,
}

/// A cell of a table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(untagged)]
pub enum Cell {
    /// A number, whole in CSV, with three digits in a report.
    Number(f64),
    /// A number, whole in CSV, with digits of its own in a report.
    Rounded {
        /// The number.
        value: f64,
        /// The number in a report, with its digits.
        text: String,
    },
    /// Whether a criterion is met.
    Outcome(Outcome),
    /// A text.
    Text(String),
    /// Nothing: not measured.
    Missing(()),
}

impl From<f64> for Cell {
    fn from(value: f64) -> Self {
        Self::Number(value)
    }
}

impl From<Option<f64>> for Cell {
    fn from(value: Option<f64>) -> Self {
        value.map_or(Self::Missing(()), Self::Number)
    }
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl From<String> for Cell {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

impl From<Outcome> for Cell {
    fn from(outcome: Outcome) -> Self {
        Self::Outcome(outcome)
    }
}

impl Cell {
    /// A number with `decimals` digits behind the point in a report; a missing one where it is not finite.
    ///
    /// ```
    /// use piezotact::page::Cell;
    /// let cell = Cell::rounded(-0.0012, 2);
    /// assert_eq!([cell.text(), cell.whole()], ["0.00", "-0.0012"]);
    /// ```
    #[must_use]
    pub fn rounded(value: f64, decimals: usize) -> Self {
        if !value.is_finite() {
            return Self::Missing(());
        }
        Self::Rounded {
            value,
            text: fixed(value, decimals),
        }
    }

    /// The cell for a person: numbers with three digits that count, "–" where nothing was measured.
    ///
    /// ```
    /// use piezotact::page::Cell;
    /// assert_eq!([Cell::from(-0.012345), Cell::from(None)].map(|cell| cell.text()), ["−0.0123", "–"]);
    /// ```
    #[must_use]
    pub fn text(&self) -> String {
        match self {
            Self::Number(value) => digits(*value).replace('-', "−"),
            Self::Rounded { text, .. } | Self::Text(text) => text.clone(),
            Self::Outcome(outcome) => outcome.word().to_owned(),
            Self::Missing(()) => "–".into(),
        }
    }

    /// The cell for a program: numbers with all their digits, empty where nothing was measured.
    #[must_use]
    pub fn whole(&self) -> String {
        match self {
            Self::Number(value) | Self::Rounded { value, .. } => value.to_string(),
            Self::Outcome(outcome) => outcome.word().to_owned(),
            Self::Text(text) => text.clone(),
            Self::Missing(()) => String::new(),
        }
    }
}

/// `value` with `decimals` digits behind the point, with a minus sign that is one and without the sign of a zero.
///
/// Source: house rule.
///
/// ```
/// use piezotact::page::fixed;
/// assert_eq!([fixed(-0.004, 2), fixed(-1.25, 1)], ["0.00", "−1.2"]);
/// ```
#[must_use]
pub fn fixed(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    match text.strip_prefix('-') {
        Some(size) if size.contains(|sign: char| ('1'..='9').contains(&sign)) => format!("−{size}"),
        Some(zero) if zero.starts_with('0') => zero.to_owned(),
        _ => text.replace('-', "−"),
    }
}

impl Column {
    /// A column with the same words in a report and in CSV.
    #[must_use]
    pub fn new(heading: &str, name: &str) -> Self {
        Self {
            heading: heading.into(),
            name: name.into(),
        }
    }
}

impl Table {
    /// A table without rows.
    #[must_use]
    pub fn new(columns: impl IntoIterator<Item = Column>) -> Self {
        Self {
            columns: columns.into_iter().collect(),
            rows: Vec::new(),
        }
    }

    /// The criteria of a conclusion: what was looked at, what was found with its interval, the limit, and the outcome.
    #[must_use]
    pub fn of_criteria<'a, W: Display + 'a>(
        criteria: impl IntoIterator<Item = &'a Criterion<W>>,
    ) -> Self {
        let heads = [
            ("criterion", "criterion"),
            ("found", "found"),
            ("95 % interval", "interval"),
            ("limit", "limit"),
            ("outcome", "outcome"),
        ];
        let mut table = Self::new(heads.map(|(heading, name)| Column::new(heading, name)));
        table.rows = criteria.into_iter().map(criterion_row).collect();
        table
    }
}

fn criterion_row<W: Display>(criterion: &Criterion<W>) -> Vec<Cell> {
    let unit = &criterion.unit;
    let number = |value: f64| limit_number(value, unit);
    let found = criterion.found.map_or("not measured".into(), number);
    let interval = criterion.interval.map_or(Cell::Missing(()), |[low, high]| {
        Cell::Text(format!("{} to {}", number(low), number(high)))
    });
    vec![
        Cell::Text(criterion.what.to_string()),
        Cell::Text(found),
        interval,
        Cell::Text(limit_text(criterion.limit, unit)),
        Cell::from(criterion.outcome),
    ]
}

/// `value` with its unit and as many digits as tell it from a limit.
///
/// Source: docs/decisions/documents.md.
///
/// ```
/// use piezotact::page::limit_number;
/// assert_eq!([limit_number(-0.25, "dB"), limit_number(120.04, "")], ["−0.25\u{a0}dB", "120"]);
/// assert_eq!([limit_number(1.0, "people"), limit_number(2.0, "people")], ["1\u{a0}person", "2\u{a0}people"]);
/// ```
#[must_use]
pub fn limit_number(value: f64, unit: &str) -> String {
    let space = if unit.is_empty() || unit == "°" {
        ""
    } else {
        "\u{a0}"
    };
    let unit = match unit {
        "people" if value == 1.0 => "person",
        unit => unit,
    };
    // A negative zero is a zero.
    let value = value + 0.0;
    let size = value.abs();
    let decimals = match size {
        _ if size >= 100.0 => 1,
        _ if size >= 10.0 => 2,
        _ if size >= 0.01 || value == 0.0 => 3,
        _ => return format!("{value:.1e}{space}{unit}").replace('-', "−"),
    };
    let text = format!("{value:.decimals$}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    format!("{text}{space}{unit}").replace('-', "−")
}

/// What differs by less is equal except for rounding.
const ROUNDING: f64 = 1e-6;

/// A limit in words, with the range in which nothing is decided.
///
/// Source: docs/decisions/documents.md.
///
/// ```
/// use piezotact::criterion::Limit;
/// use piezotact::page::limit_text;
/// assert_eq!(limit_text(Limit::at_least(0.9), ""), "at least 0.9");
/// ```
#[must_use]
pub fn limit_text(limit: Limit, unit: &str) -> String {
    let value = limit_number(limit.value(), unit);
    let other = limit_number(limit.not_met_from(), unit);
    match limit {
        Limit::AtMost { met, not_met } if met < not_met => {
            format!("at most {value}; not decided up to {other}")
        }
        Limit::AtLeast { met, not_met } if not_met < met => {
            format!("at least {value}; not decided down to {other}")
        }
        Limit::AtMost { met: 0.0, .. } if unit.is_empty() => "none".into(),
        Limit::AtMost { .. } => format!("at most {value}"),
        Limit::AtLeast { .. } => format!("at least {value}"),
        Limit::Within { reach } if reach < ROUNDING => "no difference".into(),
        Limit::Within { .. } => format!("within ±{value}"),
    }
}

impl Number {
    /// `value`, with its unit, called `name`.
    #[must_use]
    pub fn new(value: impl Into<String>, name: impl Into<String>) -> Self {
        Self {
            value: value.into(),
            name: name.into(),
        }
    }
}

impl Fact {
    /// `value`, called `name`.
    #[must_use]
    pub fn new(name: impl Into<String>, value: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            value: value.into(),
            steps: Vec::new(),
        }
    }

    /// The same with what was done to it.
    #[must_use]
    pub fn steps(mut self, steps: impl IntoIterator<Item = impl Display>) -> Self {
        self.steps = steps.into_iter().map(|step| step.to_string()).collect();
        self
    }
}

impl Block {
    /// A conclusion.
    #[must_use]
    pub fn conclusion(text: impl Into<String>, outcome: impl Into<Option<Outcome>>) -> Self {
        Self::Conclusion {
            text: text.into(),
            outcome: outcome.into(),
        }
    }

    /// A heading within a section.
    #[must_use]
    pub fn heading(text: impl Into<String>) -> Self {
        Self::Heading { text: text.into() }
    }

    /// A paragraph.
    #[must_use]
    pub fn text(text: impl Into<String>) -> Self {
        Self::Text { text: text.into() }
    }

    /// A remark.
    #[must_use]
    pub fn note(text: impl Into<String>) -> Self {
        Self::Note { text: text.into() }
    }

    /// Numbers side by side.
    #[must_use]
    pub fn numbers(numbers: impl IntoIterator<Item = Number>) -> Self {
        Self::Numbers {
            numbers: numbers.into_iter().collect(),
        }
    }

    /// Facts.
    #[must_use]
    pub fn facts(facts: impl IntoIterator<Item = Fact>) -> Self {
        Self::Facts {
            facts: facts.into_iter().collect(),
        }
    }

    /// Blocks behind a summary.
    #[must_use]
    pub fn folded(summary: impl Into<String>, blocks: impl IntoIterator<Item = Self>) -> Self {
        Self::Folded {
            summary: summary.into(),
            blocks: blocks.into_iter().collect(),
        }
    }

    /// Warnings about a part of the result.
    #[must_use]
    pub fn warnings(about: impl Into<String>, warnings: Vec<Merged>) -> Self {
        Self::Warnings {
            about: about.into(),
            warnings,
        }
    }

    /// Blocks side by side.
    #[must_use]
    pub fn beside(blocks: impl IntoIterator<Item = Self>) -> Self {
        Self::Beside {
            blocks: blocks.into_iter().collect(),
        }
    }
}

impl From<Figure> for Block {
    fn from(figure: Figure) -> Self {
        Self::Figure(figure)
    }
}

impl From<Table> for Block {
    fn from(table: Table) -> Self {
        Self::Table(table)
    }
}

impl Page {
    /// A report without sections.
    #[must_use]
    pub fn new(title: impl Into<String>, origin: impl Into<String>) -> Self {
        Self {
            title: title.into(),
            origin: origin.into(),
            simulated: None,
            sections: Vec::new(),
            rows: None,
        }
    }

    /// The same with what is simulated of the recordings behind it.
    #[must_use]
    pub fn simulated(self, simulated: Option<String>) -> Self {
        Self { simulated, ..self }
    }

    /// The same with what a CSV file of it holds.
    #[must_use]
    pub fn rows(mut self, rows: Table) -> Self {
        self.rows = Some(rows);
        self
    }

    /// What a CSV file of it holds: its rows, otherwise its first table that is not folded; `None` where it has no table.
    #[must_use]
    pub fn csv_table(&self) -> Option<&Table> {
        self.rows.as_ref().or_else(|| self.first_table())
    }

    /// Its first table that is not folded.
    #[must_use]
    pub fn first_table(&self) -> Option<&Table> {
        self.blocks().find_map(|block| match block {
            Block::Table(table) => Some(table),
            _ => None,
        })
    }

    /// Its blocks that are not folded, in order.
    pub fn blocks(&self) -> impl Iterator<Item = &Block> {
        let blocks = self.sections.iter().flat_map(|section| &section.blocks);
        blocks.flat_map(|block| match block {
            Block::Beside { blocks } => blocks.iter(),
            block => std::slice::from_ref(block).iter(),
        })
    }

    /// Its warnings, those of one kind as one, each with the part of the result that it is about.
    pub fn merged_warnings(&self) -> impl Iterator<Item = (&str, &Merged)> {
        let warnings = self.blocks().filter_map(|block| match block {
            Block::Warnings { about, warnings } => Some((about.as_str(), warnings)),
            _ => None,
        });
        warnings.flat_map(|(about, warnings)| warnings.iter().map(move |one| (about, one)))
    }

    /// The same with a section more.
    #[must_use]
    pub fn section(mut self, heading: &str, blocks: impl IntoIterator<Item = Block>) -> Self {
        self.sections.push(Section {
            heading: heading.into(),
            blocks: blocks.into_iter().collect(),
        });
        self
    }

    /// The same with its warnings.
    #[must_use]
    pub fn warnings(self, warnings: &[Warning]) -> Self {
        let warnings = merged(warnings);
        self.section("Warnings", [Block::warnings("", warnings)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_say_where_they_are_met_and_where_not() {
        let range = Limit::AtMost {
            met: 1.5,
            not_met: 2.5,
        };
        let nb = |text: &str| text.replace(" dB", "\u{a0}dB");
        assert_eq!(
            limit_text(range, "dB"),
            nb("at most 1.5 dB; not decided up to 2.5 dB")
        );
        assert_eq!(limit_text(Limit::at_most(0.0), ""), "none");
        assert_eq!(
            limit_text(Limit::Within { reach: 1e-9 }, "°"),
            "no difference"
        );
        let numbers = [15.0, -0.25, 0.0, 120.04, 0.000_05].map(|value| limit_number(value, ""));
        assert_eq!(numbers, ["15", "−0.25", "0", "120", "5.0e−5"]);
    }

    #[test]
    fn a_page_is_stored_and_read_again() {
        let mut table = Table::of_criteria(&[Criterion::new(
            "level",
            "dB",
            0.8,
            Some([0.7, 0.9]),
            Limit::at_most(1.0),
        )]);
        assert_eq!(table.rows[0][4], Cell::from(Outcome::Met));
        table.rows.push(vec![
            Cell::from(1.5),
            Cell::from("a"),
            Cell::from(None),
            Cell::from("b"),
            Cell::from(f64::from(2)),
        ]);
        let page = Page::new("Noise", "")
            .section("Table", [Block::Table(table)])
            .warnings(&[]);
        let text = serde_json::to_string(&page).unwrap();
        assert_eq!(serde_json::from_str::<Page>(&text).unwrap(), page);
    }
}
