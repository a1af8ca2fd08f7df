//! Reports as data: sections of text, numbers, tables and figures. Whoever draws them computes nothing.
//!
//! A value that has a report makes a [`Page`]; `piezotact-report` draws it as HTML, and a [`Table`] as CSV or text.

use std::fmt::Display;

use serde::{Deserialize, Serialize};

use crate::criterion::{Criterion, Limit, Outcome};
use crate::figure::Figure;
use crate::number::digits;
use crate::warning::{Merged, Warning, merged};

/// A report.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Page {
    /// What it is a report of.
    pub title: String,
    /// One line below the title: which bench and which recording it comes from; may be empty.
    pub origin: String,
    /// Its sections, in order.
    pub sections: Vec<Section>,
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
    /// Warnings, those of one kind as one; the words are those of whoever draws them.
    Warnings {
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

impl Cell {
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
            Self::Text(text) => text.clone(),
            Self::Missing(()) => "–".into(),
        }
    }

    /// The cell for a program: numbers with all their digits, empty where nothing was measured.
    #[must_use]
    pub fn whole(&self) -> String {
        match self {
            Self::Number(value) => value.to_string(),
            Self::Text(text) => text.clone(),
            Self::Missing(()) => String::new(),
        }
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
        Cell::from(criterion.outcome.word()),
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

impl Page {
    /// A report without sections.
    #[must_use]
    pub fn new(title: impl Into<String>, origin: impl Into<String>) -> Self {
        Self {
            title: title.into(),
            origin: origin.into(),
            sections: Vec::new(),
        }
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
        self.section("Warnings", [Block::Warnings { warnings }])
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
        assert_eq!(table.rows[0][4], Cell::from("met"));
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
